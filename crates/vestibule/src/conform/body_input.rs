//! Bodies as vectors describe them: place, spheres, step heights and what the last move left.

use glam::Vec3;
use serde::Deserialize;
use vestibule_physics::{Carried, ContactPlane, Mover, ObjectState, SweepError};
use vestibule_world::{CellId, Plane, Position, Sphere};

/// A body at the start of a move: the input that `sweep`, `walk` and the workload share.
#[derive(Clone, Debug, Deserialize)]
pub struct BodyInput {
    /// The cell it is in.
    pub cell: u32,
    /// Foot point, relative to the landblock of the cell, metres.
    pub pos: [f32; 3],
    /// Spheres relative to the foot point, the lower one first: x, y, z, radius.
    pub spheres: Vec<[f32; 4]>,
    /// How high it steps up, metres; a player's height unless given.
    #[serde(default = "player_step_up")]
    pub step_up: f32,
    /// How far it steps down, metres; a player's unless given.
    #[serde(default = "player_step_down")]
    pub step_down: f32,
    /// What it carries from its last move.
    #[serde(default)]
    pub state: BodyState,
    /// Whether it keeps off ledges; it does unless told otherwise.
    #[serde(default = "yes")]
    pub edge_slide: bool,
    /// Further bits of the mover's ObjectInfo state.
    #[serde(default)]
    pub flags: u32,
}

/// What a body carries from one move to the next; what is absent is not set.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct BodyState {
    /// In contact with `plane`.
    pub contact: bool,
    /// That plane can be walked on.
    pub on_walkable: bool,
    /// The contact plane: normal and d.
    pub plane: Option<[f32; 4]>,
    /// The cell in whose landblock the plane is given.
    pub plane_cell: u32,
    /// The plane is a water surface.
    pub water: bool,
    /// Normal that it slid along.
    pub sliding: Option<[f32; 3]>,
    /// How long it has been falling in place.
    pub stationary: u8,
}

fn player_step_up() -> f32 {
    vestibule_physics::locomotion::PLAYER_STEP_UP
}

fn player_step_down() -> f32 {
    vestibule_physics::locomotion::PLAYER_STEP_DOWN
}

fn yes() -> bool {
    true
}

impl BodyInput {
    /// Its spheres and how it collides.
    ///
    /// # Errors
    /// A number is not finite, or a radius is negative.
    pub fn mover(&self) -> Result<Mover, SweepError> {
        let sphere = |&[x, y, z, r]: &[f32; 4]| Sphere::new(Vec3::new(x, y, z), r);
        let spheres: Vec<Sphere> = self.spheres.iter().map(sphere).collect();
        let mut mover = Mover::new(&spheres)?.with_steps(self.step_up, self.step_down);
        let edge_slide = if self.edge_slide {
            ObjectState::EDGE_SLIDE
        } else {
            ObjectState::default()
        };
        mover.state = edge_slide | ObjectState(self.flags);
        Ok(mover)
    }

    /// Where it starts.
    pub fn start(&self) -> Position {
        Position::new(CellId(self.cell), self.pos.into())
    }

    /// What it carries at the start.
    pub fn carried(&self) -> Carried {
        self.state.carried()
    }
}

impl BodyState {
    /// As sweeps take it.
    pub fn carried(&self) -> Carried {
        let contact = self
            .plane
            .filter(|_| self.contact)
            .map(|[x, y, z, d]| ContactPlane {
                plane: Plane {
                    normal: Vec3::new(x, y, z),
                    d,
                },
                cell: CellId(self.plane_cell),
                is_water: self.water,
            });
        Carried {
            contact,
            on_walkable: self.on_walkable,
            last_known: None,
            sliding_normal: self.sliding.map(Vec3::from),
            stationary: self.stationary,
        }
    }
}
