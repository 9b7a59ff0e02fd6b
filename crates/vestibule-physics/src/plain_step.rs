//! The usual step, worked out without a transition: a walker over a floor or on terrain, reaching nothing but its
//! own cell (`transition.md` 3.5, 5.1, 5.6, 5.8).
//!
//! Where everything that could interfere is certainly out of reach, the rules come down to a few: the offset is
//! bent by the plane stood on, the candidate is lowered, it is moved back onto the ground, and the ground must
//! support it. The arithmetic is that of the rules, in their order; where one is not certain to apply, the
//! answer is `None` and the sweep goes the long way.

use glam::Vec3;
use vestibule_world::{
    CellEntry, CellId, CylSphere, EnvCell, Frame, Landblock, Lanes, PhysicsBsp, Plane, Position, ShadowLists,
    Sphere, StaticObject, StaticReach, TransitHints, World, certain_rooms,
};

use crate::adjust_offset::along_planes;
use crate::bsp_tree::{self, WalkableSearch};
use crate::constants::{EPSILON, FLOOR_Z};
use crate::cylsphere::overlaps_cylinder;
use crate::flags::{ObjectState, PhysicsState};
use crate::math::normalised;
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
    pub(crate) offset: Lanes,
    /// The floor's plane in the frame of the cell's landblock.
    pub(crate) plane: Plane,
    pub(crate) walk_interp: f32,
}

/// A candidate: the origin of its position, its spheres in the frame of the landblock, and where they are relative
/// to the origin. Radii are in the fourth lanes.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) origin: Lanes,
    pub(crate) spheres: [Lanes; 2],
    pub(crate) arms: [Lanes; 2],
    pub(crate) count: usize,
}

impl Candidate {
    /// A mover at a place.
    #[inline(always)]
    pub(crate) fn at(origin: Lanes, arms: &Arms, mover: &Mover) -> Self {
        Candidate {
            origin,
            spheres: [origin + arms.center[0], origin + arms.center[1]],
            arms: arms.center,
            count: mover.spheres().len(),
        }
    }

    /// The radius of its larger sphere, metres.
    #[inline(always)]
    fn larger_radius(&self) -> f32 {
        let [foot, head] = self.arms.map(Lanes::fourth);
        if self.count > 1 && head > foot { head } else { foot }
    }

    #[inline(always)]
    pub(crate) fn shift(&mut self, v: Lanes) {
        self.origin += v;
        self.spheres[0] += v;
        self.spheres[1] += v;
    }

    /// Its spheres.
    #[inline(always)]
    pub(crate) fn spheres(&self) -> [Sphere; 2] {
        self.spheres.map(Sphere::from)
    }

    /// Sphere `i` in a local frame, as polygons see it (retail `cache_localspace_sphere`).
    #[inline(always)]
    pub(crate) fn local(&self, frame: &Frame, i: usize) -> Lanes {
        let radius = self.arms[i].fourth();
        let center = frame.turned_in(self.origin + self.arms[i] - Lanes::from(frame.origin));
        center.with_fourth(radius)
    }

    /// Whether another pose is less than `distance` away.
    #[inline(always)]
    pub(crate) fn is_within(&self, pose: &Candidate, distance: f32) -> bool {
        let shift = pose.spheres[0] - self.spheres[0];
        shift.dot(shift) < distance * distance
    }

    /// Whether an insertion finds nothing of a part of a static object.
    fn clears_part(&self, frame: &Frame, bsp: &PhysicsBsp, bound: &Sphere, placing: bool) -> bool {
        let local = [self.local(frame, 0), self.local(frame, 1)];
        let local = local.get(..self.count).unwrap_or(&local);
        let reached = local
            .iter()
            .any(|&s| bsp_tree::spheres_overlap(bound, &s.into()));
        !reached
            || local
                .iter()
                .all(|&s| !bsp_tree::sphere_intersects_solid(bsp, s, placing))
    }

    /// Whether a moving insertion into the cell finds nothing.
    #[inline(always)]
    fn is_clear(&self, cell: &EnvCell) -> bool {
        self.is_in_the_open(cell) || self.overlaps_nothing(cell)
    }

