//! What a sweep refuses.

/// Why a body could not be swept or placed at all. An obstacle is no error: see [`crate::Swept`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// A number is NaN or infinite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// A sphere has a negative radius.
    #[error("a sphere has the radius {radius} m, below zero")]
    NegativeRadius {
        /// The radius, metres.
        radius: f32,
    },
    /// A scale is zero or below.
    #[error("scale {scale} is not above zero")]
    BadScale {
        /// The scale.
        scale: f32,
    },
    /// The move is too long to be swept.
    #[error("the move takes {steps} steps, more than the limit of {limit}: teleport instead")]
    TooManySteps {
        /// Steps it would take.
        steps: u32,
        /// [`crate::Settings::max_steps`].
        limit: u32,
    },
    /// A saved body's shape cannot be had.
    #[error("no shape record 0x{id:08X} for a saved body")]
    NoShape {
        /// Record id.
        id: u32,
    },
    /// There is no such body.
    #[error("no body with this id")]
    NoSuchBody,
}
