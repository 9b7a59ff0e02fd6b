//! Where a world's records come from.

use std::borrow::Cow;
use std::collections::BTreeMap;

/// Why a record could not be read.
pub type SourceError = Box<dyn core::error::Error + Send + Sync>;

/// A store of records, readable from many threads at once.
pub trait RecordSource: Send + Sync {
    /// The bytes of a record; `Ok(None)` when there is none with this id.
    ///
    /// # Errors
    /// When the store is damaged where the record lies.
    fn record(&self, id: u32) -> Result<Option<Cow<'_, [u8]>>, SourceError>;

    /// The name of the file in which record `id` is, or would be, for messages.
    fn file_of(&self, id: u32) -> String;
}

/// Records in memory, for tests and for worlds made on the spot.
#[derive(Clone, Debug, Default)]
pub struct MemoryRecords {
    records: BTreeMap<u32, Vec<u8>>,
}

impl MemoryRecords {
    /// No records.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds or replaces a record.
    pub fn insert(&mut self, id: u32, bytes: Vec<u8>) {
        self.records.insert(id, bytes);
    }

    /// Removes a record; returns whether it was there.
    pub fn remove(&mut self, id: u32) -> bool {
        self.records.remove(&id).is_some()
    }

    /// All records, ascending by id.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[u8])> {
        self.records.iter().map(|(&id, bytes)| (id, bytes.as_slice()))
    }
}

impl RecordSource for MemoryRecords {
    fn record(&self, id: u32) -> Result<Option<Cow<'_, [u8]>>, SourceError> {
        Ok(self.records.get(&id).map(|bytes| Cow::Borrowed(bytes.as_slice())))
    }

    fn file_of(&self, _: u32) -> String {
        "memory".to_owned()
    }
}
