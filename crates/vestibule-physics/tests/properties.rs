//! What holds for every sweep, and what becomes of input that makes no sense (issue "The sweep", `transition.md` 10).

use std::sync::Arc;

use glam::{Quat, Vec3};
use proptest::prelude::*;
use vestibule_dat::record::Stab;
use vestibule_physics::{
    Body, Carried, ContactPlane, Locomotion, Motion, Mover, Placed, Placement, Population, Scratch,
    SetPositionError, Simulation, SweepError, Swept, place, sweep,
};
use vestibule_testing::records::{Builder, Room};
use vestibule_world::{BlockId, CellId, CylSphere, Frame, Plane, Position, Shape, Sphere, World};

const BLOCK: u16 = 0xA9B4;

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

fn level(x: [f32; 2], y: [f32; 2], z: f32) -> Vec<Vec3> {
    vec![
        v(x[0], y[0], z),
        v(x[1], y[0], z),
        v(x[1], y[1], z),
        v(x[0], y[1], z),
    ]
}

fn object(b: &mut Builder, id: u32, at: Vec3, faces: &[Vec<Vec3>]) {
    let local: Vec<Vec<Vec3>> = faces
        .iter()
        .map(|f| f.iter().map(|p| *p - at).collect())
        .collect();
    b.model(id, &local, true);
    b.info.objects.push(Stab {
        id,
        frame: vestibule_dat::primitive::Frame {
            origin: at,
            rotation: Quat::IDENTITY,
        },
    });
}

/// Ground, a wall, a platform, a ramp and a house of two rooms, all within 30 m of the corner of the landblock.
fn yard() -> Builder {
    let mut b = Builder::new(BLOCK);
    let wall = vec![
        v(14.0, 8.0, -1.0),
        v(14.0, 8.0, 4.0),
        v(14.0, 14.0, 4.0),
        v(14.0, 14.0, -1.0),
    ];
    let ramp = vec![
        v(20.0, 4.0, 0.0),
        v(23.0, 4.0, 1.5),
        v(23.0, 7.0, 1.5),
        v(20.0, 7.0, 0.0),
    ];
    let faces = [
        wall,
        ramp,
        level([8.0, 11.0], [4.0, 7.0], 2.5),
        level([5.0, 7.0], [8.0, 12.0], 0.4),
    ];
    object(&mut b, 0x0100_0002, v(12.0, 12.0, 0.0), &faces);
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
    let mut front = Room::of_box(0x100, v(18.0, 18.0, -0.1), v(22.0, 23.0, 3.0))
        .opening(None, -1, false, &door)
        .opening(Some(0x101), 0, false, &between)
        .walls(&[level([18.0, 22.0], [18.0, 23.0], 0.0)])
        .stabs(&[0x101]);
    let mut back = Room::of_box(0x101, v(22.0, 18.0, -0.1), v(26.0, 23.0, 3.0))
        .opening(Some(0x100), 1, true, &between)
        .walls(&[level([22.0, 26.0], [18.0, 23.0], 0.0)])
        .stabs(&[0x100]);
    (front.seen_outside, back.seen_outside) = (true, true);
    b.room(front)
        .room(back)
        .building(v(20.0, 20.0, 0.0), &[(0x100, 0)]);
    b
}

/// The yard with as much as one likes more than 60 m away: objects, rooms, landblocks.
fn yard_and_more() -> World {
    let mut b = yard();
    for (i, block) in [0xA9B5, 0xAAB4, 0xAAB5, 0x5050, 0xAAB6].into_iter().enumerate() {
        b.flat_block(block);
        let far = v(100.0 + 10.0 * i as f32, 150.0, 0.0);
        object(
            &mut b,
            0x0100_0010 + i as u32,
            far,
            &[level([far.x, far.x + 3.0], [far.y, far.y + 3.0], 0.3)],
        );
    }
    for i in 0..4u16 {
        let min = v(100.0 + 10.0 * f32::from(i), 100.0, -20.0);
        let floor = level([min.x, min.x + 5.0], [min.y, min.y + 5.0], min.z);
        b.room(
            Room::of_box(0x102 + i, min, min + Vec3::splat(5.0))
                .opening(
                    None,
                    -1,
                    false,
                    &[
                        min.to_array(),
                        [min.x + 1.0, min.y, min.z],
                        [min.x + 1.0, min.y, min.z + 2.0],
                    ],
                )
                .walls(&[floor]),
        );
    }
    b.world()
}

