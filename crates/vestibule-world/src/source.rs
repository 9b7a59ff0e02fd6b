//! Where a world's records come from.

use std::borrow::Cow;
use std::collections::BTreeMap;

use vestibule_dat::DatSet;

/// Why a record could not be read.
pub type SourceError = Box<dyn core::error::Error + Send + Sync>;

/// Which file a record belongs to. The id alone does not tell: 0x01000100 is a GfxObj in the portal file and an
/// env cell of landblock 0x0100 in the cell file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Store {
    /// LandBlock, LandBlockInfo, EnvCell.
    Cell,
    /// Everything else.
    Portal,
}

/// A store of records, readable from many threads at once.
pub trait RecordSource: Send + Sync {
    /// The bytes of a record; `Ok(None)` when there is none with this id.
    ///
    /// # Errors
    /// When the store is damaged where the record lies.
    fn record(&self, store: Store, id: u32) -> Result<Option<Cow<'_, [u8]>>, SourceError>;

    /// The name of the file that is, or would be, the record's, for messages.
    fn file_of(&self, store: Store, id: u32) -> String;
}

/// Records in memory, for tests and for worlds made on the spot.
#[derive(Clone, Debug, Default)]
pub struct MemoryRecords {
    records: BTreeMap<(Store, u32), Vec<u8>>,
}

impl MemoryRecords {
    /// No records.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds or replaces a record.
    pub fn insert(&mut self, store: Store, id: u32, bytes: Vec<u8>) {
        self.records.insert((store, id), bytes);
    }

    /// Removes a record; returns whether it was there.
    pub fn remove(&mut self, store: Store, id: u32) -> bool {
        self.records.remove(&(store, id)).is_some()
    }

    /// All records, the cell file's first, ascending by id.
    pub fn iter(&self) -> impl Iterator<Item = (Store, u32, &[u8])> {
        self.records
            .iter()
            .map(|(&(store, id), bytes)| (store, id, bytes.as_slice()))
    }
}

impl RecordSource for MemoryRecords {
    fn record(&self, store: Store, id: u32) -> Result<Option<Cow<'_, [u8]>>, SourceError> {
        Ok(self
            .records
            .get(&(store, id))
            .map(|bytes| Cow::Borrowed(bytes.as_slice())))
    }

    fn file_of(&self, store: Store, _: u32) -> String {
        match store {
            Store::Cell => "cell records in memory".to_owned(),
            Store::Portal => "portal records in memory".to_owned(),
        }
    }
}

impl RecordSource for DatSet {
    fn record(&self, store: Store, id: u32) -> Result<Option<Cow<'_, [u8]>>, SourceError> {
        Ok(match store {
            Store::Cell => self.get_cell(id)?,
            Store::Portal => self.get_asset(id)?,
        })
    }

    fn file_of(&self, store: Store, _: u32) -> String {
        match store {
            Store::Cell => self.cell().name().to_owned(),
            Store::Portal => self.portal().name().to_owned(),
        }
    }
}

impl<S: RecordSource + ?Sized> RecordSource for std::sync::Arc<S> {
    fn record(&self, store: Store, id: u32) -> Result<Option<Cow<'_, [u8]>>, SourceError> {
        (**self).record(store, id)
    }

    fn file_of(&self, store: Store, id: u32) -> String {
        (**self).file_of(store, id)
    }
}
