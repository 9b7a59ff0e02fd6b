//! LandBlock, `xxyyFFFF` (`dat-format.md` 9.1).

use super::{DatRecord, RecordError, inherent_parse_and_encode};
use crate::primitive::{Bool32, Reader, Writer};

/// Terrain of one landblock: a grid of 9 x 9 vertices, 24 m apart.
///
/// Both arrays are x-major: index `9 * x + y`, x growing east, y north (L1).
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LandBlock {
    /// Data id as stored.
    pub id: u32,
    /// Whether the block's LandBlockInfo exists (L3).
    pub has_objects: Bool32,
    /// Per vertex: bits 0-1 road, 2-6 terrain type, 7-10 unused, 11-15 scene index.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::record::serialize_array"))]
    pub terrain: [u16; 81],
    /// Per vertex: index into the Region's height table.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::record::serialize_array"))]
    pub height: [u8; 81],
}

impl LandBlock {
    /// Vertices along a side.
    pub const VERTICES_PER_SIDE: usize = 9;

    /// Position of vertex (x, y) in the arrays; `None` off the grid.
    pub fn index(x: usize, y: usize) -> Option<usize> {
        (x < Self::VERTICES_PER_SIDE && y < Self::VERTICES_PER_SIDE)
            .then_some(Self::VERTICES_PER_SIDE * x + y)
    }

    /// Road bits of a terrain word, 0 to 3; 0 is no road.
    pub fn road(terrain: u16) -> u16 {
        terrain & 3
    }

    /// Terrain type of a terrain word, 0 to 31.
    pub fn terrain_type(terrain: u16) -> u16 {
        terrain >> 2 & 0x1F
    }

    /// Scene index of a terrain word, 0 to 31.
    pub fn scene(terrain: u16) -> u16 {
        terrain >> 11
    }
}

impl DatRecord for LandBlock {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let has_objects = reader.bool32("has_objects")?;
        let mut terrain = [0; 81];
        let (words, _) = reader.take(2 * 81, "terrain")?.as_chunks();
        for (vertex, word) in terrain.iter_mut().zip(words) {
            *vertex = u16::from_le_bytes(*word);
        }
        let height = reader.array("height")?;
        reader.take(1, "padding")?;
        Ok(Self {
            id,
            has_objects,
            terrain,
            height,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.bool32(self.has_objects);
        writer.u16s(&self.terrain);
        writer.bytes(&self.height);
        writer.pad(1);
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(LandBlock);