fn post() -> Body {
    let shape = Body::player().shape().as_ref().clone();
    let cylinder = CylSphere {
        low_point: Vec3::ZERO,
        radius: 0.3,
        height: 0.5,
    };
    let shape = Shape {
        spheres: Box::default(),
        cylspheres: [cylinder].into(),
        ..shape
    };
    Body::new(Arc::new(shape), 1.0).unwrap()
}

/// The position of a foot, in the room that holds it, if any.
fn stand(world: &World, at: Vec3) -> Position {
    for low in [0x100u16, 0x101] {
        let cell = CellId::new(BlockId(BLOCK), low);
        if world.point_in_cell(cell, at + v(0.0, 0.0, 0.48)) {
            return Position::new(cell, at);
        }
    }
    let (cell, origin) = CellId(0xA9B4_0001).adjust_to_outside(at).unwrap();
    Position::new(cell, origin)
}

fn on_ground() -> Carried {
    Carried {
        contact: Some(ContactPlane {
            plane: Plane {
                normal: Vec3::Z,
                d: 0.0,
            },
            cell: CellId(0xA9B4_0001),
            is_water: false,
        }),
        on_walkable: true,
        ..Carried::default()
    }
}

fn place_in_yard() -> impl Strategy<Value = Vec3> {
    (1f32..30.0, 1f32..30.0, prop_oneof![Just(0.005f32), 0f32..5.0]).prop_map(|(x, y, z)| v(x, y, z))
}

fn offset() -> impl Strategy<Value = Vec3> {
    (-1.2f32..1.2, -1.2f32..1.2, -0.4f32..0.2).prop_map(|(x, y, z)| v(x, y, z))
}

fn turned() -> impl Strategy<Value = Quat> {
    (-3.2f32..3.2).prop_map(|a| Quat::from_xyzw(0.0, 0.0, libm::sinf(a * 0.5), libm::cosf(a * 0.5)))
}

/// All of it, with signed zeros told apart.
fn bits(value: &impl core::fmt::Debug) -> String {
    format!("{value:?}")
}

fn any_f32() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -300f32..300.0,
        2 => any::<u32>().prop_map(f32::from_bits),
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(f32::MAX),
        1 => Just(0.0),
    ]
}

fn any_vec() -> impl Strategy<Value = Vec3> {
    (any_f32(), any_f32(), any_f32()).prop_map(|(x, y, z)| v(x, y, z))
}

