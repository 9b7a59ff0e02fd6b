//! How the ground is painted: terrain textures, their blending and roads (`rendering.md` 11.5).

use std::sync::Arc;

use glam::Vec3;
use vestibule_dat::record::Region;
use vestibule_world::texture_code::{blend_hash, quarter_turns, road_masks, terrain_layers};
use vestibule_world::{REGION_RECORD, World};

use crate::assets::{Assets, rgb};
use crate::texel::TexelWalk;
use crate::texture::{DecodeAs, Texture};

/// Terrain type of roads (`rendering.md` 11.4).
const ROAD: usize = 32;
/// Terrain types, roads among them.
const TYPES: usize = 33;

/// The texture of a terrain type.
#[derive(Clone, Debug)]
pub struct TypeTexture {
    /// The picture.
    pub texture: Arc<Texture>,
    /// Repeats per cell.
    pub tiling: f32,
}

/// A blend map and the corners it shows as the other terrain's.
#[derive(Clone, Debug)]
struct BlendMap {
    code: u32,
    map: Arc<Texture>,
}

/// What a renderer needs of the region's terrain description.
#[derive(Clone, Debug)]
pub struct TerrainPaint {
    types: Vec<TypeTexture>,
    corner_maps: Vec<BlendMap>,
    side_maps: Vec<BlendMap>,
    road_maps: Vec<BlendMap>,
    textured: bool,
}

/// How one layer covers a cell.
#[derive(Clone, Debug)]
pub enum Cover {
    /// By a map, turned by this many quarters.
    Map(Arc<Texture>, u32),
    /// By the corners alone, for worlds without maps: smooth from corner to corner.
    Corners(u32),
    /// All of it.
    Whole,
}

/// One layer over the base.
#[derive(Clone, Debug)]
pub struct Layer {
    /// What it shows.
    pub texture: TypeTexture,
    /// Where.
    pub cover: Cover,
}

/// How a land cell is painted.
#[derive(Clone, Debug)]
pub struct CellPaint {
    /// Covers all of it.
    pub base: TypeTexture,
    /// Over the base, the last on top.
    pub overlays: Vec<Layer>,
    /// Road maps; they share one texture.
    pub roads: Vec<Cover>,
    /// The texture of roads, on top of everything.
    pub road: TypeTexture,
}

impl TerrainPaint {
    pub(crate) fn read(assets: &Assets, world: &World) -> Self {
        let region = assets.record(world, REGION_RECORD, Region::parse);
        let terrain = region.map(|r| r.terrain);
        let mut types: Vec<TypeTexture> = (0..TYPES)
            .map(|i| {
                let named = terrain
                    .as_ref()
                    .and_then(|t| t.terrain_types.get(i))
                    .map(|t| rgb(t.color));
                let color = named.filter(|c| *c != Vec3::ZERO).unwrap_or(DEFAULT_COLORS[i]);
                TypeTexture {
                    texture: Arc::new(ground_texture(color, i as u32)),
                    tiling: 4.0,
                }
            })
            .collect();
        let mut textured = false;
        let mut maps: [Vec<BlendMap>; 3] = Default::default();
        if let Some(merge) = terrain.as_ref().map(|t| &t.tex_merge) {
            let how = DecodeAs::default();
            for t in &merge.textures {
                let slot = usize::try_from(t.terrain_type).ok().filter(|&i| i < TYPES);
                let Some(slot) = slot else { continue };
                if t.texture == 0 {
                    continue;
                }
                if let Some((texture, _)) = assets.try_texture(world, t.texture, 0, how) {
                    let tiling = t.tex_tiling.clamp(1, 64) as f32;
                    types[slot] = TypeTexture { texture, tiling };
                    textured = true;
                }
            }
            let lists = [
                merge
                    .corner_maps
                    .iter()
                    .map(|m| (m.tcode, m.texture))
                    .collect::<Vec<_>>(),
                merge.side_maps.iter().map(|m| (m.tcode, m.texture)).collect(),
                merge.road_maps.iter().map(|m| (m.rcode, m.texture)).collect(),
            ];
            for (out, list) in maps.iter_mut().zip(lists) {
                for (code, id) in list {
                    if let Some((map, _)) = assets.try_texture(world, id, 0, how) {
                        out.push(BlendMap { code, map });
                    }
                }
            }
        }
        let [corner_maps, side_maps, road_maps] = maps;
        TerrainPaint {
            types,
            corner_maps,
            side_maps,
            road_maps,
            textured,
        }
    }

    /// Whether any terrain type has a texture from a record.
    pub fn has_textures(&self) -> bool {
        self.textured
    }

    /// The textures of all terrain types, roads among them.
    pub fn types(&self) -> &[TypeTexture] {
        &self.types
    }

