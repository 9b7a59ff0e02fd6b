//! Boxes of polygons in groups of four: which faces of a physics BSP a sphere is near, without a walk.

use glam::Vec3;

use crate::geometry::BoundingBox;
use crate::physics_bsp::Face;

/// The boxes of four polygons side by side, so that a sphere is held against all four at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoxQuad {
    center: [[f32; 4]; 3],
    half: [[f32; 4]; 3],
    /// Positions in the faces.
    pub(crate) faces: [u32; 4],
}

impl BoxQuad {
    /// Boxes that nothing is near.
    const EMPTY: BoxQuad = BoxQuad {
        center: [[0.0; 4]; 3],
        half: [[f32::NEG_INFINITY; 4]; 3],
        faces: [0; 4],
    };

    /// Which boxes the cube around a sphere meets.
    #[inline(always)]
    pub(crate) fn near(&self, p: Vec3, radius: f32) -> u32 {
        // Axis by axis, leaving early: which is also what compiles to four lanes at once.
        let mut bits = within(p.x, radius, &self.center[0], &self.half[0]);
        if bits != 0 {
            bits &= within(p.y, radius, &self.center[1], &self.half[1]);
        }
        if bits != 0 {
            bits &= within(p.z, radius, &self.center[2], &self.half[2]);
        }
        bits
    }
}

/// Which of four intervals on an axis are within `radius` of `x`.
#[inline(always)]
fn within(x: f32, radius: f32, center: &[f32; 4], half: &[f32; 4]) -> u32 {
    let mut bits = 0;
    for k in 0..4 {
        let far = half[k] + radius < (x - center[k]).abs();
        bits |= u32::from(!far) << k;
    }
    bits
}

/// Trees with more polygons than this are only ever walked.
const MAX_SCANNED_FACES: usize = 96;

/// Faces whose normal z is at least this look up.
const LOOKS_UP: f32 = 0.05;

/// What is known of the faces of a tree without walking it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BoxQuads {
    /// Each polygon's box once, those that look up first.
    pub(crate) quads: Box<[BoxQuad]>,
    /// How many of `quads` hold the faces that look up.
    pub(crate) up: usize,
    /// The only face that looks up, if there is just one.
    pub(crate) only_up: Option<u32>,
}

impl BoxQuads {
    /// `boxes` has the boxes of the faces. `None` for large trees.
    pub(crate) fn new(faces: &[Face], boxes: &[BoundingBox]) -> Option<Self> {
        let mut seen = std::collections::BTreeSet::new();
        let mut order: Vec<usize> = (0..faces.len())
            .filter(|&i| faces[i].edge_count != 0 && seen.insert(faces[i].polygon))
            .collect();
        if order.len() > MAX_SCANNED_FACES {
            return None;
        }
        let looks_up = |i: &usize| faces[*i].plane.normal.z >= LOOKS_UP;
        order.sort_by_key(|i| !looks_up(i));
        let up = order.iter().take_while(|i| looks_up(i)).count();
        let quads = order.chunks(4).map(|chunk| {
            let mut quad = BoxQuad::EMPTY;
            for (k, &i) in chunk.iter().enumerate() {
                for axis in 0..3 {
                    quad.center[axis][k] = (boxes[i].min[axis] + boxes[i].max[axis]) * 0.5;
                    quad.half[axis][k] = (boxes[i].max[axis] - boxes[i].min[axis]) * 0.5;
                }
                quad.faces[k] = i as u32;
            }
            quad
        });
        Some(BoxQuads {
            quads: quads.collect(),
            up: up.div_ceil(4),
            only_up: order.first().filter(|_| up == 1).map(|&i| i as u32),
        })
    }
}
