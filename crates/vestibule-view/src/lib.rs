//! What can be seen: the viewer's cell, the portal traversal and the frame to draw.
//!
//! From the cell of the viewer one traversal through openings yields every room to draw, each with the regions of the
//! screen through which it is seen, and the regions through which the outside shows. Nothing else decides what is
//! drawn. The crate is pure computation: no GPU types, no files, no clock.
//!
//! | for | see |
//! |---|---|
//! | drawing with a renderer of your own | [`FrameView`]: the steps of a frame in order, as a value |
//! | the rooms a camera sees | [`PView::look`] and its [`Flood`] |
//! | what can be seen without a camera, for servers | [`PView::look_around`], [`potentially_visible()`] |
//! | looking into buildings | [`PView::look_into`], [`LookIns`] |
//! | the camera behind the player | [`CameraRig`], [`ChaseCamera`], [`update_viewer()`] |
//! | culling by the regions | [`Region::sphere`], [`Region::meets_box`] |
//! | pictures of the regions | [`flood_svg`], [`frame_svg`] |
//! | holding it to test vectors | [`conform`] |
//!
//! # Units and frames
//! Metres and radians. Positions are in the frame of the landblock named by the cell id; regions and polygons are
//! relative to the eye, in the same axes (x east, y north, z up). Camera axes are x right, y forward, z up. Pixels
//! count from the top left corner.
//!
//! # Guarantees
//! - Superset: a room that a line of sight through openings reaches is listed. What is inside rooms hides nothing.
//! - Every traversal ends, whatever the data; reaching a limit widens regions, drops no room and is reported
//!   ([`Flood::truncated`]). Anything odd is counted ([`FloodCounters`], [`FrameCounters`]).
//! - The same input gives the same bits, whatever was computed before; all arithmetic is f32 in a fixed order.
//! - A warm [`PView`] or [`FrameView`] does not allocate. Keep one per viewer; [`Openings`] and the world are shared
//!   by reference between threads.
//!
//! # Example
//! Two rooms and a door between them, made by hand; for rooms from records use [`Openings`] and [`PView::look`].
//! ```
//! use glam::{Vec2, Vec3};
//! use vestibule_view::{BlockOpenings, Camera, PView, PortalSpec, RoomSpec};
//! use vestibule_world::{BlockId, CellBsp, CellId, Frame, PortalTarget};
//!
//! // A doorway in the plane y = 5. Its positive side is north: the second room.
//! let door = [(1.0, 0.0), (-1.0, 0.0), (-1.0, 2.5), (1.0, 2.5)].map(|(x, z)| Vec3::new(x, 5.0, z));
//! let block = BlockId(0xA9B4);
//! let [south, north] = [CellId::new(block, 0x100), CellId::new(block, 0x101)];
//! let room = |id, other, interior_is_negative| RoomSpec {
//!     id,
//!     frame: Frame::IDENTITY,
//!     bsp: CellBsp::default(),
//!     portals: vec![PortalSpec {
//!         target: PortalTarget::Cell(other),
//!         other_portal: Some(0),
//!         vertices: door.to_vec(),
//!         interior_is_negative,
//!         exact_match: true,
//!     }],
//!     stab_list: vec![other],
//! };
//! let openings = BlockOpenings::from_rooms(block, &[room(south, north, true), room(north, south, false)]);
//!
//! let eye = Vec3::new(0.0, 0.0, 1.5);
//! let camera = Camera::new(south, eye, Vec3::Y, Vec3::Z, 1.2, Vec2::new(1280.0, 720.0))?;
//! let mut pview = PView::default();
//! let flood = pview.look_in_block(Some(&openings), &camera);
//! let seen: Vec<CellId> = flood.cells().iter().map(|cell| cell.id).collect();
//! assert_eq!(seen, [south, north]);
//! let (low, high) = flood.regions(&flood.cells()[1]).next().unwrap().pixel_bounds(&camera);
//! assert!(low.x > 500.0 && high.x < 780.0, "the doorway is in the middle of the screen");
//! # Ok::<(), vestibule_view::CameraError>(())
//! ```

#![forbid(unsafe_code)]

mod camera;
mod chase_camera;
pub mod conform;
pub mod constants;
mod flood;
mod frame;
mod frame_source;
mod land_outline;
mod look_in;
mod number_map;
mod openings;
mod polygon_pieces;
mod potentially_visible;
mod pview;
mod ring_order;
mod svg;
mod update_viewer;
mod view;
mod viewer;

pub use camera::{Camera, CameraError, retail_fov_y};
pub use chase_camera::{CameraMode, CameraRig, ChaseCamera, MouseSmoothing};
pub use flood::{Flood, FloodArena, FloodCounters, FloodSettings, Seal, SeenCell, SeenView};
pub use frame::{
    Command, FrameCounters, FrameInput, FramePath, FrameSettings, FrameView, LightSet, PolygonRef, SealDepth,
    Views,
};
pub use frame_source::{FrameObject, FrameSource, WorldObjects};
pub use look_in::{LookIn, LookIns};
pub use number_map::{NumberHasher, NumberMap};
pub use openings::{BlockOpenings, DoorSpec, HouseSpec, OpeningProblems, Openings, PortalSpec, RoomSpec};
pub use potentially_visible::{PotentiallyVisible, potentially_visible};
pub use pview::PView;
pub use svg::{flood_svg, frame_svg};
pub use update_viewer::{
    PIVOT_OFFSET, VIEWER_SPHERE_RADIUS, Viewer, ViewerSource, ViewerTarget, update_viewer,
};
pub use vestibule_world::bounding_sphere;
pub use view::{Edge, InView, Region};
pub use viewer::{PlayerCell, ViewerCell};
