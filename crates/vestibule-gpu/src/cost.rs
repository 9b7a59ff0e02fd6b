//! What frames cost: deciding, building and submitting them on the processor, and drawing them on the adapter at hand, with
//! the traversal and without.

use std::time::Instant;

use glam::{Vec2, Vec3};
use vestibule_render::{Assets, Everything, RenderSettings, Scene, everything_commands};
use vestibule_view::{Camera, CameraError, FrameInput, FrameView, Openings, WorldObjects};
use vestibule_world::{CellId, World};

use crate::device::Gpu;
use crate::error::GpuError;
use crate::items::FrameStats;
use crate::renderer::{Renderer, RendererOptions};
use crate::{Picture, Target};

/// Frames that upload, before those that count.
const FIRST_FRAMES: usize = 5;

/// What a frame of one view costs; times are medians over many frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameCost {
    /// Milliseconds this thread computes from the start of the traversal to the return of the submit. What the driver
    /// does in threads of its own is not in it, what it does in this one is.
    pub processor_ms: f64,
    /// Of these, the traversal; 0 when there was none.
    pub traversal_ms: f64,
    /// Of these, the submit: sending the commands to the driver.
    pub submit_ms: f64,
    /// Frames a second when each waits until the adapter has drawn the one before.
    pub frames_per_second: f64,
    /// What was drawn.
    pub stats: FrameStats,
}

/// Views of the embedded world that frames are timed at: before and in a cottage, over the village, in a shop.
///
/// # Errors
/// When the size makes no camera.
pub fn views(size: (u32, u32)) -> Result<[(&'static str, Camera); 4], CameraError> {
    let size = Vec2::new(size.0 as f32, size.1 as f32);
    let camera = |cell, eye: [f32; 3], at: [f32; 3]| {
        let (eye, at) = (Vec3::from_array(eye), Vec3::from_array(at));
        Camera::new(CellId(cell), eye, at - eye, Vec3::Z, 0.94, size)
    };
    Ok([
        (
            "before the cottage",
            camera(0xA9B4_0031, [155.4, 24.0, 95.6], [155.4, 12.0, 95.2])?,
        ),
        (
            "over the village",
            camera(0xA9B4_0029, [130.0, 20.0, 104.0], [110.0, 90.0, 94.0])?,
        ),
        (
            "in the cottage",
            camera(0xA9B4_0101, [155.4, 11.0, 95.6], [155.4, 30.0, 95.4])?,
        ),
        (
            "in the shop",
            camera(0xA9B4_010E, [109.5, 82.5, 93.9], [103.0, 84.2, 94.6])?,
        ),
    ])
}

/// Times frames of one world.
#[derive(Debug)]
pub struct FrameTimer<'a> {
    gpu: &'a Gpu,
    world: &'a World,
    openings: Openings,
    assets: Assets,
    renderer: Renderer,
    target: Target,
    frame: FrameView,
}

impl<'a> FrameTimer<'a> {
    /// A timer of frames of this size.
    ///
    /// # Errors
    /// As [`Target::new`].
    pub fn new(gpu: &'a Gpu, world: &'a World, size: (u32, u32)) -> Result<Self, GpuError> {
        let renderer = Renderer::new(gpu, RendererOptions::default());
        Ok(FrameTimer {
            gpu,
            world,
            openings: Openings::new(),
            assets: Assets::new(),
            target: renderer.target(gpu, size.0, size.1)?,
            renderer,
            frame: FrameView::default(),
        })
    }

    /// The renderer, to see what it uploaded.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The cost of a view, over so many frames. `traversal`: what is seen is drawn, otherwise everything in the nine
    /// landblocks around.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn time(&mut self, camera: &Camera, traversal: bool, frames: usize) -> Result<FrameCost, GpuError> {
        let scene = Scene::new(self.world, &self.assets);
        let settings = RenderSettings::default();
        let what = Everything {
            radius: 1,
            ..Everything::default()
        };
        let all = everything_commands(&scene, camera, what);
        let everything = Picture {
            camera,
            commands: &all,
            frame: None,
            sealed: false,
        };
        let (mut processor, mut decide, mut submit) = (Vec::new(), Vec::new(), Vec::new());
        let (mut whole, mut stats) = (Vec::new(), FrameStats::default());
        for k in 0..frames + FIRST_FRAMES {
            let (begin, clock) = (Instant::now(), Clock::now());
            let mut picture = everything;
            if traversal {
                let objects = WorldObjects::new(self.world);
                let input = FrameInput::new(*camera);
                self.frame.update(self.world, &self.openings, &objects, &input);
                picture = Picture::of(&self.frame).unwrap_or(everything);
            }
            let decided = clock.milliseconds();
            let mut before_submit = 0.0;
            stats = self
                .renderer
                .draw_with(self.gpu, &self.target, &scene, &picture, &settings, || {
                    before_submit = clock.milliseconds();
                })?;
            let submitted = clock.milliseconds();
            let wait = wgpu::PollType::wait_indefinitely();
            self.gpu
                .device
                .poll(wait)
                .map_err(|e| GpuError::ReadBack(e.to_string()))?;
            if k >= FIRST_FRAMES {
                processor.push(submitted);
                decide.push(decided);
                submit.push(submitted - before_submit);
                whole.push(begin.elapsed().as_secs_f64());
            }
        }
        Ok(FrameCost {
            processor_ms: median(processor),
            traversal_ms: if traversal { median(decide) } else { 0.0 },
            submit_ms: median(submit),
            frames_per_second: 1.0 / median(whole),
            stats,
        })
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The time this thread has computed, which other programs do not change; by the clock on the wall where that is not told.
struct Clock {
    #[cfg(unix)]
    start: f64,
    #[cfg(not(unix))]
    start: Instant,
}

#[cfg(unix)]
impl Clock {
    fn computed() -> f64 {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 * 1e-6
    }

    fn now() -> Self {
        Clock {
            start: Self::computed(),
        }
    }

    fn milliseconds(&self) -> f64 {
        Self::computed() - self.start
    }
}

#[cfg(not(unix))]
impl Clock {
    fn now() -> Self {
        Clock {
            start: Instant::now(),
        }
    }

    fn milliseconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64() * 1e3
    }
}
