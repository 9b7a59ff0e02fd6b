//! The cell graph of Asheron's Call, from the records of the retail DAT files.
//!
//! Everything lives in a *cell*: a 24 m square of land ([`LandCell`]) or a room ([`EnvCell`]). This crate knows
//! ids and positions ([`CellId`], [`Position`]), terrain, rooms and the portals between them, buildings, static
//! objects and the cells they occupy, and answers the questions movement and visibility ask:
//!
//! * [`World`] opens records and loads landblocks when they are first touched, from any thread;
//! * [`CellManager`] instead keeps resident what one viewer needs, loaded off the thread that moves it;
//! * [`find_cell_list`] tells which cells spheres touch and which cell holds the first centre, seeded from the
//!   cell a body was in: membership is carried, never re-derived;
//! * [`adjust_position`] finds the cell of a placement or teleport;
//! * [`World::statics_in`] lists the static objects that reach a cell.
//!
//! Units are metres. A position is relative to the south-west corner of the landblock named in its cell id, with
//! x east, y north and z up; see [`ids::block_offset`] for crossing between landblocks. All arithmetic is f32 in
//! a fixed order, the same on every platform.
//!
//! ```no_run
//! use vestibule_world::{CellArray, Sphere, World, find_cell_list, Position};
//! # fn demo(source: vestibule_world::MemoryRecords) -> Result<(), Box<dyn std::error::Error>> {
//! let world = World::open(source)?;
//! let feet: Position = "0xA9B40031 [155.372 16.028 94.005]".parse()?;
//! let foot_sphere = Sphere::new(feet.origin() + glam::Vec3::new(0.0, 0.0, 0.475), 0.48);
//! let mut cells = CellArray::new();
//! let found = find_cell_list(&world, feet.cell, feet.origin(), &[foot_sphere], &mut cells, true);
//! println!("in {:?}, touching {} cells", found.containing, cells.len());
//! # Ok(()) }
//! ```

#![forbid(unsafe_code)]

mod adjust_position;
mod aperture_tree;
mod assets;
mod box_quads;
mod cell_array;
mod cell_bsp;
mod cell_manager;
mod certain_cells;
mod certain_land_cells;
pub mod compile;
pub mod constants;
mod edge_quads;
mod env_cell;
mod error;
mod find_cell_list;
mod frame;
mod geometry;
pub mod ids;
mod landblock;
mod lanes;
mod level_floor;
mod load;
mod loader;
pub mod lscape;
mod open_box;
mod open_ground;
mod physics_bsp;
mod plane_quads;
mod polygon;
mod position;
mod records;
mod region;
mod residency;
pub mod scenery;
mod shadow;
mod shape;
mod source;
pub mod terrain;
pub mod texture_code;
pub mod transit;
mod transit_hints;
mod transit_parts;
mod world;

pub use adjust_position::{AdjustedPosition, adjust_position, find_visible_child_cell};
pub use aperture_tree::ApertureTree;
pub use cell_array::{CellArray, CellEntry};
pub use cell_bsp::{CellBsp, Inside};
pub use cell_manager::CellManager;
pub use certain_cells::{certain_cells, certain_crossing, certain_rooms};
pub use certain_land_cells::{add_land_cells, distance_to_rooms};
pub use edge_quads::{EdgeQuad, RimSide, rim_side};
pub use env_cell::{CellPortal, CellStruct, EnvCell, PortalTarget};
pub use error::{LoadProblem, ProblemKind, WorldError};
pub use find_cell_list::{CellList, MAX_CELL_LIST_CYLSPHERES, find_cell_list, find_cell_list_of_cylspheres};
pub use frame::{Frame, normalise};
pub use geometry::{BoundingBox, CylSphere, Plane, Side, Sphere};
pub use ids::{BlockId, CellId, LandCoord, ParseCellIdError};
pub use landblock::{LAND_CELLS, Land, Landblock};
pub use lanes::{LaneBox, Lanes};
pub use level_floor::LevelFloor;
pub use physics_bsp::{Child, ChildKind, Face, FaceEdge, PhysicsBsp, PhysicsLeaf, PhysicsNode, SURE_OVERLAP};
pub use polygon::{Polygon, PolygonSet};
pub use position::{MapCoordinates, ParseMapCoordinatesError, ParsePositionError, Position, heading_of};
pub use region::{REGION_RECORD, Region};
pub use residency::{ResidencySettings, ResidencyStats};
pub use shadow::{ReachQuad, ShadowLists, StaticReach, calc_cross_cells_static, part_bounds};
pub use shape::{
    Aperture, Building, BuildingPortal, Model, Shape, ShapePart, StaticObject, StaticRef, bounding_sphere,
};
pub use source::{MemoryRecords, RecordSource, SourceError, Store};
pub use terrain::{LandCell, Split, TerrainPolygon, TerrainWord, Water};
pub use transit_hints::TransitHints;
pub use transit_parts::{PartBounds, find_bbox_cell_list};
pub use world::{Ground, World, WorldSettings, is_over_block};