fn any_cell() -> impl Strategy<Value = CellId> {
    prop_oneof![
        Just(CellId(0xA9B4_0001)),
        Just(CellId(0xA9B4_0100)),
        Just(CellId(0xA9B4_0101)),
        Just(CellId(0xA9B4_0102)),
        Just(CellId(0)),
        any::<u32>().prop_map(CellId),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn standing_still_never_changes_the_cell(
        at in place_in_yard(), from in turned(), to in turned(), cell in 0usize..4, contact: bool,
    ) {
        // Whether the cell holds the place or not: it is never asked.
        let world = yard().world();
        let mut at = stand(&world, at);
        at.cell = [at.cell, CellId(0xA9B4_0100), CellId(0xA9B4_0101), CellId(0xA9B4_0012)][cell];
        at.frame.set_rotation(from);
        let mut end = at;
        end.frame.set_rotation(to);
        let carried = if contact { on_ground() } else { Carried::default() };
        let mut scratch = Scratch::new();
        let swept = sweep(&world, &Population::new(), &mut scratch, &Mover::player(), &carried, &at, &end).unwrap();
        prop_assert_eq!((swept.ok, swept.cell), (true, Some(at.cell)));
        prop_assert_eq!(bits(&swept.position), bits(&end));
        prop_assert_eq!(swept.contact, carried.contact);
    }

    #[test]
    fn a_blocked_step_changes_nothing(at in place_in_yard(), by in offset(), contact: bool, sliding: bool) {
        let world = yard().world();
        let at = stand(&world, at);
        let mut to = at;
        to.frame.origin += by;
        let mut carried = if contact { on_ground() } else { Carried::default() };
        if sliding {
            carried.sliding_normal = Some(-by.with_z(0.0).normalize_or_zero());
        }
        let mut scratch = Scratch::new();
        let swept = sweep(&world, &Population::new(), &mut scratch, &Mover::player(), &carried, &at, &to).unwrap();
        if !swept.ok {
            prop_assert_eq!(bits(&swept.position.origin()), bits(&at.origin()));
            prop_assert_eq!(swept.cell, Some(at.cell));
        }
        let stayed = swept.position.origin() == at.origin() && swept.position.cell == at.cell;
        if stayed {
            prop_assert_eq!(swept.cell, Some(at.cell));
            // A walker keeps the ground it touched (5.11.4).
            let foot = at.origin().z + Mover::player().spheres()[0].center.z;
            if contact && (foot - 0.48).abs() < 0.0001 {
                prop_assert_eq!(swept.contact.map(|c| c.plane), carried.contact.map(|c| c.plane));
                prop_assert!(swept.on_walkable);
            }
        }
    }

    #[test]
    fn a_result_depends_on_nothing_out_of_reach(
        at in place_in_yard(), moves in prop::collection::vec(offset(), 1..5), order in prop::sample::subsequence(vec![0u16, 1, 2, 3, 4], 0..5),
        last_first: bool,
    ) {
        // Alone, and in a world with more in it that was loaded in some order and has other bodies far off.
        let (alone, more) = (yard().world(), yard_and_more());
        let mut blocks: Vec<u16> = order.iter().map(|&i| [0xA9B5, 0xAAB4, 0xAAB5, 0x5050, 0xAAB6][usize::from(i)]).collect();
        if last_first {
            blocks.reverse();
        }
        for block in blocks {
            let _ = more.block(BlockId(block)).map(|b| more.shadow_lists(b));
        }
        let mut crowd = Population::new();
        let mut scratch_more = Scratch::new();
        for (x, body) in [(120.0, post()), (140.0, Body::player())] {
            let id = crowd.add(body);
            let (cell, origin) = CellId(0xA9B4_0001).adjust_to_outside(v(x, 60.0, 0.0)).unwrap();
            prop_assert!(crowd.force_into_cell(&more, &mut scratch_more, id, &Position::new(cell, origin)));
        }
        let (nobody, mut scratch) = (Population::new(), Scratch::new());
        let (mut at, mut carried) = (stand(&alone, at), Carried::default());
        for by in moves {
            let mut to = at;
            to.frame.origin += by;
            let mover = Mover::player();
            let a = sweep(&alone, &nobody, &mut scratch, &mover, &carried, &at, &to).unwrap();
            let b = sweep(&more, &crowd, &mut scratch_more, &mover, &carried, &at, &to).unwrap();
            prop_assert_eq!(bits(&a), bits(&b));
            prop_assert_eq!(scratch.cells(), scratch_more.cells());
            prop_assert_eq!(scratch.touched(), scratch_more.touched());
            let (true, Some(_)) = (a.ok, a.cell) else { break };
            (at, carried) = (a.position, a.carried());
        }
    }

    #[test]
    fn a_body_goes_on_the_same_when_saved_and_restored(
        at in place_in_yard(), turns in prop::collection::vec((-1f32..1.0, -1f32..1.0, any::<bool>()), 1..12), cut in 0usize..12,
    ) {
        let world = yard().world();
        let mut scratch = Scratch::new();
        let mut population = Population::new();
        let player = population.add(Body::player());
        let other = population.add(Body::creature(&[Sphere::new(v(0.0, 0.0, 0.5), 0.5)], Locomotion::default()).unwrap());
        for (id, at) in [(player, at), (other, at + v(1.2, 0.3, 0.0))] {
            let _ = population.set_position(&world, &mut scratch, id, &Placement::at(stand(&world, at))).unwrap();
        }
        let mut twin = None;
        let mut now = 0.0;
        for (i, (forward, turn, jump)) in turns.into_iter().enumerate() {
            if i == cut.min(3) {
                twin = Some(restored(&population));
            }
            now += 0.05;
            for p in [Some(&mut population), twin.as_mut()].into_iter().flatten() {
                let body = p.body_mut(player).unwrap();
                body.set_motion(Motion { forward, turn, run: jump, ..Motion::default() });
                if jump {
                    body.jump(0.3, now);
                }
                let mut fresh = Scratch::new();
                for id in [player, other] {
                    p.update(&world, &mut fresh, id, now).unwrap();
                }
            }
            if let Some(twin) = &twin {
                prop_assert_eq!(bits(&population.save()), bits(&twin.save()));
            }
        }
    }

    #[test]
    fn any_numbers_give_an_error_or_a_place(
        from in any_vec(), to in any_vec(), cells in (any_cell(), any_cell()),
        spheres in prop::collection::vec((any_vec(), any_f32()), 0..3), steps in (any_f32(), any_f32()),
        plane in prop::option::of((any_vec(), any_f32())), sliding in prop::option::of(any_vec()), stationary: u8,
    ) {
        let world = yard().world();
        let spheres: Vec<Sphere> = spheres.into_iter().map(|(c, r)| Sphere::new(c, r)).collect();
        let mover = match Mover::new(&spheres) {
            Ok(mover) => mover.with_steps(steps.0, steps.1),
            Err(SweepError::NotFinite { .. } | SweepError::NegativeRadius { .. }) => return Ok(()),
            Err(other) => panic!("{other}"),
        };
        let plane = plane.map(|(normal, d)| ContactPlane { plane: Plane { normal, d }, cell: cells.1, is_water: false });
        let carried = Carried { contact: plane, on_walkable: true, last_known: plane, sliding_normal: sliding, stationary };
        let (from, to) = (Position::new(cells.0, from), Position::new(cells.1, to));
        let mut scratch = Scratch::new();
        // Long moves are another test's: they are many steps.
        let mut population = Population::new();
        let settings = vestibule_physics::Settings { max_steps: 2_000, ..Default::default() };
        population.set_settings(settings);
        match sweep(&world, &population, &mut scratch, &mover, &carried, &from, &to) {
            Ok(swept) => prop_assert!(swept.position.is_finite()),
            Err(SweepError::NotFinite { .. } | SweepError::TooManySteps { .. }) => {}
            Err(other) => panic!("{other}"),
        }
        match place(&world, &population, &mut scratch, &mover, &from, true, stationary % 2 == 0) {
            Ok(swept) => prop_assert!(swept.position.is_finite()),
            Err(SweepError::NotFinite { .. }) => {}
            Err(other) => panic!("{other}"),
        }
    }
}

fn restored(population: &Population) -> Population {
    let saved = population.save();
    #[cfg(feature = "serde")]
    let saved: vestibule_physics::save::SavedPopulation =
        serde_json::from_str(&serde_json::to_string(&saved).unwrap()).unwrap();
    Population::restore(&saved, |_| None).unwrap()
}

fn go(
    world: &World,
    mover: &Mover,
    carried: &Carried,
    from: Position,
    by: Vec3,
) -> Result<Swept, SweepError> {
    let mut to = from;
    to.frame.origin += by;
    sweep(
        world,
        &Population::new(),
        &mut Scratch::new(),
        mover,
        carried,
        &from,
        &to,
    )
}

fn ground(x: f32, y: f32) -> Position {
    Position::new(CellId(0xA9B4_0001), v(x, y, 0.005))
}

#[test]
fn bad_input_numbers_that_are_not_finite_are_refused_by_name() {
    let world = yard().world();
    let player = Mover::player();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let refused = |r: Result<Swept, SweepError>, name: &str| match r {
            Err(SweepError::NotFinite { what }) => assert_eq!(what, name),
            other => panic!("{name}: {other:?}"),
        };
        refused(
            go(&world, &player, &on_ground(), ground(bad, 3.0), Vec3::X),
            "position",
        );
        refused(
            go(&world, &player, &on_ground(), ground(3.0, 3.0), v(0.0, 0.0, bad)),
            "target position",
        );
        let steps = player.with_steps(bad, 1.0);
        refused(
            go(&world, &steps, &on_ground(), ground(3.0, 3.0), Vec3::X),
            "step height",
        );
        let mut carried = on_ground();
        carried.sliding_normal = Some(v(0.0, bad, 0.0));
        refused(
            go(&world, &player, &carried, ground(3.0, 3.0), Vec3::X),
            "sliding normal",
        );
        let mut carried = on_ground();
        carried.contact.as_mut().unwrap().plane.d = bad;
        refused(
            go(&world, &player, &carried, ground(3.0, 3.0), Vec3::X),
            "contact plane",
        );
        for sphere in [Sphere::new(Vec3::splat(bad), 0.5), Sphere::new(Vec3::ZERO, bad)] {
            assert_eq!(
                Mover::new(&[sphere]),
                Err(SweepError::NotFinite { what: "sphere" })
            );
            assert!(Body::creature(&[sphere], Locomotion::default()).is_err());
        }
        assert!(Body::new(Body::player().shape().clone(), bad).is_err());
    }
    assert_eq!(
        Mover::new(&[Sphere::new(Vec3::ZERO, -0.1)]),
        Err(SweepError::NegativeRadius { radius: -0.1 })
    );
    for scale in [0.0, -1.0] {
        let body = Body::new(Body::player().shape().clone(), scale);
        assert!(matches!(body, Err(SweepError::BadScale { .. })));
    }
}

