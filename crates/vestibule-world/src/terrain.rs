//! Terrain: split direction, triangles, heights, water and roads (`world.md` 4 and 5).

use glam::Vec3;

use crate::constants::{
    BLOCK_SIDE_CELLS, BLOCK_SIDE_VERTICES, EPSILON, SQUARE_LENGTH, WATER_DEPTH_DRY_CORNER,
    WATER_DEPTH_ENTIRELY, WATER_DEPTH_WET_CORNER,
};
use crate::geometry::Plane;
use crate::ids::LandCoord;
use crate::lanes::Lanes;

/// Which diagonal splits a land cell into its two triangles (`world.md` 4.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// From the south-west to the north-east corner.
    SwNe,
    /// From the south-east to the north-west corner.
    SeNw,
}

/// The hash whose top bit picks the diagonal of the land cell at `c` (`world.md` 4.2).
pub fn split_hash(c: LandCoord) -> u32 {
    let (x, y) = (c.x as u32, c.y as u32);
    y.wrapping_mul(x.wrapping_mul(214_614_067).wrapping_add(1_813_693_831))
        .wrapping_sub(x.wrapping_mul(1_109_124_029))
        .wrapping_sub(1_369_149_221)
}

/// The diagonal of the land cell at `c` (`world.md` 4.2).
pub fn split_direction(c: LandCoord) -> Split {
    if split_hash(c) >= 0x8000_0000 {
        Split::SwNe
    } else {
        Split::SeNw
    }
}

/// One terrain vertex word: `road`, terrain `type` and `scene` (`world.md` A1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct TerrainWord(pub u16);

impl TerrainWord {
    /// Road kind, 0 for none.
    pub const fn road(self) -> u8 {
        (self.0 & 3) as u8
    }

    /// Terrain type, 0…31.
    pub const fn terrain_type(self) -> u8 {
        (self.0 >> 2 & 0x1F) as u8
    }

    /// Scene index of this terrain type, 0…31.
    pub const fn scene(self) -> u8 {
        (self.0 >> 11) as u8
    }

    /// Whether this is one of the five water types, 16…20 (`world.md` A2).
    pub const fn is_water(self) -> bool {
        matches!(self.terrain_type(), 16..=20)
    }
}

/// How much of a land cell or a landblock is water (`world.md` A3, A4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Water {
    /// None.
    #[default]
    Not,
    /// Some of it.
    Partially,
    /// All of it.
    Entirely,
}

/// One of a land cell's two triangles, in the frame of its landblock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerrainPolygon {
    /// Corners, counter-clockwise seen from above, metres.
    pub vertices: [Vec3; 3],
    /// Its plane; the normal points up.
    pub plane: Plane,
}

impl TerrainPolygon {
    fn new(vertices: [Vec3; 3]) -> Self {
        TerrainPolygon {
            vertices,
            plane: Plane::of_polygon(&vertices),
        }
    }

    /// Whether the column over `p` meets the triangle; edges count as inside, z is ignored
    /// (`world.md` T8, retail `point_in_poly2D`, positive side).
    #[inline]
    pub fn contains_2d(&self, p: Vec3) -> bool {
        let [a, b, c] = self.vertices;
        let beyond =
            |prev: Vec3, cur: Vec3| (cur.x - prev.x) * (p.y - cur.y) - (cur.y - prev.y) * (p.x - cur.x) > 0.0;
        !(beyond(a, c) | beyond(c, b) | beyond(b, a))
    }

    /// Ground height over (x, y), metres; `None` on a vertical plane (`world.md` T9).
    pub fn height_at(&self, p: Vec3) -> Option<f32> {
        let Plane { normal: n, d } = self.plane;
        (n.z.abs() > EPSILON).then(|| -(n.x * p.x + n.y * p.y + d) / n.z)
    }
}

/// A land cell: a 24 m square of a landblock, an infinite column over two triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct LandCell {
    /// The two triangles in retail's order (`world.md` 4.3), landblock frame.
    pub polygons: [TerrainPolygon; 2],
    /// Which diagonal separates them.
    pub split: Split,
    /// Water at its four corners.
    pub water: Water,
    /// Which corners are water: bit 0 SW, 1 SE, 2 NE, 3 NW.
    pub water_corners: u8,
    /// Index into the landblock's buildings of the one that stands here (`world.md` C1).
    pub building: Option<u16>,
    /// Object that decides who may enter, from the restriction table (`world.md` 19).
    pub restriction: Option<u32>,
    /// Middle of the square.
    middle: Lanes,
    /// For each polygon where the cell's diagonal ends, x and y, and how it runs there.
    diagonals: [Lanes; 2],
    /// See [`LandCell::water_depth`]: in the north-eastern quarter of the cell, the north-western, the south-eastern, the
    /// south-western, metres.
    depths: [f32; 4],
}

