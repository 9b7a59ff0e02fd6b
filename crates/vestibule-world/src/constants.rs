//! The numbers that every rule shares, named once.

/// Retail `F_EPSILON`: the tolerance of plane sides and equalities, metres (`world.md` notation).
pub const EPSILON: f32 = 0.0002;
/// Side of a land cell, metres (`world.md` K2).
pub const SQUARE_LENGTH: f32 = 24.0;
/// Side of a landblock, metres (`world.md` K2).
pub const BLOCK_LENGTH: f32 = 192.0;
/// Land cells along one side of a landblock.
pub const BLOCK_SIDE_CELLS: i32 = 8;
/// Terrain vertices along one side of a landblock.
pub const BLOCK_SIDE_VERTICES: usize = 9;
/// Land cells along one side of the map: 255 landblocks (`world.md` I3).
pub const MAP_SIDE_CELLS: i32 = 2040;
/// Smallest normal z of ground that can be walked on (`world.md` T10, `transition.md` 1.2): cos 48.38°.
pub const FLOOR_Z: f32 = 0.664_174_15;
/// How much a cell BSP widens a sphere, metres (`world.md` 9.2).
pub const CELL_BSP_SPHERE_FUDGE: f32 = 0.01;
/// Water depth in a cell that is water at all four corners, metres (`world.md` A5).
pub const WATER_DEPTH_ENTIRELY: f32 = 0.9;
/// Water depth nearest to a water corner of a partly watered cell, metres (`world.md` A5).
pub const WATER_DEPTH_WET_CORNER: f32 = 0.45;
/// Water depth nearest to a dry corner of a partly watered cell, metres (`world.md` A5).
pub const WATER_DEPTH_DRY_CORNER: f32 = 0.1;
