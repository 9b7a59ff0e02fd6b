//! The window without a graphics adapter: the CPU renderer draws, at a lower resolution.

use std::num::NonZeroU32;
use std::sync::Arc;

use egui::TexturesDelta;
use egui::epaint::ClippedPrimitive;
use vestibule_render::{Image, RenderSettings, render_commands};
use winit::window::Window;

use crate::error::ExploreError;
use crate::explorer::Explorer;
use crate::panels::FrameTimes;
use crate::soft_paint::{Pixels, SoftPainter};

/// Pixels of the picture at most; it is enlarged to the window.
const MOST_PIXELS: f32 = 200_000.0;

pub(crate) struct CpuScreen {
    surface: softbuffer::Surface<Arc<Window>, Arc<Window>>,
    painter: SoftPainter,
    last: Option<Image>,
}

impl CpuScreen {
    pub(crate) fn new(window: Arc<Window>) -> Result<Self, ExploreError> {
        let failed = |e: softbuffer::SoftBufferError| ExploreError::NoScreen(e.to_string());
        let context = softbuffer::Context::new(window.clone()).map_err(failed)?;
        let surface = softbuffer::Surface::new(&context, window).map_err(failed)?;
        Ok(CpuScreen {
            surface,
            painter: SoftPainter::default(),
            last: None,
        })
    }

    /// Size of the picture for a window of this size.
    pub(crate) fn picture_size(width: u32, height: u32) -> (u32, u32) {
        let pixels = width as f32 * height as f32;
        let shrink = if pixels > MOST_PIXELS {
            (MOST_PIXELS / pixels).sqrt()
        } else {
            1.0
        };
        let side = |v: u32| ((v as f32 * shrink) as u32).max(1);
        (side(width), side(height))
    }

    pub(crate) fn image(&self) -> Option<Image> {
        self.last.clone()
    }

    pub(crate) fn draw(
        &mut self,
        (width, height): (u32, u32),
        explorer: Option<&Explorer>,
        list: &[ClippedPrimitive],
        delta: &TexturesDelta,
        points: f32,
        times: &mut FrameTimes,
    ) -> Result<(), ExploreError> {
        self.painter.update(delta);
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        if let Some(explorer) = explorer
            && let Some(frame) = explorer.regions_frame()
        {
            let drawn = render_commands(
                &explorer.scene(),
                frame,
                explorer.commands(),
                &RenderSettings::default(),
            );
            if let Ok((image, counters)) = drawn {
                times.triangles = counters.triangles;
                self.last = Some(image);
            }
        }
        let failed = |e: softbuffer::SoftBufferError| ExploreError::NoScreen(e.to_string());
        self.surface.resize(w, h).map_err(failed)?;
        let mut buffer = self.surface.buffer_mut().map_err(failed)?;
        let (width, height) = (width as usize, height as usize);
        match &self.last {
            Some(image) => {
                for y in 0..height {
                    let from = (y * image.height() as usize / height) as u32;
                    for x in 0..width {
                        let c = image.get((x * image.width() as usize / width) as u32, from);
                        let [r, g, b, _] = c.unwrap_or_default().map(u32::from);
                        if let Some(slot) = buffer.get_mut(y * width + x) {
                            *slot = r << 16 | g << 8 | b;
                        }
                    }
                }
            }
            None => buffer.fill(0x0012_1218),
        }
        let mut pixels = Pixels {
            width,
            height,
            data: &mut buffer,
        };
        self.painter.paint(&mut pixels, list, points);
        buffer.present().map_err(failed)
    }
}
