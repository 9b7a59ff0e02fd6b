//! 5.11 and 5.12: accepting and rejecting steps, and sliding.

use glam::{Quat, Vec3};
use vestibule_world::CellId;

use crate::flags::{ObjectState, PhysicsState};
use crate::rig::*;
use crate::sphere_path::Pose;
use crate::sweep::{Carried, Mover};
use crate::transition::{Transition, TransitionState};

const AT: Vec3 = Vec3::new(12.0, 12.0, 5.0);

/// Validates a candidate at `AT`, moved and prepared, and tells how often there has been no progress by then.
fn progress(
    mover: &Mover,
    carried: &Carried,
    ts: TransitionState,
    prepare: impl Fn(&mut Transition<'_, '_>),
) -> u8 {
    let mut rig = Rig::flat();
    let carried = Carried {
        stationary: 1,
        ..*carried
    };
    let mut t = rig.transition(mover, &carried, AT);
    prepare(&mut t);
    assert_eq!(t.validate_transition(ts), TransitionState::Ok);
    t.info.frames_stationary_fall
}

#[test]
fn s5_11_3_a_step_that_changes_nothing_is_no_progress() {
    let falls = Carried::default();
    let ok = |prepare: fn(&mut Transition<'_, '_>)| progress(&walker(), &falls, TransitionState::Ok, prepare);
    assert_eq!(ok(|_| {}), 2);
    assert_eq!(
        ok(|t| t.path.add_offset_to_check_pos(v(0.000_19, -0.000_19, 0.000_19))),
        2
    );
    assert_eq!(ok(|t| t.path.add_offset_to_check_pos(v(0.000_21, 0.0, 0.0))), 0);
    // A turn and another cell are changes too (1.3.3).
    assert_eq!(
        ok(|t| t.path.set_check_rotation(Quat::from_xyzw(0.0, 0.0, 0.6, 0.8))),
        0
    );
    assert_eq!(ok(|t| t.path.check_pos.cell = CellId(0xA9B4_0002)), 0);
}

#[test]
fn s5_11_3_the_cell_is_taken_over_even_without_progress() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &Carried::default(), AT);
    let other = CellId(0xA9B4_0002);
    t.path.check_cell = t.cell_ref(other);
    t.validate_transition(TransitionState::Ok);
    assert_eq!(t.path.curr_cell.map(|c| c.id()), Some(other));
}

#[test]
fn s5_11_7_only_what_falls_by_gravity_can_be_stuck() {
    let falls = Carried::default();
    let rejected = TransitionState::Collided;
    assert_eq!(progress(&walker(), &falls, rejected, |_| {}), 2);
    let mut weightless = walker();
    weightless.physics.set(PhysicsState::GRAVITY, false);
    assert_eq!(progress(&weightless, &falls, rejected, |_| {}), 1);
    let viewer = crate::viewer::viewer_mover(&walker());
    assert_eq!(progress(&viewer, &falls, rejected, |_| {}), 1);
}

/// A walker rejected `height` over the plane it stood on.
fn rejected(height: f32, on_walkable: bool) -> (bool, u8) {
    let mut rig = Rig::flat();
    let carried = Carried {
        on_walkable,
        stationary: 1,
        ..on_level(5.0 - height)
    };
    let mut t = rig.transition(&walker(), &carried, AT);
    t.info.clear_contact_plane();
    t.path.add_offset_to_check_pos(v(0.2, 0.0, 0.0));
    assert_eq!(t.validate_transition(TransitionState::Slid), TransitionState::Ok);
    assert_eq!(t.path.check_pos.origin(), AT);
    assert!(t.info.velocity_killed);
    assert_eq!(t.info.last_known.valid, t.info.contact.valid);
    (t.info.contact.valid, t.info.frames_stationary_fall)
}

#[test]
fn s5_11_4_a_rejected_walker_keeps_the_plane_it_touches() {
    // On walkable ground that counts as progress.
    assert_eq!(rejected(0.0, true), (true, 0));
    assert_eq!(rejected(0.0, false), (true, 2));
    // Within epsilon of the radius it touches, farther off it does not.
    assert_eq!(rejected(0.000_15, true), (true, 0));
    assert_eq!(rejected(0.000_3, true), (false, 2));
    assert_eq!(rejected(1.0, true), (false, 2));
}

