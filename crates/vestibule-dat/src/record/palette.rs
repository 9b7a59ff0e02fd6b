//! Palette, `04......` (`dat-format.md` 10.8).

use super::{DatRecord, RecordError, inherent_parse_and_encode};
use crate::primitive::{Argb, Reader, Writer};

/// Colours by index.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Palette {
    /// Data id as stored.
    pub id: u32,
    /// The colours; usually 2048, or 256.
    pub colors: Vec<Argb>,
}

impl DatRecord for Palette {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let colors = reader.list_i32(4, "colors", |reader| reader.argb("colors"))?;
        Ok(Self { id, colors })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.count_i32(self.colors.len(), "colors")?;
        self.colors.iter().for_each(|&color| writer.argb(color));
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(Palette);
