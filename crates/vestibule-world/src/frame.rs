//! Frames: an origin and a rotation from a local to an enclosing frame (`transition.md` 1.4, `world.md` K4).

use glam::{Quat, Vec3};

use crate::geometry::Plane;
use crate::lanes::Lanes;

/// An origin and a rotation that take local coordinates to the enclosing frame (for positions: the frame of
/// the landblock named in the cell id). Metres.
///
/// The rotation matrix is computed once from the quaternion exactly as stored: numbers from records are not
/// renormalised (`dat-format.md` P10).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Where the local origin lies in the enclosing frame, metres.
    pub origin: Vec3,
    rotation: Quat,
    /// The local axes in the enclosing frame. Not in lanes: positions are copied about, and a fourth more is felt.
    rows: [Vec3; 3],
    /// The rows turned: what [`Frame::global_to_local_vec`] multiplies with.
    columns: [Lanes; 3],
}

impl Default for Frame {
    fn default() -> Self {
        Frame::IDENTITY
    }
}

impl Frame {
    /// No displacement, no rotation.
    pub const IDENTITY: Frame = Frame {
        origin: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        rows: [Vec3::X, Vec3::Y, Vec3::Z],
        columns: AXES,
    };

    /// A frame from its parts; the quaternion is used as it is, not normalised.
    pub fn new(origin: Vec3, rotation: Quat) -> Self {
        let rows = rows(rotation);
        Frame {
            origin,
            rotation,
            rows,
            columns: columns(&rows),
        }
    }

    /// An unrotated frame.
    pub fn at(origin: Vec3) -> Self {
        Frame {
            origin,
            ..Frame::IDENTITY
        }
    }

    /// The quaternion that rotates local to enclosing vectors.
    #[inline]
    pub fn rotation(&self) -> Quat {
        self.rotation
    }

    /// Replaces the rotation, keeping the origin.
    pub fn set_rotation(&mut self, rotation: Quat) {
        *self = Frame::new(self.origin, rotation);
    }

    /// The local axes in the enclosing frame.
    #[inline]
    pub fn axes(&self) -> &[Vec3; 3] {
        &self.rows
    }

    /// The enclosing frame's z axis in local coordinates.
    #[inline(always)]
    pub fn up(&self) -> Lanes {
        self.columns[2]
    }

    /// A plane in the enclosing frame, its `d` in the fourth lane: through the foot of the local plane's normal
    /// (`transition.md` 1.5.9).
    #[inline]
    pub fn plane_out(&self, plane: &Plane) -> Lanes {
        let plane = Lanes::of_plane(plane);
        let normal = self.turned_out(plane);
        let foot = Lanes::from(self.origin) + self.turned_out(plane * -plane.fourth());
        // Retail adds the offset between landblocks, here zero, which takes the sign of a zero away.
        normal.with_fourth(-normal.dot(Lanes::ZERO + foot))
    }

    /// A local point in the enclosing frame (retail `localtoglobal`).
    #[inline]
    pub fn local_to_global(&self, p: Vec3) -> Vec3 {
        self.origin + self.local_to_global_vec(p)
    }

    /// A local direction in the enclosing frame (retail `localtoglobalvec`).
    #[inline(always)]
    pub fn local_to_global_vec(&self, v: Vec3) -> Vec3 {
        self.turned_out(v.into()).xyz()
    }

    /// As [`Frame::local_to_global_vec`].
    #[inline(always)]
    pub fn turned_out(&self, v: Lanes) -> Lanes {
        Lanes::combined(&self.rows.map(Lanes::from), v)
    }

    /// A point of the enclosing frame in local coordinates (retail `globaltolocal`).
    #[inline]
    pub fn global_to_local(&self, p: Vec3) -> Vec3 {
        self.global_to_local_vec(p - self.origin)
    }

    /// A direction of the enclosing frame in local coordinates (retail `globaltolocalvec`).
    #[inline(always)]
    pub fn global_to_local_vec(&self, v: Vec3) -> Vec3 {
        self.turned_in(v.into()).xyz()
    }

    /// As [`Frame::global_to_local_vec`].
    #[inline(always)]
    pub fn turned_in(&self, v: Lanes) -> Lanes {
        // Lane i is the dot product with row i, its terms added in order.
        Lanes::combined(&self.columns, v)
    }

    /// `inner`, given in this frame, expressed in the enclosing one; the product is renormalised
    /// (`transition.md` 1.4.3, retail `combine`).
    pub fn combine(&self, inner: &Frame) -> Frame {
        Frame::new(
            self.local_to_global(inner.origin),
            normalise(self.rotation * inner.rotation),
        )
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.origin.is_finite() && self.rotation.is_finite()
    }
}

const AXES: [Lanes; 3] = [
    Lanes::new(Vec3::X, 0.0),
    Lanes::new(Vec3::Y, 0.0),
    Lanes::new(Vec3::Z, 0.0),
];

fn columns(rows: &[Vec3; 3]) -> [Lanes; 3] {
    let [a, b, c] = rows;
    [
        Vec3::new(a.x, b.x, c.x),
        Vec3::new(a.y, b.y, c.y),
        Vec3::new(a.z, b.z, c.z),
    ]
    .map(Lanes::from)
}

/// The quaternion at unit length; the identity when it has none.
pub fn normalise(q: Quat) -> Quat {
    let length = libm::sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    if length > 0.0 && length.is_finite() {
        Quat::from_xyzw(q.x / length, q.y / length, q.z / length, q.w / length)
    } else {
        Quat::IDENTITY
    }
}

/// The local axes in the enclosing frame (`transition.md` 1.4.1).
fn rows(q: Quat) -> [Vec3; 3] {
    let (w, x, y, z) = (q.w, q.x, q.y, q.z);
    [
        Vec3::new(
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ),
        Vec3::new(
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + w * x),
        ),
        Vec3::new(
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let h = core::f32::consts::FRAC_1_SQRT_2;
        let frame = Frame::new(Vec3::new(10.0, 20.0, 0.0), Quat::from_xyzw(0.0, 0.0, h, h));
        assert!((frame.local_to_global(Vec3::X) - Vec3::new(10.0, 21.0, 0.0)).length() < 1e-6);
        assert!((frame.global_to_local(Vec3::new(10.0, 21.0, 0.0)) - Vec3::X).length() < 1e-6);
    }

    #[test]
    fn p10_a_record_quaternion_is_used_as_stored() {
        let q = Quat::from_xyzw(0.0, 0.0, 0.70710677, 0.70710677);
        let frame = Frame::new(Vec3::ZERO, q);
        assert_eq!(frame.rotation().to_array(), q.to_array());
        assert_eq!(frame.axes()[0].x, 1.0 - 2.0 * (q.z * q.z));
    }

    #[test]
    fn combine_renormalises() {
        let off = Quat::from_xyzw(0.0, 0.0, 0.8, 0.61);
        let q = Frame::IDENTITY.combine(&Frame::new(Vec3::ONE, off)).rotation();
        assert!((q.length() - 1.0).abs() < 1e-6);
    }
}
