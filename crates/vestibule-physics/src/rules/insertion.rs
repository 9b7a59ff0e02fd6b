//! 5.1 to 5.6: inserting the candidate into its cell and the cells around it.

use glam::Vec3;
use vestibule_world::{CellId, Plane, Sphere};

use crate::constants::{FLOOR_Z, Z_FOR_LANDING};
use crate::flags::ObjectState;
use crate::rig::*;
use crate::sweep::{Carried, Mover};
use crate::transition::{InsertType, Transition, TransitionState};

const AT: Vec3 = Vec3::new(12.0, 12.0, 5.0);

/// A wall that only heads meet: it begins 1 m over the feet at 5 m.
fn lintel() -> Vec<Vec3> {
    wall_facing_west(12.6, [8.0, 16.0], [6.2, 9.0])
}

/// A walker that went 0.2 m east and 0.1 m north to `at`.
fn went<'r>(rig: &'r mut Rig, mover: &Mover, carried: &Carried, at: Vec3) -> Transition<'r, 'r> {
    let g = v(0.2, 0.1, 0.0);
    let mut t = rig.transition(mover, carried, at - g);
    t.path.add_offset_to_check_pos(g);
    t
}

#[test]
fn s5_1_whatever_is_not_ok_forgets_the_overlapped_polygon() {
    let neg = |t: &mut Transition<'_, '_>| {
        t.path.set_neg_poly_hit(true, Vec3::X);
        let ts = t.transitional_insert(1);
        (ts, t.path.neg_poly_hit.is_some(), t.path.step_up_normal)
    };
    // Adjusted by the ground, collided with water, slid along a wall.
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(0.0), v(12.0, 12.0, -0.05));
    assert_eq!(neg(&mut t), (TransitionState::Adjusted, false, Vec3::ZERO));
    let mut builder = records::Builder::new(BLOCK);
    builder.terrain = [0x14 << 2; 81];
    let mut rig = Rig::of(builder);
    let mut t = rig.transition(&walker(), &on_level(0.0), v(3.0, 2.0, 1.0));
    assert_eq!(neg(&mut t), (TransitionState::Collided, false, Vec3::ZERO));
    let mut rig = Rig::with_faces(&[lintel()]);
    let mut t = went(&mut rig, &walker(), &on_level(5.0), v(12.3, 12.0, 5.0));
    assert_eq!(neg(&mut t), (TransitionState::Slid, false, Vec3::ZERO));
}

#[test]
fn s5_1_other_cells_that_answer_forget_it_too() {
    // The candidate's low point is over the next land cell, in the ground there.
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(0.0), v(24.2, 12.0, -0.05));
    t.path.set_neg_poly_hit(true, Vec3::X);
    assert_eq!(t.transitional_insert(1), TransitionState::Adjusted);
    assert!(t.path.neg_poly_hit.is_none());
}

#[test]
fn s5_2_a_slide_loses_the_contact_plane() {
    let mut rig = Rig::with_faces(&[lintel()]);
    let mut t = went(&mut rig, &walker(), &on_level(5.0), v(12.3, 12.0, 5.0));
    let cell = t.path.check_cell;
    assert_eq!(t.insert_into_cell(cell, 1), TransitionState::Slid);
    assert!(!t.info.contact.valid);
    assert_eq!(t.insert_into_cell(None, 3), TransitionState::Collided);
}

#[test]
fn s5_3_a_slide_in_another_cell_loses_the_contact_plane() {
    let mut rig = Rig::with_faces(&[lintel()]);
    // Over the border of two land cells, so that there is another one.
    let face = wall_facing_west(24.3, [8.0, 16.0], [6.2, 9.0]);
    rig = Rig::with_turned_faces(v(24.0, 12.0, 5.0), glam::Quat::IDENTITY, &[face])
        .with_settings(*rig.population.settings());
    let mut t = went(&mut rig, &walker(), &on_level(5.0), v(23.95, 12.0, 5.0));
    let own = t.path.check_cell;
    assert_eq!(t.check_other_cells(own), TransitionState::Slid);
    assert!(!t.info.contact.valid);
}

