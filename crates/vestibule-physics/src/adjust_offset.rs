//! The offset of a step, bent by the plane stood on and the wall slid along (`transition.md` 4.2).

use glam::Vec3;
use vestibule_world::{Lanes, Sphere};

use crate::constants::EPSILON;
use crate::math::normalised;
use crate::transition::Transition;

impl Transition<'_, '_> {
    /// The offset of the next step. Uses the planes that the last step left; may push the candidate out of the
    /// contact plane, which is not part of the offset.
    pub(crate) fn adjust_offset(&mut self, v: Vec3) -> Vec3 {
        let s = self.info.sliding.normal;
        let slide = self.info.sliding.valid && v.dot(s) < 0.0;
        self.info.sliding.valid = slide;
        if !self.info.contact.valid {
            return if slide { v - s * v.dot(s) } else { v };
        }
        let plane = Lanes::of_plane(&self.info.contact.plane);
        let adjusted = along_planes(v.into(), plane, slide.then_some(s)).xyz();
        self.safety_push();
        adjusted
    }

    /// Lifts a foot sphere that is in the contact plane. Water is left out: a body legitimately stands in it.
    fn safety_push(&mut self) {
        let contact = &self.info.contact;
        if contact.is_water || contact.cell.is_none() {
            return;
        }
        let foot = Sphere::from(self.path.global_sphere[0]);
        let n = contact.plane.normal;
        let center = foot.center - self.blk(self.path.check_pos.cell, contact.cell);
        let s = contact.plane.dist(center);
        if s < foot.radius - EPSILON {
            let z = (foot.radius - s) / n.z;
            if foot.radius > z.abs() {
                self.path.add_offset_to_check_pos(Vec3::new(0.0, 0.0, z));
            }
        }
    }
}

/// An offset bent by the plane stood on and the wall slid along, if any.
#[inline(always)]
pub(crate) fn along_planes(v: Lanes, plane: Lanes, wall: Option<Vec3>) -> Lanes {
    let k = v.dot(plane);
    if let Some(s) = wall {
        // Along the crease of floor and wall.
        match normalised(plane.xyz().cross(s)) {
            Some(crease) => (crease * crease.dot(v.xyz())).into(),
            None => Lanes::ZERO,
        }
    } else if k > 0.0 {
        snap_to_plane(v.xyz(), plane.xyz()).into()
    } else {
        v - plane.with_fourth(0.0) * k
    }
}

/// Follows the plane downhill at the full horizontal speed.
#[inline]
fn snap_to_plane(v: Vec3, n: Vec3) -> Vec3 {
    if n.z.abs() > EPSILON {
        Vec3::new(v.x, v.y, -(v.x * n.x + v.y * n.y) / n.z)
    } else {
        v
    }
}
