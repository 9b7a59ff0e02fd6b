//! What can be wrong with one record.

use thiserror::Error;

/// A record that could not be read or written: which record, which byte, which field, and what is wrong there.
///
/// The name of the file is added by whoever knows it (the container and `DatSet`).
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("record {id:08X}, byte {offset:#x}, field `{field}`: {kind}")]
pub struct RecordError {
    /// Data id of the record.
    pub id: u32,
    /// Byte offset from the record's start: where the offending field begins when reading, where it would have
    /// been put when writing.
    pub offset: usize,
    /// Name of the field.
    pub field: &'static str,
    /// What is wrong.
    pub kind: RecordErrorKind,
}

/// What is wrong at the place a [`RecordError`] names.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RecordErrorKind {
    /// The record ends before the field does.
    #[error("record is truncated: {wanted} bytes wanted, {left} left")]
    Truncated {
        /// Bytes that the field needs.
        wanted: usize,
        /// Bytes that the record still has.
        left: usize,
    },
    /// Bytes remain after the last field (`dat-format.md` F6).
    #[error("{left} bytes left over after the last field")]
    TrailingBytes {
        /// How many.
        left: usize,
    },
    /// A count that the rest of the record cannot hold (D1).
    #[error("count {count} needs at least {needed} bytes, {left} left")]
    CountTooLarge {
        /// The count as read.
        count: u64,
        /// The fewest bytes so many items take.
        needed: u64,
        /// Bytes that the record still has.
        left: usize,
    },
    /// A signed count below zero (D6).
    #[error("count {0} is negative")]
    NegativeCount(i32),
    /// A value the format does not allow here.
    #[error("value {value:#x} is not {expected}")]
    BadValue {
        /// The value, its bits as an unsigned number.
        value: u32,
        /// What would be allowed.
        expected: &'static str,
    },
    /// A BSP node tag that is neither LEAF, PORT nor begins with B (section 8.3).
    #[error("{0:#010X} is not a BSP node tag")]
    BadBspTag(u32),
    /// A BSP tree deeper than the limit of G13.
    #[error("BSP tree is more than {limit} nodes deep")]
    BspTooDeep {
        /// The limit.
        limit: usize,
    },
    /// A BSP tree with more nodes than the limit of G13.
    #[error("BSP tree has more than {limit} nodes")]
    BspTooManyNodes {
        /// The limit.
        limit: usize,
    },
    /// Writing only: more items than the stored count can say.
    #[error("{count} items do not fit, at most {max}")]
    TooMany {
        /// Items to write.
        count: usize,
        /// The most that can be written.
        max: usize,
    },
    /// Writing only: two fields of the value contradict each other, so that no bytes say both.
    #[error("cannot be written: {0}")]
    Inconsistent(&'static str),
}
