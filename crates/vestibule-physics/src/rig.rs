//! Small worlds and bare transitions for the tests of this crate.

use std::sync::Arc;

use glam::{Quat, Vec3};
use vestibule_dat::record::Stab;
use vestibule_world::{CellId, CylSphere, Plane, Position, Shape, Sphere, World};

use crate::body::Body;
use crate::flags::{ObjectState, PhysicsState};
use crate::locomotion::Locomotion;
use crate::population::Population;
use crate::settings::Settings;
use crate::sphere_path::LocalSpace;
use crate::sweep::{self, Carried, ContactPlane, Mover, Scratch, Swept};
use crate::transition::{InsertType, Transition};

pub(crate) use vestibule_testing::records;

pub(crate) const BLOCK: u16 = 0xA9B4;
/// The land cell over (12, 12).
pub(crate) const LAND: CellId = CellId(0xA9B4_0001);

/// A vector.
pub(crate) fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

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

/// A static object with these polygons, given in the coordinates of the landblock.
pub(crate) fn add_faces(builder: &mut records::Builder, center: Vec3, rotation: Quat, faces: &[Vec<Vec3>]) {
    let model = 0x0100_0002;
    let local: Vec<Vec<Vec3>> = faces
        .iter()
        .map(|f| f.iter().map(|p| rotation.inverse() * (*p - center)).collect())
        .collect();
    builder.model(model, &local, true);
    builder.info.objects.push(Stab {
        id: model,
        frame: vestibule_dat::primitive::Frame {
            origin: center,
            rotation,
        },
    });
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
            add_faces(&mut builder, v(12.0, 12.0, 0.0), Quat::IDENTITY, faces);
        }
        Self::of(builder)
    }

    /// The same with a landblock to the east, and an object whose own frame is at `center`, turned by `rotation`.
    pub(crate) fn with_turned_faces(center: Vec3, rotation: Quat, faces: &[Vec<Vec3>]) -> Self {
        let mut builder = records::Builder::new(BLOCK);
        builder.flat_block(0xAAB4);
        add_faces(&mut builder, center, rotation, faces);
        Self::of(builder)
    }

    /// A world whose land cell (0, 0) slopes up to the east by `rise` m over 24 m, south half.
    pub(crate) fn slope(rise: u8) -> Self {
        let mut builder = records::Builder::new(BLOCK);
        for j in 0..9 {
            for i in 1..9 {
                builder.heights[9 * i + j] = rise / 2;
            }
        }
        Self::of(builder)
    }

    /// A yard with one of everything: flat ground, a wall, a platform, a step, a ramp, a roof too steep to walk
    /// on, a house of two rooms that one enters by a door, a post and a creature.
    pub(crate) fn yard() -> Self {
        let ramp = vec![
            v(20.0, 4.0, 0.0),
            v(23.0, 4.0, 1.5),
            v(23.0, 7.0, 1.5),
            v(20.0, 7.0, 0.0),
        ];
        let roof = vec![
            v(4.0, 20.0, 0.2),
            v(6.0, 20.0, 4.0),
            v(6.0, 24.0, 4.0),
            v(4.0, 24.0, 0.2),
        ];
        let faces = [
            wall_facing_west(14.0, [8.0, 14.0], [-1.0, 4.0]),
            level([8.0, 11.0], [4.0, 7.0], 2.5),
            level([5.0, 7.0], [8.0, 12.0], 0.4),
            ramp,
            roof,
        ];
        let mut builder = records::Builder::new(BLOCK);
        add_faces(&mut builder, v(12.0, 12.0, 0.0), Quat::IDENTITY, &faces);
        // The house: rooms 18..22 and 22..26 on x, 18..23 on y, a door to the south.
        let door = [
            [19.0, 18.0, 0.0],
            [20.5, 18.0, 0.0],
            [20.5, 18.0, 2.5],
            [19.0, 18.0, 2.5],
        ];
        let between = [
            [22.0, 20.0, 0.0],
            [22.0, 21.5, 0.0],
            [22.0, 21.5, 2.5],
            [22.0, 20.0, 2.5],
        ];
        let floor = |x| level(x, [18.0, 23.0], 0.0);
        let front = records::Room::of_box(0x100, v(18.0, 18.0, -0.1), v(22.0, 23.0, 3.0))
            .opening(None, -1, false, &door)
            .opening(Some(0x101), 0, false, &between)
            .walls(&[
                floor([18.0, 22.0]),
                // The frame of the door.
                wall_facing_west(20.5, [17.8, 18.6], [0.0, 3.0]),
            ])
            .stabs(&[0x101]);
        let back = records::Room::of_box(0x101, v(22.0, 18.0, -0.1), v(26.0, 23.0, 3.0))
            .opening(Some(0x100), 1, true, &between)
            .walls(&[
                floor([22.0, 26.0]),
                wall_facing_west(26.0, [18.0, 23.0], [0.0, 3.0]),
            ])
            .stabs(&[0x100]);
        let (mut front, mut back) = (front, back);
        (front.seen_outside, back.seen_outside) = (true, true);
        builder
            .room(front)
            .room(back)
            .building(v(20.0, 20.0, 0.0), &[(0x100, 0)]);
        let mut rig = Self::of(builder);
        let post = crate::body::sphere_shape(&[]);
        let post = Shape {
            cylspheres: [CylSphere {
                low_point: Vec3::ZERO,
                radius: 0.3,
                height: 0.5,
            }]
            .into(),
            ..post
        };
        let post = Body::new(Arc::new(post), 1.0).unwrap();
        let creature = Body::creature(&[Sphere::new(v(0.0, 0.0, 0.5), 0.5)], Locomotion::default()).unwrap();
        for (body, at) in [(post, v(10.0, 20.0, 0.0)), (creature, v(16.0, 16.0, 0.0))] {
            let id = rig.population.add(body);
            let at = LAND
                .adjust_to_outside(at)
                .map(|(cell, origin)| Position::new(cell, origin))
                .unwrap();
            assert!(
                rig.population
                    .force_into_cell(&rig.world, &mut rig.scratch, id, &at)
            );
        }
        rig
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
        self.transition_at(mover, carried, &Position::new(LAND, at))
    }

    pub(crate) fn transition_at(
        &mut self,
        mover: &Mover,
        carried: &Carried,
        at: &Position,
    ) -> Transition<'_, '_> {
        self.scratch.start();
        sweep::begin(
            &self.world,
            &self.population,
            &mut self.scratch,
            mover,
            carried,
            at,
            InsertType::Transition,
        )
    }

    /// The position of a foot at this place, in the room that holds the point half a metre above it, if any.
    pub(crate) fn stand(&self, at: Vec3) -> Position {
        let rooms = [0x100, 0x101].map(|low| CellId(0xA9B4_0000 | low));
        let holds = |cell: &CellId| {
            self.world.env_cell(*cell).is_some() && self.world.point_in_cell(*cell, at + v(0.0, 0.0, 0.48))
        };
        match rooms.into_iter().find(holds) {
            Some(room) => Position::new(room, at),
            None => LAND
                .adjust_to_outside(at)
                .map(|(cell, origin)| Position::new(cell, origin))
                .unwrap(),
        }
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

/// The first polygon of the static object becomes the one last stood on.
pub(crate) fn stand_on_polygon(t: &mut Transition<'_, '_>) {
    let world = t.world;
    let object = world.static_object(world.statics_in(LAND)[0]).unwrap();
    let bsp = object.shape.parts[0]
        .model
        .as_ref()
        .unwrap()
        .physics
        .as_ref()
        .unwrap();
    t.path.cache_localspace_sphere(LocalSpace {
        cell: object.cell,
        frame: &object.part_frames[0],
        scale: 1.0,
    });
    let foot = t.path.localspace_foot.into();
    t.path.set_walkable(foot, bsp, &bsp.faces()[0]);
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