/// Many times the rounding of coordinates inside a landblock, metres.
const LAND_SLACK: f32 = 0.01;

impl LandCell {
    /// Whether seen from above both spheres are certainly inside the cell and touch no other; radii are in the fourth
    /// lanes.
    #[inline(always)]
    pub fn certainly_holds(&self, [a, b]: [Lanes; 2]) -> bool {
        let limit = Lanes::splat(SQUARE_LENGTH / 2.0 - LAND_SLACK);
        let within = |s: Lanes| ((s - self.middle).abs() + Lanes::splat(s.fourth())).less(limit);
        within(a) & within(b) & 0b11 == 0b11
    }

    /// A point from the south-west corner of the cell, metres; of the lanes the first two.
    #[inline(always)]
    pub(crate) fn in_square(&self, p: Lanes) -> Lanes {
        p - self.middle + Lanes::splat(SQUARE_LENGTH / 2.0)
    }

    /// On which sides a sphere with its centre inside the cell reaches beyond it, seen from above: 1 to the east and 1 to
    /// the north, -1 to the west and to the south. `None` where that is not certain. The radius is in the fourth lane.
    #[inline(always)]
    pub(crate) fn sides_crossed(&self, s: Lanes) -> Option<[i32; 2]> {
        const HALF: f32 = SQUARE_LENGTH / 2.0;
        let from = s - self.middle;
        let rims = from.abs() + Lanes::splat(s.fourth() - HALF);
        let inside = from.abs().less(Lanes::splat(HALF - LAND_SLACK));
        let sure = inside & Lanes::splat(LAND_SLACK).less(rims.abs());
        if sure & 0b11 != 0b11 || !(s.fourth() < HALF) {
            return None;
        }
        let (crossed, negative) = (Lanes::ZERO.less(rims), from.less(Lanes::ZERO));
        let side = |bit: u32| match (crossed & bit != 0, negative & bit != 0) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => -1,
        };
        Some([side(1), side(2)])
    }

    /// How far a sphere may be shifted so that its centre stays inside the cell and its rim on its side of each border,
    /// seen from above, metres. Zero or less: nothing is certain. The radius is in the fourth lane.
    pub(crate) fn distance_to_change(&self, s: Lanes) -> f32 {
        let inside = Lanes::splat(SQUARE_LENGTH / 2.0) - (s - self.middle).abs();
        let rim = inside - Lanes::splat(s.fourth());
        let limits = rim.abs().lesser(inside);
        let [x, y] = [limits.lane(0), limits.lane(1)];
        (if x < y { x } else { y }) - LAND_SLACK
    }

    /// As [`LandCell::find_terrain_poly`] of a point that the cell certainly holds: only the diagonal is asked.
    #[inline(always)]
    pub fn find_terrain_poly_inside(&self, p: Lanes) -> Option<&TerrainPolygon> {
        let p = p.xyz();
        let [first, second] = &self.polygons;
        let beyond = |diagonal: Lanes| {
            let (end, run) = (diagonal.xyz(), [diagonal.z(), diagonal.fourth()]);
            run[0] * (p.y - end.y) - run[1] * (p.x - end.x) > 0.0
        };
        if !beyond(self.diagonals[0]) {
            Some(first)
        } else if !beyond(self.diagonals[1]) {
            Some(second)
        } else {
            None
        }
    }

    /// The triangle under or over `p`, landblock frame (retail `find_terrain_poly`, `world.md` T7).
    #[inline]
    pub fn find_terrain_poly(&self, p: Vec3) -> Option<&TerrainPolygon> {
        self.polygons.iter().find(|poly| poly.contains_2d(p))
    }

    /// As [`LandCell::water_depth`] at a point that the cell certainly holds.
    #[inline(always)]
    pub fn water_depth_inside(&self, p: Lanes) -> f32 {
        self.depths[(p.less(self.middle) & 0b11) as usize]
    }

    /// How far a body sinks in at `p`, metres (`world.md` A5).
    pub fn water_depth(&self, p: Vec3) -> f32 {
        match self.water {
            Water::Not => 0.0,
            Water::Entirely => WATER_DEPTH_ENTIRELY,
            Water::Partially => {
                let half =
                    |v: f32| v - SQUARE_LENGTH * libm::floorf(v / SQUARE_LENGTH) >= SQUARE_LENGTH / 2.0;
                let corner = match (half(p.x), half(p.y)) {
                    (false, false) => 1,
                    (true, false) => 2,
                    (true, true) => 4,
                    (false, true) => 8,
                };
                if self.water_corners & corner != 0 {
                    WATER_DEPTH_WET_CORNER
                } else {
                    WATER_DEPTH_DRY_CORNER
                }
            }
        }
    }
}

