//! Pictures of Asheron's Call worlds, pixel by pixel on the CPU.
//!
//! The traversal of `vestibule-view` decides what is seen and in which order; this crate draws it: meshes, textures,
//! materials and lights from DAT records ([`Assets`], shared with any other renderer), and a small rasteriser that
//! walks a [`FrameView`](vestibule_view::FrameView) from first to last command. It is what other renderers are held against, and what
//! draws where there is no GPU.
//!
//! * [`render`] makes the picture of a frame, [`render_ids`] one whose pixels name the cell they show;
//! * [`render_distances`] tells how far away everything in it is, for effects;
//! * [`render_everything`] ignores the traversal and lets depth alone decide, the truth where nothing overlaps;
//! * [`Oracle`] follows the ray of a pixel through the cell graph, the truth also where rooms overlap;
//! * [`Walk`] goes over a picture's commands for any renderer, which is a [`Canvas`] that draws what is met;
//! * [`Filmstrip`] and [`write_apng`] put pictures together.
//!
//! ```no_run
//! use glam::{Vec2, Vec3};
//! use vestibule_render::{Assets, RenderSettings, Scene, render};
//! use vestibule_view::{Camera, FrameInput, FrameView, Openings, WorldObjects};
//! # fn demo(world: vestibule_world::World) -> Result<(), Box<dyn std::error::Error>> {
//! let eye: vestibule_world::Position = "0xA9B40170 [155.372 16.028 95.5]".parse()?;
//! let camera = Camera::new(eye.cell, eye.origin(), Vec3::Y, Vec3::Z, 1.0, Vec2::new(640.0, 480.0))?;
//! // One of each is kept for the whole run: openings and assets per world, a frame per viewer.
//! let (openings, assets, mut frame) = (Openings::new(), Assets::new(), FrameView::default());
//! frame.update(&world, &openings, &WorldObjects::new(&world), &FrameInput::new(camera));
//! let picture = render(&Scene::new(&world, &assets), &frame, &RenderSettings::default())?;
//! picture.save_png("view.png")?;
//! # Ok(()) }
//! ```
//!
//! What was measured and which test holds which rule is told in `docs/seamless.md`, `docs/rules.md` and
//! `docs/defects.md` beside this crate.
//!
//! Colours are stored, lit and blended as 8-bit gamma-encoded values, as retail does (`rendering.md` 9.7). Depth is
//! reversed. Missing surfaces and textures show as a magenta checker and are counted in [`AssetCounters`].

#![forbid(unsafe_code)]

mod assets;
mod cell_lamps;
mod detail;
mod distance_image;
mod dxt;
mod error;
mod everything;
mod figure;
mod filmstrip;
mod id_image;
mod image;
mod jpeg;
mod land;
mod lighting;
mod material;
mod mesh;
mod model_table;
mod oracle;
mod overlaps;
mod paint;
mod picture;
mod place;
mod raster;
mod reference;
mod scene;
mod shade;
mod sky;
mod static_parts;
mod terrain_paint;
mod texel;
mod texture;
mod walk;

pub use assets::{AssetCounters, Assets, ObjectLight};
pub use detail::{DetailedObjects, ModelLevel, model_level, turned};
pub use distance_image::DistanceImage;
pub use error::RenderError;
pub use everything::{Everything, everything_commands, render_everything, render_everything_ids};
pub use figure::{FIGURE_HEIGHT, figure};
pub use filmstrip::Filmstrip;
pub use id_image::IdImage;
pub use image::{Image, MAX_SIDE, write_apng};
pub use land::{LandMesh, TERRAIN_OFFSET};
pub use lighting::{Lamp, LightLevels, MAX_OBJECT_LAMPS, MAX_SHELL_LAMPS, OBJECT_RANGE, shell_light};
pub use material::{Blend, DrawList, Factor, Material};
pub use mesh::{Mesh, MeshFace, MeshVertex};
pub use oracle::{Oracle, RayHit};
pub use overlaps::overlapping_cells;
pub use picture::Picture;
pub use place::{EyeFrame, Placed};
pub use raster::{PUNCH_DEPTH, PixelId, PixelKind};
pub use reference::{render, render_commands, render_commands_ids, render_distances, render_ids};
pub use scene::{LightDetail, RenderCounters, RenderSettings, Scene};
pub use sky::{Daylight, Fog, Moment, SkyTable, SkyThing};
pub use terrain_paint::{CellPaint, Cover, Layer, TerrainPaint, TypeTexture};
pub use texture::{DecodeAs, Level, Texture, TextureError, decode as decode_texture};
pub use vestibule_view::{NumberHasher, NumberMap};
pub use walk::{Canvas, Owner, Piece, PieceLight, PortalDepth, Walk, WalkCounters, WalkMemory};
