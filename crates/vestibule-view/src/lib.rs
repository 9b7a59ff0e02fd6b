//! What can be seen: the viewer's cell, the portal traversal and the frame to draw.
#![forbid(unsafe_code)]

mod camera;
pub mod conform;
pub mod constants;
mod flood;
mod frame;
mod frame_source;
mod look_in;
mod openings;
mod polygon_pieces;
mod pview;
mod ring_order;
mod view;
mod viewer;

pub use camera::{Camera, CameraError, retail_fov_y};
pub use flood::{Flood, FloodArena, FloodCounters, FloodSettings, Seal, SeenCell, SeenView};
pub use frame::{
    Command, FrameCounters, FrameInput, FramePath, FrameSettings, FrameView, LightSet, PolygonRef, SealDepth,
    Views,
};
pub use frame_source::{FrameObject, FrameSource, WorldObjects, bounding_sphere};
pub use look_in::{LookIn, LookIns};
pub use openings::{BlockOpenings, DoorSpec, HouseSpec, OpeningProblems, Openings, PortalSpec, RoomSpec};
pub use pview::PView;
pub use view::{Edge, InView, Region};
pub use viewer::{PlayerCell, ViewerCell};
