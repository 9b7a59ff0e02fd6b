//! The graphics card, for pictures and for timing them.

use vestibule::render::Image;
use vestibule::studio::{Shot, Studio};
use vestibule::view::Camera;
use vestibule::world::World;
use vestibule_gpu::{AdapterChoice, FrameTimer, Gpu, Renderer, RendererOptions, cost_views};

use super::gpu_cost::{Costs, ViewCost};

/// Frames timed at each view, by an adapter that draws in software and by others.
const FRAMES: (usize, usize) = (25, 200);

/// An adapter that is open.
pub(crate) struct Graphics(Gpu);

impl Graphics {
    /// The fastest adapter, or why there is none.
    pub(crate) fn open() -> Result<Self, String> {
        Gpu::headless(AdapterChoice::Best)
            .map(Graphics)
            .map_err(|e| e.to_string())
    }

    /// What drew, for people.
    pub(crate) fn name(&self) -> String {
        match self.0.is_software() {
            true => format!("{}, which draws in software", self.0.name()),
            false => self.0.name().to_owned(),
        }
    }

    /// The picture of a shot, edges smoothed.
    pub(crate) fn picture(&self, studio: &Studio<'_>, shot: &Shot) -> Result<Image, String> {
        let options = RendererOptions {
            samples: 4,
            ..RendererOptions::default()
        };
        Renderer::new(&self.0, options)
            .image(&self.0, &studio.scene(shot), &shot.frame, &studio.settings)
            .map_err(|e| e.to_string())
    }

    /// What frames cost: at the views of the embedded world, or else at these.
    pub(crate) fn costs(
        &self,
        world: &World,
        size: (u32, u32),
        others: Option<Vec<(String, Camera)>>,
        done: &mut dyn FnMut(),
    ) -> anyhow::Result<Costs> {
        let views = match others {
            Some(others) => others,
            None => cost_views(size)?
                .map(|(name, camera)| (name.to_owned(), camera))
                .into(),
        };
        let frames = if self.0.is_software() { FRAMES.0 } else { FRAMES.1 };
        let mut timer = FrameTimer::new(&self.0, world, size)?;
        let mut out = Vec::new();
        for (name, camera) in views {
            let seen = timer.time(&camera, true, frames)?;
            let all = timer.time(&camera, false, frames)?;
            out.push(ViewCost {
                name,
                processor_ms: seen.processor_ms,
                traversal_ms: seen.traversal_ms,
                submit_ms: seen.submit_ms,
                draws: seen.stats.draws,
                triangles: seen.stats.triangles,
                frames_per_second: seen.frames_per_second,
                everything_ms: all.processor_ms,
                everything_draws: all.stats.draws,
                everything_frames_per_second: all.frames_per_second,
            });
            done();
        }
        Ok(Costs {
            adapter: self.0.name().to_owned(),
            software: self.0.is_software(),
            size,
            views: out,
        })
    }
}
