//! Polygons against spheres (`transition.md` 6.5 to 6.8). Everything is in the polygon's own space.

use glam::Vec3;
use vestibule_world::{EdgeQuad, Face, FaceEdge, Lanes, Plane, RimSide, Sphere, rim_side};

use crate::constants::{EPSILON, POLYGON_INTERP_LIMIT};

/// The edge vector of `edges[i]`: from its start to the start of the next.
#[inline]
fn edge_vector(edges: &[FaceEdge], i: usize) -> Vec3 {
    let next = if i + 1 == edges.len() { 0 } else { i + 1 };
    edges[next].start - edges[i].start
}

/// How a sphere overlaps a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Overlap {
    /// Not at all.
    None,
    /// Over an edge or a corner.
    Rim,
    /// Over the inside, with this distance of the centre from the plane.
    Inside(f32),
}

/// Whether the sphere overlaps the polygon (6.5.1).
#[inline]
pub(crate) fn polygon_hits_sphere(face: &Face, edges: &[FaceEdge], sphere: &Sphere) -> bool {
    let sphere = Lanes::from(*sphere);
    let s = Lanes::of_plane(&face.plane).dist(sphere);
    let rho = sphere.fourth() - EPSILON;
    if rho < s.abs() {
        return false;
    }
    let point = sphere - Lanes::of_plane(&face.plane) * s;
    is_inside(face, edges, point) || edges_reach(edges, point.xyz(), rho * rho - s * s, false)
}

/// As [`polygon_hits_sphere`], saying how.
#[inline(always)]
pub(crate) fn overlap(face: &Face, edges: &[EdgeQuad], sphere: Lanes) -> Overlap {
    overlap_at(face, edges, sphere, Lanes::of_plane(&face.plane).dist(sphere))
}

/// As [`overlap`], given the distance `s` of the centre from the plane.
#[inline(always)]
pub(crate) fn overlap_at(face: &Face, edges: &[EdgeQuad], sphere: Lanes, s: f32) -> Overlap {
    let rho = sphere.fourth() - EPSILON;
    if rho < s.abs() {
        return Overlap::None;
    }
    let point = sphere - Lanes::of_plane(&face.plane) * s;
    if face.certainly_inside(point) {
        return Overlap::Inside(s.abs());
    }
    match side_of_rim(edges, point, rho * rho - s * s) {
        RimSide::Inside => Overlap::Inside(s.abs()),
        RimSide::Near => Overlap::Rim,
        RimSide::Away => Overlap::None,
    }
}

#[inline(never)]
fn side_of_rim(edges: &[EdgeQuad], point: Lanes, reach: f32) -> RimSide {
    rim_side(edges, point.xyz(), reach)
}

/// Whether a point of the plane is on the inner side of all edges.
#[inline(always)]
fn is_inside(face: &Face, edges: &[FaceEdge], point: Lanes) -> bool {
    face.certainly_inside(point) || is_inside_all(edges, point.xyz())
}

#[inline(never)]
fn is_inside_all(edges: &[FaceEdge], point: Vec3) -> bool {
    edges.iter().all(|e| (point - e.start).dot(e.inward) >= 0.0)
}

/// Whether a sphere that is known to overlap the polygon still does with a radius smaller by `less`.
#[inline(never)]
pub(crate) fn hits_deeper(face: &Face, edges: &[EdgeQuad], sphere: Lanes, less: f32) -> bool {
    overlap(face, edges, sphere.with_fourth(sphere.fourth() - less)) != Overlap::None
}

/// The loop over edges and corners that 6.5.1 and 6.7.1 share: whether `point` is within the square distance
/// `reach` of the polygon, or else `fallback`.
#[inline(never)]
fn edges_reach(edges: &[FaceEdge], point: Vec3, reach: f32, mut fallback: bool) -> bool {
    for (i, edge) in edges.iter().enumerate() {
        let w = point - edge.start;
        let wc = w.dot(edge.inward);
        if wc < 0.0 {
            if edge.inward.dot(edge.inward) * reach < wc * wc {
                return false;
            }
            let e = edge_vector(edges, i);
            let along = w.dot(e);
            if 0.0 <= along && along <= e.dot(e) {
                return true;
            }
            fallback = false;
        }
        // The corner counts whether or not the point is beyond the edge.
        if w.dot(w) <= reach {
            return true;
        }
    }
    fallback
}

