//! 6.4 to 6.8 on trees of several polygons, 9.4 to 9.7 on bodies and their placement.

use glam::{Quat, Vec3};
use vestibule_world::{CellId, Frame, Position, Sphere};

use crate::body::Body;
use crate::bsp_tree;
use crate::flags::{ObjectKind, PhysicsState, SetPositionFlags, TransientState};
use crate::locomotion::Motion;
use crate::population::Population;
use crate::rig::*;
use crate::set_position::{Placed, Placement, SetPositionError};
use crate::settings::Settings;
use crate::sweep::Scratch;

#[test]
fn s6_5_3_of_several_polygons_left_behind_none_is_hit_and_the_last_is_named() {
    let rig = Rig::with_faces(&[
        level([8.0, 12.0], [8.0, 16.0], 5.0),
        level([12.0, 16.0], [8.0, 16.0], 5.0),
    ]);
    let object = rig.world.static_object(rig.world.statics_in(LAND)[0]).unwrap();
    let bsp = object.shape.parts[0]
        .model
        .as_ref()
        .unwrap()
        .physics
        .as_ref()
        .unwrap();
    let sphere = Sphere::new(v(0.0, 0.0, 5.3), 0.48);
    for (movement, hit, named_at) in [
        (v(0.0, 0.0, -0.1), true, 0),
        (v(0.1, 0.0, 0.0), false, 1),
        (v(0.0, 0.0, 0.1), false, 1),
    ] {
        let mut named = None;
        assert_eq!(
            bsp_tree::sphere_intersects_poly(bsp, sphere.into(), movement.into(), &mut named),
            hit
        );
        assert_eq!(named.map(|f| f.polygon), Some(named_at));
    }
}

#[test]
fn s6_8_beside_an_edge_the_bisection_creeps_forward() {
    // The plane is met at x = 11.7, the edge of the wall, 0.2 m aside, only at 12 - 0.2236.
    let rig = Rig::with_faces(&[wall_facing_west(12.0, [8.0, 12.0], [4.0, 6.0])]);
    let object = rig.world.static_object(rig.world.statics_in(LAND)[0]).unwrap();
    let bsp = object.shape.parts[0]
        .model
        .as_ref()
        .unwrap()
        .physics
        .as_ref()
        .unwrap();
    let struck = &bsp.faces()[0];
    let at = |y: f32| {
        let check = Sphere::new(v(-0.1, y, 5.0), 0.3);
        bsp_tree::adjust_to_plane(bsp, &check, v(-0.4, y, 5.0), struck)
            .unwrap()
            .x
    };
    assert!((at(-1.0) + 0.3).abs() < 1e-4, "{}", at(-1.0));
    assert!(
        (-0.2236 - 0.006..=-0.2236 + 0.000_5).contains(&at(0.2)),
        "{}",
        at(0.2)
    );
}

#[test]
fn s9_5_2_who_leaves_the_ground_takes_its_motion_along() {
    let mut body = Body::player();
    let quarter = Quat::from_xyzw(
        0.0,
        0.0,
        core::f32::consts::FRAC_1_SQRT_2,
        core::f32::consts::FRAC_1_SQRT_2,
    );
    body.set_frame(Frame::new(Vec3::ZERO, quarter));
    body.cell = Some(LAND);
    body.set_motion(Motion {
        forward: 1.0,
        ..Motion::default()
    });
    body.transient
        .set(TransientState::CONTACT | TransientState::ON_WALKABLE, true);
    assert!(body.jump(0.5, 1.0));
    // North turned by a quarter to the left is west.
    assert!(
        body.velocity.x < -1.0 && body.velocity.y.abs() < 1e-4 && body.velocity.z > 2.6,
        "{}",
        body.velocity
    );
    assert!(!body.is_on_walkable() && !body.jump(0.5, 1.0));
}

