//! The land: heights, types and roads of every vertex.

use std::collections::BTreeMap;

use glam::DVec2;
use vestibule_dat::primitive::Bool32;
use vestibule_dat::record::LandBlock;
use vestibule_world::terrain::split_direction;
use vestibule_world::{BlockId, LandCoord, Split};

use super::noise::{hash01, value_noise};
use crate::scene::{Area, Scene, TerrainOp};
use crate::text::Messages;

/// Metres between vertices.
const SQUARE: f64 = 24.0;
/// Land cells along a landblock's side.
const SIDE: i32 = 8;

/// Numbers of vertices from west to east and from south to north.
#[derive(Clone, Copy)]
struct Size {
    x: i32,
    y: i32,
}

/// The vertices of all landblocks of a scene.
pub(crate) struct Land {
    /// Land cell of the south-west corner.
    corner: LandCoord,
    /// Map coordinates of the south-west corner.
    base: DVec2,
    size: Size,
    /// Metres per height index.
    step: f64,
    heights: Vec<f64>,
    index: Vec<u8>,
    kinds: Vec<u8>,
    roads: Vec<bool>,
}

impl Land {
    pub(crate) fn build(scene: &Scene, messages: &mut Messages) -> Land {
        let blocks = |a: u8, b: u8| i32::from(b) - i32::from(a) + 1;
        let size = Size {
            x: blocks(scene.south_west.x(), scene.north_east.x()) * SIDE + 1,
            y: blocks(scene.south_west.y(), scene.north_east.y()) * SIDE + 1,
        };
        let corner = scene.south_west.corner();
        let origin = scene.origin.corner();
        let base = DVec2::new(f64::from(corner.x - origin.x), f64::from(corner.y - origin.y)) * SQUARE;
        let count = (size.x * size.y) as usize;
        let mut land = Land {
            corner,
            base,
            size,
            step: scene.height_step,
            heights: vec![0.0; count],
            index: Vec::new(),
            kinds: vec![1; count],
            roads: vec![false; count],
        };
        for op in &scene.terrain {
            land.apply(op, messages);
        }
        land.index = land
            .heights
            .iter()
            .map(|h| (h / land.step).round().clamp(0.0, 255.0) as u8)
            .collect();
        land
    }

    fn vertices(&self) -> impl Iterator<Item = (usize, DVec2)> + use<> {
        let (size, base) = (self.size, self.base);
        (0..size.x * size.y).map(move |k| {
            let at = DVec2::new(f64::from(k / size.y), f64::from(k % size.y));
            (k as usize, base + at * SQUARE)
        })
    }

    fn at(&self, x: i32, y: i32) -> Option<usize> {
        let inside = (0..self.size.x).contains(&x) && (0..self.size.y).contains(&y);
        inside.then(|| (x * self.size.y + y) as usize)
    }

    fn nearest(&self, p: DVec2) -> Option<usize> {
        let at = ((p - self.base) / SQUARE).round();
        self.at(at.x as i32, at.y as i32)
    }

    fn apply(&mut self, op: &TerrainOp, messages: &mut Messages) {
        match op {
            TerrainOp::Base(z) => self.heights.fill(*z),
            TerrainOp::Noise(height, length, seed) => {
                for (k, p) in self.vertices() {
                    let fine = value_noise(p / *length * 2.1, seed.wrapping_add(77)) * 0.35;
                    self.heights[k] += height * (value_noise(p / *length, *seed) + fine);
                }
            }
            TerrainOp::Hill(center, radius, height) => {
                for (k, p) in self.vertices() {
                    self.heights[k] += height * bump(p.distance(*center) / radius);
                }
            }
            TerrainOp::Ridge(a, b, width, height) => {
                for (k, p) in self.vertices() {
                    let along = ((p - *a).dot(*b - *a) / a.distance_squared(*b).max(1.0)).clamp(0.0, 1.0);
                    self.heights[k] += height * bump(p.distance(*a + (*b - *a) * along) / width);
                }
            }
            TerrainOp::Bowl(center, inner, outer, height) => {
                for (k, p) in self.vertices() {
                    let t = ((p.distance(*center) - inner) / (outer - inner)).clamp(0.0, 1.0);
                    self.heights[k] += height * t * t * (3.0 - 2.0 * t);
                }
            }
            TerrainOp::Level(low, high, z) => {
                for (k, p) in self.vertices() {
                    if p.cmpge(*low - 0.01).all() && p.cmple(*high + 0.01).all() {
                        self.heights[k] = *z;
                    }
                }
            }
            TerrainOp::Set(p, z) => {
                if let Some(k) = self.nearest(*p) {
                    self.heights[k] = *z;
                }
            }
            TerrainOp::Paint(kind, area) => {
                for (k, p) in self.vertices() {
                    if self.covers(area, k, p) {
                        self.kinds[k] = *kind;
                    }
                }
            }
            TerrainOp::Road(points, span) => {
                // From vertex to vertex, along sides and diagonals of the grid.
                let vertices: Vec<DVec2> = points
                    .iter()
                    .map(|p| ((*p - self.base) / SQUARE).round())
                    .collect();
                for pair in vertices.windows(2) {
                    let steps = (pair[1] - pair[0]).abs().max_element().clamp(1.0, 10_000.0);
                    for i in 0..=steps as u32 {
                        let at = pair[0].lerp(pair[1], f64::from(i) / steps).round();
                        match self.at(at.x as i32, at.y as i32) {
                            Some(k) => self.roads[k] = true,
                            None => messages.warning(
                                *span,
                                "this road leaves the land",
                                "enlarge `land`, or end the road at its border",
                            ),
                        }
                    }
                }
            }
        }
    }