/// Whether the polygon is level enough to stand on and overlaps the sphere (6.5.2).
#[inline]
pub(crate) fn walkable_hits_sphere(
    face: &Face,
    edges: &[FaceEdge],
    sphere: &Sphere,
    up: Vec3,
    walkable_allowance: f32,
) -> bool {
    up.dot(face.plane.normal) > walkable_allowance && polygon_hits_sphere(face, edges, sphere)
}

/// Moves the sphere back along `movement` until it touches the plane, if the fraction to undo is allowed;
/// `walk_interp` takes what is left of the movement (6.6.1).
#[inline(always)]
pub(crate) fn adjust_sphere_to_plane(
    plane: &Plane,
    sphere: &mut Lanes,
    movement: Lanes,
    walk_interp: &mut f32,
) -> bool {
    let plane = Lanes::of_plane(plane);
    let radius = sphere.fourth();
    let s = plane.dist(*sphere);
    let k = movement.dot(plane);
    let a = if k > EPSILON {
        (-radius - s) / k
    } else if k < -EPSILON {
        (s - radius) / k
    } else {
        return false;
    };
    let w = (1.0 - a) * *walk_interp;
    if w >= *walk_interp || w < POLYGON_INTERP_LIMIT {
        return false;
    }
    *sphere = *sphere - movement * a;
    *walk_interp = w;
    true
}

/// Whether the sphere, taken with this radius and dropped onto the plane along `up`, is supported by the polygon (6.7.1).
#[inline(always)]
pub(crate) fn check_walkable(face: &Face, edges: &[FaceEdge], sphere: Lanes, radius: f32, up: Lanes) -> bool {
    support(face, edges, sphere, radius * radius, up)
}

/// As [`check_walkable`] with half the radius (6.7.2).
#[inline]
pub(crate) fn check_small_walkable(face: &Face, edges: &[FaceEdge], sphere: &Sphere, up: Vec3) -> bool {
    let reach = sphere.radius * sphere.radius / 4.0;
    support(face, edges, Lanes::from(*sphere), reach, up.into())
}

#[inline(always)]
fn support(face: &Face, edges: &[FaceEdge], center: Lanes, reach: f32, up: Lanes) -> bool {
    match drop_onto(&face.plane, center, up) {
        // Inside all edges the answer is yes, corners or not.
        Some(point) => is_inside(face, edges, point) || edges_reach(edges, point.xyz(), reach, true),
        None => false,
    }
}

/// `center` moved onto the plane along `up`; `None` when they are parallel.
#[inline(always)]
fn drop_onto(plane: &Plane, center: Lanes, up: Lanes) -> Option<Lanes> {
    let plane = Lanes::of_plane(plane);
    let k = up.dot(plane);
    if k.abs() < EPSILON {
        None
    } else {
        Some(center - up * (plane.dist(center) / k))
    }
}

/// The inward normal of the first edge that the sphere's centre is beyond (6.7.3).
pub(crate) fn find_crossed_edge(face: &Face, edges: &[FaceEdge], sphere: &Sphere, up: Vec3) -> Option<Vec3> {
    let point = drop_onto(&face.plane, sphere.center.into(), up.into())?.xyz();
    let edge = edges.iter().find(|e| (point - e.start).dot(e.inward) < 0.0)?;
    let length = edge.inward.dot(edge.inward).sqrt();
    Some(Vec3::new(
        edge.inward.x / length,
        edge.inward.y / length,
        edge.inward.z / length,
    ))
}

/// The fraction of `movement` at which the sphere, starting at `curr`, touches the plane (6.8).
pub(crate) fn adjust_sphere_to_poly(plane: &Plane, radius: f32, curr: Vec3, movement: Vec3) -> f64 {
    let s = plane.dist(curr);
    if radius > s.abs() {
        return 1.0;
    }
    let k = movement.dot(plane.normal);
    if k.abs() < EPSILON {
        return 0.0;
    }
    let side = if s <= 0.0 { -1.0 } else { 1.0 };
    (f64::from(side * radius) - f64::from(s)) / f64::from(k)
}

