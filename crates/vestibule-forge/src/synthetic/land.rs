//! Terrain of synthetic worlds: rolling ground, some water.

use vestibule_world::BlockId;

use super::Draws;

/// Metres per height step; the palette's scene says the same.
pub(super) const STEP: f32 = 2.0;
/// Terrain words: grassland, packed dirt, standing water.
const GRASS: u16 = 1 << 2;
const DIRT: u16 = 7 << 2;
const WATER: u16 = 17 << 2;
/// Ground lower than this is under water, height steps.
const SEA: u8 = 12;
/// Distance of the points that the ground rolls between, squares.
const WAVE: i64 = 32;

/// Terrain of a landblock.
pub(super) struct Land {
    pub(super) terrain: [u16; 81],
    pub(super) heights: [u8; 81],
}

/// The global coordinates of a vertex.
pub(super) fn vertex(block: BlockId, i: usize, j: usize) -> (i64, i64) {
    (
        i64::from(block.x()) * 8 + i as i64,
        i64::from(block.y()) * 8 + j as i64,
    )
}

/// Height of a vertex without buildings, in steps. In whole numbers, so that it is the same everywhere.
pub(super) fn height_index(seed: u64, (x, y): (i64, i64)) -> u8 {
    let at = |cx: i64, cy: i64| {
        i64::from(Draws::new(seed, 0x4C41_4E44 ^ ((cx as u64) << 32 | cy as u64)).below(48))
    };
    let (cx, cy) = (x / WAVE, y / WAVE);
    let (u, v) = (x % WAVE, y % WAVE);
    let south = at(cx, cy) * (WAVE - u) + at(cx + 1, cy) * u;
    let north = at(cx, cy + 1) * (WAVE - u) + at(cx + 1, cy + 1) * u;
    let height = (south * (WAVE - v) + north * v) / (WAVE * WAVE);
    (6 + height).clamp(0, 255) as u8
}

/// The terrain of a landblock before buildings.
pub(super) fn block(seed: u64, id: BlockId, side: u16) -> Land {
    let mut land = Land {
        terrain: [GRASS; 81],
        heights: [0; 81],
    };
    for i in 0..9 {
        for j in 0..9 {
            let (x, y) = vertex(id, i, j);
            let border = x == 0 || y == 0 || x == i64::from(side) * 8 || y == i64::from(side) * 8;
            let height = height_index(seed, (x, y));
            land.heights[i * 9 + j] = height;
            land.terrain[i * 9 + j] = if height < SEA || border {
                WATER
            } else if height > 40 {
                DIRT
            } else {
                GRASS
            };
        }
    }
    land
}

/// Makes a land cell level and dry for a building; its height, metres.
pub(super) fn level(land: &mut Land, cx: u8, cy: u8) -> f32 {
    let (i, j) = (usize::from(cx), usize::from(cy));
    let height = land.heights[i * 9 + j].max(SEA);
    for (i, j) in [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)] {
        land.heights[i * 9 + j] = height;
        land.terrain[i * 9 + j] = DIRT;
    }
    f32::from(height) * STEP
}
