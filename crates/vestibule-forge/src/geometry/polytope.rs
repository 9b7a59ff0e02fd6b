//! Convex solids.

use glam::DVec3;

use super::{ON_PLANE, Plane, Polygon, Side};

/// Half the side of the squares that faces are clipped from, metres: larger than a row of landblocks.
const HUGE: f64 = 1.0e5;

/// A face of a convex solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// The face, seen from outside.
    pub polygon: Polygon,
    /// Whatever its owner wants to remember about it.
    pub tag: u32,
}

/// A bounded convex solid, as the faces around it. Normals point outwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Polytope {
    /// The faces.
    pub faces: Vec<Face>,
}

impl Polytope {
    /// The solid behind all of `planes`, each with the tag of its face; `None` when it is empty, unbounded or
    /// thinner than can be told.
    pub fn from_planes(planes: &[(Plane, u32)]) -> Option<Self> {
        let mut faces: Vec<Face> = Vec::new();
        for (i, (plane, tag)) in planes.iter().enumerate() {
            if planes[..i].iter().any(|(p, _)| p.same_as(plane)) {
                continue;
            }
            let face = planes.iter().filter(|(p, _)| !p.same_as(plane)).try_fold(
                Polygon::huge(*plane, HUGE),
                |part, (other, _)| {
                    let inside = other.flipped();
                    // A face that lies in another plane facing away from it bounds nothing.
                    (part.side(&inside) != Side::On)
                        .then(|| part.clipped(&inside))
                        .flatten()
                },
            );
            faces.extend(face.map(|polygon| Face { polygon, tag: *tag }));
        }
        let solid = Polytope { faces };
        let far = solid.points().any(|p| p.abs().max_element() > HUGE * 0.4);
        (solid.faces.len() >= 4 && !far && solid.volume() > 1.0e-9).then_some(solid)
    }

    /// The box between two corners. Tags: 0.
    pub fn cuboid(a: DVec3, b: DVec3) -> Option<Self> {
        let (low, high) = (a.min(b), a.max(b));
        let planes = [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .flat_map(|n| [(Plane::through(n, high), 0), (Plane::through(-n, low), 0)]);
        Self::from_planes(&planes.collect::<Vec<_>>())
    }

    /// The convex hull of some points; `None` when they lie in a plane. Meant for a few dozen points.
    pub fn hull(points: &[DVec3]) -> Option<Self> {
        let mut planes: Vec<(Plane, u32)> = Vec::new();
        for (i, a) in points.iter().enumerate() {
            for (j, b) in points.iter().enumerate().skip(i + 1) {
                for c in &points[j + 1..] {
                    let Some(plane) = Plane::of_points(&[*a, *b, *c]) else {
                        continue;
                    };
                    let plane = match plane.side_of(points) {
                        Side::Back => plane,
                        Side::Front => plane.flipped(),
                        _ => continue,
                    };
                    if !planes.iter().any(|(p, _)| p.same_as(&plane)) {
                        planes.push((plane, 0));
                    }
                }
            }
        }
        Self::from_planes(&planes)
    }

    /// The planes with the tags of their faces.
    pub fn planes(&self) -> Vec<(Plane, u32)> {
        self.faces.iter().map(|f| (f.polygon.plane, f.tag)).collect()
    }

    /// All corners, each once per face it belongs to.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.faces.iter().flat_map(|f| f.polygon.points.iter().copied())
    }

    /// Smallest and largest corner of the box around it.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.points()
            .fold(start, |(low, high), p| (low.min(p), high.max(p)))
    }

    /// Mean of the corners: a point inside.
    pub fn center(&self) -> DVec3 {
        self.points().sum::<DVec3>() / self.points().count() as f64
    }

    /// Volume, cubic metres.
    pub fn volume(&self) -> f64 {
        let Some(origin) = self.points().next() else {
            return 0.0;
        };
        let cone = |f: &Face| f.polygon.area() * f.polygon.plane.dist(origin) / -3.0;
        self.faces.iter().map(cone).sum()
    }

    /// Whether a point is inside, or at most `slack` metres outside.
    pub fn contains(&self, p: DVec3, slack: f64) -> bool {
        self.faces.iter().all(|f| f.polygon.plane.dist(p) <= slack)
    }

    /// Cuts the solid: the part in front of and the part behind a plane. New faces get `tag`.
    pub fn split(&self, plane: &Plane, tag: u32) -> (Option<Polytope>, Option<Polytope>) {
        let (mut front, mut back) = (false, false);
        for p in self.points() {
            front |= plane.dist(p) > ON_PLANE;
            back |= plane.dist(p) < -ON_PLANE;
        }
        if !(front && back) {
            return if front {
                (Some(self.clone()), None)
            } else {
                (None, Some(self.clone()))
            };
        }
        let part = |cut: Plane| {
            let mut planes = self.planes();
            planes.push((cut, tag));
            Self::from_planes(&planes)
        };
        (part(plane.flipped()), part(*plane))
    }

    /// What is left when `other` is taken away: convex parts that touch. New faces get `tag`.
    pub fn without(&self, other: &Polytope, tag: u32) -> Vec<Polytope> {
        if self.intersection(other).is_none() {
            return vec![self.clone()];
        }
        let mut parts = Vec::new();
        let mut rest = Some(self.clone());
        for face in &other.faces {
            let Some(inner) = rest else { break };
            let (front, back) = inner.split(&face.polygon.plane, tag);
            parts.extend(front);
            rest = back;
        }
        parts
    }

    /// What it shares with `other`.
    pub fn intersection(&self, other: &Polytope) -> Option<Polytope> {
        let ((a, b), (c, d)) = (self.bounds(), other.bounds());
        if a.max(c).cmpge(b.min(d)).any() {
            return None;
        }
        let mut planes = self.planes();
        planes.extend(other.planes());
        Self::from_planes(&planes)
    }

    /// The solid with every face moved inwards by `by` metres.
    pub fn shrunk(&self, by: f64) -> Option<Polytope> {
        let planes: Vec<_> = self
            .planes()
            .iter()
            .map(|(p, tag)| (p.moved(-by), *tag))
            .collect();
        Self::from_planes(&planes)
    }

    /// The solid with every point moved by a rigid motion.
    pub fn mapped(&self, map: impl Fn(DVec3) -> DVec3) -> Option<Polytope> {
        let face = |f: &Face| {
            let points = f.polygon.points.iter().map(|p| map(*p)).collect();
            Polygon::new(points).map(|polygon| Face { polygon, tag: f.tag })
        };
        self.faces
            .iter()
            .map(face)
            .collect::<Option<Vec<_>>>()
            .map(|faces| Polytope { faces })
    }
}
