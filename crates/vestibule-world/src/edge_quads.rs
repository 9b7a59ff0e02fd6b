//! Edges of polygons in groups of four, so that a point is held against four at once (`transition.md` 6.5.1).

use glam::Vec3;

use crate::lanes::Lanes;
use crate::physics_bsp::FaceEdge;

/// Four edges of a polygon side by side: coordinates of where they start, of what points inwards, and of the way to
/// the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeQuad {
    start: [Lanes; 3],
    inward: [Lanes; 3],
    along: [Lanes; 3],
}

/// Where a point of a polygon's plane is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RimSide {
    /// On the inner side of all edges.
    Inside,
    /// Outside, near enough to an edge or a corner.
    Near,
    /// Outside.
    Away,
}

impl EdgeQuad {
    /// The edges of a polygon in their order. The last group is filled up with edges that every point is on the inner
    /// side of and far from.
    pub(crate) fn of(edges: &[FaceEdge]) -> impl Iterator<Item = EdgeQuad> {
        let next = |i: usize| edges.get(i + 1).or(edges.first()).map_or(Vec3::ZERO, |e| e.start);
        let count = edges.len().div_ceil(4);
        (0..count).map(move |first| {
            let mut quad = EdgeQuad {
                start: [Lanes::splat(1e18), Lanes::ZERO, Lanes::ZERO],
                inward: [Lanes::ZERO; 3],
                along: [Lanes::ZERO; 3],
            };
            for (k, i) in (4 * first..edges.len()).take(4).enumerate() {
                let edge = &edges[i];
                let along = next(i) - edge.start;
                for axis in 0..3 {
                    quad.start[axis].set_lane(k, edge.start[axis]);
                    quad.inward[axis].set_lane(k, edge.inward[axis]);
                    quad.along[axis].set_lane(k, along[axis]);
                }
            }
            quad
        })
    }
}

/// The products of four pairs of vectors side by side.
#[inline(always)]
fn dots(a: &[Lanes; 3], b: &[Lanes; 3]) -> Lanes {
    a[0].times(b[0]) + a[1].times(b[1]) + a[2].times(b[2])
}

/// Where a point of a polygon's plane is, near enough being within the square distance `reach`. The first edge decides
/// that the point is too far beyond, near the edge, or near the corner where it starts.
#[inline(always)]
pub fn rim_side(edges: &[EdgeQuad], p: Vec3, reach: f32) -> RimSide {
    let [x, y, z] = p.to_array().map(Lanes::splat);
    let mut is_inside = true;
    let mut near = None;
    for quad in edges {
        let w = [x - quad.start[0], y - quad.start[1], z - quad.start[2]];
        let inner = dots(&w, &quad.inward);
        let outside = inner.less(Lanes::ZERO);
        is_inside &= outside == 0;
        if near.is_some() {
            continue;
        }
        // The corner counts whether or not the point is beyond the edge.
        let corner = dots(&w, &w).at_most(Lanes::splat(reach));
        let (mut far, mut beside) = (0, 0);
        if outside != 0 {
            let limit = dots(&quad.inward, &quad.inward) * reach;
            far = outside & limit.less(inner.times(inner));
            let along = dots(&w, &quad.along);
            let length = dots(&quad.along, &quad.along);
            beside = outside & Lanes::ZERO.at_most(along) & along.at_most(length);
        }
        let decided = far | beside | corner;
        if decided != 0 {
            near = Some(far & (decided & decided.wrapping_neg()) == 0);
        }
    }
    match near {
        _ if is_inside => RimSide::Inside,
        Some(true) => RimSide::Near,
        _ => RimSide::Away,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pentagon around the origin in the plane z = 0.
    fn pentagon() -> Vec<EdgeQuad> {
        let corner = |k: usize| {
            let a = k as f32 * core::f32::consts::TAU / 5.0;
            Vec3::new(libm::cosf(a), libm::sinf(a), 0.0)
        };
        let edges: Vec<FaceEdge> = (0..5)
            .map(|k| FaceEdge {
                start: corner(k),
                inward: Vec3::Z.cross(corner(k + 1) - corner(k)),
            })
            .collect();
        EdgeQuad::of(&edges).collect()
    }

    #[test]
    fn s6_5_1_a_point_is_inside_near_an_edge_or_corner_or_away() {
        let edges = pentagon();
        assert_eq!(edges.len(), 2);
        let at = |x: f32, y: f32| rim_side(&edges, Vec3::new(x, y, 0.0), 0.01);
        assert_eq!((at(0.0, 0.0), at(0.95, 0.0)), (RimSide::Inside, RimSide::Inside));
        assert_eq!((at(1.05, 0.0), at(1.15, 0.0)), (RimSide::Near, RimSide::Away));
        // The middle of the edge opposite is 0.809 away.
        assert_eq!((at(-0.88, 0.0), at(-0.92, 0.0)), (RimSide::Near, RimSide::Away));
        assert_eq!(rim_side(&[], Vec3::ZERO, 0.01), RimSide::Inside);
    }
}
