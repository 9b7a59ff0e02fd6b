//! What of a physics BSP is solid, and how far a sphere is from it (`transition.md` 6.3): walks as those of
//! [`crate::bsp_tree`]. Everything is in the tree's space.

use glam::Vec3;
use vestibule_world::{Child, ChildKind, Face, Lanes, PhysicsBsp, Sphere};

use crate::bsp_tree::{Reach, is_sure, reach, reached_faces};
use crate::polygon::{self, Overlap};

/// Whether the point is in front of solid ground: in a leaf that has polygons (6.3.1).
pub fn point_intersects_solid(bsp: &PhysicsBsp, p: Vec3) -> bool {
    let mut at = bsp.root;
    loop {
        match at.kind() {
            ChildKind::Absent => return false,
            ChildKind::Leaf(leaf) => return bsp.leaves().get(leaf).is_some_and(|l| l.count != 0),
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return false;
                };
                at = if node.plane.dist(p) >= 0.0 {
                    node.positive
                } else {
                    node.negative
                };
            }
        }
    }
}

/// Whether the sphere overlaps a polygon, or its centre a solid leaf when `center_check` (6.3.2).
#[inline(always)]
pub(crate) fn sphere_intersects_solid(bsp: &PhysicsBsp, s: Lanes, center_check: bool) -> bool {
    let hollow = !center_check || bsp.open_is_hollow();
    !(hollow && bsp.certainly_clear(s)) && finds_solid(bsp, s, center_check)
}

#[inline(never)]
fn finds_solid(bsp: &PhysicsBsp, s: Lanes, center_check: bool) -> bool {
    let mut hit = false;
    let sure = bsp.any_face_near(s, false, |face, distance| {
        let overlap = polygon::overlap_at(face, bsp.edge_quads(face), s, distance);
        hit |= overlap != Overlap::None;
        overlap != Overlap::None && is_sure(bsp, face, overlap, s)
    });
    match sure {
        Some(true) => true,
        Some(false) if !hit => {
            center_check && !bsp.is_certainly_hollow_around(s, 0.0) && center_is_solid(bsp, &s.into())
        }
        _ => solid(bsp, bsp.root, &s.into(), center_check),
    }
}

/// How far the sphere may be shifted and certainly overlaps no polygon, its centre in nothing solid, metres. Zero:
/// it overlaps none where it is, and more is not known. Below zero: it overlaps some.
#[inline(always)]
pub(crate) fn clearance(bsp: &PhysicsBsp, s: Lanes) -> f32 {
    /// Farther than a body is lifted that stood before.
    const REACH: f32 = 0.01;
    if bsp.certainly_clear(s) {
        return 0.0;
    }
    match bsp.clearance(s) {
        Some(d) if bsp.is_certainly_hollow_around(s, REACH) || is_hollow_around(bsp, s, REACH) => {
            if d < REACH { d } else { REACH }
        }
        Some(_) => 0.0,
        None if finds_solid(bsp, s, false) => -1.0,
        None => 0.0,
    }
}

/// Whether the centre, shifted by up to `reach`, is in no leaf that is solid and has polygons; `false` where that is not
/// told by one way through the tree.
fn is_hollow_around(bsp: &PhysicsBsp, s: Lanes, reach: f32) -> bool {
    let mut at = bsp.root;
    loop {
        match at.kind() {
            ChildKind::Absent => return true,
            ChildKind::Leaf(index) => {
                return !bsp.leaves().get(index).is_some_and(|l| l.count != 0 && l.solid);
            }
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return true;
                };
                // Planes may be a little longer than unit vectors.
                let dist = Lanes::of_plane(&node.plane).dist(s);
                let n = node.plane.normal;
                let limit = reach * 1.01;
                at = if n.dot(n) > 1.01 {
                    return false;
                } else if dist > limit {
                    node.positive
                } else if dist < -limit {
                    node.negative
                } else {
                    return false;
                };
            }
        }
    }
}

/// Whether the leaf on the centre's side of everything is solid and has polygons (6.3.2).
fn center_is_solid(bsp: &PhysicsBsp, s: &Sphere) -> bool {
    let mut at = bsp.root;
    loop {
        match at.kind() {
            ChildKind::Absent => return false,
            ChildKind::Leaf(index) => {
                return bsp.leaves().get(index).is_some_and(|l| l.count != 0 && l.solid);
            }
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return false;
                };
                at = match reach(node, s, s.radius) {
                    Reach::None => return false,
                    Reach::Positive => node.positive,
                    Reach::Negative => node.negative,
                    Reach::Both(dist) if dist >= 0.0 => node.positive,
                    Reach::Both(_) => node.negative,
                };
            }
        }
    }
}

