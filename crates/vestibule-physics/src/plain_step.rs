//! The usual step, worked out without a transition: a walker over a floor or on terrain, reaching nothing but its
//! own cell (`transition.md` 3.5, 5.1, 5.6, 5.8).
//!
//! Where everything that could interfere is certainly out of reach, the rules come down to a few: the offset is
//! bent by the plane stood on, the candidate is lowered, it is moved back onto the ground, and the ground must
//! support it. The arithmetic is that of the rules, in their order; where one is not certain to apply, the
//! answer is `None` and the sweep goes the long way.

use glam::Vec3;
use vestibule_world::{
    CellEntry, CellId, CylSphere, EnvCell, Frame, Landblock, PhysicsBsp, Plane, Position, ShadowLists,
    Sphere, StaticObject, StaticReach, TransitHints, World, certain_rooms,
};

use crate::adjust_offset::along_planes;
use crate::bsp_tree::{self, WalkableSearch};
use crate::constants::{EPSILON, FLOOR_Z};
use crate::cylsphere::overlaps_cylinder;
use crate::flags::{ObjectState, PhysicsState};
use crate::math::{length, normalised};
use crate::plain_land::plain_step_on_land;
use crate::polygon;
use crate::population::Population;
use crate::sphere::overlaps_sphere;
use crate::sphere_path::Arms;
use crate::sweep::{Carried, ContactPlane, Mover, Scratch, Swept};
use crate::transition::BuiltArray;

/// A floor found below a candidate.
pub(crate) struct OpenFloor {
    /// What takes the lowered candidate back up.
    pub(crate) offset: Vec3,
    /// The floor's plane in the frame of the cell's landblock.
    pub(crate) plane: Plane,
    pub(crate) walk_interp: f32,
}

/// A candidate: the origin of its position, its spheres in the frame of the landblock, and where they are relative
/// to the origin.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) origin: Vec3,
    pub(crate) spheres: [Sphere; 2],
    pub(crate) arms: [Vec3; 2],
    pub(crate) count: usize,
}

impl Candidate {
    #[inline(always)]
    pub(crate) fn shift(&mut self, v: Vec3) {
        self.origin += v;
        self.spheres[0].center += v;
        self.spheres[1].center += v;
    }

    #[inline(always)]
    pub(crate) fn spheres(&self) -> &[Sphere] {
        self.spheres.get(..self.count).unwrap_or(&self.spheres)
    }

    /// Sphere `i` as the cell's polygons see it (retail `cache_localspace_sphere`).
    #[inline(always)]
    pub(crate) fn local(&self, cell: &EnvCell, i: usize) -> Sphere {
        let center = cell.frame.global_to_local(self.origin + self.arms[i]);
        Sphere::new(center, self.spheres[i].radius)
    }

    /// Whether another pose is less than `distance` away.
    #[inline(always)]
    pub(crate) fn is_within(&self, pose: &Candidate, distance: f32) -> bool {
        let shift = pose.spheres[0].center - self.spheres[0].center;
        shift.dot(shift) < distance * distance
    }

    /// Whether an insertion finds nothing of a part of a static object.
    fn clears_part(&self, frame: &Frame, bsp: &PhysicsBsp, bound: &Sphere, placing: bool) -> bool {
        let local = |i: usize| {
            Sphere::new(
                frame.global_to_local(self.origin + self.arms[i]),
                self.spheres[i].radius,
            )
        };
        if !(0..self.count).any(|i| bsp_tree::spheres_overlap(bound, &local(i))) {
            return true;
        }
        (0..self.count).all(|i| {
            if placing {
                !bsp_tree::sphere_intersects_solid(bsp, &local(i), true)
            } else {
                bsp_tree::overlaps_nothing(bsp, &local(i))
            }
        })
    }

    /// Whether a moving insertion into the cell finds nothing.
    #[inline(always)]
    fn is_clear(&self, cell: &EnvCell) -> bool {
        self.is_in_the_open(cell) || {
            // A copy, so that the candidate itself can stay in registers.
            let at = *self;
            at.overlaps_nothing(cell)
        }
    }

