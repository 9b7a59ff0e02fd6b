//! The usual step, worked out without a transition: a walker over a floor or on terrain, also beside walls
//! ([`crate::plain_walls`]) and where several cells are touched, staying in its own (`transition.md` 3.5, 5.1, 5.6, 5.8).
//!
//! Where everything that could interfere is certainly out of reach, the rules come down to a few: the offset is
//! bent by the plane stood on, the candidate is lowered, it is moved back onto the ground, and the ground must
//! support it. The arithmetic is that of the rules, in their order; where one is not certain to apply, the
//! answer is `None` and the sweep goes the long way.

use glam::Vec3;
use vestibule_world::{
    CellArray, CellId, EnvCell, Landblock, Lanes, LevelFloor, PhysicsBsp, Position, SURE_OVERLAP, World,
    certain_crossing, certain_rooms,
};

use crate::adjust_offset::along_planes;
use crate::bsp_tree::{self, Floor};
use crate::candidate::{Candidate, Shape, down};
use crate::collision_info::sliding_normal;
use crate::constants::{EPSILON, FLOOR_Z, POLYGON_INTERP_LIMIT};
use crate::flags::{ObjectState, PhysicsState};
use crate::math::normalised;
use crate::plain_land::plain_step_on_land;
use crate::plain_walls::{Known, Slide};
use crate::polygon;
use crate::population::Population;
use crate::sphere_path::Arms;
use crate::statics_around::distance_to_statics;
use crate::sweep::{Carried, ContactPlane, Mover, Scratch, Swept};

/// The floor of a cell that the foot sphere is lifted onto in a step down by `h`, level enough by `z` (6.11.1).
#[inline(always)]
pub(crate) fn search_below<'b>(
    cell: &'b EnvCell,
    shape: &Shape,
    at: &Candidate,
    h: f32,
    z: f32,
) -> Option<(&'b PhysicsBsp, Floor<'b>, Lanes)> {
    let bsp = cell.structure.physics.as_ref()?;
    let up = cell.frame.up();
    let local = at.local(shape, &cell.frame, 0);
    let floor = bsp_tree::find_floor(bsp, local, up * -h, up, z)?;
    Some((bsp, floor, local))
}

/// The plane stood on when a step down by `h` finds a floor of the cell and nothing is in the way of the candidate lifted
/// onto it (5.8). `lowered` has been lowered and is lifted; `supported`: the floor must support the
/// foot sphere. Whether any cell or object has room for the lifted candidate is for the caller to see
/// ([`Candidate::rests_in`]).
#[inline(always)]
pub(crate) fn find_open_floor(
    cell: &EnvCell,
    shape: &Shape,
    lowered: &mut Candidate,
    h: f32,
    z: f32,
    supported: bool,
) -> Option<Lanes> {
    let level = cell.hints.level_floor();
    if level.is_around(lowered.spheres[0])
        && let Some(floor) = rest_on_level_floor(level, shape, lowered, h, z)
    {
        return Some(floor);
    }
    let frame = &cell.frame;
    let (bsp, floor, local) = search_below(cell, shape, lowered, h, z)?;
    let face = floor.face;
    let plane = plane_of(cell, &floor);
    if plane.z() < z {
        return None;
    }
    lowered.shift(frame.turned_out(floor.sphere - local));
    if supported {
        let half = shape.arms[0].fourth() * 0.5;
        if !polygon::check_walkable(face, bsp.edges(face), floor.sphere, half, frame.up())
            && !has_ground_below(cell, *shape, *lowered, h, z)
        {
            return None;
        }
    }
    Some(plane)
}

/// The plane of a floor of a cell, in the frame of the landblock.
#[inline(always)]
pub(crate) fn plane_of(cell: &EnvCell, floor: &Floor<'_>) -> Lanes {
    match cell.hints.only_floor() {
        Some(plane) if floor.only => plane,
        _ => cell.frame.plane_out(&floor.face.plane),
    }
}

/// Whether some floor of a room supports a candidate once it is lowered by `h` (5.9). This is asked of the room before
/// it is asked of anything else.
#[inline(never)]
pub(crate) fn has_ground_below(cell: &EnvCell, shape: Shape, at: Candidate, h: f32, z: f32) -> bool {
    let mut lowered = at;
    lowered.shift(down(h));
    cell.structure.physics.as_ref().is_some_and(|bsp| {
        let foot = lowered.local(&shape, &cell.frame, 0);
        bsp_tree::hits_walkable(bsp, &foot.into(), cell.frame.up().xyz(), z)
    })
}

