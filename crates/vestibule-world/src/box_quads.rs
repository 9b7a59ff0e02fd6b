//! Planes and boxes of polygons in groups of four: which faces of a physics BSP a sphere is near, without a walk.

use glam::Vec3;

use crate::constants::EPSILON;
use crate::geometry::{BoundingBox, Plane};
use crate::lanes::Lanes;
use crate::physics_bsp::Face;

/// The planes and boxes of four polygons side by side, so that a sphere is held against all four at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoxQuad {
    planes: [Lanes; 4],
    center: [Lanes; 3],
    half: [Lanes; 3],
    /// Positions in the faces.
    pub(crate) faces: [u32; 4],
}

impl BoxQuad {
    /// Which polygons a sphere may overlap, a bit each, and the distances of its centre from their planes: those whose
    /// planes it reaches into by more than epsilon, and whose boxes the cube around it meets.
    #[inline(always)]
    pub(crate) fn near(&self, s: Lanes) -> (u32, Lanes) {
        let (p, radius) = (s.xyz(), s.fourth());
        let distances = Lanes::four_distances(&self.planes, s);
        let mut bits = !Lanes::splat(radius - EPSILON).less(distances.abs()) & 0b1111;
        for (axis, x) in [p.x, p.y, p.z].into_iter().enumerate() {
            // Leaving early.
            if bits != 0 {
                let away = (Lanes::splat(x) - self.center[axis]).abs();
                bits &= !(self.half[axis] + Lanes::splat(radius)).less(away);
            }
        }
        (bits, distances)
    }
}

impl BoxQuad {
    /// How far a sphere may be shifted and does not come nearer to a polygon's plane than its radius less epsilon, or
    /// does not meet its box: of the better the least. Zero or less: nothing is certain.
    #[inline(always)]
    pub(crate) fn clearances(&self, s: Lanes) -> Lanes {
        let (p, radius) = (s.xyz(), s.fourth());
        let mut clear = Lanes::four_distances(&self.planes, s).abs() - Lanes::splat(radius - EPSILON);
        if clear.less(Lanes::splat(f32::MIN_POSITIVE)) != 0 {
            for (axis, x) in [p.x, p.y, p.z].into_iter().enumerate() {
                let away = (Lanes::splat(x) - self.center[axis]).abs();
                clear = clear.greater(away - (self.half[axis] + Lanes::splat(radius)));
            }
        }
        clear
    }
}

/// A plane that nothing is near.
const NOWHERE: Plane = Plane {
    normal: Vec3::ZERO,
    d: f32::INFINITY,
};

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
    /// `boxes` has the boxes of the faces. `None` for large trees and such with planes that are no numbers.
    pub(crate) fn new(faces: &[Face], boxes: &[BoundingBox]) -> Option<Self> {
        let mut seen = std::collections::BTreeSet::new();
        let mut order: Vec<usize> = (0..faces.len())
            .filter(|&i| faces[i].edge_count != 0 && seen.insert(faces[i].polygon))
            .collect();
        let finite = |i: &usize| Lanes::of_plane(&faces[*i].plane).all_finite();
        if order.len() > MAX_SCANNED_FACES || !order.iter().all(finite) {
            return None;
        }
        let looks_up = |i: &usize| faces[*i].plane.normal.z >= LOOKS_UP;
        order.sort_by_key(|i| !looks_up(i));
        let up = order.iter().take_while(|i| looks_up(i)).count();
        let quads = order.chunks(4).map(|chunk| {
            let mut planes = [NOWHERE; 4];
            let mut center = [Lanes::ZERO; 3];
            let mut half = [Lanes::splat(f32::NEG_INFINITY); 3];
            let mut indices = [0; 4];
            for (k, &i) in chunk.iter().enumerate() {
                for axis in 0..3 {
                    center[axis].set_lane(k, (boxes[i].min[axis] + boxes[i].max[axis]) * 0.5);
                    half[axis].set_lane(k, (boxes[i].max[axis] - boxes[i].min[axis]) * 0.5);
                }
                planes[k] = faces[i].plane;
                indices[k] = i as u32;
            }
            BoxQuad {
                planes: Lanes::side_by_side(planes),
                center,
                half,
                faces: indices,
            }
        });
        Some(BoxQuads {
            quads: quads.collect(),
            up: up.div_ceil(4),
            only_up: order.first().filter(|_| up == 1).map(|&i| i as u32),
        })
    }
}