#[test]
fn s9_4_1_what_is_hidden_stands_still() {
    let mut body = Body::player();
    body.velocity = v(1.0, 0.0, 0.0);
    body.transient.set(TransientState::ON_WALKABLE, true);
    body.state.set(PhysicsState::HIDDEN, true);
    assert_eq!(body.update_position(0.1, &Frame::at(Vec3::Y)).origin, Vec3::ZERO);
    body.state.set(PhysicsState::HIDDEN, false);
    assert_ne!(body.update_position(0.1, &Frame::at(Vec3::Y)).origin, Vec3::ZERO);
}

#[test]
fn s9_4_a_sled_is_moved_by_gravity_and_a_walker_is_not() {
    for (sledding, g) in [(true, -9.8), (false, 0.0)] {
        let mut body = Body::player();
        body.omega = Vec3::Z;
        body.transient
            .set(TransientState::CONTACT | TransientState::ON_WALKABLE, true);
        body.state.set(PhysicsState::SLEDDING, sledding);
        body.calc_acceleration();
        assert_eq!((body.acceleration.z, body.omega == Vec3::ZERO), (g, !sledding));
    }
    let mut body = Body::player();
    body.state.set(PhysicsState::GRAVITY, false);
    body.calc_acceleration();
    assert_eq!(body.acceleration, Vec3::ZERO);
}

/// A room of 4 m by 5 m with walls all round.
fn room() -> Rig {
    let (min, max) = (v(18.0, 18.0, 0.0), v(22.0, 23.0, 3.0));
    let wall = |a: [f32; 2], b: [f32; 2]| {
        vec![
            v(a[0], a[1], 0.0),
            v(b[0], b[1], 0.0),
            v(b[0], b[1], 3.0),
            v(a[0], a[1], 3.0),
        ]
    };
    let walls = [
        level([min.x, max.x], [min.y, max.y], 0.0),
        wall([max.x, min.y], [min.x, min.y]),
        wall([max.x, max.y], [max.x, min.y]),
        wall([min.x, max.y], [max.x, max.y]),
        wall([min.x, min.y], [min.x, max.y]),
    ];
    let door = [[19.0, 18.0, 0.0], [20.5, 18.0, 0.0], [20.5, 18.0, 2.5]];
    let mut b = records::Builder::new(BLOCK);
    b.room(
        records::Room::of_box(0x100, min - Vec3::splat(0.1), max)
            .opening(None, -1, false, &door)
            .walls(&walls),
    );
    Rig::of(b)
}

const ROOM: CellId = CellId(0xA9B4_0100);

fn put(
    rig: &mut Rig,
    kind: ObjectKind,
    settings: Settings,
    placement: &Placement,
) -> Result<Placed, SetPositionError> {
    let mut population = Population::with_settings(settings);
    let mut body = Body::player();
    body.kind = body.kind | kind;
    let id = population.add(body);
    population
        .set_position(&rig.world, &mut Scratch::new(), id, placement)
        .unwrap()
}

fn exactly(x: f32, y: f32) -> Placement {
    Placement::at(Position::new(ROOM, v(x, y, 0.05))).with_flags(SetPositionFlags::PLACEMENT)
}

#[test]
fn w65_s9_7_4_a_placement_may_be_pushed_towards_smaller_x_and_y_only() {
    let mut rig = room();
    let none = ObjectKind::NONE;
    let retail = Settings::RETAIL;
    let both = Settings {
        signed_placement_acceptance: false,
        ..Settings::RETAIL
    };
    assert_eq!(
        put(&mut rig, none, retail, &exactly(20.0, 20.0)),
        Ok(Placed::InCell(ROOM))
    );
    // 0.18 m into each wall; the walls to the east and north push towards smaller numbers.
    for (x, y, in_retail) in [
        (18.3, 20.0, false),
        (20.0, 18.3, false),
        (21.7, 20.0, true),
        (20.0, 22.7, true),
    ] {
        assert_eq!(
            put(&mut rig, none, retail, &exactly(x, y)).is_ok(),
            in_retail,
            "{x} {y}"
        );
        assert!(put(&mut rig, none, both, &exactly(x, y)).is_err(), "{x} {y}");
    }
    // Up to 5 cm it may be pushed anyhow.
    assert!(put(&mut rig, none, retail, &exactly(18.45, 20.0)).is_ok());
    assert!(put(&mut rig, none, both, &exactly(20.0, 18.45)).is_ok());
}

