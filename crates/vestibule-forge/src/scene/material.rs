//! Materials: a pattern, colours and a size.

use crate::text::Word;

/// How a texture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pattern {
    Plain,
    Grain,
    Grass,
    Soil,
    Rock,
    Bricks,
    Blocks,
    Cobbles,
    Plaster,
    Planks,
    Thatch,
    Shingles,
    Leaves,
    Bark,
    Water,
    Beams,
    Glow,
}

const PATTERNS: [(&str, Pattern); 17] = [
    ("plain", Pattern::Plain),
    ("grain", Pattern::Grain),
    ("grass", Pattern::Grass),
    ("soil", Pattern::Soil),
    ("rock", Pattern::Rock),
    ("bricks", Pattern::Bricks),
    ("blocks", Pattern::Blocks),
    ("cobbles", Pattern::Cobbles),
    ("plaster", Pattern::Plaster),
    ("planks", Pattern::Planks),
    ("thatch", Pattern::Thatch),
    ("shingles", Pattern::Shingles),
    ("leaves", Pattern::Leaves),
    ("bark", Pattern::Bark),
    ("water", Pattern::Water),
    ("beams", Pattern::Beams),
    ("glow", Pattern::Glow),
];

/// The pattern of that name, or all names there are.
pub(crate) fn pattern_named(name: &str) -> Result<Pattern, Vec<&'static str>> {
    let found = PATTERNS.iter().find(|(n, _)| *n == name);
    found
        .map(|(_, p)| *p)
        .ok_or_else(|| PATTERNS.iter().map(|(n, _)| *n).collect())
}

/// A material as written.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Material {
    pub(crate) name: Word,
    pub(crate) pattern: Pattern,
    /// Main colour, red green blue.
    pub(crate) color: [u8; 3],
    /// Second colour: joints, beams, stalks.
    pub(crate) second: [u8; 3],
    /// Metres that the texture covers.
    pub(crate) size: f64,
    pub(crate) seed: u32,
}