/// How far along the normal spheres move out of the solid behind the polygon, metres (6.9).
pub(crate) fn adjust_to_placement_poly(
    plane: &Plane,
    struck: &Sphere,
    radius: f32,
    center_solid: bool,
    solid_check: bool,
) -> f32 {
    let s = plane.dist(struck.center);
    if !solid_check {
        return radius - s;
    }
    let mut rho = radius;
    if center_solid {
        rho = -rho;
    }
    if s <= 0.0 {
        rho = -rho;
    }
    rho - s
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_world::{Child, PhysicsBsp, PhysicsLeaf, PolygonSet};

    fn bsp(vertices: &[Vec3]) -> PhysicsBsp {
        let mut set = PolygonSet::default();
        assert!(set.push(0, false, vertices));
        let leaf = PhysicsLeaf {
            solid: false,
            sphere: Sphere::new(Vec3::ZERO, 100.0),
            first: 0,
            count: 1,
        };
        PhysicsBsp::new(Child::leaf(0), vec![], vec![leaf], &[0], set)
    }

    /// The square [0, 2]² at z = 0, normal up.
    fn square() -> PhysicsBsp {
        bsp(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Vec3::new(x, y, 0.0)))
    }

    fn ball(x: f32, y: f32, z: f32) -> Sphere {
        Sphere::new(Vec3::new(x, y, z), 0.48)
    }

    fn hits(bsp: &PhysicsBsp, s: &Sphere) -> bool {
        polygon_hits_sphere(&bsp.faces()[0], bsp.edges(&bsp.faces()[0]), s)
    }

    #[test]
    fn w29_edge_overlap() {
        let floor = square();
        assert!(hits(&floor, &ball(2.2, 1.0, 0.3)));
        assert!(!hits(&floor, &ball(2.4, 1.0, 0.3)));
        assert!(hits(&floor, &ball(2.2, 2.2, 0.3)));
        assert!(!hits(&floor, &ball(2.3, 2.3, 0.3)));
        assert!(hits(&floor, &ball(1.0, 1.0, -0.3)));
    }

    #[test]
    fn w29_reach_beyond_the_edge_is_exact() {
        let floor = square();
        assert!(hits(&floor, &ball(2.374_3, 1.0, 0.3)));
        assert!(!hits(&floor, &ball(2.374_6, 1.0, 0.3)));
    }

    #[test]
    fn w30_a_body_that_rests_at_its_radius_does_not_hit_its_floor() {
        let floor = square();
        assert!(!hits(&floor, &ball(1.0, 1.0, 0.4799)));
        assert!(hits(&floor, &ball(1.0, 1.0, 0.4797)));
    }

    #[test]
    fn s6_5_1_a_corner_in_reach_counts_inside_the_edge_too() {
        // Beyond the bottom edge only, at its end: neither the edge nor the inside, but the corner.
        let floor = square();
        assert!(hits(&floor, &ball(-0.1, -0.1, 0.3)));
        assert!(!hits(&floor, &ball(-0.3, -0.3, 0.3)));
    }

    #[test]
    fn s6_5_2_the_allowance_is_exclusive() {
        let floor = square();
        let face = &floor.faces()[0];
        let test = |allowance| {
            walkable_hits_sphere(face, floor.edges(face), &ball(1.0, 1.0, 0.3), Vec3::Z, allowance)
        };
        assert!(test(0.999));
        assert!(!test(1.0));
    }

    #[test]
    fn w32_adjust_sphere_to_plane() {
        let plane = Plane {
            normal: Vec3::Z,
            d: 0.0,
        };
        let down = Lanes::from(Vec3::new(0.0, 0.0, -0.6));
        let (mut s, mut interp) = (Lanes::from(ball(0.0, 0.0, 0.1)), 1.0);
        assert!(adjust_sphere_to_plane(&plane, &mut s, down, &mut interp));
        assert!((interp - 0.366_666_7).abs() < 1e-5 && (s.z() - 0.48).abs() < 1e-5);
        let (mut s, mut interp) = (Lanes::from(ball(0.0, 0.0, 0.1)), 1.0);
        let along = Vec3::new(0.3, 0.0, 0.0).into();
        assert!(!adjust_sphere_to_plane(&plane, &mut s, along, &mut interp));
        let mut s = Lanes::from(ball(0.0, 0.0, 0.5));
        assert!(!adjust_sphere_to_plane(&plane, &mut s, down, &mut interp));
        assert_eq!((s, interp), (ball(0.0, 0.0, 0.5).into(), 1.0));
    }

    #[test]
    fn s6_6_1_movement_along_the_normal_and_the_lower_bound() {
        let plane = Plane {
            normal: Vec3::Z,
            d: 0.0,
        };
        // A sphere that overlaps and moves along the normal has nothing to undo: a is below zero.
        for z in [-0.1, 0.1] {
            let (mut s, mut interp) = (Lanes::from(ball(0.0, 0.0, z)), 1.0);
            let along = Vec3::new(0.0, 0.0, 0.6).into();
            assert!(!adjust_sphere_to_plane(&plane, &mut s, along, &mut interp));
        }
        // W15: H = 0.85 is accepted, 0.95 is under -0.5.
        for (h, accepted) in [(0.85, true), (0.95, false)] {
            let (mut s, mut interp) = (Lanes::from(ball(0.0, 0.0, 0.48 - h)), 1.0);
            let down = Lanes::from(Vec3::new(0.0, 0.0, -0.6));
            assert_eq!(
                adjust_sphere_to_plane(&plane, &mut s, down, &mut interp),
                accepted,
                "{h}"
            );
        }
    }

    #[test]
    fn w34_support_radii() {
        let floor = square();
        let face = &floor.faces()[0];
        let at = |beyond: f32| ball(2.0 + beyond, 1.0, 0.48);
        let small = |b| check_small_walkable(face, floor.edges(face), &at(b), Vec3::Z);
        let full = |b| check_walkable(face, floor.edges(face), at(b).into(), 0.48, Vec3::Z.into());
        assert_eq!(
            (small(0.23), small(0.25), full(0.47), full(0.49)),
            (true, false, true, false)
        );
    }

    #[test]
    fn s6_7_1_a_polygon_along_up_supports_nothing_and_one_facing_down_does() {
        let wall = bsp(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, z)| Vec3::new(x, 0.0, z)));
        let face = &wall.faces()[0];
        let stands = |bsp: &PhysicsBsp, face, s: Sphere| {
            check_walkable(face, bsp.edges(face), s.into(), s.radius, Vec3::Z.into())
        };
        assert!(!stands(&wall, face, ball(1.0, 0.0, 1.0)));
        let ceiling =
            bsp(&[(0.0, 0.0), (0.0, 2.0), (2.0, 2.0), (2.0, 0.0)].map(|(x, y)| Vec3::new(x, y, 0.0)));
        let face = &ceiling.faces()[0];
        assert!(stands(&ceiling, face, ball(1.0, 1.0, 1.0)));
    }

    #[test]
    fn s6_7_1_the_drop_is_along_up() {
        // A 45° ramp rising along x: the centre is over (0, 0), its foot of the perpendicular is not.
        let ramp = bsp(&[
            Vec3::new(-1.0, -1.0, -1.0),
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(-1.0, 1.0, -1.0),
        ]);
        let face = &ramp.faces()[0];
        assert!(find_crossed_edge(face, ramp.edges(face), &ball(-0.1, 0.0, 2.0), Vec3::Z).is_none());
        assert!(find_crossed_edge(face, ramp.edges(face), &ball(0.1, 0.0, 2.0), Vec3::Z).is_some());
    }

    #[test]
    fn w21_find_crossed_edge() {
        let floor = square();
        let face = &floor.faces()[0];
        let crossed = |s: Sphere| find_crossed_edge(face, floor.edges(face), &s, Vec3::Z);
        assert_eq!(crossed(ball(2.3, 1.0, 0.4)), Some(Vec3::new(-1.0, 0.0, 0.0)));
        assert_eq!(crossed(ball(1.0, 1.0, 0.4)), None);
    }

    #[test]
    fn w33_adjust_to_placement_poly() {
        let plane = Plane {
            normal: Vec3::Z,
            d: 0.0,
        };
        let shift = |s, center_solid, check| {
            adjust_to_placement_poly(&plane, &ball(0.0, 0.0, s), 0.48, center_solid, check)
        };
        for (s, center_solid, check, expected) in [
            (0.2, false, true, 0.28),
            (-0.2, false, true, -0.28),
            (0.2, true, true, -0.68),
            (-0.2, true, true, 0.68),
            (-0.2, false, false, 0.68),
        ] {
            assert!(
                (shift(s, center_solid, check) - expected).abs() < 1e-5,
                "{s} {center_solid} {check}"
            );
        }
    }

    #[test]
    fn w66_the_direct_solve() {
        let wall = Plane {
            normal: -Vec3::X,
            d: 1.0,
        };
        let t = adjust_sphere_to_poly(&wall, 0.3, Vec3::new(0.6, 0.0, 0.0), Vec3::new(0.3, 0.0, 0.0));
        assert!((t - 1.0 / 3.0).abs() < 1e-5);
        // Touching already; moving along the plane; from behind.
        assert_eq!(
            adjust_sphere_to_poly(&wall, 0.3, Vec3::new(0.8, 0.0, 0.0), Vec3::X),
            1.0
        );
        assert_eq!(
            adjust_sphere_to_poly(&wall, 0.3, Vec3::new(0.6, 0.0, 0.0), Vec3::Y),
            0.0
        );
        let t = adjust_sphere_to_poly(&wall, 0.3, Vec3::new(2.0, 0.0, 0.0), -Vec3::X);
        assert!((t - 0.7).abs() < 1e-5);
    }
}