    /// Whether the cell's box of open space holds all spheres.
    #[inline(always)]
    fn is_in_the_open(&self, cell: &EnvCell) -> bool {
        let [foot, head] = &self.spheres;
        cell.hints.certainly_clear(foot) && (self.count < 2 || cell.hints.certainly_clear(head))
    }

    #[inline(never)]
    fn overlaps_nothing(&self, cell: &EnvCell) -> bool {
        let Some(bsp) = &cell.structure.physics else {
            return true;
        };
        (0..self.count).all(|i| bsp_tree::overlaps_nothing(bsp, &self.local(cell, i)))
    }

    /// Whether the rest of a step down onto a floor finds nothing of a cell: another attempt, which asks whether the
    /// foot overlaps ground, and the placement insertion, which asks whether any sphere overlaps anything.
    #[inline(always)]
    pub(crate) fn rests_in(&self, cell: &EnvCell) -> bool {
        (cell.hints.open_is_hollow() && self.is_in_the_open(cell)) || {
            let at = *self;
            at.touches_nothing_solid(cell)
        }
    }

    #[inline(never)]
    fn touches_nothing_solid(&self, cell: &EnvCell) -> bool {
        let Some(bsp) = &cell.structure.physics else {
            return true;
        };
        (0..self.count).all(|i| !bsp_tree::sphere_intersects_solid(bsp, &self.local(cell, i), true))
    }

    /// As [`Candidate::rests_in`] for other cells that the candidate reaches, none of which keeps anyone out.
    #[inline(always)]
    pub(crate) fn rests_beside(&self, block: &Landblock, others: &[CellEntry]) -> bool {
        for entry in others {
            let Some(other) = block.env_cell(entry.id) else {
                return false;
            };
            if other.restriction.is_some() || !self.rests_in(other) {
                return false;
            }
        }
        true
    }

    /// Where its spheres are.
    #[inline(always)]
    pub(crate) fn centers(&self) -> [Vec3; 2] {
        [self.spheres[0].center, self.spheres[1].center]
    }
}

/// The search for a floor of the cell in a step down by `h`, of which `interp` is left (6.11.1).
#[inline(always)]
pub(crate) fn search_below<'a>(
    cell: &EnvCell,
    at: &Candidate,
    h: f32,
    interp: f32,
    z: f32,
) -> WalkableSearch<'a> {
    let [x, y, z_axis] = cell.frame.axes();
    let up = Vec3::new(x.z, y.z, z_axis.z);
    WalkableSearch {
        sphere: at.local(cell, 0),
        movement: up * -(h * interp),
        up,
        walkable_allowance: z,
        walk_interp: interp,
        found: None,
    }
}

/// How a step down by `h` ends when it finds a floor of the cell and nothing of the cell is in the way of the
/// candidate lifted onto it (5.8). `lowered` has been lowered and is lifted; `supported`: the floor must support the
/// foot sphere. Whether the lifted candidate reaches other cells or objects is for the caller to see.
#[inline(always)]
pub(crate) fn find_open_floor(
    cell: &EnvCell,
    lowered: &mut Candidate,
    h: f32,
    z: f32,
    supported: bool,
) -> Option<OpenFloor> {
    let bsp = cell.structure.physics.as_ref()?;
    let frame = &cell.frame;
    let mut search = search_below(cell, lowered, h, 1.0, z);
    let (local, up) = (search.sphere, search.up);
    bsp_tree::find_walkable(bsp, &mut search);
    let face = search.found?;
    let normal = frame.local_to_global_vec(face.plane.normal);
    if normal.z < z {
        return None;
    }
    if supported {
        let half = Sphere::new(search.sphere.center, search.sphere.radius * 0.5);
        if !polygon::check_walkable(face, bsp.edges(face), &half, up) {
            return None;
        }
    }
    let offset = frame.local_to_global_vec(search.sphere.center - local.center);
    lowered.shift(offset);
    if !lowered.rests_in(cell) {
        return None;
    }
    let point = Vec3::ZERO + frame.local_to_global(face.plane.normal * -face.plane.d);
    Some(OpenFloor {
        offset,
        plane: Plane {
            normal,
            d: -normal.dot(point),
        },
        walk_interp: search.walk_interp,
    })
}

