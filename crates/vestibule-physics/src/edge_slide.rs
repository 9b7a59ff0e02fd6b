//! Ledges and cliffs: what happens when no ground is found (`transition.md` 5.10).

use glam::Vec3;

use crate::flags::ObjectState;
use crate::math::normalised;
use crate::polygon;
use crate::transition::{Transition, TransitionState};

impl Transition<'_, '_> {
    /// Keeps the mover off an edge. `true`: the insertion ends with `ts`.
    pub(crate) fn edge_slide(&mut self, ts: &mut TransitionState, h: f32, z: f32) -> bool {
        if !self
            .object
            .state
            .has(ObjectState::ON_WALKABLE | ObjectState::EDGE_SLIDE)
        {
            // Walks off the edge and falls.
            self.give_up_edge();
            *ts = TransitionState::Ok;
            return true;
        }
        if self.info.contact.valid && self.info.contact.plane.normal.z < z {
            let cliff = self.info.contact.plane.normal;
            self.path.walkable = None;
            self.path.restore_check_pos();
            *ts = self.cliff_slide(cliff);
            self.info.clear_contact_plane();
            return false;
        }
        if self.path.walkable.is_some() {
            self.path.restore_check_pos();
            self.info.clear_contact_plane();
            *ts = self.precipice_slide();
            return *ts == TransitionState::Collided;
        }
        if self.info.contact.valid {
            self.give_up_edge();
            *ts = TransitionState::Ok;
            return true;
        }
        self.look_back_for_edge(h, z);
        self.info.clear_contact_plane();
        self.path.restore_check_pos();
        let Some(walkable) = self.path.walkable else {
            *ts = TransitionState::Collided;
            return true;
        };
        self.path.cache_localspace_sphere(walkable.space);
        let foot = self.path.localspace_foot.into();
        if let Some(walkable) = &mut self.path.walkable {
            walkable.check_pos = foot;
        }
        *ts = self.precipice_slide();
        *ts == TransitionState::Collided
    }

    /// Accepts the candidate as it was before the search for ground, without contact.
    fn give_up_edge(&mut self) {
        self.path.walkable = None;
        self.path.restore_check_pos();
        self.info.clear_contact_plane();
    }

    /// Steps down from the last accepted place; only the polygon found matters (case 5).
    fn look_back_for_edge(&mut self, h: f32, z: f32) {
        let back = self.path.curr_center(0) - self.path.center(0);
        let back = if self.settings.retail_missing_block_offsets {
            back
        } else {
            back - self.path.block_offset_curr_check()
        };
        self.path.add_offset_to_check_pos(back);
        self.step_down_onto_walkable(h, z);
    }

    /// Slides along the edge of the polygon last stood on.
    fn precipice_slide(&mut self) -> TransitionState {
        let Some(walkable) = self.path.walkable.take() else {
            return TransitionState::Collided;
        };
        let edges = walkable.bsp.edges(walkable.face);
        let crossed = polygon::find_crossed_edge(walkable.face, edges, &walkable.check_pos, walkable.up);
        let Some(inward) = crossed else {
            return TransitionState::Collided;
        };
        self.path.step_up = false;
        let mut n = walkable.space.frame.local_to_global_vec(inward);
        if n.dot(self.path.foot_displacement()) > 0.0 {
            n = -n;
        }
        self.slide_foot_sphere(n)
    }

    /// Deflects a walker from ground that is too steep.
    fn cliff_slide(&mut self, cliff: Vec3) -> TransitionState {
        let crease = cliff.cross(self.info.last_known.plane.normal);
        let Some(n) = normalised(Vec3::new(-crease.y, crease.x, 0.0)) else {
            return TransitionState::Ok;
        };
        let a = n.dot(self.path.foot_displacement());
        if a > 0.0 {
            self.path.add_offset_to_check_pos(n * -a);
            self.info.set_collision_normal(-n);
        } else {
            // Retail adds the component again instead of taking it away.
            let offset = if self.settings.cliff_slide_doubling {
                n * a
            } else {
                n * -a
            };
            self.path.add_offset_to_check_pos(offset);
            self.info.set_collision_normal(n);
        }
        TransitionState::Adjusted
    }
}