    /// The maps that layers are blended by, those of corners, sides and roads.
    pub fn maps(&self) -> impl Iterator<Item = &Arc<Texture>> {
        let all = [&self.corner_maps, &self.side_maps, &self.road_maps];
        all.into_iter().flatten().map(|m| &m.map)
    }

    fn texture(&self, kind: usize) -> TypeTexture {
        self.types[kind.min(TYPES - 1)].clone()
    }

    /// The layers of a cell with this code (`rendering.md` 11.5 a-d). An overlay that no turn of its map fits is
    /// left out.
    pub(crate) fn cell(&self, code: u32) -> CellPaint {
        let kind = |shift: u32| (code >> shift & 31) as u8;
        let layers = terrain_layers([kind(15), kind(10), kind(5), kind(0)]);
        let overlays = layers.overlays[..layers.count].iter();
        let overlays = overlays
            .filter_map(|&(kind, mask)| {
                let maps = if mask.count_ones() == 1 {
                    &self.corner_maps
                } else {
                    &self.side_maps
                };
                let cover = cover(maps, code, mask, false)?;
                Some(Layer {
                    texture: self.texture(usize::from(kind)),
                    cover,
                })
            })
            .collect();
        let road = |shift: u32, bit: u32| if code >> shift & 3 != 0 { bit } else { 0 };
        let corners = road(26, 1) | road(24, 2) | road(22, 4) | road(20, 8);
        let (masks, count) = road_masks(corners);
        let roads = masks[..count].iter();
        let roads = roads
            .filter_map(|&mask| match mask {
                15 => Some(Cover::Whole),
                _ => cover(&self.road_maps, code, mask, true),
            })
            .collect();
        CellPaint {
            base: self.texture(usize::from(layers.base)),
            overlays,
            roads,
            road: self.texture(ROAD),
        }
    }
}

/// The map that covers the corners `mask`: the one the code picks, for roads the next that fits
/// (`rendering.md` 11.5d).
fn cover(maps: &[BlendMap], code: u32, mask: u32, try_all: bool) -> Option<Cover> {
    if maps.is_empty() {
        return Some(Cover::Corners(mask));
    }
    let picked = libm::floor(f64::from(blend_hash(code)) / 4_294_967_296.0 * maps.len() as f64) as usize;
    let start = if picked >= maps.len() { 0 } else { picked };
    let tries = if try_all { maps.len() } else { 1 };
    (0..tries).find_map(|k| {
        let map = maps.get((start + k) % maps.len())?;
        let turns = quarter_turns(map.code, mask)?;
        Some(Cover::Map(map.map.clone(), turns))
    })
}

impl Cover {
    /// The weight of what lies below at (u, v) of the cell, u east, v south: 0 where the layer covers
    /// (`rendering.md` 11.5 e, f).
    #[inline]
    pub(crate) fn below(&self, u: f32, v: f32) -> f32 {
        match self {
            Cover::Whole => 0.0,
            Cover::Map(map, turns) => {
                let (u, v) = match turns {
                    1 => (1.0 - v, u),
                    2 => (1.0 - u, 1.0 - v),
                    3 => (v, 1.0 - u),
                    _ => (u, v),
                };
                f32::from(map.fetch(0, u, v, false)[3]) / 255.0
            }
            Cover::Corners(mask) => {
                let on = |bit: u32| if mask & bit != 0 { 1.0 } else { 0.0 };
                let south = on(1) + (on(2) - on(1)) * u;
                let north = on(8) + (on(4) - on(8)) * u;
                let w = north + (south - north) * v;
                // A smooth step, narrower than the cell.
                let t = ((w - 0.5) * 2.5 + 0.5).clamp(0.0, 1.0);
                1.0 - t * t * (3.0 - 2.0 * t)
            }
        }
    }
}

/// The base, three overlays and the road.
const MAX_LAYERS: usize = 5;

/// A straight way over a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// (u, v), u east, v south.
    pub(crate) from: [f32; 2],
    /// (u, v).
    pub(crate) to: [f32; 2],
    /// Steps from one to the other.
    pub(crate) steps: u32,
    /// The square of how much of the cell's side a pixel covers.
    pub(crate) texels: f32,
}

