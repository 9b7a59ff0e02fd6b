//! Short ids, widened when read and shortened when written (`dat-format.md` P9).

use super::{RecordError, RecordErrorKind};
use crate::primitive::{Reader, Writer};

/// High word of a Surface id.
pub(crate) const SURFACES: u32 = 0x0800_0000;
/// High word of an Environment id.
pub(crate) const ENVIRONMENTS: u32 = 0x0D00_0000;

/// A cell of the landblock that `landblock` (any id in it) lies in.
#[inline]
pub(crate) fn widen_cell(short: u16, landblock: u32) -> u32 {
    landblock & 0xFFFF_0000 | u32::from(short)
}

/// `count` short ids under the high word of `base`.
#[inline]
pub(crate) fn read_cells(
    reader: &mut Reader<'_>,
    count: usize,
    base: u32,
    field: &'static str,
) -> Result<Vec<u32>, RecordError> {
    let (words, _) = reader.take(2 * count, field)?.as_chunks();
    Ok(words
        .iter()
        .map(|&word| widen_cell(u16::from_le_bytes(word), base))
        .collect())
}

/// Writes the low word of `id`, which must lie under the high word of `base`.
#[inline]
pub(crate) fn write_cell(
    writer: &mut Writer,
    id: u32,
    base: u32,
    field: &'static str,
) -> Result<(), RecordError> {
    if id & 0xFFFF_0000 != base & 0xFFFF_0000 {
        let expected = "an id with the high word that this field implies";
        return Err(writer.error(field, RecordErrorKind::BadValue { value: id, expected }));
    }
    writer.u16(id as u16);
    Ok(())
}