    /// Whether the cell's box of open space holds all spheres.
    #[inline(always)]
    fn is_in_the_open(&self, cell: &EnvCell) -> bool {
        let clear = |s: Lanes| cell.hints.certainly_clear(s, s.fourth());
        clear(self.spheres[0]) && (self.count < 2 || clear(self.spheres[1]))
    }

    #[inline(never)]
    fn overlaps_nothing(&self, cell: &EnvCell) -> bool {
        let Some(bsp) = &cell.structure.physics else {
            return true;
        };
        (0..self.count).all(|i| bsp_tree::overlaps_nothing(bsp, self.local(&cell.frame, i)))
    }

    /// Whether the rest of a step down onto a floor finds nothing of a cell: another attempt, which asks whether the
    /// foot overlaps ground, and the placement insertion, which asks whether any sphere overlaps anything.
    #[inline(always)]
    pub(crate) fn rests_in(&self, cell: &EnvCell) -> bool {
        (cell.hints.open_is_hollow() && self.is_in_the_open(cell)) || self.touches_nothing_solid(cell)
    }

    #[inline(never)]
    fn touches_nothing_solid(&self, cell: &EnvCell) -> bool {
        let Some(bsp) = &cell.structure.physics else {
            return true;
        };
        (0..self.count).all(|i| !bsp_tree::sphere_intersects_solid(bsp, self.local(&cell.frame, i), true))
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
    pub(crate) fn centers(&self) -> [Lanes; 2] {
        self.spheres
    }
}

/// A shift down, metres.
#[inline(always)]
pub(crate) fn down(h: f32) -> Lanes {
    Lanes::from(Vec3::new(0.0, 0.0, -h))
}

/// The search for a floor of the cell in a step down by `h` (6.11.1).
#[inline(always)]
pub(crate) fn search_below<'a>(cell: &EnvCell, at: &Candidate, h: f32, z: f32) -> WalkableSearch<'a> {
    let up = cell.frame.up();
    WalkableSearch {
        sphere: at.local(&cell.frame, 0),
        movement: up * -h,
        up,
        walkable_allowance: z,
        walk_interp: 1.0,
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
    let mut search = search_below(cell, lowered, h, z);
    let (local, up) = (search.sphere, search.up);
    bsp_tree::find_walkable(bsp, &mut search);
    let face = search.found?;
    let plane = Lanes::of_plane(&face.plane);
    let normal = frame.turned_out(plane);
    if normal.z() < z {
        return None;
    }
    if supported {
        let half = search.sphere.fourth() * 0.5;
        if !polygon::check_walkable(face, bsp.edges(face), search.sphere, half, up) {
            return None;
        }
    }
    let offset = frame.turned_out(search.sphere - local);
    lowered.shift(offset);
    if !lowered.rests_in(cell) {
        return None;
    }
    let point = Lanes::ZERO + (Lanes::from(frame.origin) + frame.turned_out(plane * -plane.fourth()));
    Some(OpenFloor {
        offset,
        plane: Plane {
            normal: normal.xyz(),
            d: -normal.dot(point),
        },
        walk_interp: search.walk_interp,
    })
}

/// How far a candidate may be shifted before one of its spheres comes near a static object of a cell, metres.
#[inline(always)]
pub(crate) fn distance_to_statics(lists: &ShadowLists, cell: CellId, pose: &Candidate) -> f32 {
    let larger = pose.larger_radius();
    let mut least = f32::INFINITY;
    for (_, reach) in lists.with_reaches(cell) {
        let d = distance_to_reach(reach, larger, pose);
        least = if d < least { d } else { least };
    }
    least
}

#[inline(always)]
fn distance_to_reach(reach: &StaticReach, larger: f32, pose: &Candidate) -> f32 {
    let center = Lanes::from(reach.sphere);
    let squared = |s: Lanes| {
        let between = s - center;
        between.dot(between)
    };
    let mut nearest = squared(pose.spheres[0]);
    if pose.count > 1 {
        let head = squared(pose.spheres[1]);
        nearest = if head < nearest { head } else { nearest };
    }
    nearest.sqrt() - (reach.sphere.radius + reach.stretch * larger)
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
    pub(crate) low: Lanes,
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
    offset: Lanes,
    built: &mut BuiltArray,
) -> Option<PlainEnd> {
    let contact = carried.contact.as_ref()?;
    let rotation = Lanes::of_rotation(from.frame.rotation());
    let unusual = !carried.on_walkable
        || mover.state.has(ObjectState::IS_VIEWER)
        || mover.physics.has(PhysicsState::MISSILE)
        || contact.cell.is_none()
        || contact.cell.block() != from.cell.block()
        || !rotation.all_equal(Lanes::of_rotation(to.frame.rotation()))
        || carried.last_known.is_some()
        || world.settings().exact;
    if unusual {
        return None;
    }
    let arms = Arms::of(&from.frame, &mover.spheres);
    let mut pose = Candidate::at(from.frame.origin.into(), &arms, mover);
    let mut low = pose.origin + arms.low;

    // The offset, bent; a foot in the floor is pushed out of it first (4.2).
    let wall = match carried.sliding_normal {
        Some(n) => Some(normalised(n).unwrap_or(Vec3::ZERO)).filter(|&n| offset.dot(n.into()) < 0.0),
        None => None,
    };
    let plane = Lanes::of_plane(&contact.plane);
    let v = along_planes(offset, plane, wall);
    if EPSILON * EPSILON > v.dot(v) {
        return None;
    }
    if !contact.is_water {
        let radius = mover.spheres[0].radius;
        let s = plane.dist(pose.spheres[0]);
        if s < radius - EPSILON {
            let z = (radius - s) / contact.plane.normal.z;
            if radius > z.abs() {
                let push = Lanes::from(Vec3::new(0.0, 0.0, z));
                pose.shift(push);
                low += push;
            }
        }
    }
    pose.shift(v);
    // Positions come in by the candidate. The long way says what is not finite.
    let steps = mover.step_up_height + mover.step_down_height;
    let slide = Lanes::new(carried.sliding_normal.unwrap_or(Vec3::ZERO), steps);
    if !(plane + rotation + slide + pose.origin).all_finite() {
        return None;
    }
    let block = world.block(from.cell.block())?;
    let step = PlainStep {
        world,
        population,
        mover,
        from,
        candidate: pose,
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
    let least = distance_to_statics(lists, cell, pose);
    if least > 0.0 {
        return Some(least);
    }
    clears_statics(world, lists, cell, pose, placing).then_some(0.0)
}

/// Whether a pose that is near static objects certainly touches none of them.
fn clears_statics(world: &World, lists: &ShadowLists, cell: CellId, pose: &Candidate, placing: bool) -> bool {
    let larger = pose.larger_radius();
    lists.with_reaches(cell).all(|(r, reach)| {
        if distance_to_reach(reach, larger, pose) > 0.0 {
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
        return !spheres.any(|s| overlaps_sphere(&s, &pose.spheres(), pose.count));
    }
    let place = |c: &CylSphere| CylSphere {
        low_point: place(c.low_point),
        ..*c
    };
    let mut cylinders = shape.cylspheres.iter().map(place);
    !cylinders.any(|c| overlaps_cylinder(&c, &pose.spheres(), pose.count))
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
        lowered.shift(down(h));
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
        let quiet = |s: Lanes| cell.hints.is_quiet(s, s.fourth());
        let [foot, head] = self.candidate.spheres;
        if quiet(foot) && (self.candidate.count < 2 || quiet(head)) {
            scratch.cell_array.start(cell.id, true);
            return TransitHints::QUIET_SHIFT;
        }
        let spheres = self.candidate.spheres();
        let spheres = spheres.get(..self.candidate.count).unwrap_or(&spheres);
        certain_rooms(block, cell, spheres, &mut scratch.cell_array)
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
        statics_around(self.world, lists, cell, pose, placing)
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
        let radius = self.mover.spheres[0].radius;
        let mut h = self.mover.step_down_height;
        if self.candidate.count < 2 && 2.0 * radius < h {
            h = radius / 2.0;
        }
        if 2.0 * radius >= h { h } else { h / 2.0 }
    }

    /// What the sweep comes to, unless it made no progress.
    #[inline(always)]
    pub(crate) fn end(&self, pose: &Candidate, plane: Plane, is_water: bool) -> Option<PlainEnd> {
        let moved = (pose.origin - Lanes::from(self.from.frame.origin)).abs();
        if moved.less(Lanes::splat(EPSILON)) & 0b111 == 0b111 {
            return None;
        }
        Some(PlainEnd {
            origin: pose.origin.xyz(),
            plane,
            is_water,
        })
    }
}
