//! What can keep the window from opening or end it.

/// Why exploring is not possible.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExploreError {
    /// There is no display to open a window on.
    #[error("cannot open a window: {0}")]
    NoDisplay(String),
    /// The window system ended the program.
    #[error("the window system failed: {0}")]
    EventLoop(#[from] winit::error::EventLoopError),
    /// Neither a graphics adapter nor the window's own pixels can be drawn to.
    #[error("cannot draw into the window: {0}")]
    NoScreen(String),
    /// The world cannot be opened.
    #[error("{0}")]
    World(String),
    /// The world has no place to stand at.
    #[error("no place to start was found: {0}")]
    NoStart(String),
}
