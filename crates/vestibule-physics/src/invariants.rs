//! The invariants I1 to I16 of `transition.md` 10.1, over many moves through a yard that has one of everything.

use glam::{Quat, Vec3};
use proptest::prelude::*;
use vestibule_world::{CellArray, CellId, Frame, Plane, Position, Sphere, find_cell_list};

use crate::body::Body;
use crate::constants::{EPSILON, FLOOR_Z, POLYGON_INTERP_LIMIT};
use crate::flags::{ObjectState, TransientState};
use crate::population::Population;
use crate::rig::*;
use crate::settings::Settings;
use crate::sphere_path::Pose;
use crate::sweep::{Carried, Mover, Scratch, Swept};
use crate::transition::{InsertType, Transition, TransitionState, calc_num_steps};

/// The parts of a step, and what must hold between them.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Curr {
    cell: CellId,
    origin: Vec3,
    named: Option<CellId>,
    centers: [Vec3; 2],
}

fn curr(t: &Transition<'_, '_>) -> Curr {
    Curr {
        cell: t.path.curr_pos.cell,
        origin: t.path.curr_pos.origin(),
        named: t.path.curr_cell.map(|c| c.id()),
        centers: [t.path.curr_center(0), t.path.curr_center(1)],
    }
}

/// One step of `find_transitional_position` (3.5), with a look between insertion and validation.
fn step(
    t: &mut Transition<'_, '_>,
    offset: Vec3,
    mut inserted: impl FnMut(&mut Transition<'_, '_>, TransitionState, Vec3),
) -> TransitionState {
    let offset = t.adjust_offset(offset);
    t.info.sliding.valid = false;
    t.info.clear_contact_plane();
    t.path.add_offset_to_check_pos(offset);
    let ts = t.transitional_insert(3);
    inserted(t, ts, offset);
    t.validate_transition(ts)
}

/// Where a mover starts in the yard: anywhere over it, on the ground, in the air or in the house.
fn start() -> impl Strategy<Value = (Vec3, Carried)> {
    let anywhere = (1.0f32..31.0, 1.0f32..31.0, 0.0f32..4.0);
    (anywhere, 0u8..4).prop_map(|((x, y, z), kind)| match kind {
        0 => (v(x, y, 0.0), on_level(0.0)),
        1 => (v(x, y, z), Carried::default()),
        2 => (v(x, y, z), on_level(z)),
        _ => (
            v(x, y, 0.0),
            Carried {
                sliding_normal: Some(-Vec3::X),
                ..on_level(0.0)
            },
        ),
    })
}

fn offsets() -> impl Strategy<Value = Vec<Vec3>> {
    let one = (-0.47f32..0.47, -0.47f32..0.47, -0.2f32..0.1).prop_map(|(x, y, z)| v(x, y, z));
    prop::collection::vec(one, 1..8)
}

