//! From a scene to records.

mod cells;
mod land;
mod mesh;
mod model;
mod noise;
mod region;
mod room;
mod site;
mod structure;
mod surface;
mod texture;
mod validate;
mod world;

pub use world::{CompileStats, CompiledWorld};

pub(crate) use world::compile;
