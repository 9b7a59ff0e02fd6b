//! What is to be drawn: a camera and commands, usually those of a frame.

use vestibule_view::{Camera, Command, FramePath, FrameView};

/// A camera, the commands to draw and the frame whose polygons and regions they refer to.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// What is drawn, from first to last.
    pub commands: &'a [Command],
    /// The frame the commands belong to: it has their polygons and regions. Without it punches and seals draw
    /// nothing and no room is confined, as befits the rooms of a frame seen from elsewhere than its own eye.
    pub frame: Option<&'a FrameView>,
    /// The viewer's cell does not see the outside: light and fog of sealed rooms (`rendering.md` 12.3, 13.3).
    pub sealed: bool,
}

impl<'a> Picture<'a> {
    /// The picture of a frame; `None` when none was made yet.
    pub fn of(frame: &'a FrameView) -> Option<Self> {
        Some(Picture {
            camera: frame.camera()?,
            commands: frame.commands(),
            frame: Some(frame),
            sealed: frame.path() == FramePath::Sealed,
        })
    }

    /// The columns and rows the landscape can show in (from, to, from, to): the regions' bounds and a pixel around
    /// them.
    pub fn sky_bounds(&self) -> [u32; 4] {
        let size = self.camera.viewport();
        let (width, height) = (size.x as u32, size.y as u32);
        let whole = [0, width, 0, height];
        let Some(frame) = self.frame else { return whole };
        if frame.path() == FramePath::Outdoors || frame.landscape_views().len() == 0 {
            return whole;
        }
        let (mut x0, mut x1, mut y0, mut y1) = (size.x, 0.0f32, size.y, 0.0f32);
        for region in frame.landscape_views() {
            let (low, high) = region.pixel_bounds(self.camera);
            x0 = if low.x < x0 { low.x } else { x0 };
            y0 = if low.y < y0 { low.y } else { y0 };
            x1 = if high.x > x1 { high.x } else { x1 };
            y1 = if high.y > y1 { high.y } else { y1 };
        }
        // Casts of floats saturate at zero.
        [
            (x0 - 2.0) as u32,
            ((x1 + 2.0) as u32).min(width),
            (y0 - 2.0) as u32,
            ((y1 + 2.0) as u32).min(height),
        ]
    }
}
