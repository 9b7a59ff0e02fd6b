//! Reads and writes the retail DAT containers and records of Asheron's Call; knows bytes, not the game.
//!
//! - [`DatSet`] opens an installation's folder and finds records in the right file.
//! - [`DatFile`] is one file open for reading: look up, iterate, query ranges of ids. Opening does not scan; records that lie in
//!   one block are borrowed from the file.
//! - [`DatBuilder`] writes a whole file in canonical form and puts it in place of an old one; [`compact`] does that with a file's
//!   own records. [`DatEditor`] inserts, replaces and deletes in place. Either leaves the file wholly old or wholly new,
//!   whenever it is stopped. [`DatFile::verify`] checks a file from end to end.
//! - [`RecordKind`] tells a record's type by its id; [`record`] has every type with `parse` and `encode`, and lint.
//!   [`DatSet::cell_record`] and [`DatSet::asset_record`] read and parse in one call.
//! - [`primitive`] has the small values records are made of, and cursors to take apart what this crate does not know.
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
//! A file made in memory, and a record out of it:
//! ```
//! use vestibule_dat::record::Palette;
//! use vestibule_dat::{DatBuilder, DatFile, DatKind, Header, WriteOptions};
//!
//! let palette = Palette { id: 0x0400_0001, ..Palette::default() };
//! let mut dat = DatBuilder::new("portal", Vec::new(), Header::new(DatKind::Portal))?;
//! dat.push(palette.id, &palette.encode()?, &WriteOptions::default())?;
//!
//! let file = DatFile::from_bytes("portal", dat.finish()?)?;
//! assert_eq!(file.record_as::<Palette>(0x0400_0001)?, Some(palette));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//! `mmap` (default): [`DatFile::open`] maps the file instead of reading it. Leave it off for wasm32.
//!
//! `serde`: every record type implements `serde::Serialize`.

mod container;
mod dat_set;
mod data_id;
mod error;
pub mod primitive;
pub mod record;

pub use container::{
    CloseReport, DatBuilder, DatEditor, DatFile, DatKind, EditOptions, Entries, Entry, FileStorage, Header,
    ITERATION_ID, IterationRecord, NewFile, Storage, TRANSACTION_CLEAN, VerifyReport, WriteOptions, compact,
};
pub use dat_set::DatSet;
pub use data_id::RecordKind;
pub use error::{Error, ErrorKind, Limits, Result};
