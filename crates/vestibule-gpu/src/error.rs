//! What can go wrong on the way to a picture.

/// Why the GPU cannot be used, or a picture cannot be drawn with it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no graphics adapter, not even a software one.
    #[error("no graphics adapter was found (Vulkan, Metal, Direct3D 12 or OpenGL): {0}")]
    NoAdapter(String),
    /// The adapter cannot do what a WebGL2 browser can.
    #[error("the graphics adapter {adapter} cannot be used: {reason}")]
    Device {
        /// Its name.
        adapter: String,
        /// What it says.
        reason: String,
    },
    /// The picture has no pixels, or more than the adapter can hold along a side.
    #[error("a picture must be 1 to {max} pixels wide and high on this adapter, not {width} x {height}")]
    Size {
        /// Width asked for, pixels.
        width: u32,
        /// Height asked for, pixels.
        height: u32,
        /// Longest side, pixels.
        max: u32,
    },
    /// The frame was never made, or its camera's screen is not the size of the picture.
    #[error("the frame was made for a screen of {width} x {height} pixels, the picture has another size")]
    Camera {
        /// Width of the camera's screen, pixels; 0 without a camera.
        width: f32,
        /// Height of the camera's screen, pixels.
        height: f32,
    },
    /// The device was lost: another program or the driver took it away. Make a new [`crate::Gpu`].
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// The picture could not be read back.
    #[error("the picture could not be read back from the graphics device: {0}")]
    ReadBack(String),
    /// The picture could not be made.
    #[error(transparent)]
    Image(#[from] vestibule_render::RenderError),
}