/// As [`find_open_floor`] over a level floor, which supports what rests on it: the arithmetic of
/// [`bsp_tree::find_floor`] less products with zero. `None`: not by it alone.
#[inline(always)]
fn rest_on_level_floor(
    level: &LevelFloor,
    shape: &Shape,
    lowered: &mut Candidate,
    h: f32,
    allowance: f32,
) -> Option<Lanes> {
    let radius = shape.arms[0].fourth();
    let reach = radius - EPSILON;
    let z = lowered.origin.z() + shape.arms[0].z() - level.origin_z;
    let s = z + level.d;
    // Deep enough for a walk to reach it, level enough, and steep faces do not matter.
    let found = s.abs() <= radius - (SURE_OVERLAP + EPSILON) && 1.0 > allowance && allowance > 0.08;
    if !(found && h > EPSILON && level.plane.z() >= allowance) {
        return None;
    }
    let a = (s - radius) / -h;
    let walk_interp = 1.0 - a;
    let rested = z - -h * a;
    let allowed = (POLYGON_INTERP_LIMIT..1.0).contains(&walk_interp);
    if !allowed || !(reach < (rested + level.d).abs()) {
        return None;
    }
    lowered.shift(level.shift_by(rested - z));
    Some(level.plane)
}

/// Where a usual step ends: on walkable ground.
pub(crate) struct PlainEnd {
    pub(crate) cell: CellId,
    pub(crate) origin: Lanes,
    /// What it stands on; its `d` in the fourth lane.
    pub(crate) plane: Lanes,
    pub(crate) plane_cell: CellId,
    pub(crate) is_water: bool,
    /// What it ran into.
    pub(crate) hit: Option<Vec3>,
    /// It was put back to where it began.
    pub(crate) stopped: bool,
}

impl PlainEnd {
    /// What the sweep comes to (5.11).
    #[inline(always)]
    pub(crate) fn swept(&self, mover: &Mover, carried: &Carried, to: &Position) -> Swept {
        let mut frame = to.frame;
        frame.origin = self.origin.xyz();
        let falls = mover.physics.has(PhysicsState::GRAVITY);
        Swept {
            ok: true,
            cell: Some(self.cell),
            position: Position {
                cell: self.cell,
                frame,
            },
            contact: Some(ContactPlane {
                plane: self.plane.plane(),
                cell: self.plane_cell,
                is_water: self.is_water,
            }),
            on_walkable: true,
            collision_normal: self.hit,
            sliding_normal: self.hit.map(sliding_normal),
            collided_with_environment: false,
            stationary: if falls { 0 } else { carried.stationary },
            velocity_killed: self.stopped,
        }
    }
}

/// What a usual step starts from.
#[derive(Clone, Copy)]
pub(crate) struct PlainStep<'a> {
    pub(crate) world: &'a World,
    pub(crate) population: &'a Population,
    pub(crate) mover: &'a Mover,
    pub(crate) from: &'a Position,
    pub(crate) contact: &'a ContactPlane,
    pub(crate) block: &'a Landblock,
    pub(crate) shape: Shape,
    /// The candidate after the step, before it is inserted.
    pub(crate) candidate: Candidate,
    /// The lowest point of the candidate.
    pub(crate) low: Lanes,
}

