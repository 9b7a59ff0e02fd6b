//! Accepting or rejecting a step: the only place where a move advances (`transition.md` 5.11).

use glam::Vec3;
use vestibule_world::{Plane, Sphere};

use crate::constants::EPSILON;
use crate::flags::ObjectState;
use crate::math::UP;
use crate::object_info::is_walkable_z;
use crate::transition::{Transition, TransitionState};

/// Steps without progress after which a body is held where it is.
const STUCK: u8 = 3;

impl Transition<'_, '_> {
    /// Accepts the candidate as the current pose, or puts it back to the current pose.
    pub(crate) fn validate_transition(&mut self, ts: TransitionState) -> TransitionState {
        let mut ts = ts;
        let mut progress = false;
        match ts {
            TransitionState::Invalid => {}
            TransitionState::Ok => {
                progress = !self.path.is_check_at_curr();
                self.path.accept();
                self.path.set_check_to_curr();
            }
            TransitionState::Collided | TransitionState::Adjusted | TransitionState::Slid => {
                if self.info.last_known.valid {
                    self.info.velocity_killed = true;
                    if self.touches_last_known_plane() {
                        let last = self.info.last_known;
                        self.info.set_contact(last.plane, last.is_water, last.cell);
                        progress = self.object.is(ObjectState::ON_WALKABLE);
                    }
                }
                if !self.info.collision.valid {
                    self.info.set_collision_normal_up();
                }
                self.path.set_check_to_curr();
                self.build_cell_array(false);
                ts = TransitionState::Ok;
            }
        }
        if let Some(n) = self.info.collision.get() {
            self.info.set_sliding_normal(n);
        }
        if self.object.gravity && !self.object.is(ObjectState::IS_VIEWER) {
            self.count_stationary_fall(progress);
        }
        let contact = self.info.contact;
        self.info.last_known.valid = contact.valid;
        if contact.valid {
            self.info.last_known = contact;
        }
        let walkable = contact.valid && is_walkable_z(contact.plane.normal.z);
        self.object.state.set(ObjectState::CONTACT, contact.valid);
        self.object.state.set(ObjectState::ON_WALKABLE, walkable);
        ts
    }

    /// Whether the last accepted foot sphere still touches the last known plane.
    fn touches_last_known_plane(&self) -> bool {
        let last = &self.info.last_known;
        let center = if self.settings.retail_missing_block_offsets {
            self.path.curr_center(0)
        } else {
            self.path.curr_center(0) - self.blk(self.path.curr_pos.cell, last.cell)
        };
        self.path.foot_radius() + EPSILON > last.plane.dist(center).abs()
    }

    /// A falling body that makes no progress lands where it is after three frames (5.11.7).
    fn count_stationary_fall(&mut self, progress: bool) {
        if progress {
            self.info.frames_stationary_fall = 0;
            return;
        }
        self.info.frames_stationary_fall = match self.info.frames_stationary_fall {
            0 => 1,
            1 => 2,
            _ => STUCK,
        };
        if self.info.frames_stationary_fall == STUCK {
            let foot = Sphere::from(self.path.global_sphere[0]);
            let plane = Plane {
                normal: UP,
                d: foot.radius - foot.center.z,
            };
            self.info.set_contact(plane, false, self.path.check_pos.cell);
            if !self.object.is(ObjectState::CONTACT) {
                self.info.set_collision_normal(Vec3::Z);
                self.info.collided_with_environment = true;
            }
        }
    }
}
