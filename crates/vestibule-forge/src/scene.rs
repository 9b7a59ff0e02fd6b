//! What a scene says, read from its text: names resolved, shapes made, nothing compiled yet.

mod material;
mod model;
mod placement;
mod read;
mod read_site;
mod read_solid;
mod read_terrain;
mod terrain_op;

pub(crate) use material::{Material, Pattern, pattern_named};
pub(crate) use model::{
    Collide, Exit, Fixture, Kind, LightDef, Link, ModelDef, Opening, Paint, RoomDef, Scatter, Scene,
    ShellDef, SiteDef, SolidDef, Start, StaticDef,
};
pub(crate) use placement::{PlaceDef, Placement, turned};
pub(crate) use read::read;
pub(crate) use terrain_op::{Area, TERRAIN_TYPES, TerrainOp, terrain_named};
