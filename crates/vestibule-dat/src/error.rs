//! What can go wrong with a container, and where it did.
//!
//! [`Error`] says *where* (file, record id, byte offset, field); its [`ErrorKind`] says *what*. Kinds fall into four groups by
//! whose fault it is: the disk, the file, the budget ([`Limits`]), the caller. "Not in this file" is never an error:
//! look-ups return `Ok(None)`.

use std::{fmt, io};

use crate::record::{RecordError, RecordErrorKind};

/// Short form used throughout the crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A failure of a container: what happened, in which file, at which record, byte and field.
///
/// The error is one pointer wide, so results of hot look-ups stay small.
#[derive(Debug)]
pub struct Error(Box<Inner>);

#[derive(Debug)]
struct Inner {
    file: String,
    id: Option<u32>,
    offset: Option<u64>,
    field: &'static str,
    kind: ErrorKind,
}

impl Error {
    /// An error of `file` (a path, or the name given to bytes in memory) at `field`.
    pub fn new(file: impl Into<String>, field: &'static str, kind: ErrorKind) -> Error {
        Error(Box::new(Inner {
            file: file.into(),
            id: None,
            offset: None,
            field,
            kind,
        }))
    }

    /// An error of a record of `file`. [`Error::offset`] then counts from the record's start.
    pub fn from_record(file: impl Into<String>, error: RecordError) -> Error {
        Error::new(file, error.field, ErrorKind::Record(error.kind))
            .with_id(error.id)
            .with_offset(error.offset as u64)
    }

    /// Adds the record concerned.
    #[must_use]
    pub fn with_id(mut self, id: u32) -> Error {
        self.0.id = Some(id);
        self
    }

    /// Adds the byte offset in the file.
    #[must_use]
    pub fn with_offset(mut self, offset: u64) -> Error {
        self.0.offset = Some(offset);
        self
    }

    /// The file: a path, or the name given to bytes in memory.
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// The record concerned, if one is.
    pub fn id(&self) -> Option<u32> {
        self.0.id
    }

    /// The byte offset in the file, if the error is about a place in it; of an [`ErrorKind::Record`] that in the record.
    pub fn offset(&self) -> Option<u64> {
        self.0.offset
    }

    /// The field concerned, in the words of `dat-format.md` ("magic", "link", "entry_count", ...).
    pub fn field(&self) -> &'static str {
        self.0.field
    }

    /// What happened.
    pub fn kind(&self) -> &ErrorKind {
        &self.0.kind
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0.kind {
            ErrorKind::MissingFile => return write!(f, "there is no {}", self.0.file),
            ErrorKind::Io(e) if self.0.field == "folder" => {
                return write!(f, "cannot read the folder {}: {e}", self.0.file);
            }
            _ => {}
        }
        if let Some(id) = self.0.id {
            write!(f, "record 0x{id:08X}: ")?;
        }
        write!(f, "{}: {}", self.0.field, self.0.kind)?;
        if let Some(offset) = self.0.offset {
            write!(f, ", at byte 0x{offset:X}")?;
            if matches!(self.0.kind, ErrorKind::Record(_)) {
                write!(f, " of the record")?;
            }
        }
        write!(f, " in {}", self.0.file)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.0.kind {
            ErrorKind::Io(e) => Some(e),
            ErrorKind::Record(e) => Some(e),
            _ => None,
        }
    }
}