#[test]
fn bad_input_velocities_that_are_not_finite_stop_the_body() {
    let world = yard().world();
    for bad in [f32::NAN, f32::INFINITY, f32::MAX] {
        for field in 0..3 {
            let (mut population, mut scratch) = (Population::new(), Scratch::new());
            let id = population.add(Body::player());
            let placed = population.set_position(&world, &mut scratch, id, &Placement::at(ground(3.0, 3.0)));
            assert!(matches!(placed, Ok(Ok(Placed::InCell(_)))));
            let before = *population.body(id).unwrap().position();
            let body = population.body_mut(id).unwrap();
            body.update_time = 0.0;
            match field {
                0 => body.velocity = v(bad, 0.0, 0.0),
                1 => body.acceleration = v(0.0, bad, 0.0),
                _ => body.omega = v(0.0, 0.0, bad),
            }
            // An error or a finite place within reach of the greatest speed, and a body that can go on.
            let _ = population.update(&world, &mut scratch, id, 0.1);
            for now in [0.2, 0.3] {
                let _ = population.update(&world, &mut scratch, id, now);
            }
            let body = population.body(id).unwrap();
            assert!(body.position().is_finite(), "{bad} {field}");
            assert!(
                (body.position().origin() - before.origin()).length() < 30.0,
                "{}",
                body.position()
            );
            assert!(
                population.update(&world, &mut scratch, id, 0.4).is_ok(),
                "{bad} {field}"
            );
        }
        // What is asked for as a velocity is refused where it is asked.
        let mut body = Body::player();
        body.set_velocity(v(bad, 0.0, 0.0), 1.0);
        assert!(body.velocity.is_finite());
    }
    let (mut population, mut scratch) = (Population::new(), Scratch::new());
    let id = population.add(Body::player());
    let time = population.update(&world, &mut scratch, id, f64::NAN);
    assert_eq!(time, Err(SweepError::NotFinite { what: "time" }));
    let placement = Placement::at(ground(f32::NAN, 0.0));
    let placed = population.set_position(&world, &mut scratch, id, &placement);
    assert!(matches!(placed, Err(SweepError::NotFinite { .. })));
}