#[test]
fn s9_7_3_what_is_forced_into_a_cell_needs_no_room() {
    let mut rig = room();
    let (retail, forced) = (Settings::RETAIL, ObjectKind::FORCED_PLACEMENT);
    assert!(put(&mut rig, ObjectKind::NONE, retail, &exactly(18.3, 20.0)).is_err());
    assert_eq!(
        put(&mut rig, forced, retail, &exactly(18.3, 20.0)),
        Ok(Placed::InCell(ROOM))
    );
}

#[test]
fn s9_7_2_scattering_tries_elsewhere_when_asked_to() {
    let mut rig = room();
    let none = ObjectKind::NONE;
    let retail = Settings::RETAIL;
    let scattered = |flags: SetPositionFlags, x: f32, tries: u32| Placement {
        scatter_radius: (1.5, 1.5),
        scatter_tries: tries,
        ..exactly(x, 20.0).with_flags(SetPositionFlags::PLACEMENT | flags)
    };
    // Into the wall: without the flag it fails, with it another place is found.
    assert!(
        put(
            &mut rig,
            none,
            retail,
            &scattered(SetPositionFlags::NONE, 18.3, 40)
        )
        .is_err()
    );
    assert!(
        put(
            &mut rig,
            none,
            retail,
            &scattered(SetPositionFlags::SCATTER, 18.3, 40)
        )
        .is_ok()
    );
    assert!(
        put(
            &mut rig,
            none,
            retail,
            &scattered(SetPositionFlags::SCATTER, 18.3, 0)
        )
        .is_err()
    );
    // Random scattering does not try the place itself.
    assert!(
        put(
            &mut rig,
            none,
            retail,
            &scattered(SetPositionFlags::SCATTER, 20.0, 0)
        )
        .is_ok()
    );
    assert!(
        put(
            &mut rig,
            none,
            retail,
            &scattered(SetPositionFlags::RANDOMSCATTER, 20.0, 0)
        )
        .is_err()
    );
    assert!(
        put(
            &mut rig,
            none,
            retail,
            &scattered(SetPositionFlags::RANDOMSCATTER, 20.0, 40)
        )
        .is_ok()
    );
}

#[test]
fn s9_8_who_rests_and_who_moves() {
    let rig = Rig::flat();
    let mut scratch = Scratch::new();
    let moves = |scratch: &mut Scratch, prepare: &dyn Fn(&mut Population, crate::population::BodyId)| {
        let mut population = Population::new();
        let id = population.add(Body::player());
        let at = Placement::at(Position::new(LAND, v(12.0, 12.0, 0.1)));
        assert!(
            population
                .set_position(&rig.world, scratch, id, &at)
                .unwrap()
                .is_ok()
        );
        let body = population.body_mut(id).unwrap();
        body.set_motion(Motion {
            forward: 1.0,
            ..Motion::default()
        });
        body.update_time = 0.0;
        prepare(&mut population, id);
        let before = population.body(id).unwrap().position().origin();
        population.update(&rig.world, scratch, id, 0.1).unwrap();
        population.body(id).unwrap().position().origin() != before
    };
    assert!(moves(&mut scratch, &|_, _| {}));
    assert!(!moves(&mut scratch, &|p, id| p
        .body_mut(id)
        .unwrap()
        .state
        .set(PhysicsState::FROZEN, true)));
    assert!(!moves(&mut scratch, &|p, id| p.leave_world(id)));
    // Its clock starts when it wakes up: nothing has passed yet.
    assert!(!moves(&mut scratch, &|p, id| p
        .body_mut(id)
        .unwrap()
        .transient
        .set(TransientState::ACTIVE, false)));
    let watched = |x: f32| {
        let mut scratch = Scratch::new();
        let world = &rig.world;
        moves(&mut scratch, &move |p: &mut Population, _| {
            let observer = p.add(Body::player());
            let (cell, origin) = LAND.adjust_to_outside(v(x, 12.0, 0.0)).unwrap();
            let mut scratch = Scratch::new();
            assert!(p.force_into_cell(world, &mut scratch, observer, &Position::new(cell, origin)));
            p.set_observer(Some(observer));
        })
    };
    assert!(watched(107.0) && !watched(109.0));
}

