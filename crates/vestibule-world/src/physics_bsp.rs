//! Physics BSPs: polygons to collide with, in a tree flattened into arrays (`transition.md` 6).

use crate::geometry::{Plane, Sphere};
use crate::polygon::PolygonSet;

/// Where a child of a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child(u32);

/// What a [`Child`] refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChildKind {
    /// No child: answers "nothing" to every query.
    Absent,
    /// Index into [`PhysicsBsp::nodes`].
    Node(usize),
    /// Index into [`PhysicsBsp::leaves`].
    Leaf(usize),
}

impl Child {
    const LEAF: u32 = 1 << 31;
    /// No child.
    pub const ABSENT: Child = Child(u32::MAX);

    /// A child that is the inner node `index`.
    pub const fn node(index: u32) -> Self {
        Child(index & !Self::LEAF)
    }

    /// A child that is the leaf `index`.
    pub const fn leaf(index: u32) -> Self {
        Child(index | Self::LEAF)
    }

    /// What this refers to.
    #[inline]
    pub const fn kind(self) -> ChildKind {
        if self.0 == u32::MAX {
            ChildKind::Absent
        } else if self.0 & Self::LEAF != 0 {
            ChildKind::Leaf((self.0 & !Self::LEAF) as usize)
        } else {
            ChildKind::Node(self.0 as usize)
        }
    }
}

/// An inner node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicsNode {
    /// Splitting plane.
    pub plane: Plane,
    /// Bounding sphere; `None` on a PORT node, which is never pruned (`transition.md` 6.1).
    pub sphere: Option<Sphere>,
    /// Child in front of the plane.
    pub positive: Child,
    /// Child behind the plane.
    pub negative: Child,
}

/// A leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicsLeaf {
    /// Whether its volume is solid.
    pub solid: bool,
    /// Bounding sphere of its polygons.
    pub sphere: Sphere,
    /// First entry in [`PhysicsBsp::leaf_polygons`].
    pub first: u32,
    /// Number of entries.
    pub count: u32,
}

/// A physics tree with the polygons it refers to; one per model or cell structure, shared by all that place it.
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicsBsp {
    /// The tree's root.
    pub root: Child,
    /// Inner nodes, parents before children.
    pub nodes: Box<[PhysicsNode]>,
    /// Leaves.
    pub leaves: Box<[PhysicsLeaf]>,
    /// Polygons of the leaves, in the leaves' own order: indices into `polygons`.
    pub leaf_polygons: Box<[u32]>,
    /// The polygons, owner-local coordinates.
    pub polygons: PolygonSet,
}

impl PhysicsBsp {
    /// The root's bounding sphere: the owner's physics sphere (`dat-format.md` G11).
    pub fn sphere(&self) -> Option<Sphere> {
        match self.root.kind() {
            ChildKind::Absent => None,
            ChildKind::Node(i) => self.nodes.get(i).and_then(|n| n.sphere),
            ChildKind::Leaf(i) => self.leaves.get(i).map(|l| l.sphere),
        }
    }

    /// The polygon indices of a leaf.
    #[inline]
    pub fn polygons_of(&self, leaf: &PhysicsLeaf) -> &[u32] {
        let first = leaf.first as usize;
        self.leaf_polygons
            .get(first..first + leaf.count as usize)
            .unwrap_or(&[])
    }
}