#[test]
fn bad_input_a_refused_sweep_stops_the_body_alone_and_in_a_simulation() {
    let world = yard().world();
    let settings = vestibule_physics::Settings {
        max_steps: 1,
        ..Default::default()
    };
    let at = Placement::at(ground(3.0, 3.0));
    let flight = v(30.0, 0.0, 10.0);
    let quantum = 0.05;

    let (mut population, mut scratch) = (Population::with_settings(settings), Scratch::new());
    let id = population.add(Body::player());
    population
        .set_position(&world, &mut scratch, id, &at)
        .unwrap()
        .unwrap();
    let body = population.body_mut(id).unwrap();
    body.update_time = 0.0;
    body.set_velocity(flight, 0.0);
    let refused = population.update(&world, &mut scratch, id, quantum);
    assert!(
        matches!(refused, Err(SweepError::TooManySteps { .. })),
        "{refused:?}"
    );

    let mut simulation = Simulation::with_population(Population::with_settings(settings), 1);
    simulation.add(7, Body::player(), at);
    simulation.step(&world, 0.0);
    let now = simulation.now();
    simulation.body_mut(7).unwrap().set_velocity(flight, now);
    simulation.step(&world, quantum);
    assert!(
        matches!(simulation.problems(), [(7, SweepError::TooManySteps { .. })]),
        "{:?}",
        simulation.problems()
    );
    let (alone, among) = (population.body(id).unwrap(), simulation.body(7).unwrap());
    assert_eq!((alone.velocity, alone.position()), (Vec3::ZERO, among.position()));
    assert_eq!(among.velocity, Vec3::ZERO);
}

