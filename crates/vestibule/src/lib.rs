//! The cell engine of retail Asheron's Call.
//!
//! This crate is the one to depend on. It re-exports the others under short names and adds what needs several of
//! them:
//!
//! * [`dat`] reads and writes the retail DAT files, byte for byte;
//! * [`world`] is the cell graph made from them: cells, portals, terrain, buildings, and which cell a body is in;
//! * [`open_world`] opens a folder of DAT files, or a small world that is built in;
//! * [`physics`] moves bodies through it by the collision sweep; [`view`] says what can be seen; [`render`] draws it;
//! * [`guide`] says how a client, a server and an editor use all this, call by call;
//! * [`studio`] makes pictures in a few lines, [`tour`] walks through everything;
//! * [`conform`] runs test vectors.
//!
//! ```
//! use vestibule::world::{CellArray, Position, Sphere, find_cell_list};
//!
//! let world = vestibule::open_world(None)?;
//! let feet: Position = "0xA9B40031 [155.3717 16.0283 94.005]".parse()?;
//! // A body is where the centre of its lower sphere is, seeded from the cell it was in before.
//! let lower = Sphere::new(feet.origin() + glam::Vec3::new(0.0, 0.0, 0.475), 0.48);
//! let mut cells = CellArray::new();
//! let found = find_cell_list(&world, feet.cell, feet.origin(), &[lower], &mut cells, true);
//! assert_eq!(found.containing.map(|c| c.to_string()).as_deref(), Some("0xA9B40100"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Units are metres, seconds and radians. A position is relative to the south-west corner of the landblock named in
//! its cell id, with x east, y north and z up. All arithmetic is f32 in a fixed order: the same input gives the same
//! bits on every platform.

#![forbid(unsafe_code)]

pub use vestibule_dat as dat;
pub use vestibule_forge as forge;
pub use vestibule_physics as physics;
pub use vestibule_render as render;
pub use vestibule_view as view;
pub use vestibule_world as world;

pub mod conform;
pub mod describe;
pub mod film;
#[doc = include_str!("../docs/guide.md")]
pub mod guide {}
pub mod locate;
pub mod map_svg;
mod open;
pub mod references;
pub mod replay;
pub mod round_trips;
pub mod route;
pub mod studio;
pub mod tour;
pub mod visible_svg;
pub mod walk;
pub mod walker;

pub use open::{EMBEDDED_NAME, OpenError, open_dats, open_world};

/// `1 cell`, `2 cells`.
fn count(n: usize, what: &str) -> String {
    if n == 1 {
        format!("{n} {what}")
    } else {
        format!("{n} {what}s")
    }
}
