//! Planes.

use glam::DVec3;

use super::ON_PLANE;

/// A plane: `normal · p + d = 0`; the positive side is where the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: DVec3,
    /// Offset, metres.
    pub d: f64,
}

/// Where a point or a polygon lies with respect to a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// In front.
    Front,
    /// Behind.
    Back,
    /// In the plane.
    On,
    /// On both sides (polygons only).
    Across,
}

impl Plane {
    /// The plane through `point` with unit normal `normal`.
    pub fn through(normal: DVec3, point: DVec3) -> Self {
        Plane {
            normal,
            d: -normal.dot(point),
        }
    }

    /// The plane of a polygon (`dat-format.md` G4, in f64); `None` when it has no area.
    pub fn of_points(points: &[DVec3]) -> Option<Self> {
        let (&first, rest) = points.split_first()?;
        let normal: DVec3 = rest.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum();
        let length = normal.length();
        if !(length > 1.0e-12 && length.is_finite()) {
            return None;
        }
        let normal = normal / length;
        let sum: f64 = points.iter().map(|p| normal.dot(*p)).sum();
        Some(Plane {
            normal,
            d: -sum / points.len() as f64,
        })
    }

    /// Signed distance of a point, metres.
    pub fn dist(&self, p: DVec3) -> f64 {
        self.normal.dot(p) + self.d
    }

    /// The same plane facing the other way.
    pub fn flipped(&self) -> Self {
        Plane {
            normal: -self.normal,
            d: -self.d,
        }
    }

    /// The plane without the rounding noise of turns: components below 1e-9 are zero.
    pub fn tidy(&self) -> Self {
        let tidy = |n: f64| if n.abs() < 1.0e-9 { 0.0 } else { n };
        Plane {
            normal: DVec3::from_array(self.normal.to_array().map(tidy)),
            d: tidy(self.d),
        }
    }

    /// The plane moved along its normal by `by` metres.
    pub fn moved(&self, by: f64) -> Self {
        Plane {
            normal: self.normal,
            d: self.d - by,
        }
    }

    /// Side of a point, on the plane within [`ON_PLANE`].
    pub fn side(&self, p: DVec3) -> Side {
        let dist = self.dist(p);
        if dist > ON_PLANE {
            Side::Front
        } else if dist < -ON_PLANE {
            Side::Back
        } else {
            Side::On
        }
    }

    /// Side of a set of points.
    pub fn side_of(&self, points: &[DVec3]) -> Side {
        let mut side = Side::On;
        for p in points {
            side = match (side, self.side(*p)) {
                (s, Side::On) => s,
                (Side::On, s) => s,
                (a, b) if a == b => a,
                _ => return Side::Across,
            };
        }
        side
    }

    /// Whether `other` is this plane, facing the same way.
    pub fn same_as(&self, other: &Plane) -> bool {
        self.normal.dot(other.normal) > 1.0 - 1.0e-7 && (self.d - other.d).abs() < 2.0 * ON_PLANE
    }

    /// Two unit vectors in the plane, at right angles to each other and to the normal: `u × v = normal`. For
    /// planes that are not level `v` points as steeply up as the plane allows.
    pub fn axes(&self) -> (DVec3, DVec3) {
        let n = self.normal;
        let u = if n.x.abs() + n.y.abs() > 1.0e-3 {
            DVec3::new(-n.y, n.x, 0.0).normalize()
        } else {
            DVec3::X
        };
        (u, n.cross(u))
    }
}