#[test]
fn bad_input_a_body_without_radius_moves_or_stays() {
    let world = yard().world();
    let point = Mover::new(&[Sphere::new(v(0.0, 0.0, 0.5), 0.0)]).unwrap();
    for by in [v(0.3, 0.0, 0.0), v(0.0, 0.0, -2.0), v(0.000_3, 0.0, 0.0)] {
        let swept = go(&world, &point, &Carried::default(), ground(3.0, 3.0), by).unwrap();
        let moved = swept.position.origin() - ground(3.0, 3.0).origin();
        assert!(
            moved.is_finite() && moved.length() <= by.length() + 0.51,
            "{moved}"
        );
        assert!(swept.ok || moved == Vec3::ZERO);
    }
}

#[test]
fn bad_input_cells_that_are_not_there_move_nothing() {
    let world = yard().world();
    let cells = [
        0u32,
        0xA9B4_0041,
        0xA9B4_00FF,
        0xA9B4_0150,
        0xA9B4_FFFE,
        0xA9B4_FFFF,
        0x1234_0001,
        0x1234_0100,
        0xFFFF_0001,
        0xFFFF_FFFF,
    ];
    for cell in cells {
        let from = Position::new(CellId(cell), v(3.0, 3.0, 0.0));
        let swept = go(&world, &Mover::player(), &on_ground(), from, Vec3::X).unwrap();
        assert_eq!((swept.ok, swept.cell), (false, None), "{cell:X}");
        assert_eq!(swept.position.origin(), from.origin());
        // Placing waits for a cell that may come, and refuses none.
        let (mut population, mut scratch) = (Population::new(), Scratch::new());
        let id = population.add(Body::player());
        let placed = population
            .set_position(&world, &mut scratch, id, &Placement::at(from))
            .unwrap();
        let fine = matches!(
            placed,
            Ok(Placed::Lost) | Ok(Placed::InCell(_)) | Err(SetPositionError::NoCell)
        );
        assert!(fine, "{cell:X}: {placed:?}");
    }
}

