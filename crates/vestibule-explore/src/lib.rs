//! A window to walk through Asheron's Call worlds and to look behind the scenes.
//!
//! [`run`] opens it. A world is loaded on a thread of its own; then the player walks by the collision sweep, the camera
//! follows by its own, and what the traversal of `vestibule-view` reaches is drawn by `vestibule-gpu`, or by the CPU
//! renderer where there is no graphics adapter. Overlays show why: cells, portals with what became of them, clip regions,
//! what is collided with, the stab list; the traversal can be held and looked at from outside.
//!
//! [`Explorer`] is the state behind the window and knows neither window nor GPU: other tools can drive it.
//!
//! ```no_run
//! use vestibule_explore::{AdapterChoice, Opened, Options, keys_help, run};
//! # fn demo(world: vestibule_world::World) -> Result<(), vestibule_explore::ExploreError> {
//! println!("{}", keys_help());
//! run(Options {
//!     open: Box::new(|| {
//!         let start = "0xA9B40031 [155.4 26 94]".parse().map_err(|e| format!("{e}"))?;
//!         Ok(Opened { world, names: Vec::new(), start })
//!     }),
//!     title: "A world".to_owned(),
//!     size: (1280, 720),
//!     adapter: AdapterChoice::Best,
//!     cpu: false,
//!     pictures: ".".into(),
//!     watch: None,
//!     lose_device: Vec::new(),
//! })
//! # }
//! ```

#![forbid(unsafe_code)]

mod cpu_screen;
mod doors;
mod error;
mod everything;
mod explorer;
mod fly;
mod gpu_screen;
mod key_list;
mod keys;
mod layout;
mod loading;
mod overlays;
mod panels;
mod picking;
mod places;
mod portals;
mod sidemap;
mod soft_paint;
#[cfg(test)]
mod testing;
mod window;

pub use doors::{DoorOutcome, Doors};
pub use error::ExploreError;
pub use everything::commands as everything_commands;
pub use explorer::{Explorer, Show, TrailStep, clock};
pub use fly::FlyCamera;
pub use keys::{Action, Group, Held, KEYS, action, keys_help};
pub use loading::{Open, Opened};
pub use overlays::{Mark, Marks, Overlay, cell_color};
pub use picking::{Picked, pick};
pub use places::{NamedPlace, PlaceError, find as find_place, middle_of};
pub use portals::{JudgedPortal, Verdict, along as portals_along, verdict};
pub use vestibule_gpu::AdapterChoice;
pub use window::{Options, Watch, run};