#[test]
fn s5_3_the_own_cell_is_not_asked_again_and_the_others_are() {
    // In the ground of the own cell.
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(0.0), v(12.0, 12.0, -0.05));
    let own = t.path.check_cell;
    assert_eq!(t.check_other_cells(own), TransitionState::Ok);
    assert_eq!(t.path.check_pos.origin().z, -0.05);
    // In the ground of another.
    let mut t = rig.transition(&walker(), &on_level(0.0), v(24.2, 12.0, -0.05));
    let own = t.path.check_cell;
    assert_eq!(t.check_other_cells(own), TransitionState::Adjusted);
}

#[test]
fn s5_3_3_the_candidate_is_re_based_to_the_cell_that_holds_it() {
    let mut rig = Rig::with_turned_faces(AT, glam::Quat::IDENTITY, &[lintel()]);
    let mut t = rig.transition(&walker(), &Carried::default(), v(192.5, 12.0, 5.0));
    let own = t.path.check_cell;
    assert_eq!(t.check_other_cells(own), TransitionState::Ok);
    let east = CellId(0xAAB4_0001);
    assert_eq!(
        (t.path.check_pos.cell, t.path.check_cell.unwrap().id()),
        (east, east)
    );
    assert!(close(t.path.check_pos.origin(), v(0.5, 12.0, 5.0)));
    assert!(close(t.path.center(1), v(0.5, 12.0, 6.355)));
}

#[test]
fn s5_3_4_leaving_the_loaded_world_is_fine_but_in_a_step_down() {
    for (step_down, ts) in [(false, TransitionState::Ok), (true, TransitionState::Collided)] {
        let mut rig = Rig::flat();
        // There is no landblock to the west.
        let mut t = rig.transition(&walker(), &on_level(5.0), v(-1.0, 12.0, 5.0));
        t.path.step_down = step_down;
        let own = t.path.check_cell;
        assert_eq!(t.check_other_cells(own), ts);
        assert!(t.path.check_cell.is_none());
        if !step_down {
            assert_eq!(t.path.check_pos.cell, CellId(0xA8B4_0039));
            assert!(close(t.path.check_pos.origin(), v(191.0, 12.0, 5.0)));
        }
    }
    // The end of the map is the end.
    let mut builder = records::Builder::new(0x00B4);
    builder.flat_block(BLOCK);
    let mut rig = Rig::of(builder);
    let at = vestibule_world::Position::new(CellId(0x00B4_0001), v(-1.0, 12.0, 5.0));
    let mut t = rig.transition_at(&walker(), &Carried::default(), &at);
    let own = t.path.check_cell;
    assert_eq!(t.check_other_cells(own), TransitionState::Collided);
}

#[test]
fn s5_1_no_ground_is_looked_for_outside_the_loaded_world() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(5.0), v(-1.0, 12.0, 5.0));
    t.info.clear_contact_plane();
    assert_eq!(t.transitional_insert(3), TransitionState::Ok);
    assert!(t.path.check_cell.is_none());
    // Nor without a cell to begin with.
    assert_eq!(t.transitional_insert(3), TransitionState::Ok);
}

#[test]
fn s5_1_no_attempts_are_invalid() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(5.0), AT);
    assert_eq!(t.transitional_insert(0), TransitionState::Invalid);
}

/// What the insertion of a walker with these bits, in the air at 5 m, makes of a polygon that it overlaps.
fn overlapping(
    rig: &mut Rig,
    foot: bool,
    prepare: impl Fn(&mut Transition<'_, '_>),
) -> (TransitionState, Vec3, Vec3) {
    let mut t = went(rig, &walker(), &on_level(5.0), AT);
    // The normal of the polygon is +X: what is stepped over or slid along is its back.
    t.path.set_neg_poly_hit(foot, Vec3::X);
    prepare(&mut t);
    let sub_mode = t.path.step_down || t.path.step_up;
    let ts = t.transitional_insert(1);
    assert_eq!(t.path.neg_poly_hit.is_some(), sub_mode);
    (ts, t.path.check_pos.origin() - AT, t.path.step_up_normal)
}