#[test]
fn bad_input_outside_the_map_is_the_lost_cell_or_a_stop() {
    // Walking west off the only landblock there is: into nothing that is loaded.
    let world = yard().world();
    let swept = go(
        &world,
        &Mover::player(),
        &on_ground(),
        ground(0.2, 3.0),
        v(-0.4, 0.0, 0.0),
    )
    .unwrap();
    assert_eq!((swept.ok, swept.cell), (true, None));
    assert_eq!(swept.position.cell.block(), BlockId(0xA8B4));
    // A body is then lost, keeps its place and comes back with it.
    let (mut population, mut scratch) = (Population::new(), Scratch::new());
    let id = population.add(Body::player());
    let placed = population.set_position(&world, &mut scratch, id, &Placement::at(ground(0.2, 3.0)));
    assert!(matches!(placed, Ok(Ok(Placed::InCell(_)))));
    let mut to = *population.body(id).unwrap().position();
    to.frame.origin.x -= 0.4;
    population.move_to(&world, &mut scratch, id, &to).unwrap();
    let body = population.body(id).unwrap();
    assert!(
        body.cell().is_none() && (body.position().origin().x - 191.8).abs() < 1e-3,
        "{}",
        body.position()
    );
    assert_eq!(population.lost().count(), 1);
    // At the edge of the map there is nothing to go to.
    let mut b = Builder::new(0x00B4);
    b.flat_block(0x01B4);
    let world = b.world();
    let from = Position::new(CellId(0x00B4_0001), v(0.2, 3.0, 0.005));
    let swept = go(&world, &Mover::player(), &on_ground(), from, v(-0.4, 0.0, 0.0)).unwrap();
    assert!(
        swept.position.origin().x >= 0.0 && swept.cell == Some(from.cell),
        "{swept:?}"
    );
}