/// How far the spheres may be shifted together before one comes near a static object of a cell, metres.
#[inline(always)]
pub(crate) fn distance_to_statics(lists: &ShadowLists, cell: CellId, spheres: &[Sphere]) -> f32 {
    let larger = larger_radius(spheres);
    let mut least = f32::INFINITY;
    for (_, reach) in lists.with_reaches(cell) {
        let d = distance_to_reach(reach, larger, spheres);
        least = if d < least { d } else { least };
    }
    least
}

#[inline(always)]
fn distance_to_reach(reach: &StaticReach, larger: f32, spheres: &[Sphere]) -> f32 {
    let limit = reach.sphere.radius + reach.stretch * larger;
    let mut least = f32::INFINITY;
    for s in spheres {
        let d = length(s.center - reach.sphere.center) - limit;
        least = if d < least { d } else { least };
    }
    least
}

#[inline(always)]
fn larger_radius(spheres: &[Sphere]) -> f32 {
    let mut larger = 0.0;
    for s in spheres {
        larger = if s.radius > larger { s.radius } else { larger };
    }
    larger
}

/// Where a usual step ends: in the cell it began in, on walkable ground.
pub(crate) struct PlainEnd {
    pub(crate) origin: Vec3,
    /// What it stands on.
    pub(crate) plane: Plane,
    pub(crate) is_water: bool,
}

impl PlainEnd {
    /// What the sweep comes to.
    #[inline(always)]
    pub(crate) fn swept(&self, mover: &Mover, carried: &Carried, cell: CellId, to: &Position) -> Swept {
        let mut frame = to.frame;
        frame.origin = self.origin;
        let falls = mover.physics.has(PhysicsState::GRAVITY);
        Swept {
            ok: true,
            cell: Some(cell),
            position: Position { cell, frame },
            contact: Some(ContactPlane {
                plane: self.plane,
                cell,
                is_water: self.is_water,
            }),
            on_walkable: true,
            collision_normal: None,
            sliding_normal: None,
            collided_with_environment: false,
            stationary: if falls { 0 } else { carried.stationary },
            velocity_killed: false,
        }
    }
}

/// What a usual step starts from.
pub(crate) struct PlainStep<'a> {
    pub(crate) world: &'a World,
    pub(crate) population: &'a Population,
    pub(crate) mover: &'a Mover,
    pub(crate) from: &'a Position,
    /// The candidate after the step, before it is inserted.
    pub(crate) candidate: Candidate,
    /// The lowest point of the candidate.
    pub(crate) low: Vec3,
}

/// A sweep of one step by `offset` from `from`, if it is a usual one. `to` says how the mover ends up turned. `built`
/// takes what was found out about the candidate's cells, for the longer way.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "those of a sweep")]
pub(crate) fn plain_step(
    world: &World,
    population: &Population,
    scratch: &mut Scratch,
    mover: &Mover,
    carried: &Carried,
    from: &Position,
    to: &Position,
    offset: Vec3,
    built: &mut BuiltArray,
) -> Option<PlainEnd> {
    let contact = carried.contact.as_ref()?;
    let unusual = !carried.on_walkable
        || mover.state.has(ObjectState::IS_VIEWER)
        || mover.physics.has(PhysicsState::MISSILE)
        || contact.cell.is_none()
        || contact.cell.block() != from.cell.block()
        || from.frame.rotation() != to.frame.rotation()
        || carried.last_known.is_some()
        || world.settings().exact;
    if unusual {
        return None;
    }
    let arms = Arms::of(&from.frame, &mover.spheres);
    let start = from.frame.origin;
    let foot = Sphere::new(start + arms.center[0], mover.spheres[0].radius);
    let mut head = start + arms.center[1];
    let (mut foot_center, mut origin) = (foot.center, start);

    // The offset, bent; a foot in the floor is pushed out of it first (4.2).
    let wall = match carried.sliding_normal {
        Some(n) => Some(normalised(n).unwrap_or(Vec3::ZERO)).filter(|&n| offset.dot(n) < 0.0),
        None => None,
    };
    let v = along_planes(offset, contact.plane.normal, wall);
    if EPSILON * EPSILON > v.dot(v) {
        return None;
    }
    let mut low = from.frame.origin + arms.low;
    if !contact.is_water {
        let s = contact.plane.dist(foot.center);
        if s < foot.radius - EPSILON {
            let z = (foot.radius - s) / contact.plane.normal.z;
            if foot.radius > z.abs() {
                let push = Vec3::new(0.0, 0.0, z);
                origin += push;
                foot_center += push;
                head += push;
                low += push;
            }
        }
    }
    origin += v;
    // Zero unless a number is not finite: then the long way says which. Positions come in by the candidate.
    let (n, q) = (contact.plane.normal, from.frame.rotation());
    let slide = carried.sliding_normal.map_or(0.0, |n| n.x + n.y + n.z);
    let sum = n.x + n.y + n.z + contact.plane.d + q.x + q.y + q.z + q.w + slide;
    let sum = sum + mover.step_up_height + mover.step_down_height + origin.x + origin.y + origin.z;
    if !(sum * 0.0 == 0.0) {
        return None;
    }
    let candidate = Candidate {
        origin,
        spheres: [
            Sphere::new(foot_center + v, foot.radius),
            Sphere::new(head + v, mover.spheres[1].radius),
        ],
        arms: arms.center,
        count: mover.spheres().len(),
    };
    let block = world.block(from.cell.block())?;
    let step = PlainStep {
        world,
        population,
        mover,
        from,
        candidate,
        low: low + v,
    };
    if from.cell.is_indoor() {
        step.in_rooms(block, scratch, built)
    } else {
        plain_step_on_land(&step, block, scratch, built)
    }
}

