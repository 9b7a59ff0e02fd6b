//! The container: header, blocks, chains, the B-tree directory, free blocks and safe writing (`dat-format.md` 1 to 6).

mod chain;
mod compress;
mod dat_file;
mod entries;
mod header;
mod iteration;
#[cfg(feature = "mmap")]
mod map;
mod node;

pub use dat_file::DatFile;
pub use entries::Entries;
pub use header::{DatKind, Header, TRANSACTION_CLEAN};
pub use iteration::{ITERATION_ID, IterationRecord};
pub use node::Entry;
