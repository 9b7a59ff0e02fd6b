//! Inserting the candidate into its cell and the cells around it (`transition.md` 5.1 to 5.6).

use vestibule_world::CellId;

use crate::candidate::Candidate;
use crate::constants::{DEFAULT_STEP_HEIGHT, FLOOR_Z, MAX_INSERTION_DEPTH, Z_FOR_LANDING};
use crate::flags::ObjectState;
use crate::sphere_path::{CellRef, Pose};
use crate::transition::{InsertType, Transition, TransitionState};

/// What an attempt of an insertion starts from.
struct Beginning {
    cell: CellId,
    pose: Candidate,
    /// Not in contact, and no surface was met in the air.
    plain: bool,
}

impl<'w> Transition<'w, '_> {
    /// Tries the candidate up to `n` times, as each attempt may move it (5.1).
    pub(crate) fn transitional_insert(&mut self, n: u32) -> TransitionState {
        self.insert_adjusted(n, 0)
    }

    /// As [`Transition::transitional_insert`] where the first attempt has been adjusted by the own cell already,
    /// `adjusted` times.
    pub(crate) fn insert_adjusted(&mut self, n: u32, adjusted: u32) -> TransitionState {
        if self.path.check_cell.is_none() {
            return TransitionState::Ok;
        }
        if self.depth >= MAX_INSERTION_DEPTH {
            return TransitionState::Collided;
        }
        self.depth += 1;
        let ts = self.insert_attempts(n, adjusted);
        self.depth -= 1;
        ts
    }

    /// As [`Transition::transitional_insert`] with a single attempt.
    pub(crate) fn insert_once(&mut self) -> TransitionState {
        let Some(cell) = self.path.check_cell else {
            return TransitionState::Ok;
        };
        let usual = self.info.contact.valid && !self.path.collide && self.path.neg_poly_hit.is_none();
        if !usual
            || self.depth >= MAX_INSERTION_DEPTH
            || self.path.insert_type == InsertType::InitialPlacement
        {
            return self.transitional_insert(1);
        }
        // Steps up may insert again.
        self.depth += 1;
        let mut ts = self.find_collisions_in_cell(cell);
        match ts {
            TransitionState::Ok => ts = self.check_other_cells(self.path.check_cell),
            TransitionState::Slid => self.info.clear_contact_plane(),
            _ => {}
        }
        self.depth -= 1;
        ts
    }

    fn insert_attempts(&mut self, n: u32, mut adjusted: u32) -> TransitionState {
        let mut ts = TransitionState::Invalid;
        for _ in 0..n {
            let before = self.beginning();
            ts = self.insert_into_cell(self.path.check_cell, n - adjusted);
            adjusted = 0;
            match ts {
                TransitionState::Ok => {
                    // The insertion may have moved the candidate to another cell.
                    ts = self.check_other_cells(self.path.check_cell);
                    if ts != TransitionState::Ok {
                        self.path.neg_poly_hit = None;
                    }
                }
                TransitionState::Slid => {
                    self.info.clear_contact_plane();
                    self.path.neg_poly_hit = None;
                    if self.would_do_the_same_again(&before) {
                        return ts;
                    }
                }
                _ => self.path.neg_poly_hit = None,
            }
            if ts == TransitionState::Collided {
                return ts;
            }
            if ts != TransitionState::Ok {
                continue;
            }
            if self.path.collide {
                return self.land(n);
            }
            let sub_mode = self.path.step_down || self.path.step_up;
            if let (Some(hit), false) = (self.path.neg_poly_hit, sub_mode) {
                self.path.neg_poly_hit = None;
                if hit.step_up {
                    if !self.step_up(hit.normal) {
                        ts = self.step_up_slide();
                    }
                } else {
                    ts = self.slide_foot_sphere(hit.normal);
                }
                if ts == TransitionState::Slid && self.would_do_the_same_again(&before) {
                    return ts;
                }
                continue;
            }
            if self.info.contact.valid
                || !self.object.is(ObjectState::CONTACT)
                || self.path.step_down
                || self.path.check_cell.is_none()
                || !self.object.step_down
            {
                return TransitionState::Ok;
            }
            if let Some(end) = self.search_ground(&mut ts) {
                return end;
            }
        }
        ts
    }

    /// Tests the candidate against one cell, up to `n` times (5.2).
    #[inline(always)]
    pub(crate) fn insert_into_cell(&mut self, cell: Option<CellRef<'w>>, n: u32) -> TransitionState {
        let Some(cell) = cell else {
            return TransitionState::Collided;
        };
        let mut ts = TransitionState::Invalid;
        for _ in 0..n {
            let before = self.beginning();
            ts = self.find_collisions_in_cell(cell);
            match ts {
                TransitionState::Ok | TransitionState::Collided => return ts,
                TransitionState::Slid => {
                    self.info.clear_contact_plane();
                    if self.would_do_the_same_again(&before) {
                        return ts;
                    }
                }
                _ => {}
            }
        }
        ts
    }

    /// What an attempt starts from.
    #[inline(always)]
    fn beginning(&self) -> Beginning {
        Beginning {
            cell: self.path.check_pos.cell,
            pose: self.path.candidate(),
            plain: !self.info.contact.valid && !self.path.collide,
        }
    }

    /// Whether an attempt that slid left everything as it was `before`: another would come to the same.
    #[inline(always)]
    fn would_do_the_same_again(&self, before: &Beginning) -> bool {
        let now = self.beginning();
        now.pose.has_bits_of(&before.pose)
            && now.cell == before.cell
            && now.plain
            && before.plain
            && !self.world.settings().exact
    }

    /// Tests the candidate against the other cells it reaches, and finds the cell that contains it (5.3).
    #[inline(always)]
    pub(crate) fn check_other_cells(&mut self, own: Option<CellRef<'w>>) -> TransitionState {
        if own.is_some_and(|own| own.id() == self.path.check_pos.cell) && self.is_calm() {
            // The own cell is the only one and contains the candidate.
            self.build_cell_array(true);
            self.path.check_cell = own;
            return TransitionState::Ok;
        }
        self.check_any_other_cells(own)
    }

    #[inline(never)]
    fn check_any_other_cells(&mut self, own_cell: Option<CellRef<'w>>) -> TransitionState {
        let own = own_cell.map(|cell| cell.id());
        // A step up below may rebuild the array; the cell found here stays.
        let new_cell = self.build_cell_array(true);
        if new_cell.is_some() && new_cell == own && self.is_calm() {
            self.path.check_cell = own_cell;
            return TransitionState::Ok;
        }
        let mut i = 0;
        while let Some(entry) = self.cell_array.get(i) {
            i += 1;
            if !entry.resident || Some(entry.id) == own {
                continue;
            }
            let Some(cell) = self.cell_ref(entry.id) else {
                continue;
            };
            match self.find_collisions_in_cell(cell) {
                TransitionState::Slid => {
                    self.info.clear_contact_plane();
                    return TransitionState::Slid;
                }
                ts @ (TransitionState::Collided | TransitionState::Adjusted) => return ts,
                _ => {}
            }
        }
        if new_cell.is_some() && new_cell == own && own == Some(self.path.check_pos.cell) {
            self.path.check_cell = own_cell;
            return TransitionState::Ok;
        }
        self.path.check_cell = new_cell.and_then(|id| self.cell_ref(id));
        if let Some(id) = new_cell {
            self.path.adjust_check_pos(id);
            return TransitionState::Ok;
        }
        if self.path.step_down {
            return TransitionState::Collided;
        }
        // The candidate leaves the known world; an interior id passes as it is.
        let mut pos = self.path.check_pos;
        if !pos.cell.is_indoor() {
            match pos.cell.adjust_to_outside(pos.origin()) {
                Some((cell, origin)) => {
                    pos = Pose {
                        cell,
                        origin: origin.into(),
                    }
                }
                None => return TransitionState::Collided,
            }
        }
        if pos.cell.is_none() {
            return TransitionState::Collided;
        }
        self.path.set_check_pos(pos, None);
        TransitionState::Ok
    }

    /// Ends an insertion that met a surface in the air (5.4).
    fn land(&mut self, n: u32) -> TransitionState {
        self.path.collide = false;
        if self.info.contact.valid && self.check_walkable(Z_FOR_LANDING) {
            let pushed = core::mem::replace(&mut self.path.insert_type, InsertType::Placement);
            let ts = self.transitional_insert(n);
            self.path.insert_type = pushed;
            if ts == TransitionState::Ok {
                self.path.walkable = None;
                return TransitionState::Ok;
            }
        }
        self.path.walkable = None;
        self.path.restore_check_pos();
        self.info.clear_contact_plane();
        if self.info.last_known.valid {
            self.info.velocity_killed = true;
            self.info.last_known.valid = false;
        } else {
            let n = self.path.step_up_normal;
            self.info.set_collision_normal(n);
        }
        TransitionState::Collided
    }

    /// Looks for supporting ground below the candidate (5.6). `Some` ends the insertion.
    fn search_ground(&mut self, ts: &mut TransitionState) -> Option<TransitionState> {
        let (z, mut h) = if self.object.is(ObjectState::ON_WALKABLE) {
            (FLOOR_Z, self.object.step_down_height)
        } else {
            (Z_FOR_LANDING, DEFAULT_STEP_HEIGHT)
        };
        self.path.walkable_allowance = z;
        self.path.save_check_pos();
        let r = self.path.foot_radius();
        if self.path.num_sphere < 2 && 2.0 * r < h {
            h = r / 2.0;
        }
        let found = if 2.0 * r >= h {
            self.step_down(h, z)
        } else {
            h /= 2.0;
            // The second half starts where the first one left the candidate.
            self.step_down(h, z) || self.step_down(h, z)
        };
        if found {
            self.path.walkable = None;
            return Some(TransitionState::Ok);
        }
        if self.edge_slide(ts, h, z) {
            Some(*ts)
        } else {
            None
        }
    }
}
