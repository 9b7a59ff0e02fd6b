//! Planes in groups of four: which faces of a physics BSP a sphere is near, without a walk.

use glam::Vec3;

use crate::geometry::Plane;
use crate::physics_bsp::Face;

/// The planes of four polygons side by side, so that a sphere is held against all four at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaneQuad {
    x: [f32; 4],
    y: [f32; 4],
    z: [f32; 4],
    d: [f32; 4],
    /// Positions in the faces.
    pub(crate) faces: [u32; 4],
}

impl PlaneQuad {
    /// Planes that nothing is near.
    const EMPTY: PlaneQuad = PlaneQuad {
        x: [0.0; 4],
        y: [0.0; 4],
        z: [0.0; 4],
        d: [f32::INFINITY; 4],
        faces: [0; 4],
    };

    /// Which planes are within `reach` of `p`; the same arithmetic as [`Plane::dist`], lane by lane.
    #[inline]
    pub(crate) fn near(&self, p: Vec3, reach: f32) -> u32 {
        let mut bits = 0;
        for k in 0..4 {
            let dist = self.x[k] * p.x + self.y[k] * p.y + self.z[k] * p.z + self.d[k];
            let far = reach < dist.abs();
            bits |= u32::from(!far) << k;
        }
        bits
    }
}

/// Trees with more polygons than this are only ever walked.
const MAX_SCANNED_FACES: usize = 96;

/// Faces whose normal z is at least this look up.
const LOOKS_UP: f32 = 0.05;

/// Each polygon's plane once, in groups of four, those that look up first; and how many groups those fill.
pub(crate) fn plane_quads(faces: &[Face]) -> (Option<Box<[PlaneQuad]>>, usize) {
    let mut seen = std::collections::BTreeSet::new();
    let mut order: Vec<usize> = (0..faces.len())
        .filter(|&i| faces[i].edge_count != 0 && seen.insert(faces[i].polygon))
        .collect();
    if order.len() > MAX_SCANNED_FACES {
        return (None, 0);
    }
    let looks_up = |i: &usize| faces[*i].plane.normal.z >= LOOKS_UP;
    order.sort_by_key(|i| !looks_up(i));
    let up = order.iter().take_while(|i| looks_up(i)).count();
    let quads = order.chunks(4).map(|chunk| {
        let mut quad = PlaneQuad::EMPTY;
        for (k, &i) in chunk.iter().enumerate() {
            let Plane { normal, d } = faces[i].plane;
            (quad.x[k], quad.y[k], quad.z[k], quad.d[k]) = (normal.x, normal.y, normal.z, d);
            quad.faces[k] = i as u32;
        }
        quad
    });
    (Some(quads.collect()), up.div_ceil(4))
}

/// The only face that looks up, if there is just one.
pub(crate) fn only_face_up(quads: &[PlaneQuad], faces: &[Face]) -> Option<u32> {
    let lanes = quads
        .iter()
        .flat_map(|q| q.faces.iter().zip(&q.z).zip(&q.d))
        .filter(|((_, z), d)| **z >= LOOKS_UP && d.is_finite());
    let mut up = lanes.map(|((&face, _), _)| face);
    let only = up.next()?;
    (up.next().is_none() && (only as usize) < faces.len()).then_some(only)
}
