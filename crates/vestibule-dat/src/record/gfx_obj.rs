//! GfxObj, `01......` (`dat-format.md` 10.2).

use glam::Vec3;

use super::{BspTree, Polygon, VertexArray};
use crate::primitive::CompressedForm;

/// A rigid model: vertices, polygons to collide with, polygons to draw.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GfxObj {
    /// Data id as stored.
    pub id: u32,
    /// Bit 0 has physics, 1 has drawing, 3 has a degrade id.
    pub flags: u32,
    /// Surfaces that polygons select from, full ids (0x08...).
    pub surfaces: Vec<u32>,
    /// Spelling of the surface count.
    pub surfaces_form: CompressedForm,
    /// Vertices of both polygon lists.
    pub vertices: VertexArray,
    /// What is collided with; present iff flags bit 0.
    pub physics: Option<GfxObjPolygons>,
    /// Point by which translucent models are sorted.
    pub sort_center: Vec3,
    /// What is drawn; present iff flags bit 1.
    pub drawing: Option<GfxObjPolygons>,
    /// GfxObjDegradeInfo; present iff flags bit 3.
    pub degrade_id: Option<u32>,
}

/// Polygons and the tree that splits them.
#[derive(Debug, Clone, PartialEq)]
pub struct GfxObjPolygons {
    /// The polygons.
    pub polygons: Vec<Polygon>,
    /// Spelling of their count.
    pub form: CompressedForm,
    /// The tree.
    pub bsp: BspTree,
}

impl GfxObj {
    /// Flag: physics polygons and their tree follow.
    pub const HAS_PHYSICS: u32 = 1;
    /// Flag: drawn polygons and their tree follow.
    pub const HAS_DRAWING: u32 = 2;
    /// Flag: a degrade id follows.
    pub const HAS_DEGRADE: u32 = 8;

    /// Box around all vertex origins, lowest and highest corner, metres; zero when there are none (X1).
    pub fn bounding_box(&self) -> (Vec3, Vec3) {
        let mut origins = self.vertices.vertices.iter().map(|vertex| vertex.origin);
        let first = origins.next().unwrap_or_default();
        origins.fold((first, first), |(low, high), origin| {
            (low.min(origin), high.max(origin))
        })
    }
}