#[test]
fn s5_5_a_polygon_overlapped_by_the_foot_is_stepped_over_or_slid_along() {
    // Nothing to step onto: along its back, with the contact plane lost.
    let (ts, moved, tried) = overlapping(&mut Rig::flat(), true, |_| {});
    assert_eq!((ts, tried), (TransitionState::Slid, -Vec3::X));
    assert!(close(moved, v(-0.2, 0.0, 0.0)), "{moved}");
    // A step of 0.3 m: up, and the insertion goes on.
    let mut rig = Rig::with_faces(&[level([8.0, 16.0], [8.0, 16.0], 5.3)]);
    let mut t = went(&mut rig, &walker(), &on_level(5.0), AT);
    let cell = t.path.check_cell;
    // Its test of the cell would step up by itself: only the branch is looked at here.
    t.path.set_neg_poly_hit(true, Vec3::X);
    t.object.state.set(ObjectState::CONTACT, true);
    let _ = cell;
    let stepped = t.transitional_insert(1);
    assert_eq!(stepped, TransitionState::Ok);
    assert!((t.path.check_pos.origin().z - 5.3).abs() < 1e-4);
}

#[test]
fn s5_5_a_polygon_overlapped_by_the_head_is_slid_along_only() {
    let (ts, moved, tried) = overlapping(&mut Rig::flat(), false, |_| {});
    assert_eq!((ts, tried), (TransitionState::Slid, Vec3::ZERO));
    assert!(close(moved, v(-0.2, 0.0, 0.0)), "{moved}");
}

#[test]
fn s5_5_not_while_stepping() {
    for down in [true, false] {
        let (ts, moved, tried) = overlapping(&mut Rig::flat(), true, |t| {
            (t.path.step_down, t.path.step_up) = (down, !down);
        });
        assert_eq!((ts, moved, tried), (TransitionState::Ok, Vec3::ZERO, Vec3::ZERO));
    }
}

/// Ends a landing of a walker that met something with the normal (0, 0.6, 0.8) at 5.2 m and is now at 5 m.
fn landing<'r>(rig: &'r mut Rig, carried: &Carried, contact: bool) -> (TransitionState, Transition<'r, 'r>) {
    let mut t = rig.transition(&walker(), carried, v(12.0, 12.0, 5.2));
    t.object.state = ObjectState::NONE;
    t.path.set_collide(v(0.0, 0.6, 0.8));
    t.path.add_offset_to_check_pos(v(0.0, 0.0, -0.2));
    t.info.clear_contact_plane();
    if contact {
        let plane = Plane {
            normal: Vec3::Z,
            d: -5.0,
        };
        t.info.set_contact(plane, false, LAND);
    }
    let ts = t.transitional_insert(3);
    assert!(!t.path.collide && t.path.walkable.is_none() && t.path.insert_type == InsertType::Transition);
    (ts, t)
}

#[test]
fn s5_4_with_ground_and_room_the_body_has_landed() {
    let mut rig = Rig::flat();
    let (ts, t) = landing(&mut rig, &Carried::default(), true);
    assert_eq!((ts, t.info.contact.valid), (TransitionState::Ok, true));
    assert_eq!(t.path.check_pos.origin(), v(12.0, 12.0, 5.0));
    assert!(!t.info.collision.valid);
}

#[test]
fn s5_4_without_ground_it_is_thrown_back_to_where_it_hit() {
    let mut rig = Rig::flat();
    let (ts, t) = landing(&mut rig, &Carried::default(), false);
    assert_eq!((ts, t.info.contact.valid), (TransitionState::Collided, false));
    assert_eq!(t.path.check_pos.origin(), v(12.0, 12.0, 5.2));
    // It never stood: what it hit is named and its velocity kept.
    assert_eq!(
        (t.info.collision.get(), t.info.velocity_killed),
        (Some(v(0.0, 0.6, 0.8)), false)
    );
}

#[test]
fn s5_4_3_who_stood_before_loses_its_velocity_instead() {
    let carried = Carried {
        contact: None,
        last_known: on_level(5.0).contact,
        ..Carried::default()
    };
    let mut rig = Rig::flat();
    let (ts, t) = landing(&mut rig, &carried, false);
    assert_eq!(ts, TransitionState::Collided);
    assert!(t.info.velocity_killed && !t.info.last_known.valid && !t.info.collision.valid);
}

#[test]
fn s5_4_without_room_it_has_not_landed() {
    let mut rig = Rig::with_faces(&[wall_facing_west(12.2, [8.0, 16.0], [4.0, 9.0])]);
    let (ts, t) = landing(&mut rig, &Carried::default(), true);
    assert_eq!((ts, t.info.contact.valid), (TransitionState::Collided, false));
    assert_eq!(t.path.check_pos.origin(), v(12.0, 12.0, 5.2));
    assert!(t.info.collision.valid);
}