/// A straight walk over a cell: its layers, each with the weight of what lies below and its change, in 256ths.
pub(crate) struct PaintWalk<'t> {
    layers: [Option<(TexelWalk<'t>, i32, i32)>; MAX_LAYERS],
    count: usize,
}

impl<'t> PaintWalk<'t> {
    /// A layer over those so far; `below` is what is left of these at both ends.
    #[inline]
    fn add(&mut self, layer: &'t TypeTexture, way: &Way, below: [f32; 2]) {
        if below[0] >= 1.0 && below[1] >= 1.0 {
            return;
        }
        if below[0] <= 0.0 && below[1] <= 0.0 {
            self.count = 0;
        }
        let size = layer.tiling * layer.texture.width() as f32;
        let level = layer
            .texture
            .level(layer.texture.level_for(way.texels * size * size));
        let (from, to) = (
            way.from.map(|v| v * layer.tiling),
            way.to.map(|v| v * layer.tiling),
        );
        let texel = TexelWalk::new(level, from, to, way.steps, true);
        let weight = below.map(|w| (w * 256.0) as i32);
        let by = (weight[1] - weight[0]) / way.steps.max(1) as i32;
        if let Some(slot) = self.layers.get_mut(self.count) {
            *slot = Some((texel, weight[0], by));
            self.count += 1;
        }
    }

    /// The colour after `k` steps.
    #[inline]
    pub(crate) fn at(&self, k: u32) -> [u8; 4] {
        let mut c = [0; 4];
        for (texel, weight, by) in self.layers[..self.count].iter().flatten() {
            let over = texel.at(k);
            let w = weight + by * k as i32;
            if w <= 0 {
                c = over;
                continue;
            }
            c = core::array::from_fn(|k| {
                let (below, over) = (i32::from(c[k]), i32::from(over[k]));
                (over + (((below - over) * w) >> 8)) as u8
            });
        }
        c
    }
}

impl CellPaint {
    /// What a straight walk over the cell meets.
    #[inline]
    pub(crate) fn walk(&self, way: &Way) -> PaintWalk<'_> {
        let mut walk = PaintWalk {
            layers: [const { None }; MAX_LAYERS],
            count: 0,
        };
        walk.add(&self.base, way, [0.0; 2]);
        for layer in &self.overlays {
            let below = |[u, v]: [f32; 2]| layer.cover.below(u, v);
            walk.add(&layer.texture, way, [below(way.from), below(way.to)]);
        }
        if !self.roads.is_empty() {
            let below = |[u, v]: [f32; 2]| self.roads.iter().fold(1.0, |w, c| w * c.below(u, v));
            walk.add(&self.road, way, [below(way.from), below(way.to)]);
        }
        walk
    }

    /// The colour at (u, v) of the cell, u east, v south; `texels` is the square of how much of the cell's side a pixel
    /// covers.
    #[inline]
    pub(crate) fn fetch(&self, u: f32, v: f32, texels: f32) -> [u8; 4] {
        let of = |t: &TypeTexture| -> [u8; 4] {
            let size = t.tiling * t.texture.width() as f32;
            let level = t.texture.level_for(texels * size * size);
            t.texture.fetch(level, u * t.tiling, v * t.tiling, true)
        };
        let mix = |below: [u8; 4], over: [u8; 4], a: f32| -> [u8; 4] {
            core::array::from_fn(|k| {
                let (b, o) = (f32::from(below[k]), f32::from(over[k]));
                (o + (b - o) * a + 0.5) as u8
            })
        };
        let mut c = of(&self.base);
        for layer in &self.overlays {
            let a = layer.cover.below(u, v);
            if a < 1.0 {
                c = mix(c, of(&layer.texture), a);
            }
        }
        let mut below = 1.0;
        for cover in &self.roads {
            below *= cover.below(u, v);
        }
        if below < 1.0 {
            c = mix(c, of(&self.road), below);
        }
        c
    }
}

/// A little picture of one colour with speckles, so that ground without textures shows distance and motion.
fn ground_texture(color: Vec3, seed: u32) -> Texture {
    const SIDE: u32 = 32;
    let mut state = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let pixels = (0..SIDE * SIDE)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            let shade = 0.88 + 0.24 * (state >> 8 & 0xFF) as f32 / 255.0;
            let c = |v: f32| (v * shade * 255.0).clamp(0.0, 255.0) as u8;
            [c(color.x), c(color.y), c(color.z), 255]
        })
        .collect();
    Texture::new(SIDE, SIDE, pixels, false)
}

