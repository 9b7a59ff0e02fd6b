//! The small values every record is made of, and the cursors that read and write them (`dat-format.md` section 7).
//!
//! [`Reader`] and [`Writer`] are public so that tools can take apart record types that this crate does not know.

mod reader;
mod writer;

pub use reader::Reader;
pub use writer::Writer;

use std::borrow::Cow;

use glam::{Quat, Vec3};

/// Place and orientation: a point `p` of the frame's own space lies at `origin + rotation * p` in the space the
/// frame is given in.
///
/// The quaternion is exactly as stored: nearly, but not always quite, of length 1 (P10). Metres.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Frame {
    /// Where the frame's own origin lies, metres.
    pub origin: Vec3,
    /// Orientation. Stored w, x, y, z; never renormalised here.
    pub rotation: Quat,
}

impl Frame {
    /// No displacement, no rotation.
    pub const IDENTITY: Self = Self {
        origin: Vec3::ZERO,
        rotation: Quat::IDENTITY,
    };
}

impl Default for Frame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// A plane; the signed distance of a point is `normal · p + d`, metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Plane {
    /// Unit normal; points to the front (positive) side.
    pub normal: Vec3,
    /// Distance term, metres.
    pub d: f32,
}

/// A sphere, metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius.
    pub radius: f32,
}

/// An upright cylinder that collides like one, metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CylSphere {
    /// Centre of the bottom disc.
    pub low_point: Vec3,
    /// Radius.
    pub radius: f32,
    /// Height above `low_point`.
    pub height: f32,
}

/// A colour, `0xAARRGGBB`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Argb(
    /// Alpha in the highest byte, blue in the lowest.
    pub u32,
);

impl Argb {
    /// Alpha, 0 to 255.
    pub fn alpha(self) -> u8 {
        (self.0 >> 24) as u8
    }

    /// Red, 0 to 255.
    pub fn red(self) -> u8 {
        (self.0 >> 16) as u8
    }

    /// Green, 0 to 255.
    pub fn green(self) -> u8 {
        (self.0 >> 8) as u8
    }

    /// Blue, 0 to 255.
    pub fn blue(self) -> u8 {
        self.0 as u8
    }
}

/// A 32-bit boolean, kept as the word that was read: any non-zero word is true (`dat-format.md` D5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bool32(
    /// The word.
    pub u32,
);

impl Bool32 {
    /// Whether the word means true.
    pub fn is_true(self) -> bool {
        self.0 != 0
    }
}

impl From<bool> for Bool32 {
    fn from(value: bool) -> Self {
        Self(u32::from(value))
    }
}

/// A string of the "AC1Legacy" kind (P3): bytes in Windows-1252, kept as they are.
#[derive(Debug, Clone, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LegacyString {
    /// The characters, one byte each.
    pub bytes: Vec<u8>,
    /// Whether the length is spelled in the long form (0xFFFF and a 32-bit length) although the short one would do.
    pub long_form: bool,
}

impl LegacyString {
    /// A string in the usual spelling.
    pub fn new(bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            bytes: bytes.into(),
            long_form: false,
        }
    }

    /// The text, decoded from Windows-1252; the five bytes that code page leaves undefined become U+FFFD.
    pub fn text(&self) -> Cow<'_, str> {
        if self.bytes.is_ascii() {
            String::from_utf8_lossy(&self.bytes)
        } else {
            Cow::Owned(self.bytes.iter().map(|&byte| windows_1252(byte)).collect())
        }
    }
}

impl From<&str> for LegacyString {
    /// Takes the characters that Windows-1252 has; any other becomes `?`.
    fn from(text: &str) -> Self {
        Self::new(
            text.chars()
                .map(|wanted| windows_1252_byte(wanted).unwrap_or(b'?'))
                .collect::<Vec<u8>>(),
        )
    }
}

/// Windows-1252 where it differs from Latin-1.
const WINDOWS_1252_80: [char; 32] = [
    '\u{20AC}', '\u{FFFD}', '\u{201A}', '\u{0192}', '\u{201E}', '\u{2026}', '\u{2020}', '\u{2021}',
    '\u{02C6}', '\u{2030}', '\u{0160}', '\u{2039}', '\u{0152}', '\u{FFFD}', '\u{017D}', '\u{FFFD}',
    '\u{FFFD}', '\u{2018}', '\u{2019}', '\u{201C}', '\u{201D}', '\u{2022}', '\u{2013}', '\u{2014}',
    '\u{02DC}', '\u{2122}', '\u{0161}', '\u{203A}', '\u{0153}', '\u{FFFD}', '\u{017E}', '\u{0178}',
];

fn windows_1252(byte: u8) -> char {
    match byte {
        0x80..=0x9F => WINDOWS_1252_80[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

fn windows_1252_byte(wanted: char) -> Option<u8> {
    match u32::from(wanted) {
        code @ (0..=0x7F | 0xA0..=0xFF) => u8::try_from(code).ok(),
        0xFFFD => None,
        _ => (0x80..=0x9F).find(|&byte| windows_1252(byte) == wanted),
    }
}

/// How many bytes a compressed u32 (P1) takes. A small value may be spelled longer than it needs; a record that is
/// written back keeps the spelling (D5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum CompressedForm {
    /// One byte: up to 0x7F.
    #[default]
    One,
    /// Two bytes: up to 0x3FFF.
    Two,
    /// Four bytes: up to 0x3FFF_FFFF.
    Four,
}

impl CompressedForm {
    /// The largest value any form can say.
    pub const MAX_VALUE: u32 = 0x3FFF_FFFF;

    /// The shortest form that can say `value`.
    pub fn shortest(value: u32) -> Self {
        match value {
            0..=0x7F => Self::One,
            0x80..=0x3FFF => Self::Two,
            _ => Self::Four,
        }
    }
}

/// An id of known type (P2): stored as an offset from the type's first id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct KnownTypeId {
    /// The whole id.
    pub id: u32,
    /// Whether the four-byte form was read; kept for D5 because offsets below 0x8000 have two spellings.
    pub long_form: bool,
}

impl KnownTypeId {
    /// An id in the spelling that retail's writers give it: the long form from offset 0x4000 up.
    pub fn new(id: u32, base: u32) -> Self {
        Self {
            id,
            long_form: id.wrapping_sub(base) >= 0x4000,
        }
    }
}

/// The header of a packed hash table (P8): what is kept beside its entries.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PackedHashTable {
    /// Number of buckets: a hint for look-up, kept but not interpreted.
    pub bucket_count: u16,
    /// Keys and values in file order.
    pub entries: Vec<(u32, u32)>,
}

impl Default for PackedHashTable {
    fn default() -> Self {
        Self {
            bucket_count: Self::DEFAULT_BUCKETS,
            entries: Vec::new(),
        }
    }
}

impl PackedHashTable {
    /// Buckets of a new table.
    pub const DEFAULT_BUCKETS: u16 = 8;

    /// A new table in the order P8 prescribes: grouped by `key mod bucket_count` ascending, then by key.
    pub fn new(mut entries: Vec<(u32, u32)>) -> Self {
        let buckets = u32::from(Self::DEFAULT_BUCKETS);
        entries.sort_by_key(|&(key, _)| (key % buckets, key));
        Self {
            bucket_count: Self::DEFAULT_BUCKETS,
            entries,
        }
    }

    /// The value of `key`; the first, should a damaged table name it twice.
    pub fn get(&self, key: u32) -> Option<u32> {
        self.entries
            .iter()
            .find(|entry| entry.0 == key)
            .map(|entry| entry.1)
    }
}