#[test]
fn bad_input_in_solid_rock_there_is_no_place_and_no_way() {
    // A block of rock 10 m wide: a closed box of polygons that face outwards, solid inside.
    let (min, max) = (v(60.0, 60.0, -5.0), v(70.0, 70.0, 5.0));
    let mut b = Builder::new(BLOCK);
    let corner = |i: u8| {
        v(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    let faces: Vec<Vec<Vec3>> = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ]
    .map(|f| f.map(corner).to_vec())
    .to_vec();
    object(&mut b, 0x0100_0002, v(65.0, 65.0, 0.0), &faces);
    let world = b.world();
    let (cell, origin) = CellId(0xA9B4_0001).adjust_to_outside(v(60.2, 65.0, 2.0)).unwrap();
    let from = Position::new(cell, origin);
    for by in [Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z * 4.0] {
        let swept = go(&world, &Mover::player(), &Carried::default(), from, by).unwrap();
        assert!(swept.position.is_finite());
    }
    let mut scratch = Scratch::new();
    let placed = place(
        &world,
        &Population::new(),
        &mut scratch,
        &Mover::player(),
        &from,
        false,
        false,
    )
    .unwrap();
    assert!(!placed.ok);
    // A placement that may slide finds room, if any, where no polygon is touched.
    let placed = place(
        &world,
        &Population::new(),
        &mut scratch,
        &Mover::player(),
        &from,
        true,
        false,
    )
    .unwrap();
    assert!(
        placed.ok && (placed.position.origin().x - min.x).abs() > 0.479,
        "{placed:?}"
    );
}

#[test]
fn bad_input_portals_that_lead_nowhere_end_in_the_lost_cell_or_a_stop() {
    let between = [[5.0, 2.0, 0.0], [5.0, 3.5, 0.0], [5.0, 3.5, 2.5], [5.0, 2.0, 2.5]];
    for (other, other_portal) in [(0x1FFu16, 0i16), (0x101, 77), (0x100, 0), (0x101, -1)] {
        let mut b = Builder::new(BLOCK);
        b.room(
            Room::of_box(0x100, v(0.0, 0.0, -0.1), v(5.0, 5.0, 3.0))
                .opening(Some(other), other_portal, false, &between)
                .walls(&[level([0.0, 5.0], [0.0, 5.0], 0.0)])
                .stabs(&[0x1FF, 0x1FE]),
        );
        b.building(v(2.0, 2.0, 0.0), &[(0x1FD, 3), (0x100, 9)]);
        let world = b.world();
        let (mut at, mut carried) = (
            Position::new(CellId(0xA9B4_0100), v(2.5, 2.75, 0.005)),
            on_ground(),
        );
        for _ in 0..40 {
            let swept = go(&world, &Mover::player(), &carried, at, v(0.2, 0.0, 0.0)).unwrap();
            assert!(swept.position.is_finite());
            if swept.cell.is_none() {
                break;
            }
            (at, carried) = (swept.position, swept.carried());
        }
    }
}

#[test]
fn bad_input_rooms_without_bsp_and_polygons_without_area_are_walked_through() {
    let mut b = Builder::new(BLOCK);
    let p = v(3.0, 3.0, 0.5);
    let degenerate = [
        vec![p, p, p],
        vec![p, p + Vec3::X, p + Vec3::X * 2.0],
        vec![p, p + Vec3::X],
        vec![p],
        vec![],
        vec![p, v(f32::NAN, 0.0, 0.0), p + Vec3::Y],
        vec![p, v(f32::INFINITY, 0.0, 0.0), p + Vec3::Y],
        vec![p, p + Vec3::X * 1e30, p + Vec3::Y * 1e30],
        vec![p, p + Vec3::X * 1e-30, p + Vec3::Y * 1e-30],
    ];
    b.room(Room::of_box(0x100, v(0.0, 0.0, -0.1), v(6.0, 6.0, 3.0)).walls(&degenerate));
    b.room(Room::of_box(0x101, v(6.0, 0.0, -0.1), v(12.0, 6.0, 3.0)));
    object(&mut b, 0x0100_0002, v(3.0, 3.0, 0.0), &degenerate);
    let world = b.world();
    for (cell, x) in [(0xA9B4_0100, 2.0), (0xA9B4_0101, 8.0), (0xA9B4_0001, 2.0)] {
        let from = Position::new(CellId(cell), v(x, 3.0, 0.3));
        for by in [v(0.4, 0.0, 0.0), v(0.0, 0.0, -0.4), v(1.5, 0.2, -0.1)] {
            for carried in [Carried::default(), on_ground()] {
                let swept = go(&world, &Mover::player(), &carried, from, by).unwrap();
                assert!(swept.position.is_finite());
            }
        }
        let mut scratch = Scratch::new();
        let placed = place(
            &world,
            &Population::new(),
            &mut scratch,
            &Mover::player(),
            &from,
            true,
            false,
        )
        .unwrap();
        assert!(placed.position.is_finite());
    }
}

#[test]
fn bad_input_a_move_of_ten_kilometres_ends_and_a_longer_one_is_refused() {
    let world = yard().world();
    for by in [
        v(10_000.0, 0.0, 0.0),
        v(0.0, -10_000.0, 0.0),
        v(0.0, 0.0, -10_000.0),
        v(0.0, 0.0, 10_000.0),
    ] {
        let swept = go(&world, &Mover::player(), &on_ground(), ground(100.0, 100.0), by).unwrap();
        assert!(
            swept.position.is_finite() && swept.position.origin().z > -0.1,
            "{swept:?}"
        );
    }
    for by in [1e9, 1e30, f32::MAX] {
        let far = go(
            &world,
            &Mover::player(),
            &on_ground(),
            ground(100.0, 100.0),
            v(by, 0.0, 0.0),
        );
        assert!(matches!(far, Err(SweepError::TooManySteps { .. })), "{far:?}");
    }
}

#[test]
fn a_body_names_frames_it_was_given() {
    // A frame whose rotation is no rotation at all is refused or normalised, and never spreads.
    let world = yard().world();
    let mut at = ground(3.0, 3.0);
    at.frame = Frame::new(at.origin(), Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    let swept = go(&world, &Mover::player(), &on_ground(), at, v(0.2, 0.0, 0.0));
    assert!(swept.is_err() || swept.is_ok_and(|s| s.position.is_finite()));
}
