//! 5.7 to 5.9: stepping up, stepping down and asking for ground.

use crate::constants::{FLOOR_Z, Z_FOR_LANDING};
use crate::flags::ObjectState;
use crate::rig::*;
use crate::settings::Settings;
use crate::sweep::{Carried, Mover};
use glam::Vec3;
use vestibule_world::Sphere;

/// In contact with a plane at 5 m that may or may not be walkable.
fn touching(on_walkable: bool) -> Carried {
    Carried {
        on_walkable,
        ..on_level(5.0)
    }
}

/// A ceiling that faces down at this height.
fn ceiling(z: f32) -> Vec<Vec3> {
    let mut face = level([8.0, 16.0], [8.0, 16.0], z);
    face.reverse();
    face
}

#[test]
fn s5_7_stepping_up_forgets_the_contact_plane() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &touching(true), v(12.0, 12.0, 5.0));
    assert!(t.info.contact.valid && !t.step_up(-Vec3::X));
    assert!(!t.info.contact.valid && !t.path.step_up);
    assert_eq!(t.path.step_up_normal, -Vec3::X);
    assert_eq!(t.path.check_pos.origin(), v(12.0, 12.0, 5.0));
}

#[test]
fn s5_7_how_high_and_onto_what_depends_on_the_ground_left() {
    for (on_walkable, expected) in [(true, (0.6, FLOOR_Z)), (false, (0.04, Z_FOR_LANDING))] {
        let mut rig = Rig::flat();
        let mut t = rig.transition(&walker(), &touching(on_walkable), v(12.0, 12.0, 5.0));
        t.step_up(-Vec3::X);
        assert_eq!((t.path.step_down_amt, t.path.walkable_allowance), expected);
    }
}

#[test]
fn w15_off_walkable_ground_a_step_is_at_most_six_centimetres() {
    for (h, onto) in [(0.05, true), (0.07, false)] {
        let mut rig = Rig::with_faces(&[level([8.0, 16.0], [8.0, 16.0], 5.0 + h)]);
        let mut t = rig.transition(&walker(), &touching(false), v(12.0, 12.0, 5.0));
        assert_eq!(t.step_up(-Vec3::X), onto, "{h}");
    }
}

#[test]
fn s5_7_a_step_up_that_fails_puts_the_candidate_back() {
    // Room to lift the foot onto the step, but none for the head.
    let step = level([11.0, 16.0], [8.0, 16.0], 5.5);
    for (height, ok) in [(6.9, false), (7.5, true)] {
        let mut rig = Rig::with_faces(&[step.clone(), ceiling(height)]);
        let mut t = rig.transition(&walker(), &touching(true), v(11.3, 12.0, 5.0));
        assert_eq!(t.step_up(-Vec3::X), ok);
        let lifted = t.path.check_pos.origin() - v(11.3, 12.0, 5.0);
        assert!(
            if ok {
                (lifted.z - 0.5).abs() < 1e-4
            } else {
                lifted == Vec3::ZERO
            },
            "{lifted}"
        );
        assert!(t.path.walkable.is_none());
    }
}

#[test]
fn s5_8_stepping_up_does_not_ask_whether_there_is_an_edge() {
    // The foot's centre is 0.3 m before the step, farther than half its radius, and there is nothing below.
    let mut rig = Rig::with_faces(&[level([11.6, 16.0], [8.0, 16.0], 5.3)]);
    let mut t = rig.transition(&walker(), &touching(true), v(11.3, 12.0, 5.0));
    assert!(t.step_up(-Vec3::X));
    // Stepping down does.
    let mut t = rig.transition(&walker(), &touching(true), v(11.3, 12.0, 5.4));
    assert!(!t.step_down(0.3, FLOOR_Z));
    let mut careless = walker();
    careless.state = ObjectState::NONE;
    let mut t = rig.transition(&careless, &touching(true), v(11.3, 12.0, 5.4));
    assert!(t.step_down(0.3, FLOOR_Z));
}

#[test]
fn s5_8_stepping_down_forgets_what_was_overlapped() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &touching(true), v(12.0, 12.0, 5.0));
    t.path.set_neg_poly_hit(true, Vec3::X);
    t.info.clear_contact_plane();
    assert!(!t.step_down(0.5, FLOOR_Z));
    assert!(t.path.neg_poly_hit.is_none() && !t.path.step_down);
    // Nothing is put back: the callers do that.
    assert!((t.path.check_pos.origin().z - 4.5).abs() < 1e-5);
}

#[test]
fn s5_8_the_ground_must_be_level_enough_and_just_level_enough_will_do() {
    let mut careless = walker();
    careless.state = ObjectState::NONE;
    let down = |z: f32| {
        // 48 m over 24 m: N.z = 0.447.
        let mut rig = Rig::slope(48);
        let mut t = rig.transition(&careless, &on_level(24.2), v(12.0, 6.0, 24.2));
        t.info.clear_contact_plane();
        let found = t.step_down(0.5, z);
        (found, t.info.contact.plane.normal.z)
    };
    let (_, z) = down(Z_FOR_LANDING);
    assert!((z - 0.447).abs() < 1e-3);
    let above = f32::from_bits(z.to_bits() + 1);
    assert_eq!(
        (down(Z_FOR_LANDING).0, down(z).0, down(above).0, down(FLOOR_Z).0),
        (true, true, false, false)
    );
}

