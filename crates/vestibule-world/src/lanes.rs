//! Vectors in the four lanes of one register, for what every sweep does. Each operation is that of its lanes, so the
//! bits are those of [`Vec3`], on every target.

use core::ops::{Add, AddAssign, Div, Mul, Sub};

use glam::{Quat, Vec3};
use wide::f32x4;

use crate::geometry::{BoundingBox, Plane, Sphere};

/// A vector of three coordinates and a fourth lane, which is zero unless it is said. Metres where it is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes(f32x4);

impl Default for Lanes {
    fn default() -> Self {
        Lanes::ZERO
    }
}

impl From<Vec3> for Lanes {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Lanes::new(v, 0.0)
    }
}

impl From<Lanes> for Vec3 {
    #[inline(always)]
    fn from(v: Lanes) -> Self {
        v.xyz()
    }
}

impl From<Sphere> for Lanes {
    /// The centre, the radius in the fourth lane.
    #[inline(always)]
    fn from(s: Sphere) -> Self {
        Lanes::new(s.center, s.radius)
    }
}

impl From<Lanes> for Sphere {
    #[inline(always)]
    fn from(s: Lanes) -> Self {
        Sphere::new(s.xyz(), s.fourth())
    }
}

impl Lanes {
    /// Zero in each lane.
    pub const ZERO: Lanes = Lanes(f32x4::ZERO);

    /// A vector and what is in the fourth lane.
    #[inline(always)]
    pub const fn new(v: Vec3, fourth: f32) -> Self {
        Lanes(f32x4::new([v.x, v.y, v.z, fourth]))
    }

    /// The same in each lane.
    #[inline(always)]
    pub const fn splat(v: f32) -> Self {
        Lanes(f32x4::new([v; 4]))
    }

    /// The components of a rotation.
    #[inline(always)]
    pub fn of_rotation(q: Quat) -> Self {
        Lanes(f32x4::new([q.x, q.y, q.z, q.w]))
    }

    /// The same vector with another fourth lane.
    #[inline(always)]
    pub fn with_fourth(self, v: f32) -> Self {
        let [x, y, z, _] = self.0.to_array();
        Lanes(f32x4::new([x, y, z, v]))
    }

    /// A plane's normal, its `d` in the fourth lane.
    #[inline(always)]
    pub fn of_plane(p: &Plane) -> Self {
        Lanes::new(p.normal, p.d)
    }

    /// The plane of [`Lanes::of_plane`].
    #[inline(always)]
    pub fn plane(self) -> Plane {
        let [x, y, z, d] = self.0.to_array();
        Plane {
            normal: Vec3::new(x, y, z),
            d,
        }
    }

    /// The first three lanes.
    #[inline(always)]
    pub fn xyz(self) -> Vec3 {
        let [x, y, z, _] = self.0.to_array();
        Vec3::new(x, y, z)
    }

    /// The third lane.
    #[inline(always)]
    pub fn z(self) -> f32 {
        self.0.to_array()[2]
    }

    /// The fourth lane.
    #[inline(always)]
    pub fn fourth(self) -> f32 {
        self.0.to_array()[3]
    }

    /// The product of the first three lanes, added in their order.
    #[inline(always)]
    pub fn dot(self, other: Lanes) -> f32 {
        let [x, y, z, _] = (self.0 * other.0).to_array();
        x + y + z
    }

    /// The squares of all four lanes, added.
    pub fn squared_length(self) -> f32 {
        let [a, b, c, d] = (self.0 * self.0).to_array();
        a + b + c + d
    }

    /// Distance of a point from the plane that [`Lanes::of_plane`] made of a plane, as [`Plane::dist`].
    #[inline(always)]
    pub fn dist(self, p: Lanes) -> f32 {
        self.dot(p) + self.fourth()
    }

