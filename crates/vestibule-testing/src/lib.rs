//! What the tests of the other crates share. It is not published: whoever uses it names no version, so that it is left
//! out of packages.
//!
//! * [`records`] makes small worlds of records: [`records::Builder`], [`records::Room`];
//! * [`doorway_e1`] is the doorway recorded from the retail client (`evidence.md` E1);
//! * [`vectors`] is the folder of test vectors, where it is there.
//!
//! ```
//! use glam::Vec3;
//! use vestibule_testing::records::{Builder, Room};
//!
//! let mut builder = Builder::new(0xA9B4);
//! builder.room(Room::of_box(0x100, Vec3::ZERO, Vec3::splat(5.0)));
//! assert_eq!(builder.world().problems(), []);
//! ```

#![forbid(unsafe_code)]

pub mod doorway_e1;
pub mod records;
mod vectors;

pub use vectors::{vectors, vectors_world};
