//! Makes and checks worlds: from scene text to the records of the client's DAT files.
//!
//! * [`compile_scene`] and [`compile_scene_path`] compile the scene language ([`scenes`]) into a [`CompiledWorld`]:
//!   terrain, rooms with exact portals, buildings with shells, objects, textures, stab lists. What is wrong with a
//!   scene comes back as [`Diagnostics`]: file, line, what, and how to mend it.
//! * [`embedded_world`] is the small world that is built in.
//! * [`bsp`] builds cell, physics and drawing trees from plain polygons, for any tool that makes models or rooms.
//! * [`visibility`] tells which cells can be seen from anywhere in a cell.
//! * [`geometry`] is what both stand on: convex polygons and solids, unions, cutting into convex parts.
//!
//! Everything is computed in f64 in a fixed order and stored as f32: the same scene gives the same bytes on every
//! platform.
//!
//! ```
//! let world = vestibule_forge::compile_scene(
//!     "rooms.scene",
//!     "dungeon d 0x0101 {
//!          room hall { box (0 0 0) (8 6 3) }
//!          room cell { box (8 2 0) (12 4 2.5) }
//!          opening hall cell
//!      }",
//! )?;
//! assert_eq!(world.stats.cells, 2);
//! let opened = vestibule_world::World::open(world.memory_records())?;
//! let hall = world.cell_named("d.hall").and_then(|id| opened.env_cell(id)).ok_or("no hall")?;
//! assert!(hall.contains_point(glam::Vec3::new(1.0, 1.0, 1.0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

pub mod bsp;
mod compile;
mod embedded;
pub mod geometry;
mod scene;
mod scene_path;
pub mod synthetic;
mod text;
pub mod visibility;

#[doc = include_str!("../docs/scenes.md")]
pub mod scenes {}

pub use compile::{CompileStats, CompiledWorld};
pub use embedded::{EMBEDDED_SCENE, embedded_world};
pub use scene_path::{SceneError, compile_scene_path};
pub use text::{Diagnostic, Diagnostics, Severity};

/// Compiles the text of a scene; `name` is the file's name for messages.
///
/// # Errors
/// When the scene has errors; warnings come with the compiled world.
pub fn compile_scene(name: &str, text: &str) -> Result<CompiledWorld, Diagnostics> {
    compile::compile(&[(name, text)])
}
