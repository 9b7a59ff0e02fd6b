//! Physics trees: polygons to collide with in leaves, and which leaves are solid (`transition.md` 6).

use vestibule_dat::primitive::Sphere;
use vestibule_dat::record::{BspKind, BspLeafPhysics, BspNode, BspTag, BspTree};

use super::{BspError, Piece, best_splitter, bounding_sphere, check_count, stored};
use crate::geometry::{Plane, Polygon, Side};

/// A physics tree with the polygons it names.
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicsBsp {
    /// The tree.
    pub tree: BspTree,
    /// The polygons to store, in order of their ids.
    pub pieces: Vec<Piece>,
}

/// Builds a physics tree.
///
/// Polygons face away from what is solid: outwards on objects, into the room on the walls of a cell. A polygon goes
/// into the leaf *behind* it, so that the solid leaves of objects hold the polygons around them: the engine takes a
/// leaf for solid only if it has polygons.
///
/// `closing`: polygons that are not there but close the surface, such as doorways; they only help to tell what is
/// solid. `hull`: for a cell, its planes facing inwards. What is behind them is not the cell's to judge (the next cell may
/// be there), so it is never solid. Empty for objects.
///
/// # Errors
/// When there are too many polygons, or they need too deep a tree.
pub fn physics_bsp(
    polygons: &[Polygon],
    closing: &[Polygon],
    hull: &[Plane],
) -> Result<PhysicsBsp, BspError> {
    check_count(polygons.len())?;
    let items = polygons
        .iter()
        .enumerate()
        .map(|(source, polygon)| Item {
            piece: Piece {
                source,
                polygon: polygon.clone(),
            },
            used: false,
        })
        .chain(closing.iter().map(|polygon| Item {
            piece: Piece {
                source: CLOSING,
                polygon: polygon.clone(),
            },
            used: false,
        }))
        .collect();
    let sphere = bounding_sphere(polygons.iter().flat_map(|p| p.points.iter().copied()));
    let mut builder = Builder {
        nodes: Vec::new(),
        pieces: Vec::new(),
        leaves: 1,
        sphere,
    };
    builder.node(items, hull, Region::Open, 1)?;
    check_count(builder.pieces.len())?;
    Ok(PhysicsBsp {
        tree: BspTree {
            kind: BspKind::Physics,
            nodes: builder.nodes,
        },
        pieces: builder.pieces,
    })
}

/// `Piece::source` of what only closes the surface.
const CLOSING: usize = usize::MAX;

struct Item {
    piece: Piece,
    /// A plane above in the tree is this polygon's.
    used: bool,
}

/// What a part of space is if no polygon splits it further.
#[derive(Clone, Copy, PartialEq)]
enum Region {
    Open,
    Solid,
    /// Behind the hull of a cell.
    Elsewhere,
}

struct Builder {
    nodes: Vec<BspNode>,
    pieces: Vec<Piece>,
    leaves: i32,
    /// Around everything.
    sphere: Sphere,
}

/// What a subtree holds: its first piece and whether any leaf in it is solid.
struct Below {
    pieces: Vec<u16>,
    solid: bool,
}

