//! Small worlds and bare transitions for the tests of this crate.

use glam::Vec3;
use vestibule_dat::record::Stab;
use vestibule_world::{CellId, Plane, Position, Sphere, World};

use crate::flags::{ObjectState, PhysicsState};
use crate::population::Population;
use crate::settings::Settings;
use crate::sweep::{self, Carried, ContactPlane, Mover, Scratch, Swept};
use crate::transition::{InsertType, Transition};

#[path = "../../vestibule-world/tests/common/mod.rs"]
#[allow(unused_imports, reason = "shared with another crate's tests")]
pub(crate) mod records;

pub(crate) const BLOCK: u16 = 0xA9B4;
/// The land cell over (12, 12).
pub(crate) const LAND: CellId = CellId(0xA9B4_0001);

pub(crate) struct Rig {
    pub(crate) world: World,
    pub(crate) population: Population,
    pub(crate) scratch: Scratch,
}

/// Corners of a rectangle on x and y at height z, normal up.
pub(crate) fn level(x: [f32; 2], y: [f32; 2], z: f32) -> Vec<Vec3> {
    let at = |x, y| Vec3::new(x, y, z);
    vec![at(x[0], y[0]), at(x[1], y[0]), at(x[1], y[1]), at(x[0], y[1])]
}

/// A wall in the plane x = `x`, facing towards smaller x.
pub(crate) fn wall_facing_west(x: f32, y: [f32; 2], z: [f32; 2]) -> Vec<Vec3> {
    let at = |y, z| Vec3::new(x, y, z);
    vec![at(y[0], z[0]), at(y[0], z[1]), at(y[1], z[1]), at(y[1], z[0])]
}

impl Rig {
    /// Flat ground at z = 0.
    pub(crate) fn flat() -> Self {
        Self::with_faces(&[])
    }

    /// Ground at z = 0 with a static object of these polygons, in the coordinates of the landblock.
    pub(crate) fn with_faces(faces: &[Vec<Vec3>]) -> Self {
        let mut builder = records::Builder::new(BLOCK);
        if !faces.is_empty() {
            let model = 0x0100_0002;
            let center = Vec3::new(12.0, 12.0, 0.0);
            let local: Vec<Vec<Vec3>> = faces
                .iter()
                .map(|f| f.iter().map(|p| *p - center).collect())
                .collect();
            builder.model(model, &local, true);
            builder.info.objects.push(Stab {
                id: model,
                frame: vestibule_dat::primitive::Frame {
                    origin: center,
                    ..Default::default()
                },
            });
        }
        Self::of(builder)
    }

    pub(crate) fn of(builder: records::Builder) -> Self {
        Rig {
            world: builder.world(),
            population: Population::new(),
            scratch: Scratch::new(),
        }
    }

    pub(crate) fn with_settings(mut self, settings: Settings) -> Self {
        self.population.set_settings(settings);
        self
    }

    /// A transition that stands at `at` (feet) and has not begun.
    pub(crate) fn transition(&mut self, mover: &Mover, carried: &Carried, at: Vec3) -> Transition<'_, '_> {
        let at = Position::new(LAND, at);
        sweep::begin(
            &self.world,
            &self.population,
            &mut self.scratch,
            mover,
            carried,
            &at,
            InsertType::Transition,
        )
    }

    pub(crate) fn sweep(&mut self, mover: &Mover, carried: &Carried, from: Vec3, to: Vec3) -> Swept {
        let (from, to) = (Position::new(LAND, from), Position::new(LAND, to));
        sweep::sweep(
            &self.world,
            &self.population,
            &mut self.scratch,
            mover,
            carried,
            &from,
            &to,
        )
        .unwrap()
    }
}

/// The mover of the worked examples: foot 0.48 m over the ground, head at 1.355 m (`transition.md` 11).
pub(crate) fn walker() -> Mover {
    let sphere = |z| Sphere::new(Vec3::new(0.0, 0.0, z), 0.48);
    let mut mover = Mover::new(&[sphere(0.48), sphere(1.355)])
        .unwrap()
        .with_steps(0.6, 1.5);
    mover.state = ObjectState::EDGE_SLIDE;
    mover
}

pub(crate) fn missile() -> Mover {
    let mut mover = Mover::new(&[Sphere::new(Vec3::ZERO, 0.3)]).unwrap();
    mover.state = ObjectState::PATH_CLIPPED | ObjectState::PERFECT_CLIP;
    mover.physics = PhysicsState::MISSILE;
    mover
}

pub(crate) fn on_plane(normal: Vec3, d: f32) -> Carried {
    let plane = Plane { normal, d };
    Carried {
        contact: Some(ContactPlane {
            plane,
            cell: LAND,
            is_water: false,
        }),
        on_walkable: normal.z >= crate::constants::FLOOR_Z,
        ..Carried::default()
    }
}

/// In contact with level ground at this height.
pub(crate) fn on_level(z: f32) -> Carried {
    on_plane(Vec3::Z, -z)
}

pub(crate) fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().max_element() < 1e-5
}

pub(crate) fn near(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-5
}
