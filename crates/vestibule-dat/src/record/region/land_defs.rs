//! The measures of the land.

/// How the land is divided and how high it is.
#[derive(Debug, Clone, PartialEq)]
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
    pub land_height_table: [f32; 256],
}