    /// Each lane without its sign.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Lanes(self.0.abs())
    }

    /// Which lanes are less than those of `other`, a bit each.
    #[inline(always)]
    pub fn less(self, other: Lanes) -> u32 {
        self.0.simd_lt(other.0).to_bitmask()
    }

    /// Which lanes are not greater than those of `other`, a bit each.
    #[inline(always)]
    pub fn at_most(self, other: Lanes) -> u32 {
        self.0.simd_le(other.0).to_bitmask()
    }

    /// Which lanes are equal to those of `other`, as numbers are, a bit each.
    #[inline(always)]
    pub fn equal(self, other: Lanes) -> u32 {
        self.0.simd_eq(other.0).to_bitmask()
    }

    /// Whether all four lanes are equal, as numbers are.
    #[inline(always)]
    pub fn all_equal(self, other: Lanes) -> bool {
        self.0.simd_eq(other.0).to_bitmask() == 0b1111
    }

    /// Whether the first three lanes have the same bits.
    #[inline(always)]
    pub fn has_bits_of(self, other: Lanes) -> bool {
        let differ = self.0 ^ other.0;
        let [a, b, c, _] = differ.to_array().map(f32::to_bits);
        a | b | c == 0
    }

    /// Whether the first two lanes are equal, as numbers are.
    #[inline(always)]
    pub fn has_xy_of(self, other: Lanes) -> bool {
        self.0.simd_eq(other.0).to_bitmask() & 0b11 == 0b11
    }

    /// Whether all four lanes are finite.
    #[inline(always)]
    pub fn all_finite(self) -> bool {
        // A number times zero is zero unless it is not finite.
        (self.0 * f32x4::ZERO).simd_eq(f32x4::ZERO).to_bitmask() == 0b1111
    }

    /// Distances of a point from four planes whose coefficients lie side by side, as [`Plane::dist`] of each.
    #[inline(always)]
    pub fn four_distances(planes: &[Lanes; 4], p: Lanes) -> Lanes {
        let [px, py, pz, _] = p.0.to_array();
        let [x, y, z, d] = planes;
        Lanes(x.0 * f32x4::splat(px) + y.0 * f32x4::splat(py) + z.0 * f32x4::splat(pz) + d.0)
    }

    /// The coefficients of four planes side by side, for [`Lanes::four_distances`].
    pub fn side_by_side(planes: [Plane; 4]) -> [Lanes; 4] {
        let of = |f: fn(&Plane) -> f32| {
            Lanes(f32x4::new([
                f(&planes[0]),
                f(&planes[1]),
                f(&planes[2]),
                f(&planes[3]),
            ]))
        };
        [
            of(|p| p.normal.x),
            of(|p| p.normal.y),
            of(|p| p.normal.z),
            of(|p| p.d),
        ]
    }

    /// The lesser of both in each lane; `other` where a lane is no number.
    #[inline(always)]
    pub fn lesser(self, other: Lanes) -> Lanes {
        Lanes(self.0.fast_min(other.0))
    }

    /// The greater of both in each lane; `other` where a lane is no number.
    #[inline(always)]
    pub fn greater(self, other: Lanes) -> Lanes {
        Lanes(self.0.fast_max(other.0))
    }

    /// The products of the lanes.
    #[inline(always)]
    pub fn times(self, other: Lanes) -> Lanes {
        Lanes(self.0 * other.0)
    }

    /// The square roots of the lanes.
    #[inline(always)]
    pub fn sqrt(self) -> Lanes {
        Lanes(self.0.sqrt())
    }

    /// The least of all four lanes.
    #[inline(always)]
    pub fn least(self) -> f32 {
        let [a, b, c, d] = self.0.to_array();
        let lesser = |a: f32, b: f32| if a < b { a } else { b };
        lesser(lesser(a, b), lesser(c, d))
    }

    /// Lane `i`, 0 to 3.
    #[inline(always)]
    pub fn lane(self, i: usize) -> f32 {
        self.0.to_array()[i & 3]
    }

    /// Replaces lane `i`, 0 to 3.
    #[inline(always)]
    pub fn set_lane(&mut self, i: usize, v: f32) {
        let mut lanes = self.0.to_array();
        lanes[i & 3] = v;
        self.0 = f32x4::new(lanes);
    }

    /// The vectors scaled by the components of `v` and added in order: a turn by the matrix whose rows, or columns,
    /// they are.
    #[inline(always)]
    pub fn combined(vectors: &[Lanes; 3], v: Lanes) -> Lanes {
        let [x, y, z, _] = v.0.to_array();
        let [a, b, c] = vectors;
        Lanes(f32x4::splat(x) * a.0 + f32x4::splat(y) * b.0 + f32x4::splat(z) * c.0)
    }
}