/// A sweep of one step by `offset` from `from`, if it is a usual one. `to` says how the mover ends up turned. `found`
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
    found: &mut Option<Known>,
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
    // A call: before there is anything to be kept over it.
    let block = world.block(from.cell.block())?;
    let arms = Arms::of(&from.frame, &mover.spheres);
    let shape = Shape {
        arms: arms.center,
        two: mover.spheres().len() > 1,
    };
    let mut pose = Candidate::at(from.frame.origin.into(), &shape);
    let mut low = pose.origin + arms.low;

    // The offset, bent; a foot in the floor is pushed out of it first (4.2).
    let plane = Lanes::of_plane(&contact.plane);
    let v = match carried.sliding_normal {
        Some(n) => along_wall(offset, plane, n)?,
        None => along_planes(offset, plane, None),
    };
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
    let heights = Lanes::splat(mover.step_up_height + mover.step_down_height);
    if !(plane + rotation + heights + pose.origin).all_finite() {
        return None;
    }
    let step = || PlainStep {
        world,
        population,
        mover,
        from,
        contact,
        block,
        shape,
        candidate: pose,
        low: low + v,
    };
    if !from.cell.is_indoor() {
        return plain_step_on_land(&step(), &mut scratch.cell_array);
    }
    let cell = block.env_cell(from.cell)?;
    if cell.hints.are_calm(pose.spheres) {
        if population.has_bodies() && !population.is_alone_in(cell.id, mover.body) {
            return None;
        }
        let lists = world.shadow_lists(block);
        let quads = lists.quads(cell.id);
        let distance = |pose: &Candidate| match quads.is_empty() {
            true => f32::INFINITY,
            false => distance_to_statics(quads, pose.spheres, shape.larger_radius()),
        };
        let mut objects = distance(&pose);
        if !(objects > 0.0) {
            objects = step().look_at_statics(lists, cell.id, pose, false)?;
        }
        // Touching nothing but the floor: the usual way.
        let h = search_depth(mover, shape.two);
        let mut lowered = pose;
        lowered.shift(down(h));
        let supported = mover.state.has(ObjectState::EDGE_SLIDE);
        if let Some(floor) = find_open_floor(cell, &shape, &mut lowered, h, FLOOR_Z, supported)
            && cell.hints.are_calm(lowered.spheres)
            && (lowered.is_within(pose.spheres[0], objects)
                || distance(&lowered) > 0.0
                || step().look_at_statics(lists, cell.id, lowered, true).is_some())
        {
            scratch.cell_array.start(cell.id, true);
            return end_at(from, cell.id, &lowered, floor, false, None);
        }
    }
    step().in_rooms(cell, scratch, found)
}

/// The offset of a mover that carries a sliding normal (4.2); `None` when that is not finite.
#[inline(never)]
fn along_wall(offset: Lanes, plane: Lanes, sliding: Vec3) -> Option<Lanes> {
    let n = normalised(sliding).unwrap_or(Vec3::ZERO);
    let wall = (offset.dot(n.into()) < 0.0).then_some(n);
    sliding.is_finite().then(|| along_planes(offset, plane, wall))
}

/// See [`Known::cells_of`].
#[inline(never)]
fn know_cells(
    step: PlainStep<'_>,
    cell: &EnvCell,
    at: Candidate,
    mut known: Known,
    array: &mut CellArray,
) -> Known {
    known.cells_of(&step, cell, &at, array);
    known
}