impl Builder {
    fn node(
        &mut self,
        items: Vec<Item>,
        hull: &[Plane],
        region: Region,
        depth: usize,
    ) -> Result<Below, BspError> {
        if depth > BspTree::MAX_DEPTH {
            return Err(BspError::TooDeep);
        }
        let needed = hull
            .iter()
            .position(|h| items.iter().any(|i| i.piece.polygon.side(h) != Side::Front));
        let (plane, hull, behind) = match needed {
            Some(k) => (hull[k], &hull[k + 1..], Region::Elsewhere),
            None => {
                let polygons: Vec<&Polygon> = items.iter().map(|i| &i.piece.polygon).collect();
                let unused = items.iter().filter(|i| !i.used).map(|i| &i.piece.polygon.plane);
                match best_splitter(unused, &polygons, &[]) {
                    Some(plane) => (plane, &[][..], region.or_solid()),
                    None => return Ok(self.leaf(items, region)),
                }
            }
        };
        let (mut front, mut back) = (Vec::new(), Vec::new());
        for item in items {
            let Item {
                piece: Piece { source, polygon },
                mut used,
            } = item;
            let parts = match polygon.side(&plane) {
                Side::On => {
                    used = true;
                    // Behind it is where the plane's back is if both face the same way.
                    let same = polygon.plane.normal.dot(plane.normal) > 0.0;
                    if same {
                        (None, Some(polygon))
                    } else {
                        (Some(polygon), None)
                    }
                }
                _ => polygon.split(&plane),
            };
            let item = |polygon| Item {
                piece: Piece { source, polygon },
                used,
            };
            front.extend(parts.0.map(item));
            back.extend(parts.1.map(item));
        }
        let at = self.nodes.len();
        self.nodes.push(BspNode::Leaf {
            index: 0,
            physics: None,
        });
        let in_front = if behind == Region::Elsewhere {
            region
        } else {
            region.or_open()
        };
        let mut below = self.node(front, hull, in_front, depth + 1)?;
        let neg = self.nodes.len();
        let other = self.node(back, &[], behind, depth + 1)?;
        self.mark_solid(neg, &below.pieces);
        self.mark_solid(at + 1, &other.pieces);
        below.pieces.extend(other.pieces);
        below.solid |= other.solid;
        // A solid leaf may reach beyond the polygons below this node, never beyond all of them.
        let sphere = if below.solid {
            self.sphere
        } else {
            let polygons = below
                .pieces
                .iter()
                .map(|&id| &self.pieces[usize::from(id)].polygon);
            bounding_sphere(polygons.flat_map(|p| p.points.iter().copied()))
        };
        self.nodes[at] = BspNode::Inner {
            tag: BspTag::BPNN,
            plane: stored(&plane),
            pos: Some(at as u32 + 1),
            neg: Some(neg as u32),
            sphere: Some(sphere),
            polys: Vec::new(),
        };
        Ok(below)
    }

    fn leaf(&mut self, items: Vec<Item>, region: Region) -> Below {
        let first = self.pieces.len();
        self.pieces.extend(
            items
                .into_iter()
                .map(|item| item.piece)
                .filter(|p| p.source != CLOSING),
        );
        let polys: Vec<u16> = (first..self.pieces.len()).map(|id| id as u16).collect();
        let points = self.pieces[first..]
            .iter()
            .flat_map(|p| p.polygon.points.iter().copied());
        let sphere = bounding_sphere(points);
        let solid = region == Region::Solid;
        // By convention leaf 0 is the solid one.
        let index = if solid { 0 } else { self.leaves };
        self.leaves += i32::from(!solid);
        let physics = BspLeafPhysics {
            solid: u32::from(solid),
            sphere,
            polys: polys.clone(),
        };
        self.nodes.push(BspNode::Leaf {
            index,
            physics: Some(physics),
        });
        Below { pieces: polys, solid }
    }

    /// A solid leaf deep inside an object has no polygon of its own, and would not count as solid without one:
    /// it gets one of its sibling's.
    fn mark_solid(&mut self, leaf: usize, sibling: &[u16]) {
        if let Some(BspNode::Leaf {
            physics: Some(leaf), ..
        }) = self.nodes.get_mut(leaf)
            && let (true, true, Some(&id)) = (leaf.solid != 0, leaf.polys.is_empty(), sibling.first())
        {
            leaf.polys.push(id);
            let points = self.pieces[usize::from(id)].polygon.points.iter().copied();
            leaf.sphere = bounding_sphere(points);
        }
    }
}

impl Region {
    fn or_solid(self) -> Self {
        if self == Region::Elsewhere {
            self
        } else {
            Region::Solid
        }
    }

    fn or_open(self) -> Self {
        if self == Region::Elsewhere {
            self
        } else {
            Region::Open
        }
    }
}