/// The search for ground of a mover over a floor `depth` below its feet at 5 m, over ground far below.
fn ground_below(mover: &Mover, on_walkable: bool, depth: f32) -> (TransitionState, bool, f32) {
    let mut rig = Rig::with_faces(&[level([4.0, 20.0], [4.0, 20.0], 5.0 - depth)]);
    let carried = Carried {
        on_walkable,
        ..on_level(5.0)
    };
    let mut careless = *mover;
    careless.state = ObjectState::NONE;
    let mut t = rig.transition(&careless, &carried, AT);
    t.info.clear_contact_plane();
    let ts = t.transitional_insert(3);
    let (contact, fell) = (t.info.contact.valid, 5.0 - t.path.check_pos.origin().z);
    let expected = if on_walkable { FLOOR_Z } else { Z_FOR_LANDING };
    assert_eq!(t.path.walkable_allowance, expected);
    (ts, contact, fell)
}

#[test]
fn s5_6_ground_is_found_down_to_the_step_down_height_and_no_farther() {
    for depth in [0.02, 0.3, 0.74, 0.8, 1.4, 1.49] {
        let (ts, contact, fell) = ground_below(&walker(), true, depth);
        assert_eq!((ts, contact), (TransitionState::Ok, true), "{depth}");
        assert!((fell - depth).abs() < 1e-3);
    }
    // What was not found leaves the candidate where it was.
    for depth in [1.51, 1.8, 2.2, 3.0] {
        assert_eq!(
            ground_below(&walker(), true, depth),
            (TransitionState::Ok, false, 0.0),
            "{depth}"
        );
    }
}

#[test]
fn s5_6_off_walkable_ground_the_search_is_short() {
    assert!(ground_below(&walker(), false, 0.03).1);
    assert_eq!(
        ground_below(&walker(), false, 0.05),
        (TransitionState::Ok, false, 0.0)
    );
}

#[test]
fn s5_6_3_one_sphere_searches_half_a_radius() {
    // 2r = 0.6 < 1: h = 0.15.
    let ball = Mover::new(&[Sphere::new(v(0.0, 0.0, 0.3), 0.3)])
        .unwrap()
        .with_steps(0.5, 1.0);
    assert!(ground_below(&ball, true, 0.14).1);
    assert!(!ground_below(&ball, true, 0.17).1);
    // 2r >= h: all of it at once.
    let ball = ball.with_steps(0.5, 0.5);
    assert!(ground_below(&ball, true, 0.45).1);
    assert!(!ground_below(&ball, true, 0.55).1);
}

#[test]
fn s5_6_walkers_take_level_ground_only_and_others_what_one_can_land_on() {
    for on_walkable in [true, false] {
        // N.z = 0.447, 3 cm below.
        let mut rig = Rig::slope(48);
        let carried = Carried {
            on_walkable,
            ..on_level(24.0)
        };
        let mut t = rig.transition(&walker(), &carried, v(12.0, 6.0, 24.03));
        t.info.clear_contact_plane();
        t.transitional_insert(3);
        assert_eq!(t.info.contact.valid, !on_walkable);
    }
}

#[test]
fn s5_1_who_has_no_contact_or_does_not_step_down_needs_no_ground() {
    for tweak in [0, 1, 2] {
        let mut rig = Rig::flat();
        let mut t = rig.transition(&walker(), &on_level(5.0), AT);
        t.info.clear_contact_plane();
        match tweak {
            0 => t.object.step_down = false,
            1 => t.object.state.set(ObjectState::CONTACT, false),
            _ => {}
        }
        // Who needs it and finds none is stopped (5.10, case 5).
        let expected = if tweak == 2 {
            TransitionState::Collided
        } else {
            TransitionState::Ok
        };
        assert_eq!(t.transitional_insert(3), expected, "{tweak}");
        assert_eq!(t.path.check_pos.origin(), AT);
    }
}

#[test]
fn s5_1_contact_ends_the_insertion_without_a_search() {
    let mut rig = Rig::with_faces(&[level([4.0, 20.0], [4.0, 20.0], 4.5)]);
    let mut t = rig.transition(&walker(), &on_level(5.0), AT);
    assert_eq!(t.transitional_insert(3), TransitionState::Ok);
    assert_eq!(t.path.check_pos.origin(), AT);
}