fn mover() -> impl Strategy<Value = Mover> {
    (0u8..4).prop_map(|kind| match kind {
        0 | 1 => walker(),
        2 => {
            let mut ball = Mover::new(&[Sphere::new(v(0.0, 0.0, 0.3), 0.3)])
                .unwrap()
                .with_steps(0.4, 1.0);
            ball.state = ObjectState::EDGE_SLIDE;
            ball
        }
        _ => missile(),
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn i1_the_accepted_pose_changes_only_when_a_step_is_validated(
        (at, carried) in start(), moves in offsets(), mover in mover(),
    ) {
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        for offset in moves {
            let before = curr(&t);
            step(&mut t, offset, |t, _, _| assert_eq!(curr(t), before));
        }
    }

    #[test]
    fn i2_after_validation_candidate_and_accepted_pose_are_one(
        (at, carried) in start(), moves in offsets(), mover in mover(),
    ) {
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        for offset in moves {
            let ts = step(&mut t, offset, |_, _, _| {});
            prop_assert_eq!(ts, TransitionState::Ok);
            let path = &t.path;
            prop_assert_eq!(path.check_pos.cell, path.curr_pos.cell);
            prop_assert_eq!(path.check_pos.origin(), path.curr_pos.origin());
            prop_assert_eq!(path.check_rotation, path.curr_rotation);
            prop_assert_eq!(path.check_cell.map(|c| c.id()), path.curr_cell.map(|c| c.id()));
            for i in 0..path.num_sphere {
                prop_assert_eq!(path.center(i), path.curr_center(i));
            }
        }
    }

    #[test]
    fn i3_a_test_of_one_cell_leaves_the_candidates_cell_alone((at, _) in start(), by in offsets()) {
        // A mover in the air: a walker's test may step up, which inserts into cells again (5.3).
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&walker(), &Carried::default(), &at);
        let own = t.path.check_cell.map(|c| c.id());
        for offset in by {
            t.path.add_offset_to_check_pos(offset);
            t.build_cell_array(true);
            for entry in t.cell_array.entries().to_vec() {
                if let Some(cell) = t.cell_ref(entry.id) {
                    t.find_collisions_in_cell(cell);
                    prop_assert_eq!(t.path.check_cell.map(|c| c.id()), own);
                }
            }
            t.path.collide = false;
            t.adjust_offset(offset);
            t.path.adjust_check_pos(t.path.check_pos.cell);
            prop_assert_eq!(t.path.check_cell.map(|c| c.id()), own);
        }
    }

    #[test]
    fn i4_spheres_follow_the_candidate_exactly_when_it_is_set(
        at in (0f32..192.0, 0f32..192.0, -5f32..50.0), turn in -3.2f32..3.2, by in offsets(),
    ) {
        let rotation = Quat::from_xyzw(0.0, 0.0, libm::sinf(turn * 0.5), libm::cosf(turn * 0.5));
        let mut mover = Mover::new(&[
            Sphere::new(v(0.1, 0.2, 0.48), 0.48),
            Sphere::new(v(-0.1, 0.0, 1.355), 0.4),
        ])
        .unwrap();
        mover.state = ObjectState::NONE;
        let mut rig = Rig::flat();
        let mut t = rig.transition(&mover, &Carried::default(), Vec3::ZERO);
        t.path.set_check_rotation(rotation);
        let origin = v(at.0, at.1, at.2);
        let cell = t.path.check_cell;
        let pose = Pose { cell: LAND, origin: origin.into() };
        t.path.set_check_pos(pose, cell);
        let placed = |origin| {
            let frame = Frame::new(origin, rotation);
            [0, 1].map(|i| frame.local_to_global(mover.spheres()[i].center))
        };
        let centers = |t: &Transition<'_, '_>| [0, 1].map(|i| t.path.center(i));
        prop_assert_eq!(centers(&t), placed(origin));
        let low = mover.spheres()[0].center - Vec3::Z * 0.48;
        prop_assert_eq!(t.path.global_low_point.xyz(), Frame::new(origin, rotation).local_to_global(low));
        // And to rounding when it is shifted.
        for offset in by {
            t.path.add_offset_to_check_pos(offset);
        }
        let expected = placed(t.path.check_pos.origin());
        for (center, expected) in centers(&t).iter().zip(expected) {
            prop_assert!((*center - expected).length() < 1e-3);
        }
    }

    #[test]
    fn i5_on_walkable_is_contact_with_a_level_enough_plane(
        (at, carried) in start(), moves in offsets(), mover in mover(),
    ) {
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        for offset in moves {
            step(&mut t, offset, |_, _, _| {});
            let contact = t.info.contact;
            let level = contact.valid && contact.plane.normal.z >= FLOOR_Z;
            prop_assert_eq!(t.object.is(ObjectState::CONTACT), contact.valid);
            prop_assert_eq!(t.object.is(ObjectState::ON_WALKABLE), level);
        }
    }

    #[test]
    fn i6_no_sub_mode_is_left_when_an_insertion_returns(
        (at, carried) in start(), moves in offsets(), mover in mover(),
    ) {
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        for offset in moves {
            step(&mut t, offset, |t, ts, _| {
                let path = &t.path;
                let left = [path.step_down, path.step_up, path.check_walkable, path.bldg_check, path.obstruction_ethereal];
                assert_eq!(left, [false; 5]);
                // Only attempts that run out while being adjusted leave this one, as in retail.
                assert!(!path.collide || ts == TransitionState::Adjusted);
                assert_eq!(t.depth, 0);
            });
        }
    }

    #[test]
    fn i7_the_insert_type_is_restored((at, carried) in start(), moves in offsets(), mover in mover()) {
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        for offset in moves {
            step(&mut t, offset, |t, _, _| assert_eq!(t.path.insert_type, InsertType::Transition));
            prop_assert_eq!(t.path.insert_type, InsertType::Transition);
        }
        // The settling of a placement pushes one type and ends with the other (2.2, `backup`).
        let mut t = crate::sweep::begin(
            &rig.world, &rig.population, &mut rig.scratch, &mover, &Carried::default(), &at,
            InsertType::Placement,
        );
        t.find_placement_position();
        prop_assert!(t.path.insert_type != InsertType::Transition);
    }

    #[test]
    fn i8_steps_add_up_and_none_is_longer_than_the_foot_radius(
        x in -30f32..30.0, y in -30f32..30.0, z in -30f32..30.0, scale in 0.001f32..1.0, r in 0.1f32..2.0, viewer: bool,
    ) {
        let d = v(x, y, z) * scale;
        let plan = calc_num_steps(d, r, viewer, Quat::IDENTITY);
        let last = plan.last_offset.unwrap_or(plan.offset);
        prop_assert!(plan.steps > 0 || d.length() <= EPSILON);
        if plan.steps > 0 {
            let sum = plan.offset * (plan.steps - 1) as f32 + last;
            prop_assert!((sum - d).length() <= 1e-5 * (1.0 + d.length()), "{} {}", sum, d);
            prop_assert!(last.length() <= r * 1.000_01);
            prop_assert!(plan.steps == 1 || plan.offset.length() <= r * 1.000_01);
        }
    }

    #[test]
    fn i9_normals_have_unit_length_and_sliding_ones_are_level(
        (at, carried) in start(), moves in offsets(), mover in mover(),
    ) {
        let unit = |n: Vec3| n == Vec3::ZERO || (n.length() - 1.0).abs() < 1e-5;
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        for offset in moves {
            step(&mut t, offset, |_, _, _| {});
            prop_assert!(t.info.collision.get().is_none_or(unit));
            prop_assert!(t.info.sliding.get().is_none_or(|n| unit(n) && n.z == 0.0));
        }
    }

    #[test]
    fn i12_the_cell_array_is_that_of_the_candidate((at, carried) in start(), moves in offsets(), mover in mover()) {
        let mut rig = Rig::yard();
        let mut fresh = CellArray::new();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        let mut check = |t: &mut Transition<'_, '_>| {
            let found = t.build_cell_array(true);
            let path = &t.path;
            let spheres = &path.spheres()[..path.num_sphere];
            let origin = path.check_pos.origin();
            let expected = find_cell_list(t.world, path.check_pos.cell, origin, spheres, &mut fresh, true);
            assert_eq!(found, expected.containing);
            assert_eq!(path.hits_interior_cell, expected.hits_interior);
            assert_eq!(t.cell_array.entries(), fresh.entries());
        };
        for offset in moves {
            step(&mut t, offset, |t, _, _| check(t));
            check(&mut t);
        }
    }

    #[test]
    fn i13_a_rejected_step_moves_nothing_and_an_accepted_one_no_farther_than_it_may(
        (at, carried) in start(), moves in offsets(), mover in mover(),
    ) {
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&mover, &carried, &at);
        for offset in moves {
            let before = curr(&t);
            let (mut answer, mut adjusted) = (TransitionState::Invalid, Vec3::ZERO);
            step(&mut t, offset, |_, ts, by| (answer, adjusted) = (ts, by));
            let after = curr(&t);
            if answer != TransitionState::Ok {
                prop_assert_eq!(before, after);
            }
            // A step down of 1.5 m and a step up of 1.5 times 0.6 m are the greatest adjustments.
            let moved = (t.blk(before.cell, after.cell) + after.origin - before.origin).length();
            prop_assert!(moved <= adjusted.length() + 2.0 * 1.5 + 0.9, "{} by {}", moved, adjusted);
        }
    }

    #[test]
    fn i14_walk_interp_only_falls_within_a_step_down(
        (anywhere, carried) in start(), over in (4.5f32..11.0, 4.0f32..12.0, 0.0f32..3.0), near: bool, depth in 0.04f32..1.5,
    ) {
        // Mostly over the platform and the step.
        let at = if near { v(over.0, over.1, over.2) } else { anywhere };
        let mut rig = Rig::yard();
        let at = rig.stand(at);
        let mut t = rig.transition_at(&walker(), &carried, &at);
        t.path.step_down = true;
        (t.path.step_down_amt, t.path.walk_interp) = (depth, 1.0);
        t.path.add_offset_to_check_pos(v(0.0, 0.0, -depth));
        let mut last = 1.0;
        for _ in 0..6 {
            t.build_cell_array(true);
            for entry in t.cell_array.entries().to_vec() {
                if let Some(cell) = t.cell_ref(entry.id) {
                    t.find_collisions_in_cell(cell);
                }
                let w = t.path.walk_interp;
                prop_assert!(w <= last && w >= POLYGON_INTERP_LIMIT, "{} after {}", w, last);
                last = w;
            }
        }
    }

    #[test]
    fn i15_interior_ids_never_move_the_origin(low in 0x100u16..0xFFFE, block: u16, x in -300f32..300.0) {
        let mut rig = Rig::flat();
        let mut t = rig.transition(&walker(), &Carried::default(), v(x, 12.0, 5.0));
        let before = t.path.center(0);
        t.path.adjust_check_pos(CellId(u32::from(block) << 16 | u32::from(low)));
        prop_assert_eq!(t.path.check_pos.origin(), v(x, 12.0, 5.0));
        prop_assert_eq!(t.path.center(0), before);
        prop_assert_eq!(t.path.check_pos.cell.low(), low);
    }

    #[test]
    fn i16_the_same_sweep_gives_the_same_bits(
        (at, carried) in start(), moves in offsets(), mover in mover(), far in 0f32..3.0,
    ) {
        // One scratch and population that have been used before, one of each made for the sweep.
        let mut used = Rig::yard();
        let mut at = used.stand(at);
        let mut state = carried;
        for offset in moves {
            let mut to = at;
            to.frame.origin += offset * (1.0 + far);
            let mut fresh = Rig::yard();
            let sweep = |rig: &mut Rig| {
                crate::sweep::sweep(&rig.world, &rig.population, &mut rig.scratch, &mover, &state, &at, &to).unwrap()
            };
            let (a, b) = (sweep(&mut used), sweep(&mut fresh));
            prop_assert_eq!(bits(&a), bits(&b));
            prop_assert_eq!(used.scratch.cells(), fresh.scratch.cells());
            prop_assert_eq!(used.scratch.touched(), fresh.scratch.touched());
            let (true, Some(_)) = (a.ok, a.cell) else { break };
            (at, state) = (a.position, a.carried());
        }
    }
}

