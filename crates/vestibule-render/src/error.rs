//! What can go wrong when a picture is asked for.

/// Why no picture can be made or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture has no pixels, or more than [`crate::MAX_SIDE`] along a side.
    #[error("a picture must be 1 to {max} pixels wide and high, not {width} x {height}", max = crate::MAX_SIDE)]
    Size {
        /// Width asked for, pixels.
        width: u32,
        /// Height asked for, pixels.
        height: u32,
    },
    /// The camera's screen is not the size of the picture.
    #[error(
        "the camera looks through a screen of {camera_width} x {camera_height} pixels, the picture has {width} x {height}"
    )]
    Viewport {
        /// Width of the picture, pixels.
        width: u32,
        /// Height of the picture, pixels.
        height: u32,
        /// Width of the camera's screen, pixels.
        camera_width: f32,
        /// Height of the camera's screen, pixels.
        camera_height: f32,
    },
    /// Pictures of one animation differ in size, or there are none.
    #[error("an animation needs at least one picture and all of one size")]
    Frames,
    /// The picture could not be encoded or written.
    #[error("cannot write the picture: {0}")]
    Encode(#[from] png::EncodingError),
    /// The file could not be made or written.
    #[error("cannot write the picture: {0}")]
    Io(#[from] std::io::Error),
}