impl PlainStep<'_> {
    /// In a room, and maybe partly in others of the landblock.
    #[inline(never)]
    fn in_rooms(&self, cell: &EnvCell, scratch: &mut Scratch, found: &mut Option<Known>) -> Option<PlainEnd> {
        let to_cells = self.certain_rooms(cell, &self.candidate, &mut scratch.cell_array);
        if !(to_cells > 0.0) {
            return self.cross_into_a_room(cell, &mut scratch.cell_array, found);
        }
        let mut known = Known::cells(&self.candidate, to_cells);
        let end = self.in_certain_rooms(cell, &mut known, &mut scratch.cell_array);
        if end.is_none() {
            *found = Some(known);
        }
        end
    }

    #[inline(always)]
    fn in_certain_rooms(&self, cell: &EnvCell, known: &mut Known, array: &mut CellArray) -> Option<PlainEnd> {
        if cell.restriction.is_some() {
            return None;
        }
        let own = self.candidate.clearance(&self.shape, cell);
        if own < 0.0 {
            return self.beside_walls(cell, known, array);
        }
        let mut beside = f32::INFINITY;
        let mut objects = self.objects_around(cell.id, &self.candidate, false)?;
        for entry in array.entries().get(1..)? {
            let other = self.block.env_cell(entry.id)?;
            if other.restriction.is_some() {
                return None;
            }
            let c = self.candidate.clearance(&self.shape, other);
            if c < 0.0 {
                return self.beside_walls(cell, known, array);
            }
            beside = if c < beside { c } else { beside };
            let d = self.objects_around(other.id, &self.candidate, false)?;
            objects = if d < objects { d } else { objects };
        }
        known.to_objects = objects;
        self.come_to_rest(cell, &self.candidate, [own, beside], known, array, None)
    }

    /// The candidate's foot is in another room, and neither it nor its head is in anybody's way.
    #[inline(never)]
    fn cross_into_a_room(
        &self,
        cell: &EnvCell,
        array: &mut CellArray,
        found: &mut Option<Known>,
    ) -> Option<PlainEnd> {
        // Neither the array here nor what comes after it is for the longer way.
        let mut known = Known::cells(&self.candidate, 0.0);
        *found = Some(known);
        let entered = certain_crossing(self.block, cell, self.candidate.spheres, array)?;
        for entry in array.entries() {
            let other = self.block.env_cell(entry.id)?;
            if other.restriction.is_some() || self.candidate.clearance(&self.shape, other) < 0.0 {
                return None;
            }
            self.objects_around(other.id, &self.candidate, false)?;
        }
        self.come_to_rest(entered, &self.candidate, [0.0; 2], &mut known, array, None)
    }

    /// As [`PlainStep::in_certain_rooms`], not clear of walls.
    #[inline(never)]
    fn beside_walls(&self, cell: &EnvCell, known: &mut Known, array: &mut CellArray) -> Option<PlainEnd> {
        match self.slide_along_walls(cell, known, array)? {
            Slide::To(at, n) => self.come_to_rest(cell, &at, [0.0; 2], known, array, n),
            Slide::Stopped(n) => self.stop(cell, n, known, array),
        }
    }

    /// Looks for the ground below a pose that nothing is in the way of (5.6), given its clearances in the own cell and
    /// in others.
    #[inline(always)]
    fn come_to_rest(
        &self,
        cell: &EnvCell,
        pose: &Candidate,
        [own, beside]: [f32; 2],
        known: &mut Known,
        array: &mut CellArray,
        hit: Option<Vec3>,
    ) -> Option<PlainEnd> {
        let h = self.search_depth();
        let mut lowered = *pose;
        lowered.shift(down(h));
        let supported = self.mover.state.has(ObjectState::EDGE_SLIDE);
        let mut floor = find_open_floor(cell, &self.shape, &mut lowered, h, FLOOR_Z, supported);
        if floor.is_none()
            || !(lowered.is_within(known.objects_at, known.to_objects)
                || self.objects_around(cell.id, &lowered, true).is_some())
        {
            lowered = *pose;
            lowered.shift(down(h));
            floor = self.rest_on_objects(cell, &mut lowered, h);
        }
        let floor = floor?;
        if !((own > 0.0 && lowered.is_within(pose.spheres[0], own)) || lowered.rests_in(&self.shape, cell)) {
            return None;
        }
        let mut beside = beside;
        if !lowered.is_within(known.cells_at[0], known.to_cells) {
            // Lifted onto a step, say.
            *known = know_cells(*self, cell, lowered, *known, array);
            beside = 0.0;
            if !(known.to_cells > 0.0) {
                return None;
            }
        }
        let others = array.entries().get(1..)?;
        if !(others.is_empty()
            || (beside > 0.0 && lowered.is_within(pose.spheres[0], beside))
            || lowered.rests_beside(&self.shape, self.block, others))
        {
            return None;
        }
        if !lowered.is_within(known.objects_at, known.to_objects) {
            let mut all = array.entries().iter();
            if !all.all(|entry| self.objects_around(entry.id, &lowered, true).is_some()) {
                return None;
            }
        }
        end_at(self.from, cell.id, &lowered, floor, false, hit)
    }

    /// Fills the cell array; see [`certain_rooms`].
    #[inline(always)]
    pub(crate) fn certain_rooms(&self, cell: &EnvCell, pose: &Candidate, array: &mut CellArray) -> f32 {
        certain_rooms(self.block, cell, pose.spheres, array)
    }

    /// See [`search_depth`].
    #[inline(always)]
    pub(crate) fn search_depth(&self) -> f32 {
        search_depth(self.mover, self.shape.two)
    }
}

/// How far down ground is looked for at first, metres (5.6).
#[inline(always)]
fn search_depth(mover: &Mover, two: bool) -> f32 {
    let radius = mover.spheres[0].radius;
    let mut h = mover.step_down_height;
    if !two && 2.0 * radius < h {
        h = radius / 2.0;
    }
    if 2.0 * radius >= h { h } else { h / 2.0 }
}

/// What the sweep comes to, unless it made no progress.
#[inline(always)]
pub(crate) fn end_at(
    from: &Position,
    cell: CellId,
    pose: &Candidate,
    plane: Lanes,
    is_water: bool,
    hit: Option<Vec3>,
) -> Option<PlainEnd> {
    let moved = (pose.origin - Lanes::from(from.frame.origin)).abs();
    if moved.less(Lanes::splat(EPSILON)) & 0b111 == 0b111 {
        return None;
    }
    Some(PlainEnd {
        cell,
        origin: pose.origin,
        plane,
        plane_cell: cell,
        is_water,
        hit,
        stopped: false,
    })
}