/// The sweep as the chapter has it, without the short way for the usual step.
fn long_way(rig: &mut Rig, mover: &Mover, carried: &Carried, from: &Position, to: &Position) -> Swept {
    let viewer = mover.state.has(ObjectState::IS_VIEWER);
    let radius = mover.spheres()[0].radius;
    let plan = calc_num_steps(from.offset_to(to), radius, viewer, to.frame.rotation());
    let mut t = rig.transition_at(mover, carried, from);
    let ok = t.find_valid_position(&plan);
    t.outcome(ok, &to.frame).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn i16_the_short_way_of_a_usual_step_gives_the_bits_of_the_long_one(
        (at, carried) in start(), moves in prop::collection::vec((-0.4f32..0.4, -0.4f32..0.4, -0.1f32..0.05, any::<bool>()), 1..12),
        mover in mover(), crowded: bool, retail: bool,
    ) {
        let settings = if retail {
            Settings::RETAIL
        } else {
            Settings { retail_missing_block_offsets: true, persistent_walkable_halving: false, ..Settings::RETAIL }
        };
        let make = || {
            let mut rig = Rig::yard();
            if !crowded {
                rig.population = Population::new();
            }
            rig.with_settings(settings)
        };
        let (mut short, mut long) = (make(), make());
        let (mut at, mut state) = (short.stand(at), carried);
        for (x, y, z, level) in moves {
            let mut to = at;
            to.frame.origin += v(x, y, if level { 0.0 } else { z });
            let a = crate::sweep::sweep(&short.world, &short.population, &mut short.scratch, &mover, &state, &at, &to).unwrap();
            let b = long_way(&mut long, &mover, &state, &at, &to);
            prop_assert_eq!(bits(&a), bits(&b));
            prop_assert_eq!(short.scratch.cells(), long.scratch.cells());
            prop_assert_eq!(short.scratch.touched(), long.scratch.touched());
            let (true, Some(_)) = (a.ok, a.cell) else { break };
            (at, state) = (a.position, a.carried());
        }
    }
}