#[test]
fn s5_11_4_without_a_known_plane_the_velocity_stays() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &Carried::default(), AT);
    t.validate_transition(TransitionState::Collided);
    assert!(!t.info.velocity_killed && !t.info.contact.valid);
}

#[test]
fn s5_11_4b_a_rejection_has_a_normal_up_unless_there_is_one() {
    for (known, expected) in [(None, Vec3::Z), (Some(-Vec3::X), -Vec3::X)] {
        let mut rig = Rig::flat();
        let mut t = rig.transition(&walker(), &Carried::default(), AT);
        if let Some(n) = known {
            t.info.set_collision_normal(n);
        }
        t.validate_transition(TransitionState::Adjusted);
        assert_eq!(t.info.collision.get(), Some(expected));
        // Rule 6: the horizontal part of it is slid along.
        assert_eq!(t.info.sliding.get(), Some(expected.with_z(0.0)));
    }
}

#[test]
fn s5_11_6_an_accepted_step_sets_the_sliding_normal_too() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &Carried::default(), AT);
    t.path.add_offset_to_check_pos(v(0.1, 0.0, 0.0));
    t.info.set_collision_normal(-Vec3::Y);
    t.validate_transition(TransitionState::Ok);
    assert_eq!(t.info.sliding.get(), Some(-Vec3::Y));
}

#[test]
fn s5_11_7_who_is_in_contact_gets_the_floor_but_no_collision() {
    for contact in [true, false] {
        let mut rig = Rig::flat();
        let carried = Carried {
            stationary: 2,
            ..Carried::default()
        };
        let mut t = rig.transition(&walker(), &carried, AT);
        t.object.state.set(ObjectState::CONTACT, contact);
        t.info.set_collision_normal(-Vec3::X);
        t.validate_transition(TransitionState::Collided);
        assert_eq!(t.info.frames_stationary_fall, 3);
        assert!(t.info.contact.valid && !t.info.contact.is_water);
        assert_eq!(t.info.contact.cell, LAND);
        let expected = if contact { -Vec3::X } else { Vec3::Z };
        assert_eq!(t.info.collision.get(), Some(expected));
        assert_eq!(t.info.collided_with_environment, !contact);
    }
}

#[test]
fn s5_11_8_the_last_known_plane_is_the_contact_plane_or_invalid() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(3.0), AT);
    let plane = on_plane(Vec3::Z, -4.0).contact.unwrap();
    t.info.set_contact(plane.plane, true, CellId(0xA9B4_0002));
    t.path.add_offset_to_check_pos(v(0.1, 0.0, 0.0));
    t.validate_transition(TransitionState::Ok);
    let last = t.info.last_known;
    assert_eq!(
        (last.valid, last.plane, last.is_water, last.cell),
        (true, plane.plane, true, CellId(0xA9B4_0002))
    );
    t.info.clear_contact_plane();
    t.path.add_offset_to_check_pos(v(0.1, 0.0, 0.0));
    t.validate_transition(TransitionState::Ok);
    // Invalid, but still there for slides (5.12.3).
    assert_eq!(
        (t.info.last_known.valid, t.info.last_known.plane),
        (false, plane.plane)
    );
    assert!(!t.object.is(ObjectState::CONTACT | ObjectState::ON_WALKABLE));
}

#[test]
fn s5_11_5_an_invalid_insertion_stays_invalid() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &Carried::default(), AT);
    t.path.add_offset_to_check_pos(v(0.1, 0.0, 0.0));
    assert_eq!(
        t.validate_transition(TransitionState::Invalid),
        TransitionState::Invalid
    );
    assert_eq!(t.path.curr_pos.origin(), AT);
    assert!(!t.info.collision.valid && t.path.check_pos.origin() != AT);
}

#[test]
fn s5_12_4_the_crease_need_not_be_a_unit_vector() {
    // A floor that rises towards the wall: |n x P| = 0.8.
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_plane(v(-0.6, 0.0, 0.8), 100.0), AT);
    t.path.add_offset_to_check_pos(v(0.2, 0.1, 0.0));
    assert_eq!(t.slide_sphere(0, -Vec3::X), TransitionState::Slid);
    assert!(
        close(t.path.check_pos.origin(), v(12.0, 12.1, 5.0)),
        "{}",
        t.path.check_pos.origin()
    );
}

