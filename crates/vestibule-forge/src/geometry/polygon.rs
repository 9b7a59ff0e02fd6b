//! Convex polygons.

use glam::DVec3;

use super::{MIN_AREA, ON_PLANE, Plane, Side};

/// A convex planar polygon; its points run counter-clockwise seen from the front.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Corners, metres.
    pub points: Vec<DVec3>,
    /// Its plane.
    pub plane: Plane,
}

impl Polygon {
    /// A polygon from its corners; `None` when they span no area.
    pub fn new(points: Vec<DVec3>) -> Option<Self> {
        let plane = Plane::of_points(&points)?;
        Self::in_plane(points, plane)
    }

    /// A polygon in a known plane: repeated points are dropped, and `None` is answered when no area is left.
    pub fn in_plane(mut points: Vec<DVec3>, plane: Plane) -> Option<Self> {
        points.dedup_by(|a, b| a.distance_squared(*b) < 1.0e-12);
        while points.len() > 1 && points[0].distance_squared(points[points.len() - 1]) < 1.0e-12 {
            points.pop();
        }
        let polygon = Polygon { points, plane };
        (polygon.points.len() >= 3 && polygon.area() > MIN_AREA).then_some(polygon)
    }

    /// A square of side 2 `half` in a plane, large enough to be clipped to anything.
    pub fn huge(plane: Plane, half: f64) -> Self {
        let (u, v) = plane.axes();
        let center = plane.normal * -plane.d;
        let (u, v) = (u * half, v * half);
        Polygon {
            points: vec![center - u - v, center + u - v, center + u + v, center - u + v],
            plane,
        }
    }

    /// Area, square metres.
    pub fn area(&self) -> f64 {
        let Some((&first, rest)) = self.points.split_first() else {
            return 0.0;
        };
        let sum: DVec3 = rest.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum();
        sum.dot(self.plane.normal) * 0.5
    }

    /// Mean of the corners.
    pub fn center(&self) -> DVec3 {
        self.points.iter().sum::<DVec3>() / self.points.len() as f64
    }

    /// The polygon seen from the other side.
    pub fn flipped(&self) -> Self {
        Polygon {
            points: self.points.iter().rev().copied().collect(),
            plane: self.plane.flipped(),
        }
    }

    /// Where it lies to a plane.
    pub fn side(&self, plane: &Plane) -> Side {
        plane.side_of(&self.points)
    }

    /// For each edge the plane through it, upright on the polygon, with the inside in front.
    pub fn edge_planes(&self) -> impl Iterator<Item = Plane> + '_ {
        let n = self.points.len();
        (0..n).filter_map(move |i| {
            let (a, b) = (self.points[i], self.points[(i + 1) % n]);
            let inward = self.plane.normal.cross(b - a);
            let length = inward.length();
            (length > 1.0e-9).then(|| Plane::through(inward / length, a))
        })
    }

    /// Cuts the polygon: the part in front and the part behind. A polygon in the plane counts as in front if it
    /// faces the same way. Parts thinner than [`ON_PLANE`] are not cut off.
    pub fn split(&self, plane: &Plane) -> (Option<Polygon>, Option<Polygon>) {
        match self.side(plane) {
            Side::Front => return (Some(self.clone()), None),
            Side::Back => return (None, Some(self.clone())),
            Side::On => {
                let front = self.plane.normal.dot(plane.normal) > 0.0;
                return if front {
                    (Some(self.clone()), None)
                } else {
                    (None, Some(self.clone()))
                };
            }
            Side::Across => {}
        }
        let (mut front, mut back) = (Vec::new(), Vec::new());
        let n = self.points.len();
        for i in 0..n {
            let (a, b) = (self.points[i], self.points[(i + 1) % n]);
            let (da, db) = (plane.dist(a), plane.dist(b));
            if da >= -ON_PLANE {
                front.push(a);
            }
            if da <= ON_PLANE {
                back.push(a);
            }
            if (da > ON_PLANE && db < -ON_PLANE) || (da < -ON_PLANE && db > ON_PLANE) {
                // From the same end whichever way the edge runs, so that neighbours get the same point.
                let cut = if da > 0.0 {
                    a + (b - a) * (da / (da - db))
                } else {
                    b + (a - b) * (db / (db - da))
                };
                front.push(cut);
                back.push(cut);
            }
        }
        let whole = |points| Polygon::in_plane(points, self.plane);
        match (whole(front), whole(back)) {
            (None, None) => (Some(self.clone()), None),
            parts => parts,
        }
    }

    /// The part in front of a plane (in the plane counts, whichever way it faces).
    pub fn clipped(&self, plane: &Plane) -> Option<Polygon> {
        match self.side(plane) {
            Side::Front | Side::On => Some(self.clone()),
            Side::Back => None,
            Side::Across => self.split(plane).0,
        }
    }

    /// What this polygon shares with `other`, which lies in the same plane (facing either way).
    pub fn intersection(&self, other: &Polygon) -> Option<Polygon> {
        other.edge_planes().try_fold(self.clone(), |part, edge| {
            // A part that only touches the edge from outside shares no area.
            (part.side(&edge) != Side::On)
                .then(|| part.clipped(&edge))
                .flatten()
        })
    }

    /// What is left of this polygon when `hole`, in the same plane, is cut out: convex parts.
    pub fn without(&self, hole: &Polygon) -> Vec<Polygon> {
        if self.intersection(hole).is_none() {
            return vec![self.clone()];
        }
        let mut parts = Vec::new();
        let mut rest = Some(self.clone());
        for edge in hole.edge_planes() {
            let Some(inner) = rest else { break };
            if inner.side(&edge) == Side::Across {
                let (front, back) = inner.split(&edge);
                parts.extend(back);
                rest = front;
            } else if inner.side(&edge) == Side::Back {
                parts.push(inner);
                rest = None;
            } else {
                rest = Some(inner);
            }
        }
        parts
    }

    /// Whether it lies in the same plane as `other`, facing the other way.
    pub fn meets(&self, other: &Polygon) -> bool {
        self.plane.same_as(&other.plane.flipped())
    }

    /// Whether a point of its plane is inside or nearer to it than `slack` metres.
    pub fn contains(&self, p: DVec3, slack: f64) -> bool {
        self.edge_planes().all(|edge| edge.dist(p) >= -slack)
    }
}
