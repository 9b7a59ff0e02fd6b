//! Env cells: rooms, placed copies of a shared cell structure (`world.md` 8).

use std::sync::Arc;

use glam::Vec3;

use crate::cell_bsp::CellBsp;
use crate::frame::Frame;
use crate::geometry::{BoundingBox, Plane};
use crate::ids::CellId;
use crate::physics_bsp::PhysicsBsp;
use crate::polygon::PolygonSet;
use crate::transit_hints::TransitHints;

/// The geometry of a room in its own frame: one per record, shared by every env cell that places it.
#[derive(Clone, Debug, PartialEq)]
pub struct CellStruct {
    /// Environment record it comes from (0x0D…).
    pub environment: u32,
    /// Its key inside the Environment.
    pub key: u16,
    /// What is inside the cell.
    pub cell_bsp: CellBsp,
    /// What there is to collide with; `None` when the tree has no node.
    pub physics: Option<PhysicsBsp>,
    /// The drawn polygons, portals among them.
    pub polygons: PolygonSet,
    /// Ids of the polygons that are portals, in record order.
    pub portal_polygons: Box<[u16]>,
    /// Box of the vertices, cell-local metres; `None` without vertices.
    pub bounds: Option<BoundingBox>,
}

/// Where a portal leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortalTarget {
    /// To the landscape (`dat-format.md` L8).
    Outside,
    /// To an env cell of the same landblock.
    Cell(CellId),
}

/// An opening of an env cell (retail `CCellPortal`, `world.md` 8.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellPortal {
    /// Where it leads.
    pub other: PortalTarget,
    /// Index of the opposite portal in the other cell; `None` when the record says -1.
    pub other_portal: Option<u16>,
    /// Position of the portal polygon in [`CellStruct::polygons`].
    pub polygon: u32,
    /// Plane of the portal polygon, cell-local.
    pub plane: Plane,
    /// `true` (retail `portal_side` 1): the cell's interior is on the negative side of the plane.
    pub interior_is_negative: bool,
    /// Both portal polygons coincide exactly, so visibility may skip clipping against the far one.
    pub exact_match: bool,
    /// Position of the portal in the record, which other cells refer to.
    pub record_index: u16,
}

/// A room: a frame, a shared structure, portals and the list of what may be seen from it.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvCell {
    /// Full id.
    pub id: CellId,
    /// Cell-local to landblock frame.
    pub frame: Frame,
    /// Geometry, shared.
    pub structure: Arc<CellStruct>,
    /// Surfaces (0x08…) that polygon surface indices select from.
    pub surfaces: Box<[u32]>,
    /// Portals in record order, less those whose polygon is missing (`dat-format.md` E3).
    pub portals: Box<[CellPortal]>,
    /// Cells that may be seen from here, full ids, usually without the cell itself (`world.md` P6).
    pub stab_list: Box<[CellId]>,
    /// The landscape may be seen from here: flag bit 0 of the record (`world.md` P5).
    pub seen_outside: bool,
    /// Object that decides who may enter (`world.md` 19).
    pub restriction: Option<u32>,
    /// The cell's static objects: a range of its landblock's [`crate::Landblock::statics`].
    pub statics: core::ops::Range<u32>,
    /// What spares most look-ups their exact tests; empty hints are fine.
    pub hints: TransitHints,
}

impl EnvCell {
    /// Whether `q`, a point in the frame of the cell's landblock, is inside (retail `point_in_cell`,
    /// `world.md` P3-P4). A cell without portals contains no point.
    #[inline]
    pub fn contains_point(&self, q: Vec3) -> bool {
        !self.portals.is_empty()
            && self
                .structure
                .cell_bsp
                .contains_point(self.frame.global_to_local(q))
    }

    /// Memory behind the cell, bytes, about: its lists, without the shared structure.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&*self.surfaces)
            + size_of_val(&*self.portals)
            + size_of_val(&*self.stab_list)
            + self.hints.memory()
    }

    /// The portal that had position `index` in the record, which is how other cells and buildings name it.
    pub fn portal(&self, index: u16) -> Option<&CellPortal> {
        let guess = self
            .portals
            .get(usize::from(index))
            .filter(|p| p.record_index == index);
        guess.or_else(|| {
            let at = self.portals.binary_search_by_key(&index, |p| p.record_index);
            self.portals.get(at.ok()?)
        })
    }

    /// Vertices of a portal's polygon, cell-local metres.
    pub fn portal_vertices(&self, portal: &CellPortal) -> &[Vec3] {
        let polygons = &self.structure.polygons;
        polygons
            .get(portal.polygon as usize)
            .map_or(&[], |p| polygons.vertices(p))
    }
}