impl Add for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn add(self, other: Lanes) -> Lanes {
        Lanes(self.0 + other.0)
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Lanes) {
        self.0 += other.0;
    }
}

impl Sub for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn sub(self, other: Lanes) -> Lanes {
        Lanes(self.0 - other.0)
    }
}

impl Div<f32> for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn div(self, k: f32) -> Lanes {
        Lanes(self.0 / f32x4::splat(k))
    }
}

impl Mul<f32> for Lanes {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, k: f32) -> Lanes {
        Lanes(self.0 * f32x4::splat(k))
    }
}

/// An axis-aligned box, to be held against points and spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneBox {
    min: Lanes,
    max: Lanes,
}

impl LaneBox {
    /// Holds nothing.
    pub const NOTHING: LaneBox = LaneBox {
        min: Lanes::new(Vec3::INFINITY, f32::INFINITY),
        max: Lanes::new(Vec3::NEG_INFINITY, f32::NEG_INFINITY),
    };

    /// The box with these corners.
    pub const fn new(b: &BoundingBox) -> Self {
        LaneBox {
            min: Lanes::new(b.min, f32::NEG_INFINITY),
            max: Lanes::new(b.max, f32::INFINITY),
        }
    }

    /// The corners.
    pub fn bounds(&self) -> BoundingBox {
        BoundingBox {
            min: self.min.xyz(),
            max: self.max.xyz(),
        }
    }

    /// The same box with limits of the fourth lane.
    pub(crate) fn with_fourth(self, min: f32, max: f32) -> Self {
        LaneBox {
            min: self.min.with_fourth(min),
            max: self.max.with_fourth(max),
        }
    }

    /// Whether the centres of two spheres, radii in the fourth lanes, are inside, along z all of them but the outermost
    /// `skin`, metres. The fourth lanes count.
    #[inline(always)]
    pub(crate) fn hold_upright(&self, [a, b]: [Lanes; 2], skin: f32) -> bool {
        let reach = |s: Lanes| Lanes::from(Vec3::new(0.0, 0.0, s.fourth() - skin)).0;
        let (ra, rb) = (reach(a), reach(b));
        let low = (a.0 - ra).simd_gt(self.min.0) & (b.0 - rb).simd_gt(self.min.0);
        let high = (a.0 + ra).simd_lt(self.max.0) & (b.0 + rb).simd_lt(self.max.0);
        (low & high).to_bitmask() == 0b1111
    }

    /// How deep a point is inside, metres: the least distance from a face, below zero outside.
    #[inline(always)]
    pub fn depth(&self, p: Lanes) -> f32 {
        (p - self.min).lesser(self.max - p).least()
    }

    /// Whether a point is inside, the faces left out. The fourth lane does not count, but must be a number.
    #[inline(always)]
    pub fn holds(&self, p: Lanes) -> bool {
        (p.0.simd_gt(self.min.0) & p.0.simd_lt(self.max.0)).to_bitmask() == 0b1111
    }

