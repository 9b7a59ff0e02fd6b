//! Placing a body where none was before (`transition.md` 3.6, 3.7).

use crate::collision_info::CollisionInfo;
use crate::constants::{
    EPSILON, MIN_PLACEMENT_RADIUS, MOVE_ATTEMPTS, PLACEMENT_PI, PLACEMENT_SEARCH_RADIUS,
    TINY_PLACEMENT_RADIUS, Z_FOR_LANDING,
};
use crate::math::heading_to_vector;
use crate::obj_collisions::Target;
use crate::transition::{InsertType, Transition, TransitionState};

/// The rings of probes around a place that is taken (3.6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlacementSpiral {
    /// Number of rings.
    pub(crate) rings: u32,
    /// Distance between rings, metres.
    pub(crate) ring: f32,
    /// What each ring adds to half its number of probes.
    pub(crate) angle: f32,
}

impl PlacementSpiral {
    /// The spiral of a mover with foot radius `r`; `None` when the mover is too large to search.
    pub(crate) fn new(r: f32) -> Option<Self> {
        let r = if r <= EPSILON { EPSILON } else { r };
        let (reach, r, q) = if r < TINY_PLACEMENT_RADIUS {
            (
                PLACEMENT_SEARCH_RADIUS / 2.0,
                r,
                0.5 * PLACEMENT_SEARCH_RADIUS / r,
            )
        } else {
            let r = if r < MIN_PLACEMENT_RADIUS {
                MIN_PLACEMENT_RADIUS
            } else {
                r
            };
            (PLACEMENT_SEARCH_RADIUS, r, PLACEMENT_SEARCH_RADIUS / r)
        };
        if q <= 1.0 {
            return None;
        }
        let n = q.ceil();
        let ring = reach / n;
        Some(PlacementSpiral {
            rings: n as u32,
            ring,
            angle: PLACEMENT_PI * ring / r,
        })
    }

    /// Number of probes of ring `k` from 1, given the angle summed up to it.
    pub(crate) fn probes(angle: f32) -> u32 {
        2 * angle.ceil() as u32
    }
}

