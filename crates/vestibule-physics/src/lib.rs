//! The collision sweep of Asheron's Call: bodies that move, collide and own their cell, as in the retail client.
//!
//! A body's cell is whatever its last accepted sweep carried it into; it is never derived from where the body
//! rests. That is what keeps a body in a doorway from flickering between two cells.
//!
//! * [`sweep`] moves a [`Mover`] from one position to another and returns a value, [`Swept`]; [`place`] puts one
//!   somewhere without coming from anywhere. They read a [`World`](vestibule_world::World) and a [`Population`] and
//!   write nothing but [`Scratch`].
//! * [`Population`] holds bodies and the lists of who is in which cell. [`Population::move_to`] sweeps and commits,
//!   [`Population::update`] moves a body on in time by its own [`Motion`], velocity and gravity,
//!   [`Population::set_position`] teleports, [`Population::set_ethereal`] opens doors, [`Population::save`] keeps
//!   everything.
//! * [`viewer_mover`] is the camera as a mover: what is seen starts from the cell its own sweep ends in, see
//!   `vestibule-view`.
//! * [`Settings`] switches retail's quirks off one by one; the default is retail.
//! * [`workload`] is a fixed amount of walking, for benchmarks.
//!
//! Units are metres, seconds and radians. Positions are relative to the south-west corner of the landblock named in
//! their cell id; normals are global. All arithmetic is f32 in the order of the specification, the same on every
//! platform; times are f64. After the first few calls a sweep allocates nothing.
//!
//! A player that walks north through the world for a second:
//!
//! ```no_run
//! use vestibule_physics::{Body, Motion, Placement, Population, Scratch};
//! # fn demo(world: &vestibule_world::World) -> Result<(), Box<dyn std::error::Error>> {
//! let mut population = Population::new();
//! let mut scratch = Scratch::new();
//! let player = population.add(Body::player());
//! let start = "0xA9B40031 [155.4 20.0 94.0]".parse()?;
//! population.set_position(world, &mut scratch, player, &Placement::at(start))?.ok();
//! if let Some(body) = population.body_mut(player) {
//!     body.set_motion(Motion { forward: 1.0, ..Motion::default() });
//! }
//! for frame in 1..=30 {
//!     population.update(world, &mut scratch, player, f64::from(frame) / 30.0 + 0.001)?;
//! }
//! println!("{:?}", population.body(player).map(|body| body.position().to_string()));
//! # Ok(()) }
//! ```
//!
//! The behaviour is that of `transition.md`; rules are quoted by their section numbers there.
//!
//! Features: `serde` (de)serialises what [`Population::save`] and [`Body::save`] return.

#![forbid(unsafe_code)]
#![cfg_attr(
    test,
    allow(
        clippy::excessive_precision,
        reason = "examples are quoted with all their digits"
    )
)]

mod adjust_offset;
mod body;
mod bsp_solid;
mod bsp_tree;
mod candidate;
mod collision_info;
pub mod constants;
mod cylsphere;
mod edge_slide;
mod env_collisions;
mod error;
mod find_collisions;
pub mod flags;
#[cfg(test)]
mod invariants;
pub mod locomotion;
mod math;
mod near_statics;
mod obj_collisions;
mod object_info;
mod placement;
mod plain_land;
mod plain_objects;
mod plain_step;
mod plain_walls;
mod polygon;
mod population;
#[cfg(test)]
mod rig;
#[cfg(test)]
mod rules;
pub mod save;
mod set_position;
mod settings;
mod simulation;
mod slide_sphere;
mod sphere;
mod sphere_path;
mod statics_around;
mod step_down;
mod sweep;
mod transition;
mod transitional_insert;
mod update;
mod validate_transition;
mod viewer;
#[cfg(test)]
mod worked_examples;
pub mod workload;

pub use body::{Body, root_motion};
pub use bsp_solid::point_intersects_solid;
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
pub use viewer::viewer_mover;
