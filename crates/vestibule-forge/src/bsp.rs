//! The three kinds of BSP tree, built from plain convex polygons (`dat-format.md` 8.3, `transition.md` 6).
//!
//! * [`cell_bsp`] says what is inside a convex cell;
//! * [`physics_bsp`] splits a polygon soup for collisions and marks what is solid;
//! * [`drawing_bsp`] sorts polygons for drawing and holds portals in PORT nodes.
//!
//! The builders cut polygons where splitting planes cross them and never lose area: parts thinner than
//! [`crate::geometry::ON_PLANE`] stay with their other half. Polygons in one plane, facing either way, share a
//! node. The answer lists the polygons to store; their ids are their positions in the list.
//!
//! ```
//! use glam::DVec3;
//! use vestibule_forge::bsp;
//! use vestibule_forge::geometry::Polytope;
//!
//! let crate_ = Polytope::cuboid(DVec3::ZERO, DVec3::splat(1.0)).ok_or("flat")?;
//! let polygons: Vec<_> = crate_.faces.iter().map(|f| f.polygon.clone()).collect();
//! let built = bsp::physics_bsp(&polygons, &[], &[])?;
//! assert_eq!(built.pieces.len(), 6); // nothing had to be cut
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cell;
mod drawing;
mod physics;
mod sphere;

pub use cell::{cell_bsp, inward_planes};
pub use drawing::{DrawingBsp, drawing_bsp};
pub use physics::{PhysicsBsp, physics_bsp};
pub use sphere::bounding_sphere;

use vestibule_dat::primitive;
use vestibule_dat::record::BspTree;

use crate::geometry::{Plane, Polygon, Side};

/// A polygon to store: one of the builder's input or a part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Position in the input of the polygon it was cut from.
    pub source: usize,
    /// Its shape.
    pub polygon: Polygon,
}

/// Why a tree could not be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BspError {
    /// More polygons than 16-bit ids can name.
    #[error("{0} polygons are more than a BSP tree can name (65,535)")]
    TooManyPolygons(usize),
    /// More vertices than 16-bit ids can name.
    #[error("{0} vertices are more than a model can have (65,536)")]
    TooManyVertices(usize),
    /// Deeper than readers accept (`dat-format.md` G13).
    #[error("the BSP tree would be more than {} nodes deep", BspTree::MAX_DEPTH)]
    TooDeep,
}

/// How many polygons are tried as splitters at a node, spread over those that could be.
const CANDIDATES: usize = 20;
/// How many polygons out of balance a cut polygon is worth when splitters are compared.
const SPLIT_COST: usize = 8;

/// The best plane to split `polygons` with, out of `candidates`; `forbidden` polygons must not be cut if that can
/// be helped.
pub(crate) fn best_splitter<'a>(
    candidates: impl Iterator<Item = &'a Plane> + Clone,
    polygons: &[&Polygon],
    forbidden: &[&Polygon],
) -> Option<Plane> {
    let count = candidates.clone().count();
    let step = count.div_ceil(CANDIDATES).max(1);
    let cost = |plane: &Plane| {
        let (mut front, mut back, mut cut) = (0usize, 0usize, 0usize);
        for p in polygons {
            match p.side(plane) {
                Side::Front => front += 1,
                Side::Back => back += 1,
                Side::On => {}
                Side::Across => cut += 1,
            }
        }
        let broken = forbidden.iter().filter(|p| p.side(plane) == Side::Across).count();
        broken * 10_000 + cut * SPLIT_COST + front.abs_diff(back)
    };
    candidates.step_by(step).min_by_key(|plane| cost(plane)).copied()
}

/// A plane as stored.
fn stored(plane: &Plane) -> primitive::Plane {
    let plane = plane.tidy();
    primitive::Plane {
        normal: plane.normal.as_vec3(),
        d: plane.d as f32,
    }
}

fn check_count(polygons: usize) -> Result<(), BspError> {
    if polygons > usize::from(u16::MAX) {
        Err(BspError::TooManyPolygons(polygons))
    } else {
        Ok(())
    }
}
