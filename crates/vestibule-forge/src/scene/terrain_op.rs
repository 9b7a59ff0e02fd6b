//! What shapes the land, in the order in which it was written.

use glam::DVec2;

use crate::text::Span;

/// The terrain types by the names used in scenes (`world.md` A1).
pub(crate) const TERRAIN_TYPES: [(&str, u8); 33] = [
    ("barren_rock", 0),
    ("grassland", 1),
    ("ice", 2),
    ("lush_grass", 3),
    ("marsh", 4),
    ("mud", 5),
    ("obsidian", 6),
    ("packed_dirt", 7),
    ("patchy_dirt", 8),
    ("patchy_grass", 9),
    ("yellow_sand", 10),
    ("grey_sand", 11),
    ("rocky_sand", 12),
    ("sedimentary_rock", 13),
    ("semi_barren", 14),
    ("snow", 15),
    ("running_water", 16),
    ("standing_water", 17),
    ("shallow_sea", 18),
    ("still_sea", 19),
    ("deep_sea", 20),
    ("forest_floor", 21),
    ("faux_water", 22),
    ("sea_slime", 23),
    ("argila", 24),
    ("volcano_1", 25),
    ("volcano_2", 26),
    ("blue_ice", 27),
    ("moss", 28),
    ("dark_moss", 29),
    ("olthoi", 30),
    ("desolate", 31),
    ("road", 32),
];

/// The terrain type of that name; roads are not painted with types.
pub(crate) fn terrain_named(name: &str) -> Option<u8> {
    TERRAIN_TYPES
        .iter()
        .find(|(n, t)| *n == name && *t < 32)
        .map(|(_, t)| *t)
}

/// Which vertices are painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Area {
    Everywhere,
    Box(DVec2, DVec2),
    Circle(DVec2, f64),
    /// Higher than this.
    Above(f64),
    /// Lower than this.
    Below(f64),
    /// Where the ground rises by more than this to a neighbouring vertex, metres per metre.
    Steeper(f64),
    /// A share of the vertices, picked by a patchy noise.
    Patches(f64, u32),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TerrainOp {
    Base(f64),
    /// Rolling ground: height, wavelength, seed.
    Noise(f64, f64, u32),
    /// A round hill (or hollow): centre, radius, height.
    Hill(DVec2, f64, f64),
    /// A long hill: ends, half width, height.
    Ridge(DVec2, DVec2, f64, f64),
    /// Ground that rises all around a point: centre, radius where it starts, radius where it is full, height.
    Bowl(DVec2, f64, f64, f64),
    /// All vertices of a rectangle at one height.
    Level(DVec2, DVec2, f64),
    /// The vertex nearest to a point.
    Set(DVec2, f64),
    Paint(u8, Area),
    /// Vertices along a line.
    Road(Vec<DVec2>, Span),
}
