//! Surface, `08......` (`dat-format.md` 10.5).

use crate::primitive::Argb;

/// How a polygon is painted. The record holds no id.
#[derive(Debug, Clone, Copy, PartialEq)]
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