/// Index of vertex (i, j) in a landblock's 81: x-major (`dat-format.md` L1).
pub const fn vertex_index(i: usize, j: usize) -> usize {
    BLOCK_SIDE_VERTICES * i + j
}

/// Builds the 64 land cells of the block whose south-west land cell is `corner`, in order of their ids.
/// `heights` are metres, `words` the terrain words, both in vertex order.
pub fn build_land_cells(corner: LandCoord, heights: &[f32; 81], words: &[TerrainWord; 81]) -> Vec<LandCell> {
    let side = BLOCK_SIDE_CELLS as usize;
    let mut cells = Vec::with_capacity(side * side);
    for cx in 0..side {
        for cy in 0..side {
            let vertex = |i: usize, j: usize| {
                Vec3::new(
                    i as f32 * SQUARE_LENGTH,
                    j as f32 * SQUARE_LENGTH,
                    heights[vertex_index(i, j)],
                )
            };
            let (sw, se) = (vertex(cx, cy), vertex(cx + 1, cy));
            let (ne, nw) = (vertex(cx + 1, cy + 1), vertex(cx, cy + 1));
            let split = split_direction(LandCoord {
                x: corner.x + cx as i32,
                y: corner.y + cy as i32,
            });
            // The diagonals as the polygons' own edges run, for the bits of `TerrainPolygon::contains_2d`.
            let (polygons, diagonals) = match split {
                Split::SwNe => ([[sw, se, ne], [sw, ne, nw]], [[sw, ne], [ne, sw]]),
                Split::SeNw => ([[sw, se, nw], [ne, nw, se]], [[nw, se], [se, nw]]),
            };
            let diagonal =
                |[from, to]: [Vec3; 2]| Lanes::new(Vec3::new(to.x, to.y, to.x - from.x), to.y - from.y);
            let corners = [(cx, cy), (cx + 1, cy), (cx + 1, cy + 1), (cx, cy + 1)];
            let water_corners = corners.iter().enumerate().fold(0u8, |bits, (k, &(i, j))| {
                bits | u8::from(words[vertex_index(i, j)].is_water()) << k
            });
            let water = match water_corners {
                0 => Water::Not,
                0xF => Water::Entirely,
                _ => Water::Partially,
            };
            let middle = Lanes::from((sw + ne) * 0.5);
            let mut cell = LandCell {
                polygons: polygons.map(TerrainPolygon::new),
                split,
                water,
                water_corners,
                building: None,
                restriction: None,
                middle,
                diagonals: diagonals.map(diagonal),
                depths: [0.0; 4],
            };
            let quarters = [(6.0, 6.0), (-6.0, 6.0), (6.0, -6.0), (-6.0, -6.0)];
            cell.depths = quarters.map(|(x, y)| cell.water_depth(middle.xyz() + Vec3::new(x, y, 0.0)));
            cells.push(cell);
        }
    }
    cells
}

