//! Vertices (`dat-format.md` 8.1).

use glam::{Vec2, Vec3};

use super::{RecordError, RecordErrorKind};
use crate::primitive::{Reader, Writer};

/// The only vertex type that occurs.
const VERTEX_TYPE: u32 = 1;

/// One vertex.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Vertex {
    /// Its id, by which polygons name it; in retail data also its position in the array.
    pub id: u16,
    /// Place, metres, in the owner's own frame.
    pub origin: Vec3,
    /// Unit normal for lighting.
    pub normal: Vec3,
    /// Texture coordinates; a polygon says which of them it uses.
    pub uvs: Vec<Vec2>,
}

/// The vertices of a GfxObj or of one cell structure.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct VertexArray {
    /// In file order.
    pub vertices: Vec<Vertex>,
}

impl VertexArray {
    /// The vertex with this id (G1).
    pub fn get(&self, id: u16) -> Option<&Vertex> {
        match self.vertices.get(usize::from(id)) {
            Some(vertex) if vertex.id == id => Some(vertex),
            _ => self.vertices.iter().find(|vertex| vertex.id == id),
        }
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let start = reader.position();
        let vertex_type = reader.u32("vertices.vertex_type")?;
        if vertex_type != VERTEX_TYPE {
            let kind = RecordErrorKind::BadValue {
                value: vertex_type,
                expected: "vertex type 1",
            };
            return Err(reader.error_at(start, "vertices.vertex_type", kind));
        }
        let vertices = reader.list32(28, "vertices.count", Vertex::read)?;
        Ok(Self { vertices })
    }

    pub(crate) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(VERTEX_TYPE);
        writer.count32(self.vertices.len(), "vertices.count")?;
        self.vertices.iter().try_for_each(|vertex| vertex.write(writer))
    }
}

impl Vertex {
    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u16("vertex.id")?;
        let uv_count = usize::from(reader.u16("vertex.uv_count")?);
        let origin = reader.vec3("vertex.origin")?;
        let normal = reader.vec3("vertex.normal")?;
        let uv_count = reader.check_count(uv_count as u64, 8, "vertex.uvs")?;
        let uvs = reader.items(uv_count, |reader| reader.vec2("vertex.uvs"))?;
        Ok(Self {
            id,
            origin,
            normal,
            uvs,
        })
    }

    pub(crate) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u16(self.id);
        writer.count16(self.uvs.len(), "vertex.uv_count")?;
        writer.vec3(self.origin);
        writer.vec3(self.normal);
        self.uvs.iter().for_each(|&uv| writer.vec2(uv));
        Ok(())
    }
}
