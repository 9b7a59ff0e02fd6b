//! SurfaceTexture, `05......` (`dat-format.md` 10.6).

/// The sizes in which a texture exists.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
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
