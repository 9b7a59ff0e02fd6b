//! BSP trees (`dat-format.md` 8.3).

use super::{RecordError, RecordErrorKind};
use crate::primitive::{Plane, Reader, Sphere, Writer};

/// Which of the three grammars a tree follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BspKind {
    /// Splits the polygons that are drawn.
    Drawing,
    /// Splits the polygons that are collided with.
    Physics,
    /// Says what is inside a cell.
    Cell,
}

/// A BSP tree as a flat array in file order (pre-order): node 0 is the root, a node's positive child follows it at once.
#[derive(Debug, Clone, PartialEq)]
pub struct BspTree {
    /// Which grammar.
    pub kind: BspKind,
    /// The nodes, root first. Never empty in a tree that was read.
    pub nodes: Vec<BspNode>,
}

/// One node.
#[derive(Debug, Clone, PartialEq)]
pub enum BspNode {
    /// A convex region.
    Leaf {
        /// Its number; by convention 0 is the solid outside of a physics tree.
        index: i32,
        /// Physics trees only.
        physics: Option<BspLeafPhysics>,
    },
    /// A splitting plane.
    Inner {
        /// The four characters as read, `BPnn` = 0x42506E6E and so on; see [`BspTag`].
        tag: u32,
        /// The splitting plane.
        plane: Plane,
        /// Index of the child on the positive side.
        pos: Option<u32>,
        /// Index of the child on the negative side.
        neg: Option<u32>,
        /// Sphere around all below; none in cell trees.
        sphere: Option<Sphere>,
        /// Ids of the polygons lying in the plane; drawing trees only.
        polys: Vec<u16>,
    },
    /// A splitting plane with portals in it.
    Portal {
        /// The splitting plane.
        plane: Plane,
        /// Index of the child on the positive side.
        pos: u32,
        /// Index of the child on the negative side.
        neg: u32,
        /// Sphere around all below; drawing trees only.
        sphere: Option<Sphere>,
        /// Ids of the polygons lying in the plane; drawing trees only.
        polys: Vec<u16>,
        /// Polygon id and portal index of each portal in the plane (G8, G12); drawing trees only.
        portal_polys: Vec<(u16, u16)>,
    },
}

/// What a leaf of a physics tree holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BspLeafPhysics {
    /// The word as read: non-zero means solid. Meaningful only for non-empty leaves (G9).
    pub solid: u32,
    /// Sphere around the polygons.
    pub sphere: Sphere,
    /// Ids of the polygons in the leaf.
    pub polys: Vec<u16>,
}

/// The tags of BSP nodes: four characters, the first in the highest byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BspTag;

#[allow(missing_docs, reason = "the names are the characters")]
impl BspTag {
    pub const LEAF: u32 = 0x4C45_4146;
    pub const PORT: u32 = 0x504F_5254;
    pub const BPNN_LOWER: u32 = 0x4250_6E6E;
    pub const BPIN_LOWER: u32 = 0x4250_496E;
    pub const BP_LOWER_IN: u32 = 0x4270_494E;
    pub const BP_LOWER_NN: u32 = 0x4270_6E4E;
    pub const BPIN: u32 = 0x4250_494E;
    pub const BPNN: u32 = 0x4250_6E4E;
    pub const BPOL: u32 = 0x4250_4F4C;
    pub const BPFL: u32 = 0x4250_464C;
}

impl BspTag {
    /// Whether an inner node with this tag has a positive and a negative child.
    pub fn children(tag: u32) -> (bool, bool) {
        match tag {
            Self::BPNN_LOWER | Self::BPIN_LOWER => (true, false),
            Self::BP_LOWER_IN | Self::BP_LOWER_NN => (false, true),
            Self::BPIN | Self::BPNN | Self::PORT => (true, true),
            _ => (false, false),
        }
    }

    /// The four characters; bytes that are not printable ASCII become `?`.
    pub fn text(tag: u32) -> String {
        let printable = |byte: u8| {
            if byte.is_ascii_graphic() {
                char::from(byte)
            } else {
                '?'
            }
        };
        tag.to_be_bytes().map(printable).into_iter().collect()
    }
}

impl BspNode {
    /// The node's tag.
    pub fn tag(&self) -> u32 {
        match self {
            Self::Leaf { .. } => BspTag::LEAF,
            Self::Inner { tag, .. } => *tag,
            Self::Portal { .. } => BspTag::PORT,
        }
    }

    /// The children: positive, negative.
    pub fn children(&self) -> (Option<u32>, Option<u32>) {
        match *self {
            Self::Leaf { .. } => (None, None),
            Self::Inner { pos, neg, .. } => (pos, neg),
            Self::Portal { pos, neg, .. } => (Some(pos), Some(neg)),
        }
    }

    /// The splitting plane, unless it is a leaf.
    pub fn plane(&self) -> Option<&Plane> {
        match self {
            Self::Leaf { .. } => None,
            Self::Inner { plane, .. } | Self::Portal { plane, .. } => Some(plane),
        }
    }

    /// The bounding sphere, where the kind of tree stores one.
    pub fn sphere(&self) -> Option<&Sphere> {
        match self {
            Self::Leaf { physics, .. } => physics.as_ref().map(|physics| &physics.sphere),
            Self::Inner { sphere, .. } | Self::Portal { sphere, .. } => sphere.as_ref(),
        }
    }

    /// The polygons the node holds itself.
    pub fn polys(&self) -> &[u16] {
        match self {
            Self::Leaf { physics, .. } => physics.as_ref().map_or(&[], |physics| &physics.polys),
            Self::Inner { polys, .. } | Self::Portal { polys, .. } => polys,
        }
    }
}

impl BspTree {
    /// The deepest tree that is read, counted in nodes (G13).
    pub const MAX_DEPTH: usize = 1024;
    /// The most nodes that are read (G13).
    pub const MAX_NODES: usize = 1_000_000;

    /// The root.
    pub fn root(&self) -> Option<&BspNode> {
        self.nodes.first()
    }

    /// The root's sphere; radius 0 at the origin where the tree has none (G11).
    pub fn bounding_sphere(&self) -> Sphere {
        self.root().and_then(BspNode::sphere).copied().unwrap_or_default()
    }
}
