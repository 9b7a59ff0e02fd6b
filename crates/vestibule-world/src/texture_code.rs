//! Texture codes of land cells: which terrain textures meet in a cell and how they blend (`world.md` A8).

use crate::landblock::Land;
use crate::terrain::{TerrainWord, vertex_index};

/// The code of a cell from its corner words: SW, SE, NE, NW.
pub fn texture_code([sw, se, ne, nw]: [TerrainWord; 4]) -> u32 {
    let road = |w: TerrainWord| u32::from(w.road());
    let kind = |w: TerrainWord| u32::from(w.terrain_type());
    1 << 28
        | road(sw) << 26
        | road(se) << 24
        | road(ne) << 22
        | road(nw) << 20
        | kind(sw) << 15
        | kind(se) << 10
        | kind(ne) << 5
        | kind(nw)
}

/// The code of land cell (cx, cy), each 0…7; `None` outside the block.
pub fn texture_code_of(land: &Land, cx: usize, cy: usize) -> Option<u32> {
    let word = |i: usize, j: usize| land.words.get(vertex_index(i, j)).copied();
    if cx > 7 || cy > 7 {
        return None;
    }
    Some(texture_code([
        word(cx, cy)?,
        word(cx + 1, cy)?,
        word(cx + 1, cy + 1)?,
        word(cx, cy + 1)?,
    ]))
}

/// The pseudo-random number that picks a blend map for a code.
pub fn blend_hash(code: u32) -> u32 {
    code.wrapping_mul(1_379_576_222).wrapping_sub(1_372_186_442)
}

/// Which of `count` blend maps a code starts at.
pub fn blend_index(code: u32, count: usize) -> usize {
    let index = libm::floor(crate::scenery::unit(blend_hash(code)) * count as f64) as usize;
    if index >= count { 0 } else { index }
}

/// Turns a blend map's corner mask (SW 1, SE 2, NE 4, NW 8) by one quarter.
pub fn rotate_mask(mask: u32) -> u32 {
    let doubled = 2 * mask;
    if doubled >= 16 { doubled - 15 } else { doubled }
}

/// How many quarter-turns (at most 3) take the mask `map` to `wanted`.
pub fn quarter_turns(map: u32, wanted: u32) -> Option<u32> {
    let mut mask = map;
    (0..4).find(|_| {
        let found = mask == wanted;
        mask = rotate_mask(mask);
        found
    })
}

/// The masks of the road maps that cover a cell with roads at these corners (`world.md` A8); a mask of 15 is
/// road all over.
pub fn road_masks(corners: u32) -> ([u32; 2], usize) {
    match corners & 15 {
        0 => ([0, 0], 0),
        14 => ([6, 12], 2),
        13 => ([9, 12], 2),
        11 => ([9, 3], 2),
        7 => ([3, 6], 2),
        mask => ([mask, 0], 1),
    }
}

/// The terrain of a cell: a base type and the corner masks of up to three others over it, in drawing order
/// (`world.md` A8).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TerrainLayers {
    /// Base terrain type.
    pub base: u8,
    /// Overlays: terrain type and corner mask.
    pub overlays: [(u8, u32); 3],
    /// How many overlays there are.
    pub count: usize,
}

/// Splits a cell's corner types, SW SE NE NW, into a base and overlays.
pub fn terrain_layers(corners: [u8; 4]) -> TerrainLayers {
    let twice = |t: &u8| corners.iter().filter(|&c| c == t).count() >= 2;
    let base = corners.iter().copied().find(|t| twice(t)).unwrap_or(corners[0]);
    let mut layers = TerrainLayers {
        base,
        overlays: [(0, 0); 3],
        count: 0,
    };
    for (k, &kind) in corners.iter().enumerate() {
        if kind == base {
            continue;
        }
        let bit = 1 << k;
        // Two neighbouring corners of one type share a side map; NW and SW are neighbours too.
        let joined = layers.overlays[..layers.count]
            .iter_mut()
            .find(|(t, mask)| *t == kind && (rotate_mask(*mask) == bit || rotate_mask(bit) == *mask));
        if let Some((_, mask)) = joined {
            *mask |= bit;
        } else if let Some(slot) = layers.overlays.get_mut(layers.count) {
            *slot = (kind, bit);
            layers.count += 1;
        }
    }
    layers
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(roads: [u16; 4], types: [u16; 4]) -> [TerrainWord; 4] {
        core::array::from_fn(|k| TerrainWord(types[k] << 2 | roads[k]))
    }

    #[test]
    fn example_22_38_texture_codes() {
        let plain = texture_code(words([0; 4], [1; 4]));
        assert_eq!((plain, blend_hash(plain)), (0x1000_8421, 0x673B_6E14));
        let roads = texture_code(words([0, 1, 1, 0], [3; 4]));
        assert_eq!((roads, blend_hash(roads)), (0x1141_8C63, 0x1EC6_18D0));
        assert_eq!((blend_index(roads, 4), blend_index(roads, 5)), (0, 0));
        assert_eq!(texture_code(words([1, 0, 0, 0], [1, 1, 9, 1])), 0x1400_8521);
    }

    #[test]
    fn a8_masks_turn_by_quarters() {
        assert_eq!([1, 2, 4, 8].map(rotate_mask), [2, 4, 8, 1]);
        assert_eq!(rotate_mask(9), 3);
        assert_eq!(quarter_turns(1, 8), Some(3));
        assert_eq!(quarter_turns(9, 12), Some(3));
        assert_eq!(quarter_turns(5, 3), None);
    }

    #[test]
    fn a8_layers_of_a_cell() {
        let layers = |c| {
            let l = terrain_layers(c);
            (l.base, l.overlays[..l.count].to_vec())
        };
        assert_eq!(layers([1, 1, 1, 1]), (1, vec![]));
        assert_eq!(layers([1, 2, 1, 1]), (1, vec![(2, 2)]));
        assert_eq!(layers([1, 2, 2, 3]), (2, vec![(1, 1), (3, 8)]));
        assert_eq!(layers([1, 2, 3, 4]), (1, vec![(2, 2), (3, 4), (4, 8)]));
        assert_eq!(layers([1, 1, 2, 2]), (1, vec![(2, 12)]));
    }

    #[test]
    fn a8_three_road_corners_take_two_maps() {
        assert_eq!(road_masks(14), ([6, 12], 2));
        assert_eq!(road_masks(5), ([5, 0], 1));
        assert_eq!(road_masks(0).1, 0);
    }
}
