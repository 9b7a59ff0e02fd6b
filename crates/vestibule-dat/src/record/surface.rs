//! Surface, `08......` (`dat-format.md` 10.5).

use super::{DatRecord, RecordError, inherent_parse_and_encode};
use crate::primitive::{Argb, Reader, Writer};

/// How a polygon is painted. The record holds no id.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Surface {
    /// Type bits, the constants of this type.
    pub surface_type: u32,
    /// Image or colour; an image iff `surface_type & 6`.
    pub paint: Paint,
    /// 0 opaque to 1 invisible (X10).
    pub translucency: f32,
    /// Light of its own, 0 to 1.
    pub luminosity: f32,
    /// Light reflected, 0 to 1.
    pub diffuse: f32,
}

/// What a surface is painted with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Paint {
    /// A picture.
    Image {
        /// SurfaceTexture (0x05...).
        texture: u32,
        /// Palette (0x04...), 0 none.
        palette: u32,
    },
    /// One colour.
    Color(Argb),
}

#[allow(missing_docs, reason = "the names say what section 10.5 does")]
impl Surface {
    pub const SOLID: u32 = 1;
    pub const IMAGE: u32 = 2;
    pub const CLIP_MAP: u32 = 4;
    pub const TRANSLUCENT: u32 = 0x10;
    pub const DIFFUSE: u32 = 0x20;
    pub const LUMINOUS: u32 = 0x40;
    pub const ALPHA: u32 = 0x100;
    pub const INVERSE_ALPHA: u32 = 0x200;
    pub const ADDITIVE: u32 = 0x1_0000;
    pub const DETAIL: u32 = 0x2_0000;
    pub const GOURAUD: u32 = 0x1000_0000;
    pub const STIPPLED: u32 = 0x4000_0000;
    pub const PERSPECTIVE: u32 = 0x8000_0000;
}

impl Surface {
    /// Whether it is painted with an image.
    pub fn is_image(surface_type: u32) -> bool {
        surface_type & (Self::IMAGE | Self::CLIP_MAP) != 0
    }
}

impl DatRecord for Surface {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let surface_type = reader.u32("surface_type")?;
        let paint = if Self::is_image(surface_type) {
            Paint::Image {
                texture: reader.u32("texture")?,
                palette: reader.u32("palette")?,
            }
        } else {
            Paint::Color(reader.argb("color")?)
        };
        Ok(Self {
            surface_type,
            paint,
            translucency: reader.f32("translucency")?,
            luminosity: reader.f32("luminosity")?,
            diffuse: reader.f32("diffuse")?,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.surface_type);
        let image = matches!(self.paint, Paint::Image { .. });
        let what = "a surface is painted with an image iff its type says so";
        writer.require(image == Self::is_image(self.surface_type), "surface_type", what)?;
        match self.paint {
            Paint::Image { texture, palette } => writer.u32s(&[texture, palette]),
            Paint::Color(color) => writer.argb(color),
        }
        writer.f32s(&[self.translucency, self.luminosity, self.diffuse]);
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        None
    }
}

inherent_parse_and_encode!(Surface);