/// All of an outcome, with signed zeros told apart.
fn bits(swept: &Swept) -> String {
    format!("{swept:?}")
}

#[test]
fn i5_a_plane_at_the_threshold_is_walkable() {
    // The comparison of 5.11.9 is `>=`.
    for (z, walkable) in [(FLOOR_Z, true), (FLOOR_Z - 1e-6, false)] {
        let mut rig = Rig::flat();
        let mut t = rig.transition(&walker(), &Carried::default(), v(12.0, 12.0, 5.0));
        let normal = v(-libm::sqrtf(1.0 - z * z), 0.0, z);
        t.info.set_contact(Plane { normal, d: 0.0 }, false, LAND);
        t.validate_transition(TransitionState::Ok);
        assert!(t.object.state.has(ObjectState::CONTACT));
        assert_eq!(t.object.is(ObjectState::ON_WALKABLE), walkable);
    }
}

#[test]
fn i9_the_normal_of_a_sphere_that_could_not_be_stepped_onto_has_unit_length() {
    // It is the one normal that callers do not normalise (8.3.6).
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(5.0), v(11.15, 12.0, 4.92));
    t.path.add_offset_to_check_pos(v(0.1, 0.05, 0.0));
    t.intersects_sphere(&Sphere::new(v(12.0, 12.0, 5.0), 0.5), false);
    assert!(
        (t.path.step_up_normal.length() - 1.0).abs() > 0.05,
        "{}",
        t.path.step_up_normal
    );
    assert!((t.info.collision.get().unwrap().length() - 1.0).abs() < 1e-5);
}

