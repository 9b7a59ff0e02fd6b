//! Stepping up, stepping down and asking for ground (`transition.md` 5.7 to 5.9).

use glam::Vec3;
use vestibule_world::{EnvCell, Landblock, Lanes, PhysicsBsp};

use crate::bsp_tree::Floor;
use crate::candidate::{Candidate, down};
use crate::constants::{
    DEFAULT_STEP_HEIGHT, FLOOR_Z, MAX_INSERTION_DEPTH, STEP_DOWN_ATTEMPTS, Z_FOR_LANDING,
};
use crate::flags::ObjectState;
use crate::plain_step::{plane_of, search_below};
use crate::polygon;
use crate::sphere_path::{CellRef, LocalSpace, Walkable};
use crate::transition::{InsertType, Transition, TransitionState};

/// Where the floor of a room lifts a lowered candidate.
struct Lift<'w> {
    cell: &'w EnvCell,
    block: &'w Landblock,
    bsp: &'w PhysicsBsp,
    floor: Floor<'w>,
    /// The floor's plane in the frame of the cell's landblock.
    plane: Lanes,
    /// What takes the lowered candidate back up.
    offset: Lanes,
    /// The candidate, lifted.
    at: Candidate,
}

impl<'w> Transition<'w, '_> {
    /// Tries to get onto what has the normal `n`. Nothing is lifted here: the search for ground below lifts a
    /// sphere that overlaps it (5.7).
    pub(crate) fn step_up(&mut self, n: Vec3) -> bool {
        self.info.clear_contact_plane();
        self.path.step_up = true;
        self.path.step_up_normal = n;
        let (h, z) = if self.object.is(ObjectState::ON_WALKABLE) {
            (self.object.step_up_height, FLOOR_Z)
        } else {
            (DEFAULT_STEP_HEIGHT, Z_FOR_LANDING)
        };
        self.path.walkable_allowance = z;
        self.path.save_check_pos();
        let ok = !self.has_nothing_to_stand_on(h, z) && self.step_down(h, z);
        self.path.step_up = false;
        self.path.walkable = None;
        if !ok {
            self.path.restore_check_pos();
        }
        ok
    }

    /// Lowers the candidate by `h` and lets ground lift it again. Nothing is restored on failure (5.8).
    pub(crate) fn step_down(&mut self, h: f32, z: f32) -> bool {
        let lift = self.lift_from_below(h, z);
        if let Some(lift) = &lift
            && self.comes_to_rest_on(lift, z)
        {
            self.begin_step_down(h);
            self.lift_onto(lift);
            self.build_cell_array(true);
            return true;
        }
        self.step_down_lifted(lift.as_ref(), h, z)
    }

    /// As [`Transition::step_down`], leaving the polygon stood on to be read.
    pub(crate) fn step_down_onto_walkable(&mut self, h: f32, z: f32) -> bool {
        let lift = self.lift_from_below(h, z);
        self.step_down_lifted(lift.as_ref(), h, z)
    }

    fn begin_step_down(&mut self, h: f32) {
        self.path.neg_poly_hit = None;
        self.path.step_down_amt = h;
        self.path.walk_interp = 1.0;
        if !self.path.step_up {
            self.path.shift(down(h));
        }
    }

    /// What remains of a step down once it is known where the floor of the own room lifts the candidate, if it does.
    fn step_down_lifted(&mut self, lift: Option<&Lift<'w>>, h: f32, z: f32) -> bool {
        self.begin_step_down(h);
        let mut adjusted = 0;
        if let Some(lift) = lift {
            self.lift_onto(lift);
            adjusted = 1;
        }
        self.path.step_down = true;
        let ts = self.insert_adjusted(STEP_DOWN_ATTEMPTS, adjusted);
        self.path.step_down = false;
        if ts != TransitionState::Ok
            || !self.info.contact.valid
            || self.info.contact.plane.normal.z < z
            || !(!self.object.is(ObjectState::EDGE_SLIDE) || self.path.step_up || self.check_walkable(z))
        {
            return false;
        }
        if self.is_placement_certain() {
            self.build_cell_array(true);
            return true;
        }
        let pushed = core::mem::replace(&mut self.path.insert_type, InsertType::Placement);
        let ts = self.insert_once();
        self.path.insert_type = pushed;
        ts == TransitionState::Ok
    }

    /// Where the floor of the candidate's own room lifts it in a step down (6.11.1), the first thing that happens in
    /// it; `None` also where that is not easily told.
    fn lift_from_below(&self, h: f32, z: f32) -> Option<Lift<'w>> {
        let CellRef::Env { cell, block } = self.path.check_cell? else {
            return None;
        };
        let path = &self.path;
        if path.collide
            || !self.keeps_shape
            || path.insert_type != InsertType::Transition
            || path.walkable_allowance != z
            || path.check_walkable
            || self.depth >= MAX_INSERTION_DEPTH
            || cell.restriction.is_some()
            || cell.id != path.check_pos.cell
            || self.world.settings().exact
        {
            return None;
        }
        let (shape, mut at) = (path.shape(), path.candidate());
        if !path.step_up {
            at.shift(down(h));
        }
        let (bsp, floor, local) = search_below(cell, &shape, &at, h, z)?;
        let plane = plane_of(cell, &floor);
        let offset = cell.frame.turned_out(floor.sphere - local);
        at.shift(offset);
        Some(Lift {
            cell,
            block,
            bsp,
            floor,
            plane,
            offset,
            at,
        })
    }

    /// The candidate, lowered, comes to rest on a floor for the time being.
    fn lift_onto(&mut self, lift: &Lift<'w>) {
        self.path.shift(lift.offset);
        self.path.walk_interp = lift.floor.walk_interp;
        self.path.obstruction_ethereal = false;
        self.info.set_contact(lift.plane.plane(), false, lift.cell.id);
        self.path.walkable = Some(Walkable {
            bsp: lift.bsp,
            face: lift.floor.face,
            check_pos: lift.floor.sphere.into(),
            up: lift.cell.frame.up().xyz(),
            space: LocalSpace {
                cell: lift.cell.id,
                frame: &lift.cell.frame,
                scale: 1.0,
            },
        });
    }

    /// Whether a step down certainly ends where the floor lifts the candidate: on walkable ground, touching nothing
    /// else.
    fn comes_to_rest_on(&mut self, lift: &Lift<'w>, z: f32) -> bool {
        let (cell, block, at) = (lift.cell, lift.block, lift.at.spheres[0]);
        let known = self.built.holds(cell.id, at);
        if lift.plane.z() < z
            || !(known || self.built.may_be_certain(cell.id, at))
            || !self.has_no_objects_near(cell.id, block, at)
        {
            return false;
        }
        let shape = self.path.shape();
        let edge_slide = self
            .object
            .state
            .has(ObjectState::EDGE_SLIDE | ObjectState::ON_WALKABLE);
        if edge_slide && !self.path.step_up {
            let (face, half) = (lift.floor.face, shape.arms[0].fourth() * 0.5);
            let edges = lift.bsp.edges(face);
            if !polygon::check_walkable(face, edges, lift.floor.sphere, half, cell.frame.up()) {
                return false;
            }
        }
        if !lift.at.rests_in(&shape, cell) {
            return false;
        }
        // Having passed its own cell there, the candidate is held against the cells it reaches there in any case.
        if !known && !self.know_cells_at(cell.id, &lift.at) {
            return false;
        }
        let others = self.other_rooms();
        lift.at.rests_beside(&shape, block, others)
            && others
                .iter()
                .all(|other| self.has_no_objects_near(other.id, block, at))
    }

    /// Whether a step up certainly finds no ground: the candidate reaches nothing but rooms, and no floor of any.
    /// Then the step up has been done, in vain.
    fn has_nothing_to_stand_on(&mut self, h: f32, z: f32) -> bool {
        let Some(CellRef::Env { cell, block }) = self.path.check_cell else {
            return false;
        };
        if self.path.collide
            || self.path.insert_type != InsertType::Transition
            || self.depth >= MAX_INSERTION_DEPTH
            || cell.id != self.path.check_pos.cell
            || cell.restriction.is_some()
        {
            return false;
        }
        self.build_cell_array(true);
        if !self.is_array_certain() {
            return false;
        }
        let (shape, at) = (self.path.shape(), self.path.candidate());
        let finds_floor = |cell: &EnvCell| search_below(cell, &shape, &at, h, z).is_some();
        if finds_floor(cell) {
            return false;
        }
        for entry in self.other_rooms() {
            let other = block.env_cell(entry.id);
            let is_bare = |other: &EnvCell| {
                let foot = at.spheres[0];
                other.restriction.is_none()
                    && self.has_no_objects_near(other.id, block, foot)
                    && !finds_floor(other)
            };
            if !other.is_some_and(is_bare) {
                return false;
            }
        }
        self.path.step_down_amt = h;
        self.path.walk_interp = 1.0;
        if !self.has_objects_afar(cell.id, block) && !self.statics_bear_nothing(cell.id, block) {
            return false;
        }
        self.path.neg_poly_hit = None;
        self.path.obstruction_ethereal = false;
        true
    }

    /// Whether a placement insertion of the candidate certainly finds nothing: alone in open space, in contact.
    #[inline(always)]
    fn is_placement_certain(&self) -> bool {
        let Some(CellRef::Env { cell, block }) = self.path.check_cell else {
            return false;
        };
        let path = &self.path;
        let clear = |i: usize| {
            let s = path.global_sphere[i];
            cell.hints.certainly_clear(s, s.fourth())
        };
        self.info.contact.valid
            && self.keeps_shape
            && !path.collide
            && cell.id == path.check_pos.cell
            && cell.restriction.is_none()
            && cell.hints.open_is_hollow()
            && clear(0)
            && (path.num_sphere < 2 || clear(1))
            && self.is_calm()
            && self.has_no_objects_near(cell.id, block, path.global_sphere[0])
    }

    /// Whether there is still ground under the candidate (5.9).
    pub(crate) fn check_walkable(&mut self, z: f32) -> bool {
        if !self.object.is(ObjectState::ON_WALKABLE) || self.check_walkables() {
            return true;
        }
        // Not the shared backup: the caller's is in there.
        let (pos, cell) = (self.path.check_pos, self.path.check_cell);
        self.path.walkable_allowance = z;
        self.path.check_walkable = true;
        let mut h = self.object.step_down_height;
        let r = self.path.foot_radius();
        if self.path.num_sphere < 2 && h > 2.0 * r {
            h = r / 2.0;
        }
        if h > 2.0 * r {
            h /= 2.0;
        }
        self.path.shift(down(h));
        let ts = self.insert_once();
        self.path.check_walkable = false;
        self.path.set_check_pos(pos, cell);
        ts != TransitionState::Ok
    }

    /// Whether the polygon last stood on supports the sphere it was chosen for, at half the radius (2.2.13).
    fn check_walkables(&mut self) -> bool {
        let persistent = self.settings.persistent_walkable_halving;
        let Some(walkable) = &mut self.path.walkable else {
            return true;
        };
        let mut sphere = walkable.check_pos;
        sphere.radius *= 0.5;
        if persistent {
            walkable.check_pos = sphere;
        }
        polygon::check_walkable(
            walkable.face,
            walkable.bsp.edges(walkable.face),
            sphere.into(),
            sphere.radius,
            walkable.up.into(),
        )
    }
}
