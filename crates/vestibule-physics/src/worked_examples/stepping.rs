//! `transition.md` 11.3: stepping up and down, and edges.

use glam::Vec3;

use crate::constants::FLOOR_Z;
use crate::flags::ObjectState;
use crate::rig::*;
use crate::sweep::Carried;

/// A walker on the ground at (11, 12) that walks 0.3 m east, over the top of a polygon at height `h`.
fn step_onto(h: f32, carried: &Carried) -> f32 {
    let mut rig = Rig::with_faces(&[level([11.0, 16.0], [8.0, 16.0], h)]);
    let swept = rig.sweep(&walker(), carried, v(11.0, 12.0, 0.0), v(11.3, 12.0, 0.0));
    assert!(swept.ok);
    swept.position.origin().z
}

#[test]
fn w15_step_up_onto_polygons() {
    for (h, z) in [(0.3, 0.3), (0.5, 0.5), (0.6, 0.6), (0.7, 0.7), (0.85, 0.85)] {
        let reached = step_onto(h, &on_level(0.0));
        assert!((reached - z).abs() < 1e-3, "{h}: {reached}");
    }
    for h in [0.95, 0.97] {
        assert!(step_onto(h, &on_level(0.0)).abs() < 1e-3, "{h}");
    }
}

/// A step down of a walker at (12, 12, 0) to a polygon `h` below, over ground 10 m below.
fn step_down_to(h: f32) -> Option<f32> {
    let mut rig = Rig::with_faces(&[level([4.0, 20.0], [4.0, 20.0], 10.0 - h)]);
    let mut t = rig.transition(&walker(), &on_level(10.0), v(12.0, 12.0, 10.0));
    t.info.clear_contact_plane();
    t.object.state.set(ObjectState::EDGE_SLIDE, false);
    t.path.walkable_allowance = FLOOR_Z;
    let found = t.step_down(0.75, FLOOR_Z) || t.step_down(0.75, FLOOR_Z);
    found.then_some(t.path.check_pos.origin().z - 10.0)
}

#[test]
fn w16_step_down_in_two_halves() {
    for h in [0.10, 0.50, 0.749, 0.76, 1.40] {
        let z = step_down_to(h).unwrap_or(f32::NAN);
        assert!((z + h).abs() < 1e-3, "{h}: {z}");
    }
    assert_eq!(step_down_to(1.51), None);
}

#[test]
fn w17_step_down_to_terrain() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &on_level(0.3), v(12.0, 12.0, 0.3));
    t.info.clear_contact_plane();
    assert!(t.step_down(0.75, FLOOR_Z));
    assert!(t.path.check_pos.origin().z.abs() < 1e-5);
    assert!(near(t.path.walk_interp, 0.4));
    assert_eq!(t.info.contact.plane.normal, Vec3::Z);
}

#[test]
fn w18_walkable_threshold() {
    for (degrees, walkable) in [(40.0f32, true), (48.0, true), (49.0, false)] {
        assert_eq!(
            crate::object_info::is_walkable_z(libm::cosf(degrees.to_radians())),
            walkable
        );
    }
    assert!(crate::object_info::is_walkable_z(0.664_174_14));
}

fn platform() -> Rig {
    Rig::with_faces(&[level([10.0, 12.0], [11.0, 13.0], 5.0)])
}

#[test]
fn w19_without_edge_slide_a_walker_walks_off() {
    let mut mover = walker();
    mover.state = ObjectState::NONE;
    let swept = platform().sweep(&mover, &on_level(5.0), v(11.95, 12.0, 5.0), v(12.42, 12.0, 5.0));
    assert!(swept.ok && swept.contact.is_none() && !swept.on_walkable);
    assert!(close(swept.position.origin(), v(12.42, 12.0, 5.0)));
    // Nearer the edge the sphere still finds it, lowered as it is.
    let swept = platform().sweep(&mover, &on_level(5.0), v(11.95, 12.0, 5.0), v(12.3, 12.0, 5.0));
    assert!(swept.on_walkable);
}

#[test]
fn w20_with_edge_slide_a_walker_slides_along_the_edge() {
    let swept = platform().sweep(&walker(), &on_level(5.0), v(11.95, 12.0, 5.0), v(12.3, 12.2, 5.0));
    assert!(swept.ok && swept.on_walkable);
    assert!(
        (swept.position.origin() - v(11.95, 12.2, 5.0)).length() < 1e-3,
        "{}",
        swept.position.origin()
    );
    assert_eq!(swept.collision_normal, Some(-Vec3::X));
}

#[test]
fn w20b_a_walker_may_overhang_by_a_quarter() {
    for (x, accepted) in [(12.2, true), (12.23, true), (12.25, false)] {
        let swept = platform().sweep(&walker(), &on_level(5.0), v(11.95, 12.0, 5.0), v(x, 12.2, 5.0));
        assert_eq!((swept.position.origin().x - x).abs() < 1e-3, accepted, "{x}");
        assert!(swept.on_walkable);
    }
}

#[test]
fn s5_10_5_an_edge_is_found_by_looking_back() {
    // A small platform, approached so fast that both half steps find nothing below.
    let mut rig = Rig::with_faces(&[level([10.0, 12.0], [11.0, 13.0], 5.0)]);
    let swept = rig.sweep(
        &walker(),
        &on_level(5.0),
        v(11.95, 12.0, 5.0),
        v(12.42, 12.0, 5.0),
    );
    // Head on, the slide is too short to count: the walker stays.
    assert!(swept.ok && swept.on_walkable);
    assert!(
        (swept.position.origin() - v(11.95, 12.0, 5.0)).length() < 1e-3,
        "{}",
        swept.position.origin()
    );
    let swept = rig.sweep(
        &walker(),
        &on_level(5.0),
        v(11.95, 12.0, 5.0),
        v(12.40, 12.15, 5.0),
    );
    assert!(
        (swept.position.origin() - v(11.95, 12.15, 5.0)).length() < 1e-3,
        "{}",
        swept.position.origin()
    );
}

#[test]
fn s5_4_a_falling_body_lands_on_a_platform() {
    let mut rig = platform();
    let swept = rig.sweep(
        &walker(),
        &Carried::default(),
        v(11.0, 12.0, 5.2),
        v(11.0, 12.0, 4.9),
    );
    assert!(swept.ok && swept.on_walkable, "{swept:?}");
    assert!((swept.position.origin().z - 5.0).abs() < 1e-3);
    // Onto a wall it does not land.
    let mut rig = Rig::with_faces(&[wall_facing_west(12.0, [8.0, 16.0], [0.0, 8.0])]);
    let swept = rig.sweep(
        &walker(),
        &Carried::default(),
        v(11.4, 12.0, 4.0),
        v(11.6, 12.0, 3.9),
    );
    assert!(
        swept.contact.is_none() && swept.collision_normal == Some(-Vec3::X),
        "{swept:?}"
    );
    assert_eq!(swept.position.origin(), v(11.4, 12.0, 4.0));
}
