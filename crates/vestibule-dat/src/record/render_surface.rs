//! RenderSurface, `06......` and `07......` (`dat-format.md` 10.7).

use super::{DatRecord, RecordError, inherent_parse_and_encode};
use crate::primitive::{Reader, Writer};

/// The pixels of a texture, undecoded. Rows run from top to bottom without padding (X12).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RenderSurface {
    /// Data id as stored.
    pub id: u32,
    /// Category; kept, not interpreted.
    pub data_category: u32,
    /// Pixels.
    pub width: i32,
    /// Pixels.
    pub height: i32,
    /// Format as stored; see [`PixelFormat::of`].
    pub format: u32,
    /// The pixel bytes, as many as the record says (X15).
    pub pixels: Vec<u8>,
    /// Palette (0x04...); present iff the format is P8 or INDEX16.
    pub palette: Option<u32>,
}

/// The formats that occur.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names and codes are those of section 10.7")]
#[repr(u32)]
pub enum PixelFormat {
    R8G8B8 = 20,
    A8R8G8B8 = 21,
    X8R8G8B8 = 22,
    R5G6B5 = 23,
    A4R4G4B4 = 26,
    A8 = 28,
    P8 = 41,
    Index16 = 101,
    LscapeR8G8B8 = 243,
    LscapeAlpha = 244,
    RawJpeg = 500,
    Dxt1 = 0x3154_5844,
    Dxt3 = 0x3354_5844,
    Dxt5 = 0x3554_5844,
}

impl PixelFormat {
    /// Every format.
    pub const ALL: [Self; 14] = [
        Self::R8G8B8,
        Self::A8R8G8B8,
        Self::X8R8G8B8,
        Self::R5G6B5,
        Self::A4R4G4B4,
        Self::A8,
        Self::P8,
        Self::Index16,
        Self::LscapeR8G8B8,
        Self::LscapeAlpha,
        Self::RawJpeg,
        Self::Dxt1,
        Self::Dxt3,
        Self::Dxt5,
    ];

    /// The format with this code; `None` is "unsupported format" (X12).
    pub fn of(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|&format| format as u32 == code)
    }

    /// Whether pixels are indices into a palette, so that the record ends with a palette id.
    pub fn is_paletted(self) -> bool {
        matches!(self, Self::P8 | Self::Index16)
    }

    /// Bytes that `width` x `height` pixels take (X15); `None` for a JPEG, whose length is its own, and for sizes
    /// that do not fit.
    pub fn byte_length(self, width: u32, height: u32) -> Option<usize> {
        let (width, height) = (usize::try_from(width).ok()?, usize::try_from(height).ok()?);
        let per_pixel = match self {
            Self::RawJpeg => return None,
            Self::Dxt1 | Self::Dxt3 | Self::Dxt5 => {
                let per_block = if self == Self::Dxt1 { 8 } else { 16 };
                return width
                    .div_ceil(4)
                    .checked_mul(height.div_ceil(4))?
                    .checked_mul(per_block);
            }
            Self::A8R8G8B8 | Self::X8R8G8B8 => 4,
            Self::R8G8B8 | Self::LscapeR8G8B8 => 3,
            Self::R5G6B5 | Self::A4R4G4B4 | Self::Index16 => 2,
            Self::A8 | Self::P8 | Self::LscapeAlpha => 1,
        };
        width.checked_mul(height)?.checked_mul(per_pixel)
    }
}

impl RenderSurface {
    /// The largest width and height of a usable texture (X15).
    pub const MAX_SIDE: i32 = 8192;

    /// The format, if it is one that occurs.
    pub fn pixel_format(&self) -> Option<PixelFormat> {
        PixelFormat::of(self.format)
    }
}

impl DatRecord for RenderSurface {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let data_category = reader.u32("data_category")?;
        let width = reader.i32("width")?;
        let height = reader.i32("height")?;
        let format = reader.u32("format")?;
        let length = reader.count_i32(1, "length")?;
        let pixels = reader.take(length, "pixels")?.to_vec();
        let palette = if ends_with_palette(format) {
            Some(reader.u32("palette")?)
        } else {
            None
        };
        Ok(Self {
            id,
            data_category,
            width,
            height,
            format,
            pixels,
            palette,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32s(&[self.id, self.data_category]);
        writer.i32(self.width);
        writer.i32(self.height);
        writer.u32(self.format);
        writer.count_i32(self.pixels.len(), "length")?;
        writer.bytes(&self.pixels);
        let what = "a palette exists iff the format is P8 or INDEX16";
        writer.require(
            self.palette.is_some() == ends_with_palette(self.format),
            "palette",
            what,
        )?;
        if let Some(palette) = self.palette {
            writer.u32(palette);
        }
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(RenderSurface);

fn ends_with_palette(format: u32) -> bool {
    PixelFormat::of(format).is_some_and(PixelFormat::is_paletted)
}
