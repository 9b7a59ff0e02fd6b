//! Portal polygons made usable when a landblock is compiled (`visibility.md` 12.7, 14.5): planar, convex, with few
//! vertices. What cannot be used is closed for good.

use glam::{Vec2, Vec3};
use vestibule_world::Plane;

use crate::constants::{MAX_PIECE_VERTICES, MIN_PORTAL_AREA};

/// Vertices nearer than this are one, metres.
const SAME_VERTEX: f32 = 1.0e-5;
/// A vertex this far outside another side makes a polygon count as not convex, metres.
const CONVEX_SLACK: f32 = 1.0e-4;
/// More vertices than this are taken by their convex hull without looking for the shape, whose cost is cubic.
const MAX_EXACT_VERTICES: usize = 128;

/// What became of a portal polygon.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Pieces {
    /// Convex pieces, counter-clockwise seen from the plane's positive side, on that plane.
    Open(Vec<Vec<Vec3>>),
    /// No opening: fewer than three distinct vertices, no area, or numbers that are not finite.
    Closed,
}

/// Splits the polygon `vertices` with plane `plane` into convex pieces of at most [`MAX_PIECE_VERTICES`]. Vertices
/// off the plane are moved onto it.
pub(crate) fn pieces(vertices: &[Vec3], plane: &Plane) -> Pieces {
    let normal = plane.normal;
    if !(normal.is_finite() && plane.d.is_finite() && (normal.length_squared() - 1.0).abs() < 1.0e-2) {
        return Pieces::Closed;
    }
    if vertices.iter().any(|v| !v.is_finite()) {
        return Pieces::Closed;
    }
    let (u, v) = basis(normal);
    let base = normal * -plane.d;
    let flat = |p: Vec3| Vec2::new(u.dot(p - base), v.dot(p - base));
    let lifted = |p: Vec2| base + u * p.x + v * p.y;
    let mut points: Vec<Vec2> = Vec::with_capacity(vertices.len());
    for p in vertices.iter().map(|&p| flat(p)) {
        if points.last().is_none_or(|q| (*q - p).length() > SAME_VERTEX) {
            points.push(p);
        }
    }
    while points.len() > 1 && (points[0] - points[points.len() - 1]).length() <= SAME_VERTEX {
        points.pop();
    }
    if points.len() < 3 || area(&points).abs() < MIN_PORTAL_AREA {
        return Pieces::Closed;
    }
    // A stored plane may disagree with the order of the vertices; the plane decides.
    if area(&points) < 0.0 {
        points.reverse();
    }
    let shapes = if is_convex(&points) {
        vec![points]
    } else if points.len() > MAX_EXACT_VERTICES {
        vec![hull(&points)]
    } else {
        ear_clip(&points).unwrap_or_else(|| vec![hull(&points)])
    };
    let mut out = Vec::new();
    for shape in shapes {
        for piece in split(&shape) {
            if area(&piece) >= MIN_PORTAL_AREA {
                out.push(piece.into_iter().map(lifted).collect());
            }
        }
    }
    if out.is_empty() {
        Pieces::Closed
    } else {
        Pieces::Open(out)
    }
}

/// Two unit vectors that with `normal` form a right-handed base.
fn basis(normal: Vec3) -> (Vec3, Vec3) {
    let a = normal.abs();
    let helper = if a.x <= a.y && a.x <= a.z {
        Vec3::X
    } else if a.y <= a.z {
        Vec3::Y
    } else {
        Vec3::Z
    };
    let u = helper.cross(normal);
    let u = u / u.length();
    (u, normal.cross(u))
}

fn area(points: &[Vec2]) -> f32 {
    let Some(&first) = points.first() else { return 0.0 };
    points
        .windows(2)
        .map(|p| 0.5 * (p[0] - first).perp_dot(p[1] - first))
        .sum()
}

/// How far `p` lies inside the line from `a` to `b`, metres.
fn inside_of(a: Vec2, b: Vec2, p: Vec2) -> f32 {
    let along = b - a;
    let length = along.length();
    if length > 0.0 {
        along.perp_dot(p - a) / length
    } else {
        0.0
    }
}

fn is_convex(points: &[Vec2]) -> bool {
    let n = points.len();
    if n == 3 {
        return true;
    }
    if n > 4 * MAX_EXACT_VERTICES {
        return false;
    }
    (0..n).all(|k| {
        let (a, b) = (points[k], points[(k + 1) % n]);
        points.iter().all(|&p| inside_of(a, b, p) >= -CONVEX_SLACK)
    })
}

