//! Vectors as the chapter computes them (`transition.md` 1.3, 1.4).

use core::f32::consts::PI;

use glam::{Quat, Vec3};
use vestibule_world::normalise;

use crate::constants::EPSILON;

/// Global up.
pub(crate) const UP: Vec3 = Vec3::Z;

/// Length, by a correctly rounded square root.
#[inline]
pub(crate) fn length(v: Vec3) -> f32 {
    v.dot(v).sqrt()
}

/// `v` at unit length; `None` when it is *small*, shorter than epsilon (retail `normalize_check_small`).
#[inline]
pub(crate) fn normalised(v: Vec3) -> Option<Vec3> {
    let m = length(v);
    if m < EPSILON {
        None
    } else {
        Some(Vec3::new(v.x / m, v.y / m, v.z / m))
    }
}

/// A direction for a heading in degrees: 0 is north, clockwise (`transition.md` 1.4.5).
pub fn heading_to_vector(degrees: f32) -> Vec3 {
    let h = degrees * (PI / 180.0);
    Vec3::new(libm::sinf(h), libm::cosf(h), 0.0)
}

/// The heading of a direction, degrees in 0…360 (`transition.md` 1.4.5).
pub fn vector_to_heading(v: Vec3) -> f32 {
    let degrees = 450.0 - libm::atan2f(v.y, v.x) * (180.0 / PI);
    degrees % 360.0
}

/// The rotation that faces a heading in degrees.
pub fn heading_to_rotation(degrees: f32) -> Quat {
    let half = -degrees * (PI / 360.0);
    Quat::from_xyzw(0.0, 0.0, libm::sinf(half), libm::cosf(half))
}

/// Turns `q` by the rotation vector `w` (radians) given in **global** axes (retail `grotate`,
/// `transition.md` 1.4.4). Shorter vectors than epsilon turn nothing.
pub fn grotate(q: Quat, w: Vec3) -> Quat {
    let angle = length(w);
    if angle < EPSILON {
        return q;
    }
    let (s, c) = (libm::sinf(angle * 0.5), libm::cosf(angle * 0.5));
    let k = s / angle;
    normalise(Quat::from_xyzw(w.x * k, w.y * k, w.z * k, c) * q)
}

/// A rotation between two, `t` from 0 to 1 (`transition.md` 1.4.6).
pub fn interpolate_rotation(from: Quat, to: Quat, t: f32) -> Quat {
    // Turning from a rotation to itself is the usual case and needs no arithmetic.
    if from == to {
        return to;
    }
    let mut c = from.w * to.w + from.x * to.x + from.y * to.y + from.z * to.z;
    let mut target = to;
    if c < 0.0 {
        target = -to;
        c = -c;
    }
    let (mut a, mut b) = (1.0 - t, t);
    if 1.0 - c > EPSILON {
        let theta = libm::acosf(c);
        let sine = libm::sinf(theta);
        let (wa, wb) = (libm::sinf((1.0 - t) * theta) / sine, libm::sinf(t * theta) / sine);
        if (0.0..=1.0).contains(&wa) && (0.0..=1.0).contains(&wb) {
            (a, b) = (wa, wb);
        }
    }
    normalise(from * a + target * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn w63_a_quarter_turn_interpolates_to_an_eighth() {
        let h = core::f32::consts::FRAC_1_SQRT_2;
        let to = Quat::from_xyzw(0.0, 0.0, h, h);
        let q = interpolate_rotation(Quat::IDENTITY, to, 0.5);
        assert!((q.w - 0.923_879_5).abs() < 1e-5 && (q.z - 0.382_683_4).abs() < 1e-5);
        // The shorter way round.
        let q = interpolate_rotation(Quat::IDENTITY, -to, 0.5);
        assert!((q.w.abs() - 0.923_879_5).abs() < 1e-5 && (q.z.abs() - 0.382_683_4).abs() < 1e-5);
    }

    #[test]
    fn w63_headings() {
        let facing = |q: Quat| vector_to_heading(q * Vec3::Y);
        assert_eq!(facing(Quat::IDENTITY), 0.0);
        let h = core::f32::consts::FRAC_1_SQRT_2;
        assert!((facing(Quat::from_xyzw(0.0, 0.0, h, h)) - 270.0).abs() < 1e-3);
        assert!((facing(heading_to_rotation(123.0)) - 123.0).abs() < 1e-3);
        assert!((vector_to_heading(heading_to_vector(40.0)) - 40.0).abs() < 1e-3);
    }

    #[test]
    fn s1_4_4_grotate_turns_about_global_axes() {
        let q = grotate(heading_to_rotation(90.0), Vec3::new(0.0, 0.0, PI / 2.0));
        assert!((vector_to_heading(q * Vec3::Y)).abs() < 1e-3);
        assert_eq!(grotate(Quat::IDENTITY, Vec3::splat(1e-5)), Quat::IDENTITY);
    }

    #[test]
    fn s1_3_1_small_vectors_have_no_direction() {
        assert_eq!(normalised(Vec3::new(0.000_19, 0.0, 0.0)), None);
        assert_eq!(normalised(Vec3::new(0.000_21, 0.0, 0.0)), Some(Vec3::X));
    }
}
