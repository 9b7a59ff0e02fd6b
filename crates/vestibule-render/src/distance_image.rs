//! Distances of what a picture shows, for effects made from it afterwards (`rendering.md` 18, D23).

use crate::raster::Buffers;

/// How far away each pixel's surface is, along the view axis.
///
/// Where an exit shows the landscape, the depth buffer holds the exit's own depth (`rendering.md` 7.5): haze or blur
/// made of it would close the doorway. Here it is the landscape's.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceImage {
    width: u32,
    height: u32,
    near: f32,
    shown: Vec<f32>,
    buffer: Vec<f32>,
}

impl DistanceImage {
    pub(crate) fn new(buffers: &Buffers) -> Self {
        DistanceImage {
            width: buffers.screen.width,
            height: buffers.screen.height,
            near: buffers.screen.near as f32,
            shown: buffers.shown_depth(),
            buffer: buffers.depth.clone(),
        }
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Metres along the view axis to what column `x`, row `y` shows; infinite for the sky, `None` outside.
    pub fn get(&self, x: u32, y: u32) -> Option<f32> {
        self.distance(&self.shown, x, y)
    }

    /// The same of what the depth buffer was left with, seals and all: what effects must not be made of.
    pub fn buffer(&self, x: u32, y: u32) -> Option<f32> {
        self.distance(&self.buffer, x, y)
    }

    fn distance(&self, depths: &[f32], x: u32, y: u32) -> Option<f32> {
        if x >= self.width {
            return None;
        }
        let depth = *depths.get(y as usize * self.width as usize + x as usize)?;
        // Nothing real lies as far away as a punch.
        Some(if depth > crate::raster::PUNCH_DEPTH {
            self.near / depth
        } else {
            f32::INFINITY
        })
    }
}
