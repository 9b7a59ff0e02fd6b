//! Sliding along obstacles (`transition.md` 5.12).

use glam::Vec3;

use crate::constants::EPSILON;
use crate::math::normalised;
use crate::transition::{Transition, TransitionState};

impl Transition<'_, '_> {
    /// Slides the foot sphere along a surface with the global normal `n`.
    #[inline]
    pub(crate) fn slide_foot_sphere(&mut self, n: Vec3) -> TransitionState {
        self.slide_sphere(0, n)
    }

    /// Slides sphere `i` along a surface with the global normal `n` (retail `CSphere::slide_sphere`).
    pub(crate) fn slide_sphere(&mut self, i: usize, n: Vec3) -> TransitionState {
        let center = self.path.center(i);
        let curr = self.path.curr_center(i);
        if n == Vec3::ZERO {
            let offset = self.path.block_offset_curr_check();
            self.path
                .add_offset_to_check_pos(0.5 * (curr - (offset + center)));
            return TransitionState::Adjusted;
        }
        self.info.set_collision_normal(n);
        let g = self.path.block_offset_curr_check() + center - curr;
        let floor = self.slide_plane_normal();
        let crease = n.cross(floor);
        let squared = crease.dot(crease);
        if squared >= EPSILON {
            let along = crease * crease.dot(g) / squared;
            if along.dot(along) < EPSILON {
                return TransitionState::Collided;
            }
            self.path.add_offset_to_check_pos(along - g);
            return TransitionState::Slid;
        }
        if n.dot(floor) >= 0.0 {
            self.path.add_offset_to_check_pos(-n * n.dot(g));
            return TransitionState::Slid;
        }
        // Wedged between floor and ceiling.
        if let Some(back) = normalised(-g) {
            self.info.set_collision_normal(back);
        }
        TransitionState::Collided
    }

    /// The normal of the plane that a slide keeps to: the contact plane, else the last known one.
    #[inline]
    pub(crate) fn slide_plane_normal(&self) -> Vec3 {
        let info = &self.info;
        if info.contact.valid {
            info.contact.plane.normal
        } else if info.last_known.valid || self.settings.stale_last_known_plane {
            info.last_known.plane.normal
        } else {
            Vec3::ZERO
        }
    }

    /// Slides along what could not be stepped onto; without a contact plane, so along the old floor.
    pub(crate) fn step_up_slide(&mut self) -> TransitionState {
        self.info.clear_contact_plane();
        self.path.step_up = false;
        let n = self.path.step_up_normal;
        self.slide_foot_sphere(n)
    }
}
