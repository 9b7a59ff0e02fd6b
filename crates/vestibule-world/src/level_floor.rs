//! A room's only floor, where it is level: what stands on it needs no search (`transition.md` 6.6, 6.11.1).

use glam::Vec3;

use crate::env_cell::EnvCell;
use crate::frame::Frame;
use crate::geometry::BoundingBox;
use crate::lanes::{LaneBox, Lanes};
use crate::physics_bsp::Face;

/// The only polygon of a room that looks up, normal and vertical being exactly its z axis, so that of all arithmetic
/// about it only that along z is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelFloor {
    /// Over or under this, in the landblock's frame, a point is certainly on the inner side of all edges. Endless
    /// along z.
    over: LaneBox,
    /// The floor's plane in the landblock's frame, its `d` in the fourth lane.
    pub plane: Lanes,
    /// What a shift by nothing along the room's x and y comes to in the landblock: zeros with their signs.
    nothing: Lanes,
    /// The room's z axis in the landblock.
    axis: Lanes,
    /// The z of the room's origin in the landblock, metres.
    pub origin_z: f32,
    /// The `d` of the floor's plane in the room, metres.
    pub d: f32,
}

impl Default for LevelFloor {
    fn default() -> Self {
        LevelFloor {
            over: LaneBox::NOTHING,
            plane: Lanes::ZERO,
            nothing: Lanes::ZERO,
            axis: Lanes::ZERO,
            origin_z: 0.0,
            d: 0.0,
        }
    }
}

impl LevelFloor {
    /// Whether a point in the landblock's frame is certainly over or under the floor. Never so where there is none.
    #[inline(always)]
    pub fn is_around(&self, p: Lanes) -> bool {
        self.over.holds(p)
    }

    /// A shift by `z` along the room's z axis, in the landblock's frame; the bits are those of [`Frame::turned_out`].
    #[inline(always)]
    pub fn shift_by(&self, z: f32) -> Lanes {
        self.nothing + self.axis * z
    }

    /// The level floor of a room, if it has one.
    pub(crate) fn of(cell: &EnvCell) -> Self {
        Self::find(cell).unwrap_or_default()
    }

    fn find(cell: &EnvCell) -> Option<Self> {
        let face = cell.structure.physics.as_ref()?.only_face_up()?;
        let frame = &cell.frame;
        let [x, y, z] = *frame.axes();
        let upright = x.z == 0.0 && y.z == 0.0 && z == Vec3::Z && face.plane.normal == Vec3::Z;
        if !(upright && face.sound && face.plane.d.is_finite() && frame.origin.is_finite()) {
            return None;
        }
        let [x, y, z] = [x, y, z].map(Lanes::from);
        Some(LevelFloor {
            over: over(frame, face)?,
            plane: frame.plane_out(&face.plane),
            nothing: x * 0.0 + y * 0.0,
            axis: z,
            origin_z: frame.origin.z,
            d: face.plane.d,
        })
    }
}

/// The largest of some boxes square to the landblock that lie over a face's inside, upright in its frame.
fn over(frame: &Frame, face: &Face) -> Option<LaneBox> {
    /// Many times the rounding of coordinates up to [`MAX_COORDINATE`], metres.
    const MARGIN: f32 = 1e-3;
    /// Beyond this, f32 is too coarse for that, metres.
    const MAX_COORDINATE: f32 = 512.0;
    let inner = face.inside();
    let flat = BoundingBox {
        min: inner.min.with_z(0.0),
        max: inner.max.with_z(0.0),
    };
    if !(flat.min.cmple(flat.max).all() && flat.min.is_finite() && flat.max.is_finite()) {
        return None;
    }
    let hull = flat.mapped(|p| frame.local_to_global(p));
    let (center, half) = ((hull.min + hull.max) * 0.5, (hull.max - hull.min) * 0.5);
    let lies_inside = |b: &BoundingBox| {
        b.corners().iter().all(|&c| {
            let p = frame.global_to_local(c);
            c.abs().max_element() < MAX_COORDINATE
                && flat.min.x < p.x
                && p.x < flat.max.x
                && flat.min.y < p.y
                && p.y < flat.max.y
        })
    };
    let shrunk = |k: f32| {
        let by = half * k - Vec3::splat(MARGIN);
        BoundingBox {
            min: center - by,
            max: center + by,
        }
    };
    let found = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5]
        .map(shrunk)
        .into_iter()
        .find(lies_inside)?;
    Some(LaneBox::new(&BoundingBox {
        min: found.min.with_z(f32::NEG_INFINITY),
        max: found.max.with_z(f32::INFINITY),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_shift_along_z_has_the_bits_of_a_turn() {
        for i in 0..360 {
            let half = i as f32 * 0.008_726_646;
            let turn = Quat::from_xyzw(0.0, 0.0, libm::sinf(half), libm::cosf(half));
            let frame = Frame::new(Vec3::new(3.0, -0.0, 0.0), turn);
            let [x, y, z] = frame.axes().map(Lanes::from);
            let floor = LevelFloor {
                nothing: x * 0.0 + y * 0.0,
                axis: z,
                ..LevelFloor::default()
            };
            for shift in [0.005, -1.25, 0.0] {
                let turned = frame.turned_out(Vec3::new(0.0, 0.0, shift).into());
                assert!(floor.shift_by(shift).has_bits_of(turned), "{i} {shift}");
            }
        }
    }
}
