//! What a sweep has touched so far (retail `COLLISIONINFO`, `transition.md` 2.3).

use glam::Vec3;
use vestibule_world::{CellId, Plane};

use crate::math::{UP, normalised};

/// A contact plane slot. Clearing it leaves the plane and its cell, which later rules still read.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlaneSlot {
    pub(crate) valid: bool,
    pub(crate) is_water: bool,
    /// In the frame of the landblock of `cell`.
    pub(crate) plane: Plane,
    pub(crate) cell: CellId,
}

/// A normal that may be set. Set but without direction is the zero vector.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NormalSlot {
    pub(crate) valid: bool,
    pub(crate) normal: Vec3,
}

impl NormalSlot {
    #[inline]
    pub(crate) fn get(&self) -> Option<Vec3> {
        if self.valid { Some(self.normal) } else { None }
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CollisionInfo {
    pub(crate) contact: PlaneSlot,
    pub(crate) last_known: PlaneSlot,
    pub(crate) sliding: NormalSlot,
    pub(crate) collision: NormalSlot,
    pub(crate) collided_with_environment: bool,
    pub(crate) frames_stationary_fall: u8,
    /// The chapter's `kill_velocity`, carried out when the sweep is committed.
    pub(crate) velocity_killed: bool,
}

impl CollisionInfo {
    /// Contact plane and its cell at once.
    #[inline]
    pub(crate) fn set_contact(&mut self, plane: Plane, is_water: bool, cell: CellId) {
        self.contact = PlaneSlot {
            valid: true,
            is_water,
            plane,
            cell,
        };
    }

    /// "Clear the contact plane" (0.2): the stored plane and its cell stay.
    #[inline]
    pub(crate) fn clear_contact_plane(&mut self) {
        self.contact.valid = false;
        self.contact.is_water = false;
    }

    #[inline]
    pub(crate) fn set_collision_normal(&mut self, n: Vec3) {
        self.collision = NormalSlot {
            valid: true,
            normal: collision_normal(n),
        };
    }

    /// The normal is known to have unit length along z.
    #[inline]
    pub(crate) fn set_collision_normal_up(&mut self) {
        self.collision = NormalSlot {
            valid: true,
            normal: UP,
        };
    }

    #[inline]
    pub(crate) fn set_sliding_normal(&mut self, n: Vec3) {
        self.sliding = NormalSlot {
            valid: true,
            normal: sliding_normal(n),
        };
    }

    /// As [`CollisionInfo::set_sliding_normal`], but keeps z.
    #[inline]
    pub(crate) fn init_sliding_normal(&mut self, n: Vec3) {
        self.sliding = NormalSlot {
            valid: true,
            normal: normalised(n).unwrap_or(Vec3::ZERO),
        };
    }

    #[inline]
    pub(crate) fn init_contact_plane(&mut self, plane: Plane, is_water: bool, cell: CellId) {
        self.set_contact(plane, is_water, cell);
        self.last_known = self.contact;
    }

    #[inline]
    pub(crate) fn init_last_known_contact_plane(&mut self, plane: Plane, is_water: bool, cell: CellId) {
        self.last_known = PlaneSlot {
            valid: true,
            is_water,
            plane,
            cell,
        };
    }
}

/// What is noted of the normal of something run into (2.3.3).
#[inline]
pub(crate) fn collision_normal(n: Vec3) -> Vec3 {
    normalised(n).unwrap_or(Vec3::ZERO)
}

/// What the next move slides along after running into something with this normal (2.3.4).
#[inline]
pub(crate) fn sliding_normal(n: Vec3) -> Vec3 {
    normalised(Vec3::new(n.x, n.y, 0.0)).unwrap_or(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn s2_3_3_collision_normals_are_normalised_and_small_ones_are_zero_but_set() {
        let mut info = CollisionInfo::default();
        info.set_collision_normal(Vec3::new(0.0, 0.0, -4.0));
        assert_eq!(info.collision.get(), Some(-Vec3::Z));
        info.set_collision_normal(Vec3::splat(1e-5));
        assert_eq!(info.collision.get(), Some(Vec3::ZERO));
    }

    #[test]
    fn s2_3_4_sliding_normals_are_horizontal_unless_they_came_with_the_body() {
        let mut info = CollisionInfo::default();
        info.set_sliding_normal(Vec3::new(0.6, 0.0, 0.8));
        assert_eq!(info.sliding.get(), Some(Vec3::X));
        info.set_sliding_normal(Vec3::Z);
        assert_eq!(info.sliding.get(), Some(Vec3::ZERO));
        info.init_sliding_normal(Vec3::new(0.0, 3.0, 4.0));
        assert_eq!(info.sliding.get(), Some(Vec3::new(0.0, 0.6, 0.8)));
    }

    #[test]
    fn s0_2_clearing_keeps_the_plane_and_its_cell() {
        let mut info = CollisionInfo::default();
        let plane = Plane {
            normal: Vec3::Z,
            d: -3.0,
        };
        info.set_contact(plane, true, CellId(0xA9B4_0001));
        info.clear_contact_plane();
        assert!(!info.contact.valid && !info.contact.is_water);
        assert_eq!(
            (info.contact.plane, info.contact.cell),
            (plane, CellId(0xA9B4_0001))
        );
    }
}
