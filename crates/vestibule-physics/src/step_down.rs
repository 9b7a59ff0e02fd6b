//! Stepping up, stepping down and asking for ground (`transition.md` 5.7 to 5.9).

use glam::Vec3;
use vestibule_world::EnvCell;

use crate::candidate::down;
use crate::constants::{
    DEFAULT_STEP_HEIGHT, FLOOR_Z, MAX_INSERTION_DEPTH, STEP_DOWN_ATTEMPTS, Z_FOR_LANDING,
};
use crate::flags::ObjectState;
use crate::plain_step::{find_open_floor, search_below};
use crate::polygon;
use crate::sphere_path::CellRef;
use crate::transition::{InsertType, Transition, TransitionState};

impl Transition<'_, '_> {
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
        self.step_down_in_the_open(h, z) || self.step_down_onto_walkable(h, z)
    }

    /// As [`Transition::step_down`], leaving the polygon stood on to be read.
    pub(crate) fn step_down_onto_walkable(&mut self, h: f32, z: f32) -> bool {
        self.path.neg_poly_hit = None;
        self.path.step_down = true;
        self.path.step_down_amt = h;
        self.path.walk_interp = 1.0;
        if !self.path.step_up {
            self.path.add_offset_to_check_pos(Vec3::new(0.0, 0.0, -h));
        }
        let ts = self.transitional_insert(STEP_DOWN_ATTEMPTS);
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
        let ts = self.transitional_insert(1);
        self.path.insert_type = pushed;
        ts == TransitionState::Ok
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
        if !self.is_array_certain() || !self.has_statics_afar(cell.id, block) {
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
                let center = at.spheres[0].xyz();
                other.restriction.is_none()
                    && self.has_no_objects_near(other.id, block, center)
                    && !finds_floor(other)
            };
            if !other.is_some_and(is_bare) {
                return false;
            }
        }
        self.path.neg_poly_hit = None;
        self.path.step_down_amt = h;
        self.path.walk_interp = 1.0;
        self.path.obstruction_ethereal = false;
        true
    }

    /// As [`Transition::step_down`] where the candidate certainly comes to rest on a floor of its own room, touching
    /// nothing else; otherwise nothing is done. The polygon stood on is not noted.
    fn step_down_in_the_open(&mut self, h: f32, z: f32) -> bool {
        let Some(CellRef::Env { cell, block }) = self.path.check_cell else {
            return false;
        };
        let path = &self.path;
        if path.step_up
            || path.collide
            || !self.keeps_shape
            || path.insert_type != InsertType::Transition
            || path.walkable_allowance != z
            || self.depth >= MAX_INSERTION_DEPTH
            || cell.restriction.is_some()
            || cell.id != path.check_pos.cell
            || !self.is_array_certain()
        {
            return false;
        }
        let (shape, mut lowered) = (path.shape(), path.candidate());
        lowered.shift(down(h));
        let edge_slide = self.object.is(ObjectState::EDGE_SLIDE);
        let supported = edge_slide && self.object.is(ObjectState::ON_WALKABLE);
        let Some(floor) = find_open_floor(cell, &shape, &mut lowered, h, z, supported) else {
            return false;
        };
        let at = lowered.spheres[0].xyz();
        let others = self.other_rooms();
        if !lowered.rests_in(&shape, cell)
            || !self.built.holds(cell.id, lowered.spheres[0])
            || !lowered.rests_beside(&shape, block, others)
            || !self.has_no_objects_near(cell.id, block, at)
            || !others
                .iter()
                .all(|other| self.has_no_objects_near(other.id, block, at))
        {
            return false;
        }
        self.path.neg_poly_hit = None;
        self.path.step_down_amt = h;
        self.path.add_offset_to_check_pos(Vec3::new(0.0, 0.0, -h));
        self.path.shift(floor.offset);
        self.path.walk_interp = floor.walk_interp;
        self.path.obstruction_ethereal = false;
        self.info.set_contact(floor.plane.plane(), false, cell.id);
        self.build_cell_array(true);
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
            && self.has_no_objects_near(cell.id, block, path.center(0))
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
        self.path.add_offset_to_check_pos(Vec3::new(0.0, 0.0, -h));
        let ts = self.transitional_insert(1);
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
