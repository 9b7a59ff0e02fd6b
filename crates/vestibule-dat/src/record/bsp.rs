//! BSP trees (`dat-format.md` 8.3).

use super::{RecordError, RecordErrorKind};
use crate::primitive::{Plane, Reader, Sphere, Writer};

/// Which of the three grammars a tree follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BspTree {
    /// Which grammar.
    pub kind: BspKind,
    /// The nodes, root first. Never empty in a tree that was read.
    pub nodes: Vec<BspNode>,
}

/// One node.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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

/// How far reading or writing has come with a node that has children.
enum Step {
    /// Its positive child is next, then its negative one.
    Positive,
    /// Its negative child is next.
    Negative,
    /// Only what follows the children is left.
    Tail,
}

impl BspTree {
    /// Reads one tree. The nesting is on a stack of ours, so no input can overflow the program's.
    pub(crate) fn read(reader: &mut Reader<'_>, kind: BspKind) -> Result<Self, RecordError> {
        let mut nodes: Vec<BspNode> = Vec::new();
        let mut open: Vec<(u32, Step)> = Vec::new();
        loop {
            // One node's head.
            if nodes.len() == Self::MAX_NODES {
                return Err(reader.error(
                    "bsp",
                    RecordErrorKind::BspTooManyNodes {
                        limit: Self::MAX_NODES,
                    },
                ));
            }
            if open.len() == Self::MAX_DEPTH {
                return Err(reader.error(
                    "bsp",
                    RecordErrorKind::BspTooDeep {
                        limit: Self::MAX_DEPTH,
                    },
                ));
            }
            let index = nodes.len() as u32;
            let (node, step) = read_head(reader, kind)?;
            nodes.push(node);
            if let Some(step) = step {
                open.push((index, step));
            }
            // Then upwards: close every node whose children are complete, and stop at one that wants a child.
            loop {
                let child = nodes.len() as u32;
                let Some((index, step)) = open.last_mut() else {
                    return Ok(Self { kind, nodes });
                };
                // Never missing: only nodes of the list are open.
                let Some(node) = nodes.get_mut(*index as usize) else {
                    return Ok(Self { kind, nodes });
                };
                match step {
                    Step::Positive => {
                        *step = if node.set_positive(child) {
                            Step::Negative
                        } else {
                            Step::Tail
                        };
                        break;
                    }
                    Step::Negative => {
                        *step = Step::Tail;
                        node.set_negative(child);
                        break;
                    }
                    Step::Tail => {
                        read_tail(reader, kind, node)?;
                        open.pop();
                    }
                }
            }
        }
    }

    /// Writes the tree where one of this kind belongs.
    pub(crate) fn write_as(&self, kind: BspKind, writer: &mut Writer) -> Result<(), RecordError> {
        writer.require(self.kind == kind, "bsp.kind", "another kind of tree belongs here")?;
        self.write(writer)
    }

    /// Writes the tree from its root, following the child indices.
    pub(crate) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        let mut written = 0;
        let mut open: Vec<(u32, Step)> = vec![(0, Step::Positive)];
        self.write_head(0, writer)?;
        while let Some((index, step)) = open.last_mut() {
            let node = self.node(*index, writer)?;
            let (pos, neg) = node.children();
            let child = match step {
                Step::Positive => {
                    *step = Step::Negative;
                    pos
                }
                Step::Negative => {
                    *step = Step::Tail;
                    neg
                }
                Step::Tail => {
                    self.write_tail(node, writer)?;
                    open.pop();
                    continue;
                }
            };
            if let Some(child) = child {
                written += 1;
                writer.require(
                    written < self.nodes.len(),
                    "bsp.child",
                    "every node but the root is one node's child",
                )?;
                if open.len() == Self::MAX_DEPTH {
                    return Err(writer.error(
                        "bsp",
                        RecordErrorKind::BspTooDeep {
                            limit: Self::MAX_DEPTH,
                        },
                    ));
                }
                self.write_head(child, writer)?;
                open.push((child, Step::Positive));
            }
        }
        writer.require(
            written + 1 == self.nodes.len(),
            "bsp",
            "every node but the root is one node's child",
        )
    }

    fn node(&self, index: u32, writer: &Writer) -> Result<&BspNode, RecordError> {
        let missing = || {
            writer.error(
                "bsp.child",
                RecordErrorKind::Inconsistent("a child index names no node"),
            )
        };
        self.nodes.get(index as usize).ok_or_else(missing)
    }

    fn write_head(&self, index: u32, writer: &mut Writer) -> Result<(), RecordError> {
        let node = self.node(index, writer)?;
        writer.u32(node.tag());
        match node {
            BspNode::Leaf { index, physics } => {
                writer.i32(*index);
                let wanted = self.kind == BspKind::Physics;
                writer.require(
                    physics.is_some() == wanted,
                    "leaf",
                    "leaves of physics trees, and only they, have content",
                )?;
                if let Some(physics) = physics {
                    writer.u32(physics.solid);
                    writer.sphere(&physics.sphere);
                    writer.count32(physics.polys.len(), "leaf.polys")?;
                    writer.u16s(&physics.polys);
                }
                Ok(())
            }
            BspNode::Inner {
                tag, plane, pos, neg, ..
            } => {
                let sound = is_inner_tag(*tag) && BspTag::children(*tag) == (pos.is_some(), neg.is_some());
                writer.require(
                    sound,
                    "node.tag",
                    "the tag of an inner node says which children it has",
                )?;
                writer.plane(plane);
                Ok(())
            }
            BspNode::Portal { plane, .. } => {
                writer.plane(plane);
                Ok(())
            }
        }
    }

    fn write_tail(&self, node: &BspNode, writer: &mut Writer) -> Result<(), RecordError> {
        let drawing = self.kind == BspKind::Drawing;
        let has_sphere = match node {
            BspNode::Leaf { .. } => return Ok(()),
            BspNode::Inner { .. } => self.kind != BspKind::Cell,
            BspNode::Portal { .. } => drawing,
        };
        let sphere = node.sphere();
        let what = "nodes have a sphere and polygons where their kind of tree stores them";
        writer.require(sphere.is_some() == has_sphere, "node.sphere", what)?;
        writer.require(drawing || node.polys().is_empty(), "node.polys", what)?;
        if let Some(sphere) = sphere {
            writer.sphere(sphere);
        }
        if drawing {
            writer.count32(node.polys().len(), "node.polys")?;
            if let BspNode::Portal { portal_polys, .. } = node {
                writer.count32(portal_polys.len(), "node.portal_polys")?;
            }
            writer.u16s(node.polys());
        }
        if let BspNode::Portal { portal_polys, .. } = node {
            writer.require(drawing || portal_polys.is_empty(), "node.portal_polys", what)?;
            for &(polygon, portal) in portal_polys {
                writer.u16s(&[polygon, portal]);
            }
        }
        Ok(())
    }
}

