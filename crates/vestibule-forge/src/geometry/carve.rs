//! Convex parts of the space inside closed walls.

use glam::DVec3;

use super::{CUT, Plane, Polygon, Polytope, Side};
use crate::bsp::best_splitter;

/// How many walls may be cut through one after the other.
const MAX_DEPTH: usize = 512;

/// Cuts the space inside closed walls into convex solids that touch but do not overlap. The polygons face the inside
/// and close it without gaps; what they do not close is cut off a metre around them. Faces are tagged [`CUT`].
/// See [`super::merge_convex`] to join what need not be apart.
pub fn carve(walls: &[Polygon]) -> Vec<Polytope> {
    let inside = |plane: &Plane, p: &Polygon| matches!(p.side(plane), Side::Front | Side::On);
    if walls.iter().all(|w| walls.iter().all(|p| inside(&w.plane, p))) {
        let planes: Vec<(Plane, u32)> = walls.iter().map(|w| (w.plane.flipped(), CUT)).collect();
        return Polytope::from_planes(&planes).into_iter().collect();
    }
    let points = walls.iter().flat_map(|w| w.points.iter());
    let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
        (low.min(*p), high.max(*p))
    });
    let mut out = Vec::new();
    if let Some(space) = Polytope::cuboid(low - 1.0, high + 1.0) {
        split(space, walls.to_vec(), false, &mut out, 0);
    }
    out
}

fn split(space: Polytope, walls: Vec<Polygon>, inside: bool, out: &mut Vec<Polytope>, depth: usize) {
    let all: Vec<&Polygon> = walls.iter().collect();
    let splitter = best_splitter(walls.iter().map(|p| &p.plane), &all, &[]);
    let Some(plane) = splitter.filter(|_| depth < MAX_DEPTH) else {
        if inside {
            out.push(space);
        }
        return;
    };
    let (mut front, mut back) = (Vec::new(), Vec::new());
    // What is left of a side without further walls is inside if a wall between the two faces that way.
    let (mut front_inside, mut back_inside) = (false, false);
    for wall in walls {
        if wall.side(&plane) == Side::On {
            let same = wall.plane.normal.dot(plane.normal) > 0.0;
            front_inside |= same;
            back_inside |= !same;
        } else {
            let parts = wall.split(&plane);
            front.extend(parts.0);
            back.extend(parts.1);
        }
    }
    let (near, far) = space.split(&plane, CUT);
    if let Some(near) = near {
        split(near, front, front_inside, out, depth + 1);
    }
    if let Some(far) = far {
        split(far, back, back_inside, out, depth + 1);
    }
}