#[test]
fn z1_a_body_that_is_lost_rests() {
    let mut rig = Rig::flat();
    let id = rig.population.add(Body::player());
    let mut put = |cell: u32, z: f32| {
        let at = Position::new(CellId(cell), v(12.0, 12.0, z));
        let placed = rig
            .population
            .set_position(&rig.world, &mut rig.scratch, id, &Placement::at(at))
            .unwrap();
        let active = |body: &Body| body.transient.has(TransientState::ACTIVE);
        (placed, active(rig.population.body(id).unwrap()))
    };
    assert_eq!(put(LAND.0, 0.0), (Ok(Placed::InCell(LAND)), true));
    assert_eq!(put(0xA9B4_0100, 0.0), (Ok(Placed::Lost), false));
}

#[test]
fn s9_7_a_placement_without_sliding_ends_in_the_cell_it_began_in() {
    // Two rooms with an opening at x = 22, and a wall 0.46 m to the east of the body: it is pushed 0.02 m to the west.
    let placed = |x: f32| {
        let opening = [
            [22.0, 18.0, 0.0],
            [22.0, 23.0, 0.0],
            [22.0, 23.0, 2.5],
            [22.0, 18.0, 2.5],
        ];
        let wall = wall_facing_west(x + 0.46, [18.0, 23.0], [0.0, 3.0]);
        let west = records::Room::of_box(0x100, v(18.0, 18.0, -0.1), v(22.0, 23.0, 3.0))
            .opening(Some(0x101), 0, false, &opening)
            .walls(&[level([18.0, 22.0], [18.0, 23.0], 0.0), wall.clone()])
            .stabs(&[0x101]);
        let east = records::Room::of_box(0x101, v(22.0, 18.0, -0.1), v(26.0, 23.0, 3.0))
            .opening(Some(0x100), 0, true, &opening)
            .walls(&[level([22.0, 26.0], [18.0, 23.0], 0.0), wall])
            .stabs(&[0x100]);
        let mut builder = records::Builder::new(BLOCK);
        builder.room(west).room(east);
        let mut rig = Rig::of(builder);
        let id = rig.population.add(Body::player());
        let at = Position::new(CellId(0xA9B4_0101), v(x, 20.5, 0.01));
        let exact = Placement::at(at).with_flags(SetPositionFlags::PLACEMENT);
        rig.population
            .set_position(&rig.world, &mut rig.scratch, id, &exact)
            .unwrap()
    };
    assert_eq!(placed(22.03), Ok(Placed::InCell(CellId(0xA9B4_0101))));
    assert!(placed(22.01).is_err());
}

#[test]
fn s3_6_5_who_is_placed_over_a_floor_of_polygons_settles_on_it() {
    let mut rig = Rig::with_faces(&[level([8.0, 16.0], [8.0, 16.0], 3.0)]);
    let id = rig.population.add(Body::player());
    let at = Position::new(LAND, v(12.0, 12.0, 3.4));
    let placed = rig
        .population
        .set_position(&rig.world, &mut rig.scratch, id, &Placement::at(at))
        .unwrap();
    assert_eq!(placed, Ok(Placed::InCell(LAND)));
    let body = rig.population.body(id).unwrap();
    assert!((body.position().origin().z - 3.0).abs() < 0.01);
    assert!(body.is_on_walkable());
}
