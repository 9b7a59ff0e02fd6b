//! Reads and writes the retail DAT containers and records of Asheron's Call; knows bytes, not the game.
//!
//! - [`DatSet`] opens an installation's folder and finds records in the right file.
//! - [`DatFile`] is one file open for reading: look up, iterate, query ranges of ids. Opening does not scan; records that lie in
//!   one block are borrowed from the file.
//!
//! Everything is untrusted input: each offset, count and size is checked when it is used, a failure names file, record, byte
//! offset and field ([`Error`]), and all other records stay usable.
//!
//! # Example
//! ```no_run
//! let dats = vestibule_dat::DatSet::open("/path/to/ac")?;
//! for entry in dats.cell().range(0xA9B4_0100..=0xA9B4_FFFF) {
//!     let entry = entry?;
//!     println!("0x{:08X}: {} bytes", entry.id, dats.cell().read(&entry)?.len());
//! }
//! # Ok::<(), vestibule_dat::Error>(())
//! ```
//!
//! # Features
//! `mmap` (default): [`DatFile::open`] maps the file instead of reading it. Leave it off for wasm32.

mod container;
mod dat_set;
mod data_id;
mod error;
pub mod primitive;
pub mod record;

pub use container::{
    DatBuilder, DatFile, DatKind, Entries, Entry, FileStorage, Header, ITERATION_ID, IterationRecord,
    NewFile, Storage, TRANSACTION_CLEAN, VerifyReport, WriteOptions, compact,
};
pub use dat_set::DatSet;
pub use data_id::RecordKind;
pub use error::{Error, ErrorKind, Limits, Result};