    /// Whether the cube around a point, `r` to each side, is inside.
    #[inline(always)]
    pub fn holds_cube(&self, p: Lanes, r: f32) -> bool {
        let r = f32x4::splat(r);
        ((p.0 - r).simd_gt(self.min.0) & (p.0 + r).simd_lt(self.max.0)).to_bitmask() == 0b1111
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Vec3 = Vec3::new(0.1, -2.3, 1e3);
    const B: Vec3 = Vec3::new(7.7, 0.3, 1e-3);

    #[test]
    fn lanes_compute_the_bits_of_vectors() {
        let (a, b) = (Lanes::from(A), Lanes::from(B));
        assert_eq!((a + b).xyz(), A + B);
        assert_eq!((a - b).xyz(), A - B);
        assert_eq!(((a * 0.3).xyz(), (a / 0.3).xyz()), (A * 0.3, A / 0.3));
        assert_eq!(a.abs().xyz(), A.abs());
        assert_eq!(a.dot(b), A.dot(B));
        let plane = Plane { normal: B, d: 0.7 };
        assert_eq!(Lanes::of_plane(&plane).dist(a), plane.dist(A));
        let four = Lanes::four_distances(&[B.x, B.y, B.z, 0.7].map(Lanes::splat), a);
        assert_eq!(four, Lanes::splat(plane.dist(A)));
        let turned = Lanes::combined(&[b, a, b], a).xyz();
        assert_eq!(turned, A.x * B + A.y * A + A.z * B);
    }

    #[test]
    fn a_box_leaves_out_its_faces_and_nans() {
        let b = LaneBox::new(&BoundingBox {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        });
        let at = |x: f32| Lanes::new(Vec3::new(0.5, 0.5, x), 5.0);
        assert!(b.holds(at(0.5)) && b.holds_cube(at(0.5), 0.49));
        for x in [0.0, 1.0, -1.0, f32::NAN] {
            assert!(!b.holds(at(x)) && !b.holds_cube(at(x), 0.1), "{x}");
        }
        assert!(!b.holds_cube(at(0.5), 0.5) && !LaneBox::NOTHING.holds(at(0.5)));
        assert_eq!(b.bounds().max, Vec3::ONE);
    }

    #[test]
    fn lanes_are_told_apart() {
        let (a, b) = (Lanes::new(A, 4.0), Lanes::new(B, 5.0));
        assert_eq!((a.less(b), a.equal(a.with_fourth(5.0))), (0b1011, 0b0111));
        assert_eq!((b.at_most(a), a.at_most(a)), (0b0100, 0b1111));
        assert_eq!(Lanes::splat(f32::NAN).at_most(a), 0);
        assert_eq!(a.lesser(b), Lanes::new(Vec3::new(0.1, -2.3, 1e-3), 4.0));
        assert_eq!(a.greater(b), Lanes::new(Vec3::new(7.7, 0.3, 1e3), 5.0));
        assert_eq!(
            (a.least(), a.lane(2), a.with_fourth(9.0).fourth()),
            (-2.3, 1e3, 9.0)
        );
        let mut c = a;
        c.set_lane(3, 7.0);
        assert_eq!(c, a.with_fourth(7.0));
        assert!(a.has_bits_of(c) && !a.has_bits_of(b) && a.has_xy_of(a) && !a.has_xy_of(b));
        assert!(Lanes::ZERO.has_xy_of(Lanes::splat(-0.0)) && !Lanes::ZERO.has_bits_of(Lanes::splat(-0.0)));
        // What is no number is not kept.
        assert_eq!(Lanes::splat(f32::NAN).lesser(b), b);
        assert_eq!(Lanes::splat(f32::NAN).greater(b), b);
    }

    #[test]
    fn numbers_that_are_not_finite_are_noticed() {
        assert!(Lanes::from(A).all_finite() && Lanes::splat(f32::MAX).all_finite());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(!Lanes::new(A, bad).all_finite());
        }
        assert!(
            Lanes::from(A).all_equal(Lanes::from(A))
                && !Lanes::splat(f32::NAN).all_equal(Lanes::splat(f32::NAN))
        );
    }
}