impl<'w> Transition<'w, '_> {
    /// Places the mover at the current pose, next to it when that is taken and sliding is allowed, and settles
    /// it on the ground.
    pub(crate) fn find_placement_position(&mut self) -> bool {
        self.path.set_check_to_curr();
        self.path.insert_type = InsertType::InitialPlacement;
        let ts = self.insert_and_check_others();
        if self.validate_placement(ts, true) != TransitionState::Ok {
            return false;
        }
        self.path.insert_type = InsertType::Placement;
        if !self.find_placement_pos() {
            return false;
        }
        if self.object.step_down {
            self.settle();
        }
        self.validate_placement(TransitionState::Ok, true) == TransitionState::Ok
    }

    /// Steps down onto the ground; landing ground will do, however steep (3.6.5).
    fn settle(&mut self) {
        self.path.walkable_allowance = Z_FOR_LANDING;
        self.path.save_check_pos();
        let pushed = core::mem::replace(&mut self.path.insert_type, InsertType::Transition);
        let r = self.path.foot_radius();
        let mut h = self.object.step_down_height;
        if self.path.num_sphere < 2 && 2.0 * r < h {
            h = r / 2.0;
        }
        let settled = if 2.0 * r >= h {
            self.step_down(h, Z_FOR_LANDING)
        } else {
            h /= 2.0;
            self.step_down(h, Z_FOR_LANDING) || self.step_down(h, Z_FOR_LANDING)
        };
        if !settled {
            self.path.restore_check_pos();
            self.info.clear_contact_plane();
        }
        self.path.insert_type = pushed;
        self.path.walkable = None;
    }

    /// Retail `placement_insert`.
    fn insert_and_check_others(&mut self) -> TransitionState {
        let cell = self.path.check_cell;
        if cell.is_none() {
            return TransitionState::Collided;
        }
        match self.insert_into_cell(cell, MOVE_ATTEMPTS) {
            TransitionState::Ok => self.check_other_cells(self.path.check_cell),
            ts => ts,
        }
    }

    fn validate_placement(&mut self, ts: TransitionState, adjust: bool) -> TransitionState {
        if self.path.check_cell.is_none() {
            return TransitionState::Collided;
        }
        match ts {
            TransitionState::Ok => {
                self.path.accept();
                TransitionState::Ok
            }
            TransitionState::Adjusted | TransitionState::Slid if adjust => {
                let ts = self.insert_and_check_others();
                self.validate_placement(ts, false)
            }
            ts => ts,
        }
    }

    fn validate_placement_transition(&mut self, ts: TransitionState) -> TransitionState {
        if self.path.check_cell.is_none() {
            return TransitionState::Collided;
        }
        match ts {
            TransitionState::Ok => self.path.accept(),
            TransitionState::Invalid => {}
            _ if self.path.placement_allows_sliding => {
                // Retail `COLLISIONINFO::init`: the planes and cells of the last known plane stay.
                self.info = CollisionInfo {
                    contact: self.info.contact,
                    last_known: self.info.last_known,
                    ..CollisionInfo::default()
                };
                self.info.contact.valid = false;
                self.info.contact.cell = vestibule_world::CellId::NONE;
                self.info.last_known.valid = false;
                self.touched.clear();
            }
            _ => {}
        }
        ts
    }

    /// Tries the place itself, then rings of places around it.
    fn find_placement_pos(&mut self) -> bool {
        self.path.set_check_to_curr();
        if self.try_placement() {
            return true;
        }
        if !self.path.placement_allows_sliding {
            return false;
        }
        let Some(spiral) = PlacementSpiral::new(self.path.local_sphere[0].radius) else {
            return false;
        };
        let (mut angle, mut dist) = (0.0f32, 0.0f32);
        for _ in 0..spiral.rings {
            dist += spiral.ring;
            angle += spiral.angle;
            let probes = PlacementSpiral::probes(angle);
            for j in 0..probes {
                self.path.set_check_to_curr();
                let heading = j as f32 * 360.0 / probes as f32;
                let offset = self.adjust_offset(heading_to_vector(heading) * dist);
                if offset.dot(offset) >= EPSILON * EPSILON {
                    self.path.add_offset_to_check_pos(offset);
                    if self.try_placement() {
                        return true;
                    }
                }
            }
        }
        false
    }

    fn try_placement(&mut self) -> bool {
        self.info.sliding.valid = false;
        self.info.clear_contact_plane();
        let ts = self.transitional_insert(MOVE_ATTEMPTS);
        self.validate_placement_transition(ts) == TransitionState::Ok
    }

    /// Whether the mover at its place overlaps an object: asked before it stops being ethereal (3.7).
    pub(crate) fn check_collisions(&mut self, target: &Target<'w>) -> bool {
        self.path.insert_type = InsertType::Placement;
        self.path.set_check_to_curr();
        self.find_object_collisions(target) != TransitionState::Ok
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probes(spiral: &PlacementSpiral) -> Vec<u32> {
        let mut angle = 0.0;
        (0..spiral.rings)
            .map(|_| {
                angle += spiral.angle;
                PlacementSpiral::probes(angle)
            })
            .collect()
    }

    #[test]
    fn w64_placement_spiral() {
        let spiral = PlacementSpiral::new(0.48).unwrap();
        assert_eq!(spiral.rings, 9);
        assert!((spiral.ring - 0.444_444_4).abs() < 1e-5 && (spiral.angle - 2.908_888_8).abs() < 1e-5);
        let counts = probes(&spiral);
        assert_eq!(counts, [6, 12, 18, 24, 30, 36, 42, 48, 54]);
        assert_eq!(counts.iter().sum::<u32>(), 270);
        // A smaller mover searches as if it had a radius of 0.48; a tiny one does not.
        assert_eq!(PlacementSpiral::new(0.2), Some(spiral));
        let tiny = PlacementSpiral::new(0.1).unwrap();
        assert_eq!((tiny.rings, &probes(&tiny)[..3]), (20, &[8, 14, 20][..]));
        assert!((tiny.ring - 0.1).abs() < 1e-6 && (tiny.angle - PLACEMENT_PI).abs() < 1e-5);
        assert_eq!(PlacementSpiral::new(4.0), None);
    }
}
