//! GfxObj, `01......` (`dat-format.md` 10.2).

use glam::Vec3;

use super::{
    BspKind, BspTree, DatRecord, Polygon, RecordError, VertexArray, find_polygon, inherent_parse_and_encode,
};
use crate::primitive::{CompressedForm, Reader, Writer};

/// A rigid model: vertices, polygons to collide with, polygons to draw.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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

impl DatRecord for GfxObj {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let flags = reader.u32("flags")?;
        let (count, surfaces_form) = reader.count_compressed(4, "surfaces")?;
        let surfaces = reader.u32s(count, "surfaces")?;
        let vertices = VertexArray::read(reader)?;
        let physics = if flags & Self::HAS_PHYSICS != 0 {
            Some(GfxObjPolygons::read(
                reader,
                BspKind::Physics,
                "physics_polygons",
            )?)
        } else {
            None
        };
        let sort_center = reader.vec3("sort_center")?;
        let drawing = if flags & Self::HAS_DRAWING != 0 {
            Some(GfxObjPolygons::read(reader, BspKind::Drawing, "polygons")?)
        } else {
            None
        };
        let degrade_id = if flags & Self::HAS_DEGRADE != 0 {
            Some(reader.u32("degrade_id")?)
        } else {
            None
        };
        Ok(Self {
            id,
            flags,
            surfaces,
            surfaces_form,
            vertices,
            physics,
            sort_center,
            drawing,
            degrade_id,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        let what = "a part exists iff its bit in flags is set";
        writer.u32(self.id);
        writer.u32(self.flags);
        writer.count_compressed(self.surfaces.len(), self.surfaces_form, "surfaces")?;
        writer.u32s(&self.surfaces);
        self.vertices.write(writer)?;
        writer.require(
            self.physics.is_some() == (self.flags & Self::HAS_PHYSICS != 0),
            "physics",
            what,
        )?;
        if let Some(physics) = &self.physics {
            physics.write(writer, BspKind::Physics, "physics_polygons")?;
        }
        writer.vec3(self.sort_center);
        writer.require(
            self.drawing.is_some() == (self.flags & Self::HAS_DRAWING != 0),
            "drawing",
            what,
        )?;
        if let Some(drawing) = &self.drawing {
            drawing.write(writer, BspKind::Drawing, "polygons")?;
        }
        writer.require(
            self.degrade_id.is_some() == (self.flags & Self::HAS_DEGRADE != 0),
            "degrade_id",
            what,
        )?;
        if let Some(degrade_id) = self.degrade_id {
            writer.u32(degrade_id);
        }
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(GfxObj);

impl GfxObjPolygons {
    /// The polygon with this id.
    pub fn polygon(&self, id: u16) -> Option<&Polygon> {
        find_polygon(&self.polygons, id)
    }

    fn read(reader: &mut Reader<'_>, kind: BspKind, field: &'static str) -> Result<Self, RecordError> {
        let (polygons, form) = Polygon::read_list(reader, field)?;
        Ok(Self {
            polygons,
            form,
            bsp: BspTree::read(reader, kind)?,
        })
    }

    fn write(&self, writer: &mut Writer, kind: BspKind, field: &'static str) -> Result<(), RecordError> {
        writer.count_compressed(self.polygons.len(), self.form, field)?;
        Polygon::write_all(&self.polygons, writer)?;
        self.bsp.write_as(kind, writer)
    }
}
