//! SurfaceTexture, `05......` (`dat-format.md` 10.6).

use super::{DatRecord, RecordError, inherent_parse_and_encode};
use crate::primitive::{Reader, Writer};

/// The sizes in which a texture exists.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SurfaceTexture {
    /// Data id as stored.
    pub id: u32,
    /// Category; kept, not interpreted.
    pub data_category: u32,
    /// 2 = two-dimensional.
    pub texture_type: u8,
    /// RenderSurfaces from high to low detail; the first may exist only in the highres file (X11).
    pub textures: Vec<u32>,
}

impl DatRecord for SurfaceTexture {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let data_category = reader.u32("data_category")?;
        let texture_type = reader.u8("texture_type")?;
        let count = reader.count_i32(4, "textures")?;
        Ok(Self {
            id,
            data_category,
            texture_type,
            textures: reader.u32s(count, "textures")?,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32s(&[self.id, self.data_category]);
        writer.u8(self.texture_type);
        writer.count_i32(self.textures.len(), "textures")?;
        writer.u32s(&self.textures);
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(SurfaceTexture);