#[test]
fn s5_8_ground_under_a_low_ceiling_is_none() {
    // A walker of 1.835 m comes down onto a floor with 1.7 m over it.
    for (height, found) in [(6.7, false), (7.2, true)] {
        let mut rig = Rig::with_faces(&[level([8.0, 16.0], [8.0, 16.0], 5.0), ceiling(height)]);
        let mut t = rig.transition(&walker(), &on_level(5.2), v(12.0, 12.0, 5.2));
        t.info.clear_contact_plane();
        assert_eq!(t.step_down(0.5, FLOOR_Z), found);
    }
}

/// Whether there is ground at `at` over a platform at 5 m that ends at x = 12, for a mover that last stood on it
/// somewhere else entirely.
fn ground_at(mover: &Mover, carried: &Carried, at: Vec3) -> bool {
    let mut rig = Rig::with_faces(&[level([10.0, 12.0], [10.0, 14.0], 5.0)]);
    let mut t = rig.transition(mover, carried, at);
    stand_on_polygon(&mut t);
    if let Some(walkable) = &mut t.path.walkable {
        walkable.check_pos.center.x += 50.0;
    }
    let found = t.check_walkable(0.5);
    assert!(!t.path.check_walkable && t.path.check_pos.origin() == at);
    assert!(!t.object.is(ObjectState::ON_WALKABLE) || t.path.walkable_allowance == 0.5);
    found
}

#[test]
fn s5_9_ground_is_looked_for_below_in_one_probe() {
    let stands = on_level(5.0);
    assert!(ground_at(&walker(), &stands, v(11.0, 12.0, 5.0)));
    // Beyond the edge by less and by more than half the radius.
    assert!(ground_at(&walker(), &stands, v(12.2, 12.0, 5.0)));
    assert!(!ground_at(&walker(), &stands, v(12.3, 12.0, 5.0)));
    // 1.5 m is more than two radii: the probe is half of that, and touches 1.22 m below.
    assert!(ground_at(&walker(), &stands, v(11.0, 12.0, 5.7)));
    assert!(!ground_at(&walker(), &stands, v(11.0, 12.0, 5.8)));
    assert!(!ground_at(&walker(), &stands, v(11.0, 12.0, 6.5)));
}

#[test]
fn s5_9_a_mover_of_one_sphere_probes_half_a_radius() {
    let ball = Mover::new(&[Sphere::new(v(0.0, 0.0, 0.3), 0.3)])
        .unwrap()
        .with_steps(0.5, 1.0);
    assert!(ground_at(&ball, &on_level(5.0), v(11.0, 12.0, 5.1)));
    assert!(!ground_at(&ball, &on_level(5.0), v(11.0, 12.0, 5.2)));
}

#[test]
fn s5_9_who_does_not_stand_needs_no_ground() {
    assert!(ground_at(&walker(), &Carried::default(), v(15.0, 12.0, 5.0)));
    assert!(ground_at(&walker(), &touching(false), v(15.0, 12.0, 5.0)));
    assert!(!ground_at(&walker(), &on_level(5.0), v(15.0, 12.0, 5.0)));
}

#[test]
fn s5_9_steep_polygons_are_no_ground() {
    // 60° against an allowance of 0.5, which is exclusive, and 45°.
    for (rise, ground) in [(1.75, false), (1.0, true)] {
        let ramp = vec![
            v(10.0, 10.0, 5.0),
            v(12.0, 10.0, 5.0 + 2.0 * rise),
            v(12.0, 14.0, 5.0 + 2.0 * rise),
            v(10.0, 14.0, 5.0),
        ];
        let mut rig = Rig::with_faces(&[ramp]);
        let mut t = rig.transition(&walker(), &on_level(0.0), v(11.0, 12.0, 5.0 + rise));
        stand_on_polygon(&mut t);
        if let Some(walkable) = &mut t.path.walkable {
            walkable.check_pos.center.x += 50.0;
        }
        assert_eq!(t.check_walkable(0.5), ground);
    }
}

#[test]
fn s2_2_13_the_polygon_last_stood_on_supports_whoever_it_was_chosen_for() {
    let mut rig = Rig::with_faces(&[level([10.0, 12.0], [10.0, 14.0], 5.0)]);
    let mut t = rig.transition(&walker(), &on_level(5.0), v(11.0, 12.0, 5.0));
    stand_on_polygon(&mut t);
    // Not where the candidate is: where it was when the polygon was chosen.
    t.path.add_offset_to_check_pos(v(5.0, 0.0, 0.0));
    assert!(t.check_walkable(FLOOR_Z));
    // Without a polygon nothing is asked.
    t.path.walkable = None;
    assert!(t.check_walkable(FLOOR_Z));
}

#[test]
fn s2_2_13_each_question_halves_the_radius_for_good() {
    for (persistent, radii) in [(true, [0.24, 0.12]), (false, [0.48, 0.48])] {
        let mut rig = Rig::with_faces(&[level([10.0, 12.0], [10.0, 14.0], 5.0)]).with_settings(Settings {
            persistent_walkable_halving: persistent,
            ..Settings::RETAIL
        });
        let mut t = rig.transition(&walker(), &on_level(5.0), v(12.2, 12.0, 5.0));
        stand_on_polygon(&mut t);
        for radius in radii {
            t.check_walkable(FLOOR_Z);
            assert!(near(t.path.walkable.unwrap().check_pos.radius, radius));
        }
    }
}
