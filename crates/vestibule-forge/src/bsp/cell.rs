//! Cell trees: a chain of planes, inside where all are positive (`dat-format.md` G14).

use vestibule_dat::record::{BspKind, BspNode, BspTag, BspTree};

use super::stored;
use crate::geometry::{Plane, Polytope};

/// The planes of a convex solid, facing inwards.
pub fn inward_planes(solid: &Polytope) -> Vec<Plane> {
    solid.faces.iter().map(|f| f.polygon.plane.flipped()).collect()
}

/// The cell tree of the convex cell in front of all `planes`: a chain that ends in leaf 0. No planes: everything
/// is inside.
///
/// A cell tree can only say "in front of all these planes", so a cell that is not convex must be cut into convex
/// cells first ([`crate::geometry::convex_parts`], [`crate::geometry::merge_convex`]); a tree of its convex hull
/// would claim space that is not the cell's.
pub fn cell_bsp(planes: &[Plane]) -> BspTree {
    let mut nodes: Vec<BspNode> = (1u32..)
        .zip(planes)
        .map(|(next, plane)| BspNode::Inner {
            tag: BspTag::BPNN_LOWER,
            plane: stored(plane),
            pos: Some(next),
            neg: None,
            sphere: None,
            polys: Vec::new(),
        })
        .collect();
    nodes.push(BspNode::Leaf {
        index: 0,
        physics: None,
    });
    BspTree {
        kind: BspKind::Cell,
        nodes,
    }
}
