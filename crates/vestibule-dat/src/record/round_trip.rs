//! Holds a record's bytes against what is written back from its parsed form (`dat-format.md` D5).

use super::{Record, RecordError};
use crate::data_id::RecordKind;

/// How a record compares with itself after parsing and encoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RoundTrip {
    /// Byte for byte the same.
    Identical,
    /// The same except for padding bytes, which are written as zero.
    PaddingDiffers,
    /// Not the same.
    Different {
        /// The first byte that differs, or the length of the shorter one.
        offset: usize,
    },
}

/// Parses a record, encodes it and compares.
///
/// # Errors
/// The record cannot be parsed (or, which never happens to a record that was parsed, not be written).
///
/// ```
/// use vestibule_dat::RecordKind;
/// use vestibule_dat::record::{RoundTrip, round_trip};
///
/// let palette = [1, 0, 0, 4, 1, 0, 0, 0, 0x30, 0x20, 0x10, 0xFF];
/// assert_eq!(round_trip(RecordKind::Palette, 0x0400_0001, &palette)?, RoundTrip::Identical);
/// # Ok::<(), vestibule_dat::record::RecordError>(())
/// ```
pub fn round_trip(kind: RecordKind, id: u32, bytes: &[u8]) -> Result<RoundTrip, RecordError> {
    let (written, padding) = Record::parse(kind, id, bytes)?.write(id)?;
    if written == bytes {
        return Ok(RoundTrip::Identical);
    }
    let is_padding = |offset: usize| padding.iter().any(|range| range.contains(&offset));
    let difference = written
        .iter()
        .zip(bytes)
        .enumerate()
        .find(|&(offset, (a, b))| a != b && !is_padding(offset));
    match difference {
        Some((offset, _)) => Ok(RoundTrip::Different { offset }),
        None if written.len() == bytes.len() => Ok(RoundTrip::PaddingDiffers),
        None => Ok(RoundTrip::Different {
            offset: written.len().min(bytes.len()),
        }),
    }
}
