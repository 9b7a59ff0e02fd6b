//! What can be seen: the viewer's cell, the portal traversal and the frame to draw.
#![forbid(unsafe_code)]

mod camera;
pub mod conform;
pub mod constants;
mod flood;
mod look_in;
mod openings;
mod polygon_pieces;
mod pview;
mod view;

pub use camera::{Camera, CameraError, retail_fov_y};
pub use flood::{Flood, FloodArena, FloodCounters, FloodSettings, Seal, SeenCell, SeenView};
pub use look_in::{LookIn, LookIns};
pub use openings::{BlockOpenings, OpeningProblems, Openings, PortalSpec, RoomSpec};
pub use pview::PView;
pub use view::{Edge, InView, Region};
