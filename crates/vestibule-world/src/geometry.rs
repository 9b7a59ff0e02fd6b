//! Planes, spheres and boxes, with the side tests every rule uses (`transition.md` 1.3.4, `world.md` Q2-Q3).

use glam::Vec3;

use crate::constants::EPSILON;

/// A plane: `normal · p + d = 0`; the positive side is where the normal points.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[repr(C)]
pub struct Plane {
    /// Unit normal (zero for a degenerate polygon).
    pub normal: Vec3,
    /// Offset, metres.
    pub d: f32,
}

/// Where something lies with respect to a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// In front: farther than epsilon along the normal.
    Positive,
    /// Behind.
    Negative,
    /// On the plane within epsilon, or (for boxes) on both sides.
    Crossing,
}

impl Plane {
    /// The plane through `point` with normal `normal`.
    pub fn through(normal: Vec3, point: Vec3) -> Self {
        Plane {
            normal,
            d: -normal.dot(point),
        }
    }

    /// Signed distance of a point, metres.
    #[inline]
    pub fn dist(&self, p: Vec3) -> f32 {
        let n = self.normal;
        n.x * p.x + n.y * p.y + n.z * p.z + self.d
    }

    /// Side of a point, on the plane within epsilon.
    #[inline]
    pub fn side(&self, p: Vec3) -> Side {
        let dist = self.dist(p);
        if dist > EPSILON {
            Side::Positive
        } else if dist < -EPSILON {
            Side::Negative
        } else {
            Side::Crossing
        }
    }

    /// The plane of a polygon, in the arithmetic order of `dat-format.md` G4. Zero normal when degenerate.
    pub fn of_polygon(vertices: &[Vec3]) -> Self {
        let Some(&first) = vertices.first() else {
            return Plane::default();
        };
        let mut normal = Vec3::ZERO;
        for pair in vertices.windows(2).skip(1) {
            normal += (pair[0] - first).cross(pair[1] - first);
        }
        let length = libm::sqrtf(normal.dot(normal));
        if !(length > 0.0 && length.is_finite()) {
            return Plane::default();
        }
        let normal = normal / length;
        let mut sum = 0.0;
        for v in vertices {
            sum += normal.dot(*v);
        }
        Plane {
            normal,
            d: -(sum / vertices.len() as f32),
        }
    }
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[repr(C)]
pub struct Sphere {
    /// Centre, metres.
    pub center: Vec3,
    /// Radius, metres.
    pub radius: f32,
}

impl Sphere {
    /// A sphere from its parts.
    pub const fn new(center: Vec3, radius: f32) -> Self {
        Sphere { center, radius }
    }

    /// The smallest sphere around this one and another.
    #[must_use]
    pub fn around(&self, other: &Sphere) -> Sphere {
        let gap = other.center - self.center;
        let apart = libm::sqrtf(gap.dot(gap));
        if apart + other.radius <= self.radius {
            *self
        } else if apart + self.radius <= other.radius {
            *other
        } else {
            let radius = (apart + self.radius + other.radius) * 0.5;
            Sphere::new(self.center + gap * ((radius - self.radius) / apart), radius)
        }
    }
}

/// An upright cylinder (retail `CCylSphere`).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct CylSphere {
    /// Centre of the bottom, metres.
    pub low_point: Vec3,
    /// Radius, metres.
    pub radius: f32,
    /// Height, metres.
    pub height: f32,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl BoundingBox {
    /// The box of some points; `None` for no points.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        let mut out = BoundingBox {
            min: first,
            max: first,
        };
        for p in points {
            out.grow(p);
        }
        Some(out)
    }

    /// Extends the box to hold `p`.
    #[inline]
    pub fn grow(&mut self, p: Vec3) {
        let lower = |a: f32, b: f32| if b < a { b } else { a };
        let upper = |a: f32, b: f32| if b > a { b } else { a };
        self.min = Vec3::new(
            lower(self.min.x, p.x),
            lower(self.min.y, p.y),
            lower(self.min.z, p.z),
        );
        self.max = Vec3::new(
            upper(self.max.x, p.x),
            upper(self.max.y, p.y),
            upper(self.max.z, p.z),
        );
    }

    /// The eight corners: x changes first, z last, the smaller before the larger.
    #[inline]
    pub fn corners(&self) -> [Vec3; 8] {
        let (a, b) = (self.min, self.max);
        [
            Vec3::new(a.x, a.y, a.z),
            Vec3::new(b.x, a.y, a.z),
            Vec3::new(a.x, b.y, a.z),
            Vec3::new(b.x, b.y, a.z),
            Vec3::new(a.x, a.y, b.z),
            Vec3::new(b.x, a.y, b.z),
            Vec3::new(a.x, b.y, b.z),
            Vec3::new(b.x, b.y, b.z),
        ]
    }

    /// The box around this box after `map` moved its corners (`world.md` Q2: the true hull of all eight).
    pub fn mapped(&self, map: impl Fn(Vec3) -> Vec3) -> Self {
        let corners = self.corners();
        let mut out = BoundingBox {
            min: map(corners[0]),
            max: map(corners[0]),
        };
        for c in &corners[1..] {
            out.grow(map(*c));
        }
        out
    }

    /// Side of the whole box (retail `intersect_box`, `world.md` Q3).
    pub fn side_of(&self, plane: &Plane) -> Side {
        let (mut positive, mut negative) = (true, true);
        for c in self.corners() {
            let dist = plane.dist(c);
            positive &= dist > EPSILON;
            negative &= dist < -EPSILON;
        }
        if positive {
            Side::Positive
        } else if negative {
            Side::Negative
        } else {
            Side::Crossing
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_around_two_touches_both_and_holds_them() {
        let at = |x: f32, radius: f32| Sphere::new(Vec3::new(x, 0.0, 0.0), radius);
        assert_eq!(at(0.0, 1.0).around(&at(3.0, 2.0)), at(2.0, 3.0));
        assert_eq!(at(0.0, 3.0).around(&at(1.0, 1.0)), at(0.0, 3.0));
        assert_eq!(at(1.0, 1.0).around(&at(0.0, 3.0)), at(0.0, 3.0));
        assert_eq!(at(1.0, 1.0).around(&at(1.0, 1.0)), at(1.0, 1.0));
    }
}