fn solid(bsp: &PhysicsBsp, mut at: Child, s: &Sphere, mut center_check: bool) -> bool {
    loop {
        match at.kind() {
            ChildKind::Absent => return false,
            ChildKind::Leaf(index) => {
                let Some(leaf) = bsp.leaves().get(index) else {
                    return false;
                };
                if leaf.count == 0 {
                    return false;
                }
                if leaf.solid && center_check {
                    return true;
                }
                return reached_faces(bsp, index, s)
                    .iter()
                    .any(|face| polygon::polygon_hits_sphere(face, bsp.edges(face), s));
            }
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return false;
                };
                match reach(node, s, s.radius) {
                    Reach::None => return false,
                    Reach::Positive => at = node.positive,
                    Reach::Negative => at = node.negative,
                    Reach::Both(dist) => {
                        // Only the child on the centre's side is asked about the centre.
                        let in_front = dist >= 0.0;
                        if solid(bsp, node.positive, s, center_check && in_front) {
                            return true;
                        }
                        center_check = center_check && !in_front;
                        at = node.negative;
                    }
                }
            }
        }
    }
}

/// What [`sphere_intersects_solid_poly`] finds. The walk sets these and never clears them.
#[derive(Default)]
pub(crate) struct SolidPoly<'b> {
    pub(crate) center_solid: bool,
    pub(crate) hit: Option<&'b Face>,
}

/// As [`sphere_intersects_solid`], naming the polygon; `radius` decides what straddles (6.3.3).
pub(crate) fn sphere_intersects_solid_poly<'b>(
    bsp: &'b PhysicsBsp,
    s: &Sphere,
    radius: f32,
    found: &mut SolidPoly<'b>,
    center_check: bool,
) -> bool {
    solid_poly(bsp, bsp.root, s, radius, found, center_check)
}

fn solid_poly<'b>(
    bsp: &'b PhysicsBsp,
    mut at: Child,
    s: &Sphere,
    radius: f32,
    found: &mut SolidPoly<'b>,
    mut center_check: bool,
) -> bool {
    loop {
        match at.kind() {
            ChildKind::Absent => return false,
            ChildKind::Leaf(index) => {
                let Some(leaf) = bsp.leaves().get(index) else {
                    return false;
                };
                if leaf.count == 0 {
                    return false;
                }
                if center_check && leaf.solid {
                    found.center_solid = true;
                }
                let hits = |face: &&Face| polygon::polygon_hits_sphere(face, bsp.edges(face), s);
                if let Some(face) = reached_faces(bsp, index, s).iter().find(hits) {
                    found.hit = Some(face);
                    return true;
                }
                return found.center_solid;
            }
            ChildKind::Node(index) => {
                let Some(node) = bsp.nodes().get(index) else {
                    return false;
                };
                match reach(node, s, radius) {
                    Reach::None => return false,
                    Reach::Positive => at = node.positive,
                    Reach::Negative => at = node.negative,
                    Reach::Both(dist) => {
                        let (near, far) = if dist <= 0.0 {
                            (node.negative, node.positive)
                        } else {
                            (node.positive, node.negative)
                        };
                        solid_poly(bsp, near, s, radius, found, center_check);
                        if found.hit.is_some() {
                            return found.center_solid;
                        }
                        center_check = false;
                        at = far;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_world::{PhysicsLeaf, PhysicsNode, Plane, PolygonSet};

    /// Solid where x is below zero, with a wall of 20 m in between.
    fn half_space() -> PhysicsBsp {
        let mut set = PolygonSet::default();
        let wall = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)];
        assert!(set.push(0, false, &wall.map(|(y, z)| Vec3::new(0.0, y, z))));
        let sphere = Sphere::new(Vec3::ZERO, 100.0);
        let leaf = |solid, count| PhysicsLeaf {
            solid,
            sphere,
            first: 0,
            count,
        };
        let node = PhysicsNode {
            plane: Plane {
                normal: Vec3::X,
                d: 0.0,
            },
            sphere: Some(sphere),
            positive: Child::leaf(0),
            negative: Child::leaf(1),
        };
        PhysicsBsp::new(
            Child::node(0),
            vec![node],
            vec![leaf(false, 0), leaf(true, 1)],
            &[0],
            set,
        )
    }

    #[test]
    fn s6_3_2_nothing_is_clear_in_what_is_solid() {
        let bsp = half_space();
        let at = |x: f32| Lanes::new(Vec3::new(x, 0.0, 0.0), 0.48);
        let clear = |x: f32| clearance(&bsp, at(x));
        assert!(clear(2.0) > 0.0 && clear(0.6) > 0.0 && clear(0.3) < 0.0 && clear(-0.3) < 0.0);
        // It overlaps no polygon there, but a placement asks for the centre too.
        assert_eq!(clear(-2.0), 0.0);
        assert!(
            sphere_intersects_solid(&bsp, at(-2.0), true) && !sphere_intersects_solid(&bsp, at(-2.0), false)
        );
        assert!(!sphere_intersects_solid(&bsp, at(2.0), true));
    }
}
