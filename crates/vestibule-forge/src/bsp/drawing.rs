//! Drawing trees: polygons in the planes of inner nodes, portals in PORT nodes (`dat-format.md` 8.3, G8, G12).

use vestibule_dat::record::{BspKind, BspNode, BspTag, BspTree};

use super::{BspError, Piece, best_splitter, bounding_sphere, check_count, stored};
use crate::geometry::{Polygon, Side};

/// A drawing tree with the polygons it names.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawingBsp {
    /// The tree.
    pub tree: BspTree,
    /// The drawn polygons to store, in order of their ids. Portal `k` has the id `pieces.len() + k` and must be
    /// stored after them.
    pub pieces: Vec<Piece>,
    /// Number of leaves (a building's `num_leaves`).
    pub leaves: u32,
}

/// Builds a drawing tree over `polygons` with one PORT reference for each of `portals`, whose positions are the
/// portal indices. A portal is never cut.
///
/// # Errors
/// When there are too many polygons, or they need too deep a tree.
pub fn drawing_bsp(polygons: &[Polygon], portals: &[Polygon]) -> Result<DrawingBsp, BspError> {
    check_count(polygons.len() + portals.len())?;
    let mut builder = Builder {
        nodes: Vec::new(),
        pieces: Vec::new(),
        leaves: 1,
    };
    let pieces = polygons
        .iter()
        .cloned()
        .enumerate()
        .map(|(source, polygon)| Piece { source, polygon });
    builder.node(pieces.collect(), portals.iter().enumerate().collect(), true, 1)?;
    let Builder {
        mut nodes,
        pieces,
        leaves,
    } = builder;
    check_count(pieces.len() + portals.len())?;
    for node in &mut nodes {
        if let BspNode::Portal { portal_polys, .. } = node {
            for (polygon, index) in portal_polys {
                *polygon = (pieces.len() + usize::from(*index)) as u16;
            }
        }
    }
    Ok(DrawingBsp {
        tree: BspTree {
            kind: BspKind::Drawing,
            nodes,
        },
        pieces,
        leaves,
    })
}

struct Builder {
    nodes: Vec<BspNode>,
    pieces: Vec<Piece>,
    leaves: u32,
}

type Portals<'a> = Vec<(usize, &'a Polygon)>;

impl Builder {
    fn node(
        &mut self,
        pieces: Vec<Piece>,
        portals: Portals<'_>,
        in_front: bool,
        depth: usize,
    ) -> Result<(), BspError> {
        if depth > BspTree::MAX_DEPTH {
            return Err(BspError::TooDeep);
        }
        let polygons: Vec<&Polygon> = pieces.iter().map(|p| &p.polygon).collect();
        let uncut: Vec<&Polygon> = portals.iter().map(|(_, p)| *p).collect();
        let planes = uncut.iter().chain(&polygons).map(|p| &p.plane);
        let Some(plane) = best_splitter(planes, &polygons, &uncut) else {
            // Leaf 0 is the inside of what is solid.
            let index = if in_front { self.leaves as i32 } else { 0 };
            self.leaves += u32::from(in_front);
            self.nodes.push(BspNode::Leaf { index, physics: None });
            return Ok(());
        };
        let points = polygons
            .iter()
            .chain(&uncut)
            .flat_map(|p| p.points.iter().copied());
        let sphere = Some(bounding_sphere(points));
        let (mut front, mut back, mut polys) = (Vec::new(), Vec::new(), Vec::new());
        for Piece { source, polygon } in pieces {
            if polygon.side(&plane) == Side::On {
                polys.push(self.pieces.len() as u16);
                self.pieces.push(Piece { source, polygon });
                continue;
            }
            let parts = polygon.split(&plane);
            front.extend(parts.0.map(|polygon| Piece { source, polygon }));
            back.extend(parts.1.map(|polygon| Piece { source, polygon }));
        }
        let (mut front_portals, mut back_portals, mut portal_polys) = (Vec::new(), Vec::new(), Vec::new());
        for (index, portal) in portals {
            match portal.side(&plane) {
                Side::On => portal_polys.push((0, index as u16)),
                Side::Front => front_portals.push((index, portal)),
                Side::Back => back_portals.push((index, portal)),
                // Two portals that cut each other: the larger part decides.
                Side::Across if plane.dist(portal.center()) >= 0.0 => front_portals.push((index, portal)),
                Side::Across => back_portals.push((index, portal)),
            }
        }
        let at = self.nodes.len();
        self.nodes.push(BspNode::Leaf {
            index: 0,
            physics: None,
        });
        let plane = stored(&plane);
        let has = |pieces: &[Piece], portals: &Portals<'_>| !pieces.is_empty() || !portals.is_empty();
        if portal_polys.is_empty() {
            let (pos, neg) = (has(&front, &front_portals), has(&back, &back_portals));
            let pos_at = pos.then_some(at as u32 + 1);
            if pos {
                self.node(front, front_portals, true, depth + 1)?;
            }
            let neg_at = neg.then_some(self.nodes.len() as u32);
            if neg {
                self.node(back, back_portals, false, depth + 1)?;
            }
            let tag = match (pos, neg) {
                (true, true) => BspTag::BPIN,
                (true, false) => BspTag::BPIN_LOWER,
                (false, true) => BspTag::BP_LOWER_IN,
                (false, false) => BspTag::BPOL,
            };
            self.nodes[at] = BspNode::Inner {
                tag,
                plane,
                pos: pos_at,
                neg: neg_at,
                sphere,
                polys,
            };
        } else {
            self.node(front, front_portals, true, depth + 1)?;
            let neg = self.nodes.len() as u32;
            self.node(back, back_portals, false, depth + 1)?;
            let pos = at as u32 + 1;
            self.nodes[at] = BspNode::Portal {
                plane,
                pos,
                neg,
                sphere,
                polys,
                portal_polys,
            };
        }
        Ok(())
    }
}