/// The convex hull, counter-clockwise.
fn hull(points: &[Vec2]) -> Vec<Vec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut out: Vec<Vec2> = Vec::new();
    let mut half = |points: &mut dyn Iterator<Item = &Vec2>| {
        let floor = out.len();
        for &p in points {
            while out.len() >= floor + 2
                && (out[out.len() - 1] - out[out.len() - 2]).perp_dot(p - out[out.len() - 1]) <= 0.0
            {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
    };
    half(&mut sorted.iter());
    half(&mut sorted.iter().rev());
    out
}

/// Triangles of a simple polygon; `None` when it crosses itself.
fn ear_clip(points: &[Vec2]) -> Option<Vec<Vec<Vec2>>> {
    let mut left: Vec<Vec2> = points.to_vec();
    let mut out = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&k| {
            let (a, b, c) = (left[(k + n - 1) % n], left[k], left[(k + 1) % n]);
            let turn = (b - a).perp_dot(c - b);
            let corner = |i: usize| i == k || i == (k + 1) % n || i == (k + n - 1) % n;
            turn >= 0.0
                && left.iter().enumerate().all(|(i, &p)| {
                    // A corner on the cut would pinch what is left.
                    let within =
                        inside_of(a, b, p) >= 0.0 && inside_of(b, c, p) >= 0.0 && inside_of(c, a, p) >= 0.0;
                    corner(i) || turn == 0.0 || !within || p == a || p == b || p == c
                })
        })?;
        let n_prev = (ear + n - 1) % n;
        out.push(vec![left[n_prev], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
    }
    out.push(left);
    let sum: f32 = out.iter().map(|t| area(t)).sum();
    let whole = area(points);
    ((sum - whole).abs() <= 1.0e-3 * whole && out.iter().all(|t| area(t) >= -MIN_PORTAL_AREA)).then_some(out)
}

/// Cuts a convex polygon into pieces of few vertices, all fans around its first one.
fn split(points: &[Vec2]) -> Vec<Vec<Vec2>> {
    if points.len() <= MAX_PIECE_VERTICES {
        return vec![points.to_vec()];
    }
    let mut out = Vec::new();
    let mut at = 1;
    while at + 1 < points.len() {
        let end = (at + MAX_PIECE_VERTICES - 2).min(points.len() - 1);
        let mut piece = vec![points[0]];
        piece.extend_from_slice(&points[at..=end]);
        out.push(piece);
        at = end;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(vertices: &[Vec3]) -> Vec<Vec<Vec3>> {
        match pieces(vertices, &Plane::of_polygon(vertices)) {
            Pieces::Open(p) => p,
            Pieces::Closed => Vec::new(),
        }
    }

    fn flat(points: &[(f32, f32)]) -> Vec<Vec3> {
        points.iter().map(|&(x, z)| Vec3::new(x, 0.0, z)).collect()
    }

    #[test]
    fn s12_7_a_quad_stays_one_piece_with_its_winding() {
        let quad = flat(&[(-1.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-1.0, 2.0)]);
        let out = open(&quad);
        assert_eq!(out.len(), 1);
        let (a, b) = (Plane::of_polygon(&quad), Plane::of_polygon(&out[0]));
        assert!((a.normal - b.normal).length() < 1e-5 && (a.d - b.d).abs() < 1e-5);
    }

    #[test]
    fn s12_7_polygons_without_area_are_closed() {
        assert!(open(&flat(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)])).is_empty());
        assert!(open(&flat(&[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)])).is_empty());
        assert!(open(&flat(&[(0.0, 0.0), (1.0e-4, 0.0), (0.0, 1.0e-4)])).is_empty());
        assert!(open(&[]).is_empty());
        let nan = [Vec3::NAN, Vec3::X, Vec3::Y];
        assert_eq!(
            pieces(
                &nan,
                &Plane {
                    normal: Vec3::Z,
                    d: 0.0
                }
            ),
            Pieces::Closed
        );
    }

    #[test]
    fn s12_7_an_l_shape_becomes_triangles_that_cover_it() {
        let l = flat(&[
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (1.0, 1.0),
            (1.0, 2.0),
            (0.0, 2.0),
        ]);
        let out = open(&l);
        assert!(out.len() >= 2);
        let sum: f32 = out
            .iter()
            .map(|t| (t[1] - t[0]).cross(t[2] - t[0]).length() * 0.5)
            .sum();
        assert!((sum - 3.0).abs() < 1e-4, "{sum}");
    }

    #[test]
    fn s12_7_a_bow_tie_is_taken_by_its_hull() {
        let tie = flat(&[(0.0, 0.0), (2.0, 1.0), (2.0, 0.0), (0.0, 1.5)]);
        assert!(!open(&tie).is_empty());
    }

    #[test]
    fn s14_5_long_polygons_are_split() {
        let ring: Vec<(f32, f32)> = (0..100)
            .map(|k| {
                let a = k as f32 * core::f32::consts::TAU / 100.0;
                (libm::cosf(a), libm::sinf(a))
            })
            .collect();
        let out = open(&flat(&ring));
        assert!(out.len() >= 4 && out.iter().all(|p| p.len() <= MAX_PIECE_VERTICES));
        let sum: f32 = out.iter().map(|p| Plane::of_polygon(p).normal.length()).sum();
        assert!((sum - out.len() as f32).abs() < 1e-3);
    }
}