/// See [`PlainStep::objects_around`].
#[inline(never)]
fn statics_around(
    world: &World,
    lists: &ShadowLists,
    cell: CellId,
    pose: &Candidate,
    placing: bool,
) -> Option<f32> {
    let least = distance_to_statics(lists, cell, pose.spheres());
    if least > 0.0 {
        return Some(least);
    }
    clears_statics(world, lists, cell, pose, placing).then_some(0.0)
}

/// Whether a pose that is near static objects certainly touches none of them.
fn clears_statics(world: &World, lists: &ShadowLists, cell: CellId, pose: &Candidate, placing: bool) -> bool {
    let larger = larger_radius(pose.spheres());
    lists.with_reaches(cell).all(|(r, reach)| {
        if distance_to_reach(reach, larger, pose.spheres()) > 0.0 {
            return true;
        }
        let Some(object) = world.static_object(r) else {
            return true;
        };
        object.cell.block() == cell.block() && clears_object(object, pose, placing)
    })
}

/// Whether a pose certainly does not touch a static object of its landblock: by the one kind of shape that counts
/// (8.2).
fn clears_object(object: &StaticObject, pose: &Candidate, placing: bool) -> bool {
    let shape = &object.shape;
    if shape.has_physics_bsp {
        return shape.parts.iter().zip(&object.part_frames).all(|(part, frame)| {
            let model = part.model.as_ref();
            let Some((bsp, bound)) = model.and_then(|m| Some((m.physics.as_ref()?, m.physics_sphere?)))
            else {
                return true;
            };
            part.scale.z == 1.0 && pose.clears_part(frame, bsp, &bound, placing)
        });
    }
    let place = |p: Vec3| Vec3::ZERO + object.frame.local_to_global(p);
    if shape.cylspheres.is_empty() {
        let place = |s: &Sphere| Sphere::new(place(s.center), s.radius);
        let mut spheres = shape.spheres.iter().map(place);
        return !spheres.any(|s| overlaps_sphere(&s, &pose.spheres, pose.count));
    }
    let place = |c: &CylSphere| CylSphere {
        low_point: place(c.low_point),
        ..*c
    };
    let mut cylinders = shape.cylspheres.iter().map(place);
    !cylinders.any(|c| overlaps_cylinder(&c, &pose.spheres, pose.count))
}