impl BspNode {
    /// Notes the positive child; whether a negative one is to come.
    fn set_positive(&mut self, child: u32) -> bool {
        match self {
            Self::Leaf { .. } => false,
            Self::Inner { tag, pos, .. } => {
                *pos = Some(child);
                BspTag::children(*tag).1
            }
            Self::Portal { pos, .. } => {
                *pos = child;
                true
            }
        }
    }

    fn set_negative(&mut self, child: u32) {
        match self {
            Self::Leaf { .. } => {}
            Self::Inner { neg, .. } => *neg = Some(child),
            Self::Portal { neg, .. } => *neg = child,
        }
    }
}

/// Whether the tag is one of the inner nodes': its first letter is B.
fn is_inner_tag(tag: u32) -> bool {
    tag >> 24 == u32::from(b'B')
}

/// All of a node that comes before its children, and what is next; nothing after a leaf.
fn read_head(reader: &mut Reader<'_>, kind: BspKind) -> Result<(BspNode, Option<Step>), RecordError> {
    let start = reader.position();
    let tag = reader.u32("node.tag")?;
    match tag {
        BspTag::LEAF => {
            let index = reader.i32("leaf.index")?;
            let physics = if kind == BspKind::Physics {
                let solid = reader.u32("leaf.solid")?;
                let sphere = reader.sphere("leaf.sphere")?;
                let count = reader.count32(2, "leaf.polys")?;
                Some(BspLeafPhysics {
                    solid,
                    sphere,
                    polys: reader.u16s(count, "leaf.polys")?,
                })
            } else {
                None
            };
            Ok((BspNode::Leaf { index, physics }, None))
        }
        BspTag::PORT => {
            let plane = reader.plane("portal.plane")?;
            let node = BspNode::Portal {
                plane,
                pos: 0,
                neg: 0,
                sphere: None,
                polys: Vec::new(),
                portal_polys: Vec::new(),
            };
            Ok((node, Some(Step::Positive)))
        }
        tag if is_inner_tag(tag) => {
            let plane = reader.plane("node.plane")?;
            let node = BspNode::Inner {
                tag,
                plane,
                pos: None,
                neg: None,
                sphere: None,
                polys: Vec::new(),
            };
            let step = match BspTag::children(tag) {
                (true, _) => Step::Positive,
                (false, true) => Step::Negative,
                (false, false) => Step::Tail,
            };
            Ok((node, Some(step)))
        }
        tag => Err(reader.error_at(start, "node.tag", RecordErrorKind::BadBspTag(tag))),
    }
}

/// What comes after a node's children.
fn read_tail(reader: &mut Reader<'_>, kind: BspKind, node: &mut BspNode) -> Result<(), RecordError> {
    match node {
        BspNode::Leaf { .. } => {}
        BspNode::Inner { sphere, polys, .. } => {
            if kind != BspKind::Cell {
                *sphere = Some(reader.sphere("node.sphere")?);
            }
            if kind == BspKind::Drawing {
                let count = reader.count32(2, "node.polys")?;
                *polys = reader.u16s(count, "node.polys")?;
            }
        }
        BspNode::Portal {
            sphere,
            polys,
            portal_polys,
            ..
        } => {
            if kind == BspKind::Drawing {
                *sphere = Some(reader.sphere("portal.sphere")?);
                let poly_count = reader.count32(2, "portal.polys")?;
                let portal_count = reader.count32(4, "portal.portal_polys")?;
                *polys = reader.u16s(poly_count, "portal.polys")?;
                let portal_count = reader.check_count(portal_count as u64, 4, "portal.portal_polys")?;
                *portal_polys = reader.items(portal_count, |reader| {
                    Ok((
                        reader.u16("portal.polygon_id")?,
                        reader.u16("portal.portal_index")?,
                    ))
                })?;
            }
        }
    }
    Ok(())
}