#[test]
fn s5_12_the_head_slides_by_its_own_movement() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(5.0), AT);
    t.path.add_offset_to_check_pos(v(0.2, 0.1, 0.0));
    assert_eq!(t.slide_sphere(1, -Vec3::X), TransitionState::Slid);
    assert!(
        close(t.path.check_pos.origin(), v(12.0, 12.1, 5.0)),
        "{}",
        t.path.check_pos.origin()
    );
}

#[test]
fn s5_12_slides_know_the_landblock_of_the_accepted_pose() {
    // From x = 191.9 to x = 192.1, which is 0.1 in the next landblock.
    for (n, ts, expected) in [
        (Vec3::ZERO, TransitionState::Adjusted, 0.0),
        (-Vec3::X, TransitionState::Slid, -0.1),
    ] {
        let mut rig = Rig::with_turned_faces(AT, Quat::IDENTITY, &[level([1.0, 2.0], [1.0, 2.0], 9.0)]);
        let from = rig.stand(v(191.9, 12.0, 5.0));
        let mut t = rig.transition_at(&walker(), &on_level(5.0), &from);
        let east = CellId(0xAAB4_0001);
        let cell = t.cell_ref(east);
        t.path.set_check_pos(
            Pose {
                cell: east,
                origin: v(0.1, 12.1, 5.0).into(),
            },
            cell,
        );
        assert_eq!(t.slide_sphere(0, n), ts);
        assert!(
            (t.path.check_pos.origin().x - expected).abs() < 1e-4,
            "{}",
            t.path.check_pos.origin()
        );
    }
}

#[test]
fn s5_12_step_up_slide_keeps_to_the_last_known_plane() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(5.0), AT);
    // A contact plane that is another one.
    t.info.set_contact(
        on_plane(v(0.0, -0.6, 0.8), 0.0).contact.unwrap().plane,
        false,
        LAND,
    );
    t.path.step_up = true;
    t.path.step_up_normal = -Vec3::X;
    t.path.add_offset_to_check_pos(v(0.2, 0.1, 0.0));
    assert_eq!(t.step_up_slide(), TransitionState::Slid);
    assert!(!t.info.contact.valid && !t.path.step_up);
    assert!(
        close(t.path.check_pos.origin(), v(12.0, 12.1, 5.0)),
        "{}",
        t.path.check_pos.origin()
    );
}

#[test]
fn s3_5_a_move_of_nothing_turns_at_once_and_a_longer_one_by_steps() {
    let quarter = Quat::from_xyzw(
        0.0,
        0.0,
        core::f32::consts::FRAC_1_SQRT_2,
        core::f32::consts::FRAC_1_SQRT_2,
    );
    let mut rig = Rig::flat();
    let from = rig.stand(AT);
    let mut sweep = |by: f32, free: bool| {
        let mut mover = walker();
        mover.state.set(ObjectState::FREE_ROTATE, free);
        let mut to = from;
        to.frame.origin.x += by;
        to.frame.set_rotation(quarter);
        let state = Carried::default();
        let swept = crate::sweep::sweep(
            &rig.world,
            &rig.population,
            &mut rig.scratch,
            &mover,
            &state,
            &from,
            &to,
        );
        swept.unwrap().position.frame.rotation()
    };
    for free in [true, false] {
        for by in [0.0, 0.3, 1.9] {
            let reached = sweep(by, free);
            assert!((reached.z - quarter.z).abs() < 1e-5, "{free} {by}: {reached}");
        }
    }
}

#[test]
fn s3_5_a_rejected_step_does_not_turn_unless_it_may_freely() {
    let turn = Quat::from_xyzw(0.0, 0.0, 0.6, 0.8);
    for free in [true, false] {
        let mut rig = Rig::with_faces(&[wall_facing_west(12.6, [4.0, 20.0], [4.0, 9.0])]);
        let mut mover = walker();
        mover.state.set(ObjectState::FREE_ROTATE, free);
        let from = rig.stand(AT);
        let mut to = from;
        to.frame.origin.x += 0.3;
        to.frame.set_rotation(turn);
        let state = Carried::default();
        let swept = crate::sweep::sweep(
            &rig.world,
            &rig.population,
            &mut rig.scratch,
            &mover,
            &state,
            &from,
            &to,
        );
        let swept = swept.unwrap();
        assert_eq!(swept.position.origin(), AT);
        assert!((swept.position.frame.rotation().z - if free { 0.6 } else { 0.0 }).abs() < 1e-5);
    }
}
