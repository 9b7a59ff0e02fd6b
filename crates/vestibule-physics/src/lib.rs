//! The collision sweep of Asheron's Call: bodies that move, collide and own their cell.

#![forbid(unsafe_code)]

mod adjust_offset;
mod body;
mod bsp_tree;
mod collision_info;
pub mod constants;
mod cylsphere;
mod edge_slide;
mod env_collisions;
mod error;
mod find_collisions;
pub mod flags;
pub mod locomotion;
mod math;
mod obj_collisions;
mod object_info;
mod placement;
mod polygon;
mod population;
mod set_position;
mod settings;
mod simulation;
mod slide_sphere;
mod sphere;
mod sphere_path;
mod step_down;
mod sweep;
mod transition;
mod transitional_insert;
mod update;
mod validate_transition;
mod viewer;
pub mod workload;

pub use body::{Body, root_motion};
pub use bsp_tree::point_intersects_solid;
pub use error::SweepError;
pub use flags::{ObjectKind, ObjectState, PhysicsState, SetPositionFlags, TransientState};
pub use locomotion::{Locomotion, Motion};
pub use math::{grotate, heading_to_rotation, heading_to_vector, interpolate_rotation, vector_to_heading};
pub use obj_collisions::ObjectRef;
pub use population::{BodyId, EntryRestrictions, Event, Population};
pub use set_position::{Placed, Placement, SetPositionError};
pub use settings::Settings;
pub use simulation::{BodyKey, Simulation, StepReport};
pub use sweep::{Carried, ContactPlane, Mover, Scratch, Swept, Touch, place, sweep};
pub use update::Quanta;
pub use viewer::{Viewer, sweep_viewer, viewer_mover};