/// Water of a whole landblock from its cells (`world.md` A4).
pub fn block_water(cells: &[LandCell]) -> Water {
    if cells.iter().all(|c| c.water == Water::Entirely) {
        Water::Entirely
    } else if cells.iter().all(|c| c.water == Water::Not) {
        Water::Not
    } else {
        Water::Partially
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: i32, y: i32) -> LandCoord {
        LandCoord { x, y }
    }

    /// The cell at (0, 0) of a block at `corner` with the given corner heights and terrain types.
    fn cell(corner: LandCoord, [sw, se, ne, nw]: [f32; 4], types: [u16; 4]) -> LandCell {
        let mut heights = [0.0; 81];
        let mut words = [TerrainWord(0); 81];
        for (k, (i, j)) in [(0, 0), (1, 0), (1, 1), (0, 1)].into_iter().enumerate() {
            heights[vertex_index(i, j)] = [sw, se, ne, nw][k];
            words[vertex_index(i, j)] = TerrainWord(types[k] << 2);
        }
        build_land_cells(corner, &heights, &words).swap_remove(0)
    }

    const SW_NE: LandCoord = LandCoord { x: 0, y: 0 };
    const SE_NW: LandCoord = LandCoord { x: 0, y: 1 };

    #[test]
    fn examples_22_17_and_22_18_split_hash() {
        for (x, y, h) in [
            (0, 0, 0xAE64_70DB_u32),
            (0, 1, 0x1A7F_3662),
            (1, 0, 0x6C48_8D1E),
            (1, 1, 0xE52E_12D8),
            (1352, 1440, 0xC15B_D913),
            (1353, 1440, 0x73B9_1436),
            (1352, 1441, 0xBC3D_ABF2),
            (1024, 1024, 0xAD1B_98DB),
            (2039, 2039, 0x3846_F0E4),
            (657, 1857, 0x8000_01B8),
        ] {
            assert_eq!(split_hash(at(x, y)), h, "{x} {y}");
        }
    }

    #[test]
    fn example_22_19_splits_of_a_landblock() {
        let rows = [
            "////////",
            "////////",
            "///\\\\\\\\\\",
            "//\\\\\\\\\\/",
            "//\\\\\\///",
            "//\\\\//\\\\",
            "/\\\\//\\\\/",
            "/\\\\//\\//",
        ];
        for (k, row) in rows.iter().enumerate() {
            let cy = 7 - k as i32;
            let drawn: String = (0..8)
                .map(|cx| {
                    if split_direction(at(1352 + cx, 1440 + cy)) == Split::SwNe {
                        '/'
                    } else {
                        '\\'
                    }
                })
                .collect();
            assert_eq!(&drawn, row, "row {cy}");
        }
    }

    #[test]
    fn example_22_20_half_the_map_splits_sw_ne() {
        let count = (0..2040)
            .flat_map(|x| (0..2040).map(move |y| at(x, y)))
            .filter(|&c| split_direction(c) == Split::SwNe)
            .count();
        assert_eq!(format!("{:.3}", count as f64 / 4_161_600.0 * 100.0), "50.014");
    }

    #[test]
    fn example_22_21_heights() {
        let heights = [20.0, 40.0, 60.0, 30.0];
        for (corner, tx, ty, expected) in [
            (SW_NE, 0.75, 0.25, 40.0),
            (SW_NE, 0.25, 0.75, 35.0),
            (SW_NE, 0.5, 0.5, 40.0),
            (SE_NW, 0.25, 0.25, 27.5),
            (SE_NW, 0.75, 0.75, 47.5),
            (SE_NW, 0.5, 0.5, 35.0),
        ] {
            let cell = cell(corner, heights, [0; 4]);
            let p = Vec3::new(tx * 24.0, ty * 24.0, 0.0);
            let z = cell.find_terrain_poly(p).unwrap().height_at(p).unwrap();
            assert!((z - expected).abs() < 1e-4, "{corner:?} {tx} {ty}: {z}");
        }
    }

    #[test]
    fn example_22_22_the_diagonal_belongs_to_polygon_0() {
        let cell = cell(SW_NE, [0.0; 4], [0; 4]);
        assert_eq!(
            cell.polygons[0].plane,
            Plane {
                normal: Vec3::Z,
                d: 0.0
            }
        );
        let which = |x: f32, y: f32| {
            let p = Vec3::new(x, y, 0.0);
            cell.polygons
                .iter()
                .map(|poly| poly.contains_2d(p))
                .collect::<Vec<_>>()
        };
        assert_eq!(which(12.0, 6.0), [true, false]);
        assert_eq!(which(6.0, 12.0), [false, true]);
        assert_eq!(which(12.0, 12.0), [true, true]);
        assert_eq!(
            cell.find_terrain_poly(Vec3::new(12.0, 12.0, 0.0)),
            Some(&cell.polygons[0])
        );
    }

    #[test]
    fn example_22_23_a_steep_triangle_is_not_walkable() {
        let cell = cell(SW_NE, [0.0, 24.0, 0.0, 0.0], [0; 4]);
        let n = cell.polygons[0].plane.normal;
        let s = 1.0 / libm::sqrtf(3.0);
        assert!((n - Vec3::new(-s, s, s)).length() < 1e-6);
        assert!(n.z < crate::constants::FLOOR_Z);
        assert_eq!(cell.polygons[1].plane.normal, Vec3::Z);
    }

    #[test]
    fn example_22_24_water() {
        let wet = cell(SW_NE, [0.0; 4], [0x14; 4]);
        assert_eq!(wet.water, Water::Entirely);
        assert_eq!(wet.water_depth(Vec3::new(3.0, 3.0, 0.0)), 0.9);
        let partly = cell(SW_NE, [0.0; 4], [0x14, 1, 1, 1]);
        assert_eq!(partly.water, Water::Partially);
        let depth = |x: f32, y: f32| partly.water_depth(Vec3::new(x, y, 0.0));
        assert_eq!(
            (depth(3.0, 3.0), depth(20.0, 3.0), depth(12.0, 12.0)),
            (0.45, 0.1, 0.1)
        );
        assert_eq!(cell(SW_NE, [0.0; 4], [0x16; 4]).water, Water::Not);
    }

    #[test]
    fn t7_a5_inside_a_cell_one_look_tells_polygon_and_water() {
        let words = core::array::from_fn(|i| TerrainWord(if i % 3 == 1 || i > 50 { 0x14 << 2 } else { 1 }));
        let cells = build_land_cells(SW_NE, &[0.0; 81], &words);
        let waters = [Water::Not, Water::Partially, Water::Entirely];
        assert!(waters.map(|water| cells.iter().any(|c| c.water == water)) == [true; 3]);
        assert!([Split::SwNe, Split::SeNw].map(|split| cells.iter().any(|c| c.split == split)) == [true; 2]);
        let mut seed = 1u32;
        let mut draw = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.02 + 23.96 * ((seed >> 8) as f32 / (1u32 << 24) as f32)
        };
        for cell in &cells {
            let corner = cell.polygons[0].vertices[0];
            for _ in 0..200 {
                let (u, v) = (draw(), draw());
                // On the diagonals and in the middle as well.
                let middle = SQUARE_LENGTH / 2.0;
                for (u, v) in [(u, v), (u, u), (u, SQUARE_LENGTH - u), (u, middle), (middle, v)] {
                    let p = corner + Vec3::new(u, v, 0.0);
                    assert!(cell.certainly_holds([p.into(); 2]));
                    assert_eq!(cell.water_depth_inside(p.into()), cell.water_depth(p), "{p}");
                    assert_eq!(
                        cell.find_terrain_poly_inside(p.into()),
                        cell.find_terrain_poly(p),
                        "{p}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_cell_holds_what_keeps_away_from_its_borders() {
        let cell = &build_land_cells(SW_NE, &[7.0; 81], &[TerrainWord(0); 81])[8];
        let at = |x: f32, y: f32, r: f32| Lanes::new(Vec3::new(x, y, 900.0), r);
        let inside = at(36.0, 12.0, 0.5);
        assert!(cell.certainly_holds([at(24.6, 0.6, 0.5), at(47.4, 23.4, 0.5)]));
        for beyond in [
            at(24.5, 12.0, 0.5),
            at(47.5, 12.0, 0.5),
            at(36.0, 0.3, 0.5),
            at(36.0, 23.6, 0.5),
            at(12.0, 12.0, 0.0),
            at(36.0, f32::NAN, 0.5),
            at(36.0, 12.0, f32::NAN),
        ] {
            assert!(!cell.certainly_holds([beyond, inside]), "{beyond:?}");
            assert!(!cell.certainly_holds([inside, beyond]), "{beyond:?}");
        }
    }

    #[test]
    fn t8_borders_belong_to_both_cells() {
        let heights = [0.0; 81];
        let cells = build_land_cells(SW_NE, &heights, &[TerrainWord(0); 81]);
        let edge = Vec3::new(24.0, 12.0, 0.0);
        assert!(cells[0].find_terrain_poly(edge).is_some());
        assert!(cells[8].find_terrain_poly(edge).is_some());
        assert!(cells[0].find_terrain_poly(Vec3::new(24.001, 12.0, 0.0)).is_none());
    }
}
