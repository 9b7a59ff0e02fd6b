//! What deciding the landscape asks of a landblock, in little memory: its box, the boxes of its land cells, and where
//! buildings stand.

use glam::Vec3;
use vestibule_world::{BoundingBox, Land, Landblock, is_over_block};

/// Side of a land cell, metres.
const SQUARE: f32 = vestibule_world::constants::SQUARE_LENGTH;
/// Side of a landblock, metres.
const BLOCK: f32 = vestibule_world::constants::BLOCK_LENGTH;

/// The outline of one landblock, made when its openings are compiled: it changes no more than those.
#[derive(Clone, Debug)]
pub(crate) struct LandOutline {
    /// As [`block_bounds`].
    pub(crate) bounds: BoundingBox,
    /// Lowest and highest corner of each land cell, in order of their ids.
    heights: [(f32, f32); 64],
    /// The same of the four quarters, of 16 land cells each.
    quarters: [(f32, f32); 4],
    /// Land cells with a building, one bit each, and the positions of those buildings in that order.
    built_on: u64,
    buildings: Box<[u16]>,
}

impl LandOutline {
    /// `None` without terrain.
    pub(crate) fn of(block: &Landblock) -> Option<Self> {
        let land = block.land.as_ref()?;
        let mut heights = [(0.0, 0.0); 64];
        let mut quarters = [(f32::INFINITY, f32::NEG_INFINITY); 4];
        let (mut built_on, mut buildings) = (0, Vec::new());
        for (k, slot) in heights.iter_mut().enumerate() {
            let cell = cell_bounds(land, k);
            let (low, high) = (cell.min.z, cell.max.z);
            *slot = (low, high);
            let quarter = &mut quarters[quarter_of(k)];
            if !(low.is_finite() && high.is_finite()) {
                // Of damaged heights nothing is certain.
                *quarter = (f32::NEG_INFINITY, f32::INFINITY);
            }
            quarter.0 = if low < quarter.0 { low } else { quarter.0 };
            quarter.1 = if high > quarter.1 { high } else { quarter.1 };
            if let Some(building) = land.cells.get(k).and_then(|c| c.building) {
                built_on |= 1 << k;
                buildings.push(building);
            }
        }
        Some(LandOutline {
            bounds: block_bounds(block, land),
            heights,
            quarters,
            built_on,
            buildings: buildings.into(),
        })
    }

    /// The box of the land cell whose id is `1 + k`.
    #[inline]
    pub(crate) fn cell_bounds(&self, k: usize) -> BoundingBox {
        let (low, high) = self.heights[k & 63];
        square(k, low, high)
    }

    /// The boxes of the quarters, for [`quarter_of`]. What holds for a quarter as to a plane holds for its land cells.
    pub(crate) fn quarters(&self) -> [BoundingBox; 4] {
        core::array::from_fn(|q| {
            let (low, high) = self.quarters[q];
            let (x, y) = ((q / 2 * 4) as f32, (q % 2 * 4) as f32);
            BoundingBox {
                min: Vec3::new(x * SQUARE, y * SQUARE, low),
                max: Vec3::new((x + 4.0) * SQUARE, (y + 4.0) * SQUARE, high),
            }
        })
    }

    /// The building on that land cell, by its position among the landblock's.
    #[inline]
    pub(crate) fn building(&self, k: usize) -> Option<u16> {
        if self.built_on >> (k & 63) & 1 == 0 {
            return None;
        }
        let before = self.built_on & ((1 << (k & 63)) - 1);
        self.buildings.get(before.count_ones() as usize).copied()
    }
}

/// The quarter of a landblock that the land cell whose id is `1 + k` lies in.
pub(crate) fn quarter_of(k: usize) -> usize {
    k / 32 % 2 * 2 + k % 8 / 4
}

fn square(k: usize, low: f32, high: f32) -> BoundingBox {
    let (x, y) = ((k / 8) as f32, (k % 8) as f32);
    BoundingBox {
        min: Vec3::new(x * SQUARE, y * SQUARE, low),
        max: Vec3::new((x + 1.0) * SQUARE, (y + 1.0) * SQUARE, high),
    }
}

/// The box around the corners of the land cell whose id is `1 + k`.
pub(crate) fn cell_bounds(land: &Land, k: usize) -> BoundingBox {
    let (x, y) = (k / 8, k % 8);
    let height = |x: usize, y: usize| land.heights.get(x * 9 + y).copied().unwrap_or(0.0);
    let first = height(x, y);
    let (mut low, mut high) = (first, first);
    for z in [height(x + 1, y), height(x, y + 1), height(x + 1, y + 1)] {
        low = if z < low { z } else { low };
        high = if z > high { z } else { high };
    }
    square(k, low, high)
}

/// The box of a block's terrain, extended by its buildings (`visibility.md` 8.1).
pub(crate) fn block_bounds(block: &Landblock, land: &Land) -> BoundingBox {
    let (low, high) = land.z_limits;
    let mut bounds = BoundingBox {
        min: Vec3::new(0.0, 0.0, low),
        max: Vec3::new(BLOCK, BLOCK, high),
    };
    for building in &block.buildings {
        let b = building.bounds;
        bounds.grow(b.min);
        bounds.grow(b.max);
    }
    for object in &block.statics[..(block.land_statics as usize).min(block.statics.len())] {
        // Objects may stand higher than the terrain's margin or over the border.
        if is_over_block(object.frame.origin) {
            bounds.grow(object.frame.origin);
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_hold_their_land_cells() {
        let heights = core::array::from_fn(|k| ((k * 7 % 13) as f32, (k * 5 % 17 + 13) as f32));
        let mut quarters = [(f32::INFINITY, f32::NEG_INFINITY); 4];
        for (k, &(low, high)) in heights.iter().enumerate() {
            let q: &mut (f32, f32) = &mut quarters[quarter_of(k)];
            *q = (
                if low < q.0 { low } else { q.0 },
                if high > q.1 { high } else { q.1 },
            );
        }
        let outline = LandOutline {
            bounds: square(0, 0.0, 0.0),
            heights,
            quarters,
            built_on: 1 << 3 | 1 << 40,
            buildings: [7, 2].into(),
        };
        for k in 0..64 {
            let (cell, quarter) = (outline.cell_bounds(k), outline.quarters()[quarter_of(k)]);
            assert!(
                quarter.min.cmple(cell.min).all() && quarter.max.cmpge(cell.max).all(),
                "{k}"
            );
        }
        let built: Vec<Option<u16>> = [2, 3, 40, 41].map(|k| outline.building(k)).into();
        assert_eq!(built, [None, Some(7), Some(2), None]);
    }
}
