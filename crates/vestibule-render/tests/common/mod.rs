//! Worlds, cameras and comparisons shared by the tests and the `seamless` example.
#![allow(dead_code, unused_imports, reason = "each binary uses a part of it")]
#![allow(unreachable_pub, reason = "shared by inclusion")]

mod compare;
mod eyes;
mod stage;
mod walk;

pub use compare::{Difference, compare, compare_with_oracle};
pub use eyes::{Random, Rooms, mixed_camera, outdoor_eye};
pub use stage::{Stage, camera, hollow_records};
pub use walk::{Threshold, Walk, Walked, flash, thresholds, walk};