    fn covers(&self, area: &Area, k: usize, p: DVec2) -> bool {
        match area {
            Area::Everywhere => true,
            Area::Box(low, high) => p.cmpge(*low - 0.01).all() && p.cmple(*high + 0.01).all(),
            Area::Circle(center, radius) => p.distance(*center) <= *radius,
            Area::Above(z) => self.heights[k] > *z,
            Area::Below(z) => self.heights[k] < *z,
            Area::Steeper(slope) => {
                let (x, y) = (k as i32 / self.size.y, k as i32 % self.size.y);
                let neighbours = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                let steep = |n: usize| (self.heights[n] - self.heights[k]).abs() / SQUARE > *slope;
                neighbours
                    .into_iter()
                    .filter_map(|(x, y)| self.at(x, y))
                    .any(steep)
            }
            Area::Patches(share, seed) => {
                let patchy = value_noise(p / 60.0, *seed) * 0.5 + 0.5;
                patchy * 0.7 + hash01(k as u32, *seed) * 0.3 < *share
            }
        }
    }

    fn height(&self, x: i32, y: i32) -> f64 {
        let (x, y) = (x.clamp(0, self.size.x - 1), y.clamp(0, self.size.y - 1));
        self.at(x, y)
            .map_or(0.0, |k| f64::from(self.index[k]) * self.step)
    }

    /// Whether a place lies over the land.
    pub(crate) fn contains(&self, p: DVec2) -> bool {
        let at = (p - self.base) / SQUARE;
        at.cmpge(DVec2::ZERO).all() && at.x < f64::from(self.size.x - 1) && at.y < f64::from(self.size.y - 1)
    }

    /// A place in land cells from the south-west corner, kept near the land.
    fn in_cells(&self, p: DVec2) -> DVec2 {
        let last = DVec2::new(f64::from(self.size.x), f64::from(self.size.y));
        ((p - self.base) / SQUARE).clamp(DVec2::NEG_ONE, last)
    }

    /// Height of the ground as the engine sees it (`world.md` T9), metres; beyond the land that of its border.
    pub(crate) fn ground(&self, p: DVec2) -> f64 {
        let at = self.in_cells(p);
        let (x, y) = (at.x.floor(), at.y.floor());
        let (tx, ty) = (at.x - x, at.y - y);
        let (x, y) = (x as i32, y as i32);
        let (sw, se) = (self.height(x, y), self.height(x + 1, y));
        let (ne, nw) = (self.height(x + 1, y + 1), self.height(x, y + 1));
        match split_direction(LandCoord {
            x: self.corner.x + x,
            y: self.corner.y + y,
        }) {
            Split::SwNe if tx > ty => sw + (se - sw) * tx + (ne - se) * ty,
            Split::SwNe => sw + (ne - nw) * tx + (nw - sw) * ty,
            Split::SeNw if tx + ty <= 1.0 => sw + (se - sw) * tx + (nw - sw) * ty,
            Split::SeNw => ne + (nw - ne) * (1.0 - tx) + (se - ne) * (1.0 - ty),
        }
    }

    /// The landblock over which a place lies and the place in that block's coordinates.
    pub(crate) fn block_at(&self, p: DVec2) -> Option<(BlockId, DVec2)> {
        let at = self.in_cells(p);
        let cell = LandCoord {
            x: self.corner.x + at.x.floor() as i32,
            y: self.corner.y + at.y.floor() as i32,
        };
        let block = self.contains(p).then(|| cell.block()).flatten()?;
        Some((block, p - self.block_corner(block)))
    }

    /// Map coordinates of a landblock's south-west corner.
    pub(crate) fn block_corner(&self, block: BlockId) -> DVec2 {
        let corner = block.corner();
        let cells = DVec2::new(
            f64::from(corner.x - self.corner.x),
            f64::from(corner.y - self.corner.y),
        );
        self.base + cells * SQUARE
    }

    /// Terrain type and road of the vertex nearest to a place.
    pub(crate) fn kind_at(&self, p: DVec2) -> Option<(u8, bool)> {
        self.nearest(p).map(|k| (self.kinds[k], self.roads[k]))
    }

    /// The terrain types in use, ascending; 32 if there are roads.
    pub(crate) fn kinds_in_use(&self) -> Vec<u8> {
        let mut kinds: Vec<u8> = self.kinds.clone();
        kinds.extend(self.roads.contains(&true).then_some(32));
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }

    /// The LandBlock records, without `has_objects`.
    pub(crate) fn records(&self) -> BTreeMap<BlockId, LandBlock> {
        let mut out = BTreeMap::new();
        for bx in 0..(self.size.x - 1) / SIDE {
            for by in 0..(self.size.y - 1) / SIDE {
                let corner = LandCoord {
                    x: self.corner.x + bx * SIDE,
                    y: self.corner.y + by * SIDE,
                };
                let Some(block) = corner.block() else { continue };
                let (mut terrain, mut height) = ([0u16; 81], [0u8; 81]);
                for i in 0..81i32 {
                    let Some(k) = self.at(bx * SIDE + i / 9, by * SIDE + i % 9) else {
                        continue;
                    };
                    terrain[i as usize] = u16::from(self.kinds[k]) << 2 | u16::from(self.roads[k]);
                    height[i as usize] = self.index[k];
                }
                let id = block.land_block_record();
                out.insert(
                    block,
                    LandBlock {
                        id,
                        has_objects: Bool32(0),
                        terrain,
                        height,
                    },
                );
            }
        }
        out
    }
}

/// A smooth hump: 1 at 0, 0 from 1 on.
fn bump(t: f64) -> f64 {
    let t = (1.0 - t).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
