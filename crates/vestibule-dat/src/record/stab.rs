//! A static object in a cell or on a landblock.

use super::RecordError;
use crate::primitive::{Frame, Reader, Writer};

/// A static object, placed in the frame of the landblock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Stab {
    /// GfxObj or Setup.
    pub id: u32,
    /// Place, relative to the landblock's south-west corner.
    pub frame: Frame,
}

impl Stab {
    pub(crate) const SIZE: usize = 32;

    #[inline]
    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            id: reader.u32("object.id")?,
            frame: reader.frame("object.frame")?,
        })
    }

    pub(crate) fn write(&self, writer: &mut Writer) {
        writer.u32(self.id);
        writer.frame(&self.frame);
    }
}
