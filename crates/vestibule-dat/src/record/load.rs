//! From an id to a parsed record in one call, with errors that name the file too (`dat-format.md` D2).

use super::{DatRecord, Record, RecordError, parse};
use crate::container::DatFile;
use crate::dat_set::DatSet;
use crate::data_id::RecordKind;
use crate::error::{Error, Result};

impl DatFile {
    /// Reads and parses record `id`, whatever it is; types that this crate does not know come as
    /// [`Record::Raw`]. `Ok(None)` means that the file does not have it.
    ///
    /// # Errors
    /// As [`DatFile::get`]; or the record is not what its id says.
    pub fn record(&self, id: u32) -> Result<Option<Record>> {
        let kind = self
            .kind()
            .map_or(RecordKind::Unknown, |file| RecordKind::of(file, id));
        self.parsed(id, |bytes| Record::parse(kind, id, bytes))
    }

    /// Reads and parses record `id` as a record of type `T`. `Ok(None)` means that the file does not have it.
    ///
    /// # Errors
    /// As [`DatFile::get`]; or the record is no `T`.
    pub fn record_as<T: DatRecord>(&self, id: u32) -> Result<Option<T>> {
        self.parsed(id, |bytes| parse(id, bytes))
    }

    fn parsed<T>(
        &self,
        id: u32,
        parse: impl FnOnce(&[u8]) -> std::result::Result<T, RecordError>,
    ) -> Result<Option<T>> {
        match self.get(id)? {
            Some(bytes) => parse(&bytes)
                .map(Some)
                .map_err(|error| Error::from_record(self.name(), error)),
            None => Ok(None),
        }
    }
}

impl DatSet {
    /// Reads and parses a record of the cell file: a landblock, its info or an env cell. `Ok(None)` means that it is
    /// not there.
    ///
    /// # Errors
    /// As [`DatFile::get`]; or the record is no `T`.
    ///
    /// ```no_run
    /// use vestibule_dat::record::EnvCell;
    ///
    /// let dats = vestibule_dat::DatSet::open("/path/to/ac")?;
    /// if let Some(cell) = dats.cell_record::<EnvCell>(0xA9B4_0170)? {
    ///     println!("{} portals, sees outside: {}", cell.portals.len(), cell.seen_outside());
    /// }
    /// # Ok::<(), vestibule_dat::Error>(())
    /// ```
    pub fn cell_record<T: DatRecord>(&self, id: u32) -> Result<Option<T>> {
        self.cell().record_as(id)
    }

    /// Reads and parses a record of any other type, from the file that [`DatSet::get_asset`] would take it from.
    ///
    /// # Errors
    /// As [`DatFile::get`]; or the record is no `T`.
    pub fn asset_record<T: DatRecord>(&self, id: u32) -> Result<Option<T>> {
        for file in self.asset_files(id) {
            if let Some(record) = file.record_as(id)? {
                return Ok(Some(record));
            }
        }
        Ok(None)
    }
}