impl PlainStep<'_> {
    /// In a room, and maybe partly in others of the landblock.
    #[inline(always)]
    fn in_rooms(&self, block: &Landblock, scratch: &mut Scratch, built: &mut BuiltArray) -> Option<PlainEnd> {
        let cell = block.env_cell(self.from.cell)?;
        let to_cells = self.certain_rooms(block, cell, scratch);
        *built = BuiltArray::certain(cell.id, self.candidate.centers(), to_cells, &scratch.cell_array);
        if !(to_cells > 0.0) || cell.restriction.is_some() || !self.candidate.is_clear(cell) {
            return None;
        }
        let others = scratch.cell_array.entries().get(1..)?;
        let mut objects = self.objects_around(block, cell.id, &self.candidate, false)?;
        for entry in others {
            let other = block.env_cell(entry.id)?;
            if other.restriction.is_some() || !self.candidate.is_clear(other) {
                return None;
            }
            let d = self.objects_around(block, other.id, &self.candidate, false)?;
            objects = if d < objects { d } else { objects };
        }
        // The ground below (5.6).
        let h = self.search_depth();
        let mut lowered = self.candidate;
        lowered.shift(Vec3::new(0.0, 0.0, -h));
        let supported = self.mover.state.has(ObjectState::EDGE_SLIDE);
        let floor = find_open_floor(cell, &mut lowered, h, FLOOR_Z, supported)?;
        if !self.candidate.is_within(&lowered, to_cells) || !lowered.rests_beside(block, others) {
            return None;
        }
        if !self.candidate.is_within(&lowered, objects) {
            let mut all = scratch.cell_array.entries().iter();
            if !all.all(|entry| self.objects_around(block, entry.id, &lowered, true).is_some()) {
                return None;
            }
        }
        self.end(&lowered, floor.plane, false)
    }

    /// Fills the cell array; see [`certain_rooms`].
    #[inline(always)]
    fn certain_rooms(&self, block: &Landblock, cell: &EnvCell, scratch: &mut Scratch) -> f32 {
        let [foot, head] = &self.candidate.spheres;
        if cell.hints.is_quiet(foot) && (self.candidate.count < 2 || cell.hints.is_quiet(head)) {
            scratch.cell_array.start(cell.id, true);
            return TransitHints::QUIET_SHIFT;
        }
        let at = self.candidate;
        certain_rooms(block, cell, at.spheres(), &mut scratch.cell_array)
    }

    /// How far a pose may be shifted before it comes near an object, metres: zero when it is near some but clears
    /// them. `None` when it does not, or that is not easily told. `placing`: as a placement insertion asks.
    #[inline(always)]
    pub(crate) fn objects_around(
        &self,
        block: &Landblock,
        cell: CellId,
        pose: &Candidate,
        placing: bool,
    ) -> Option<f32> {
        if self.population.has_bodies() && !self.population.is_alone_in(cell, self.mover.body) {
            return None;
        }
        let lists = self.world.shadow_lists(block);
        if lists.is_empty_in(cell) {
            return Some(f32::INFINITY);
        }
        let pose = *pose;
        statics_around(self.world, lists, cell, &pose, placing)
    }

    /// Whether a placement insertion at `to` finds no object, given what [`PlainStep::objects_around`] said of `from`.
    #[inline(always)]
    pub(crate) fn clears_objects(
        &self,
        block: &Landblock,
        cell: CellId,
        from: (&Candidate, f32),
        to: &Candidate,
    ) -> bool {
        from.0.is_within(to, from.1) || self.objects_around(block, cell, to, true).is_some()
    }

    /// How far down ground is looked for at first, metres (5.6).
    #[inline(always)]
    pub(crate) fn search_depth(&self) -> f32 {
        let radius = self.candidate.spheres[0].radius;
        let mut h = self.mover.step_down_height;
        if self.candidate.count < 2 && 2.0 * radius < h {
            h = radius / 2.0;
        }
        if 2.0 * radius >= h { h } else { h / 2.0 }
    }

    /// What the sweep comes to, unless it made no progress.
    #[inline(always)]
    pub(crate) fn end(&self, pose: &Candidate, plane: Plane, is_water: bool) -> Option<PlainEnd> {
        let moved = (pose.origin - self.from.frame.origin).abs();
        if moved.x < EPSILON && moved.y < EPSILON && moved.z < EPSILON {
            return None;
        }
        Some(PlainEnd {
            origin: pose.origin,
            plane,
            is_water,
        })
    }
}