/// What happened to a container.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ErrorKind {
    // The disk.
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// Another writer holds the file, or another program keeps it open so that it cannot be replaced.
    #[error("in use by another program")]
    InUse,

    // The file.
    /// The file ends before what it must hold.
    #[error("the file has {have} bytes where {need} are needed")]
    TooShort {
        /// Bytes needed.
        need: u64,
        /// Bytes there.
        have: u64,
    },
    /// The word at 0x140 is not `0x00005442` (C1): not a DAT file, or one from before 2005 (C4).
    #[error("not a DAT file: magic is 0x{found:08X}, not 0x00005442")]
    BadMagic {
        /// The word found.
        found: u32,
    },
    /// The block size is below 16 or no multiple of 4 (C1), or larger than this library writes.
    #[error("{0} is no usable block size")]
    BadBlockSize(i32),
    /// An offset points outside the blocks of the file (C1, C8, B8).
    #[error("0x{value:X} is outside the blocks of a file of 0x{file_size:X} bytes")]
    OutsideFile {
        /// The offset.
        value: u64,
        /// Where the file ends.
        file_size: u64,
    },
    /// The link of a block still wanted says that the block is free (C7).
    #[error("the block is marked free")]
    FreeBlock,
    /// The chain ends, or would need more bytes than the file has, before the record does (C8).
    #[error("the chain ends {missing} bytes early")]
    ChainTooShort {
        /// Bytes still wanted.
        missing: u64,
    },
    /// A chain comes back to a block it has been at, or to one that overlaps it.
    #[error("the chain runs into itself")]
    ChainLoop,
    /// A node says that it has more than 61 entries (B8).
    #[error("{0} entries, a node has at most 61")]
    TooManyEntries(u32),
    /// A node other than the root has no entries (B8).
    #[error("a node other than the root has no entries")]
    EmptyNode,
    /// An id of a node is not above the one before, or outside of what the parents leave to it (B3, B8).
    #[error("id 0x{id:08X} is out of order in this node")]
    IdOutOfOrder {
        /// The id.
        id: u32,
    },
    /// The tree is deeper than 8 levels (B8).
    #[error("the tree is deeper than 8 levels")]
    TooDeep,
    /// A block belongs to two owners (found by a verifier).
    #[error("the block at 0x{block:X} also belongs to {other}")]
    BlockUsedTwice {
        /// Offset of the block.
        block: u64,
        /// The other owner, in words.
        other: String,
    },
    /// The free list is not what the header says (R4).
    #[error("the free list is broken: {0}")]
    FreeList(&'static str),
    /// A compressed record does not inflate to what it announces (B9, B10).
    #[error("the compressed record is corrupt: {0}")]
    Compressed(&'static str),
    /// The iteration record has another shape than section 6 allows (V3).
    #[error("not an iteration record: {0}")]
    Iteration(&'static str),
    /// The file is another one of the four than was asked for.
    #[error("this is {found}, {expected} was expected")]
    WrongKind {
        /// What was asked for.
        expected: &'static str,
        /// What the header says.
        found: String,
    },

    /// A record is not what its id says (sections 7 to 11).
    #[error("{0}")]
    Record(RecordErrorKind),

    // The budget.
    /// A record is larger than [`Limits`] allow.
    #[error("{size} bytes, the limit is {limit}")]
    OverLimit {
        /// Bytes wanted.
        size: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// Writing on would put a block at or beyond 2 GiB (C10).
    #[error("the file would grow past 2 GiB")]
    FileFull,

    // The caller.
    /// A folder lacks a file that is needed.
    #[error("not in this folder")]
    MissingFile,
    /// A builder wants ascending ids.
    #[error("ids must ascend, the one before is 0x{previous:08X}")]
    NotAscending {
        /// The id before.
        previous: u32,
    },
    /// An insert met an id that is there, see [`crate::DatEditor::insert`].
    #[error("the record exists already")]
    Exists,
    /// A replace met an id that is not there, see [`crate::DatEditor::replace`].
    #[error("there is no such record")]
    Absent,
    /// An incoming record must not replace one of a higher iteration (V4).
    #[error("iteration {given} is older than {present}, which is in the file")]
    OlderIteration {
        /// The iteration in the file.
        present: i32,
        /// The iteration given.
        given: i32,
    },
    /// An incompletely patched file is not written unless forced (V2).
    #[error("the file is incompletely patched; edit it only when forced")]
    Incomplete,
    /// An earlier failure left this handle in a state it cannot go on from. The file on disk is whole.
    #[error("an earlier failure ended this handle; open the file again")]
    Ended,
}

/// Budgets that bound what an untrusted file can make a reader do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Largest size of a record after inflating, in bytes (B10). 64 MiB unless changed.
    pub inflated: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { inflated: 64 << 20 }
    }
}

/// An error on its way up: the place inside the file is known, file name and record are not yet.
#[derive(Debug)]
pub(crate) struct Fault {
    pub(crate) offset: Option<u64>,
    pub(crate) field: &'static str,
    pub(crate) kind: ErrorKind,
}

impl Fault {
    #[cold]
    pub(crate) fn at(offset: u64, field: &'static str, kind: ErrorKind) -> Fault {
        Fault {
            offset: Some(offset),
            field,
            kind,
        }
    }

    #[cold]
    pub(crate) fn new(field: &'static str, kind: ErrorKind) -> Fault {
        Fault {
            offset: None,
            field,
            kind,
        }
    }

    #[cold]
    pub(crate) fn named(self, file: &str, id: Option<u32>) -> Error {
        Error(Box::new(Inner {
            file: file.to_owned(),
            id,
            offset: self.offset,
            field: self.field,
            kind: self.kind,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d2_names_file_record_offset_and_field() {
        let e = Fault::at(0x1400, "link", ErrorKind::FreeBlock).named("client_cell_1.dat", Some(0xA9B4_0170));
        let text = e.to_string();
        for part in ["client_cell_1.dat", "0xA9B40170", "0x1400", "link"] {
            assert!(text.contains(part), "{part} is missing from {text:?}");
        }
    }

    #[test]
    fn errors_can_cross_threads() {
        fn ok<T: Send + Sync + 'static>() {}
        ok::<Error>();
    }
}
