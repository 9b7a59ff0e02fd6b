//! Palette, `04......` (`dat-format.md` 10.8).

use crate::primitive::Argb;

/// Colours by index.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Palette {
    /// Data id as stored.
    pub id: u32,
    /// The colours; usually 2048, or 256.
    pub colors: Vec<Argb>,
}
