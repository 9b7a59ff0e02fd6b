//! The container: header, blocks, chains, the B-tree directory, free blocks and safe writing (`dat-format.md` 1 to 6).

mod builder;
mod chain;
mod chain_writer;
mod compress;
mod dat_file;
mod editor;
mod entries;
mod free_list;
mod header;
mod index;
mod iteration;
#[cfg(feature = "mmap")]
mod map;
mod node;
mod scan;
mod storage;
mod tree;
mod verify;
mod window;

pub use builder::{DatBuilder, WriteOptions, compact};
pub use dat_file::DatFile;
pub use editor::{CloseReport, DatEditor, EditOptions};
pub use entries::Entries;
pub use header::{DatKind, Header, TRANSACTION_CLEAN};
pub use iteration::{ITERATION_ID, IterationRecord};
pub use node::Entry;
pub use storage::{FileStorage, NewFile, Storage};
pub use verify::VerifyReport;
