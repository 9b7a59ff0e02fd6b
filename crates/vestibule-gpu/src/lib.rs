//! A `wgpu` renderer of Vestibule's frames.
//!
//! [`vestibule_view::FrameView`] says what a viewer sees and in which order it is drawn; this crate draws it on the
//! GPU: the landscape, the punches of doors that are looked into, then from a room a clear of the depth buffer and the
//! seals of its exits, the shells of rooms, objects, and what is see-through last (`rendering.md` 5-9). Meshes, textures
//! and light come from [`vestibule_render::Assets`] and are uploaded when they are first drawn. The pictures are those of
//! the CPU renderer in `vestibule-render`, and a test holds them to it.
//!
//! * [`Gpu`] opens an adapter: Vulkan, Metal, Direct3D 12 or OpenGL, a software one if there is no other;
//! * [`Renderer`] draws a [`Picture`] into a [`Target`], whose colours other passes can show;
//! * [`FrameTimer`] tells what frames cost;
//! * [`Renderer::image`] and [`Renderer::ids`] read pictures back.
//!
//! Nothing here asks for more than a browser with WebGL2 has: no compute, no storage buffers, no clip distances, four
//! bind groups.
//!
//! ```no_run
//! use glam::{Vec2, Vec3};
//! use vestibule_gpu::{AdapterChoice, Gpu, Renderer, RendererOptions};
//! use vestibule_render::{Assets, RenderSettings, Scene};
//! use vestibule_view::{Camera, FrameInput, FrameView, Openings, WorldObjects};
//! # fn demo(world: vestibule_world::World) -> Result<(), Box<dyn std::error::Error>> {
//! let gpu = Gpu::headless(AdapterChoice::Best)?;
//! let mut renderer = Renderer::new(&gpu, RendererOptions::default());
//! let eye: vestibule_world::Position = "0xA9B40170 [155.372 16.028 95.5]".parse()?;
//! let camera = Camera::new(eye.cell, eye.origin(), Vec3::Y, Vec3::Z, 1.0, Vec2::new(640.0, 480.0))?;
//! let (openings, assets, mut frame) = (Openings::new(), Assets::new(), FrameView::default());
//! frame.update(&world, &openings, &WorldObjects::new(&world), &FrameInput::new(camera));
//! let scene = Scene::new(&world, &assets);
//! let picture = renderer.image(&gpu, &scene, &frame, &RenderSettings::default())?;
//! picture.save_png("view.png")?;
//! # Ok(()) }
//! ```

#![forbid(unsafe_code)]

mod arena;
mod collect;
mod cost;
mod device;
mod error;
mod ground;
mod items;
mod mesh_light;
mod meshes;
mod pipelines;
mod renderer;
mod target;
mod textures;
mod uniforms;

pub use cost::{FrameCost, FrameTimer, views as cost_views};
pub use device::{AdapterChoice, Gpu, instance};
pub use error::GpuError;
pub use items::FrameStats;
pub use renderer::{Filtering, Renderer, RendererOptions, Uploaded};
pub use target::Target;
pub use vestibule_render::Picture;
pub use wgpu;
