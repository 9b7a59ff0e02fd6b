//! The measures of the land.

use crate::primitive::{Reader, Writer};
use crate::record::RecordError;

/// How the land is divided and how high it is.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LandDefs {
    /// Landblocks from west to east.
    pub num_block_length: i32,
    /// Landblocks from south to north.
    pub num_block_width: i32,
    /// Side of a land cell, metres.
    pub square_length: f32,
    /// Land cells along the side of a landblock.
    pub lblock_length: i32,
    /// Vertices per cell beyond its corners.
    pub vertex_per_cell: i32,
    /// Height of the tallest object, metres.
    pub max_obj_height: f32,
    /// Height of the sky, metres.
    pub sky_height: f32,
    /// Width of a road, metres.
    pub road_width: f32,
    /// Metres for each height byte of a landblock; always taken from the record (X8).
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::record::serialize_array"))]
    pub land_height_table: [f32; 256],
}

impl LandDefs {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            num_block_length: reader.i32("land_defs.num_block_length")?,
            num_block_width: reader.i32("land_defs.num_block_width")?,
            square_length: reader.f32("land_defs.square_length")?,
            lblock_length: reader.i32("land_defs.lblock_length")?,
            vertex_per_cell: reader.i32("land_defs.vertex_per_cell")?,
            max_obj_height: reader.f32("land_defs.max_obj_height")?,
            sky_height: reader.f32("land_defs.sky_height")?,
            road_width: reader.f32("land_defs.road_width")?,
            land_height_table: reader.f32s("land_defs.land_height_table")?,
        })
    }

    pub(super) fn write(&self, writer: &mut Writer) {
        writer.i32(self.num_block_length);
        writer.i32(self.num_block_width);
        writer.f32(self.square_length);
        writer.i32(self.lblock_length);
        writer.i32(self.vertex_per_cell);
        writer.f32s(&[self.max_obj_height, self.sky_height, self.road_width]);
        writer.f32s(&self.land_height_table);
    }

    /// Checks every value as the client does (X7).
    ///
    /// # Errors
    /// The name of the first field whose value the client refuses.
    pub fn validate(&self) -> Result<(), &'static str> {
        let blocks = 1..=255;
        let top = self.sky_height - self.max_obj_height;
        let checks = [
            ("num_block_length", blocks.contains(&self.num_block_length)),
            ("num_block_width", blocks.contains(&self.num_block_width)),
            (
                "square_length",
                0.1 <= self.square_length && self.square_length <= 1000.0,
            ),
            ("lblock_length", matches!(self.lblock_length, 2 | 4 | 8 | 16)),
            ("vertex_per_cell", (0..=64).contains(&self.vertex_per_cell)),
            (
                "max_obj_height",
                10.0 <= self.max_obj_height && self.max_obj_height < 100_000.0,
            ),
            (
                "sky_height",
                10.0 <= self.sky_height && self.sky_height < 1_000_000.0,
            ),
            (
                "road_width",
                0.0 <= self.road_width && self.road_width < self.square_length,
            ),
            (
                "land_height_table",
                self.land_height_table.iter().all(|&z| 0.0 <= z && z <= top),
            ),
        ];
        checks
            .iter()
            .find(|check| !check.1)
            .map_or(Ok(()), |check| Err(check.0))
    }
}