#[test]
fn i10_a_sweep_without_a_cell_to_begin_in_changes_nothing() {
    let mut rig = Rig::yard();
    let mut population = Population::new();
    let id = population.add(Body::player());
    let before = population.save();
    let to = Position::new(LAND, v(3.0, 3.0, 0.0));
    let swept = population.move_to(&rig.world, &mut rig.scratch, id, &to).unwrap();
    assert!(!swept.ok && swept.cell.is_none());
    assert_eq!(population.save(), before);
    // Nor does one from a cell that does not exist.
    for cell in [0xA9B4_0110, 0xFFFF_0001, 0xA9B4_FFFF] {
        let at = Position::new(CellId(cell), v(3.0, 3.0, 1.0));
        let mut to = at;
        to.frame.origin.x += 1.0;
        let carried = on_level(1.0);
        let swept = crate::sweep::sweep(
            &rig.world,
            &rig.population,
            &mut rig.scratch,
            &walker(),
            &carried,
            &at,
            &to,
        )
        .unwrap();
        assert_eq!(
            (swept.ok, swept.cell, swept.position.origin()),
            (false, None, at.origin())
        );
    }
}

#[test]
fn i11_a_failed_sweep_leaves_the_body_where_it_was_but_may_turn_it() {
    let rig = Rig::flat();
    let mut population = Population::new();
    let mut scratch = Scratch::new();
    // A body whose sweeps turn it step by step: a failed one would not.
    let shape = vestibule_world::Shape {
        allow_free_heading: false,
        ..Body::player().shape().as_ref().clone()
    };
    let id = population.add(Body::new(std::sync::Arc::new(shape), 1.0).unwrap());
    let at = Position::new(LAND, v(12.0, 12.0, 0.1));
    let placed = population.set_position(
        &rig.world,
        &mut scratch,
        id,
        &crate::set_position::Placement::at(at),
    );
    assert!(placed.unwrap().is_ok());
    // Straight against the wall it slides along: the first step is nothing (4.2.2a, 3.5).
    let body = population.body_mut(id).unwrap();
    body.sliding_normal = -Vec3::Y;
    body.transient.set(TransientState::SLIDING, true);
    body.update_time = 10.0;
    let before = body.clone();
    let turn = Quat::from_xyzw(0.0, 0.0, 0.6, 0.8);
    let motion = move |_: &Body, _: f32| Frame::new(v(0.0, 0.2, 0.0), turn);
    population
        .update_with(&rig.world, &mut scratch, id, 10.1, motion)
        .unwrap();
    let after = population.body(id).unwrap();
    assert_eq!(after.position().origin(), before.position().origin());
    assert_eq!((after.cell(), after.contact), (before.cell(), before.contact));
    let rest = |b: &Body| {
        let transient = b.transient.without(TransientState::ACTIVE);
        (transient, b.sliding_normal, b.shadow_cells().to_vec())
    };
    assert_eq!(rest(after), rest(&before));
    assert_eq!(after.cached_velocity, Vec3::ZERO);
    assert!((after.position().frame.rotation().z - 0.6).abs() < 1e-5);
}