/// Colours of the terrain types for worlds that give none (`rendering.md` 11.4).
const DEFAULT_COLORS: [Vec3; TYPES] = {
    const fn c(r: u8, g: u8, b: u8) -> Vec3 {
        Vec3::new(r as f32 / 255.0, g as f32 / 255.0, b as f32 / 255.0)
    }
    let mut all = [c(104, 104, 92); TYPES];
    all[0] = c(122, 108, 90);
    all[1] = c(88, 122, 58);
    all[2] = c(206, 222, 232);
    all[3] = c(70, 128, 52);
    all[4] = c(84, 98, 62);
    all[5] = c(98, 76, 54);
    all[6] = c(44, 40, 48);
    all[7] = c(132, 106, 76);
    all[8] = c(120, 108, 72);
    all[9] = c(104, 120, 64);
    all[10] = c(204, 184, 128);
    all[11] = c(162, 158, 148);
    all[12] = c(176, 156, 116);
    all[13] = c(136, 122, 108);
    all[14] = c(114, 110, 84);
    all[15] = c(234, 240, 246);
    all[16] = c(66, 112, 140);
    all[17] = c(58, 102, 132);
    all[18] = c(72, 132, 156);
    all[19] = c(64, 120, 150);
    all[20] = c(36, 74, 116);
    all[ROAD] = c(142, 132, 116);
    all
};

#[cfg(test)]
mod tests {
    use super::*;

    /// A map that is 0 at its SW corner and 255 at the others.
    fn corner_map() -> Arc<Texture> {
        let n = 16;
        let pixels = (0..n * n)
            .map(|i| {
                let (x, y) = (i % n, i / n);
                let near = x < n / 2 && y >= n / 2;
                [255, 255, 255, if near { 0 } else { 255 }]
            })
            .collect();
        Arc::new(Texture::new(n, n, pixels, false))
    }

    fn corner_weights(cover: &Cover) -> u32 {
        // SW, SE, NE, NW in (u, v).
        let at = [(0.05, 0.95), (0.95, 0.95), (0.95, 0.05), (0.05, 0.05)];
        at.iter().enumerate().fold(0, |bits, (k, &(u, v))| {
            bits | u32::from(cover.below(u, v) < 0.5) << k
        })
    }

    #[test]
    fn r23_a_turned_map_covers_the_corner_its_code_names() {
        for (turns, wanted) in [(0, 1), (1, 2), (2, 4), (3, 8)] {
            assert_eq!(
                corner_weights(&Cover::Map(corner_map(), turns)),
                wanted,
                "{turns} turns"
            );
            assert_eq!(quarter_turns(1, wanted), Some(turns));
        }
    }

    #[test]
    fn r23_corners_without_maps_cover_what_the_mask_names() {
        for mask in 0..16 {
            assert_eq!(corner_weights(&Cover::Corners(mask)), mask);
        }
    }

    #[test]
    fn r23_all_road_masks_cover_exactly_the_road_corners() {
        let paint = TerrainPaint {
            types: (0..TYPES)
                .map(|_| TypeTexture {
                    texture: Arc::new(Texture::solid([0; 4])),
                    tiling: 1.0,
                })
                .collect(),
            corner_maps: Vec::new(),
            side_maps: Vec::new(),
            road_maps: Vec::new(),
            textured: false,
        };
        for corners in 0..16u32 {
            let bit = |k: u32, shift: u32| (corners >> k & 1) << shift;
            let code = 1 << 28 | bit(0, 26) | bit(1, 24) | bit(2, 22) | bit(3, 20);
            let cell = paint.cell(code);
            let covered = cell.roads.iter().fold(0, |bits, c| bits | corner_weights(c));
            assert_eq!(covered, corners);
        }
    }

    #[test]
    fn r11_5e_the_last_overlay_wins_and_the_road_lies_on_top() {
        let solid = |v: u8| TypeTexture {
            texture: Arc::new(Texture::solid([v, v, v, 255])),
            tiling: 1.0,
        };
        let mut cell = CellPaint {
            base: solid(10),
            overlays: vec![
                Layer {
                    texture: solid(20),
                    cover: Cover::Whole,
                },
                Layer {
                    texture: solid(30),
                    cover: Cover::Whole,
                },
            ],
            roads: vec![],
            road: solid(40),
        };
        let way = |from, to| Way {
            from,
            to,
            steps: 8,
            texels: 0.0,
        };
        assert_eq!(cell.fetch(0.5, 0.5, 0.0)[..3], [30; 3]);
        cell.roads.push(Cover::Whole);
        assert_eq!(cell.fetch(0.5, 0.5, 0.0)[..3], [40; 3]);
        assert_eq!(cell.walk(&way([0.1; 2], [0.9; 2])).at(3)[..3], [40; 3]);
        // A walk over a border blends as single places do.
        cell.roads = vec![Cover::Corners(6)];
        let walk = cell.walk(&way([0.4, 0.5], [0.6, 0.5]));
        for k in 0..=8 {
            let exact = cell.fetch(0.4 + 0.025 * k as f32, 0.5, 0.0)[0];
            assert!(
                walk.at(k)[0].abs_diff(exact) <= 2,
                "{k}: {} {exact}",
                walk.at(k)[0]
            );
        }
    }
}
