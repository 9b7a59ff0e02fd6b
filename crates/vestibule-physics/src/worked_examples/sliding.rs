//! `transition.md` 11.4: sliding along walls and from cliffs.

use glam::Vec3;
use vestibule_world::Plane;

use crate::constants::FLOOR_Z;
use crate::rig::*;
use crate::settings::Settings;
use crate::sweep::Carried;
use crate::transition::TransitionState;

/// Slides the foot sphere of a walker that has moved by `g`, with the last plane `floor`.
fn slid(n: Vec3, floor: Option<Vec3>, g: Vec3) -> (TransitionState, Vec3, Option<Vec3>) {
    let mut rig = Rig::flat();
    let carried = floor.map_or(Carried::default(), |n| on_plane(n, 0.0));
    let mut t = rig.transition(&walker(), &carried, v(12.0, 12.0, 5.0));
    t.path.add_offset_to_check_pos(g);
    let before = t.path.check_pos.origin();
    let ts = t.slide_sphere(0, n);
    (ts, t.path.check_pos.origin() - before, t.info.collision.get())
}

#[test]
fn w22_wall_slide() {
    let (ts, offset, n) = slid(-Vec3::X, Some(Vec3::Z), v(0.2, 0.1, 0.0));
    assert_eq!((ts, n), (TransitionState::Slid, Some(-Vec3::X)));
    assert!(close(offset, v(-0.2, 0.0, 0.0)), "{offset}");
}

#[test]
fn w23_head_on_is_blocked() {
    assert_eq!(
        slid(-Vec3::X, Some(Vec3::Z), v(0.2, 0.01, 0.0)).0,
        TransitionState::Collided
    );
    assert_eq!(
        slid(-Vec3::X, Some(Vec3::Z), v(0.2, 0.0140, 0.0)).0,
        TransitionState::Collided
    );
    assert_eq!(
        slid(-Vec3::X, Some(Vec3::Z), v(0.2, 0.0143, 0.0)).0,
        TransitionState::Slid
    );
}

#[test]
fn w24_parallel_on_the_same_side() {
    let (ts, offset, _) = slid(Vec3::Z, Some(Vec3::Z), v(0.1, 0.0, -0.2));
    assert_eq!(ts, TransitionState::Slid);
    assert!(close(offset, v(0.0, 0.0, 0.2)), "{offset}");
}

#[test]
fn w25_wedged() {
    let (ts, offset, n) = slid(-Vec3::Z, Some(Vec3::Z), v(0.1, 0.0, 0.2));
    assert_eq!((ts, offset), (TransitionState::Collided, Vec3::ZERO));
    assert!(close(n.unwrap(), v(-0.447_213_6, 0.0, -0.894_427_2)));
}

#[test]
fn w26_no_plane_ever_known() {
    let (ts, offset, _) = slid(-Vec3::X, None, v(0.3, 0.1, 0.0));
    assert_eq!(ts, TransitionState::Slid);
    assert!(close(offset, v(-0.3, 0.0, 0.0)), "{offset}");
}

#[test]
fn w27_zero_normal() {
    let (ts, offset, n) = slid(Vec3::ZERO, None, v(0.2, 0.0, 0.0));
    assert_eq!((ts, n), (TransitionState::Adjusted, None));
    assert!(close(offset, v(-0.1, 0.0, 0.0)), "{offset}");
}

#[test]
fn s5_12_3_a_slide_uses_the_last_known_plane_after_the_contact_is_cleared() {
    let slide = |settings| {
        let mut rig = Rig::flat().with_settings(settings);
        let mut t = rig.transition(&walker(), &on_level(5.0), v(12.0, 12.0, 5.0));
        t.info.clear_contact_plane();
        t.info.last_known.valid = false;
        t.path.add_offset_to_check_pos(v(0.2, 0.1, -0.05));
        let ts = t.slide_sphere(0, -Vec3::X);
        (ts, t.path.check_pos.origin() - v(12.2, 12.1, 4.95))
    };
    // Along the crease with the stale floor: the fall is lost too.
    let (ts, offset) = slide(Settings::RETAIL);
    assert_eq!(ts, TransitionState::Slid);
    assert!(close(offset, v(-0.2, 0.0, 0.05)), "{offset}");
    let (_, offset) = slide(Settings {
        stale_last_known_plane: false,
        ..Settings::RETAIL
    });
    assert!(close(offset, v(-0.2, 0.0, 0.0)), "{offset}");
}

/// Deflects a walker from a cliff: offset and normal.
fn cliff(plane: Vec3, settings: Settings) -> (Vec3, Option<Vec3>) {
    let mut rig = Rig::flat().with_settings(settings);
    let mut t = rig.transition(&walker(), &on_level(5.0), v(12.0, 12.0, 5.0));
    t.path.save_check_pos();
    t.path.add_offset_to_check_pos(v(0.1, 0.05, 0.0));
    t.path.save_check_pos();
    let before = t.path.check_pos.origin();
    t.info.set_contact(
        Plane {
            normal: plane,
            d: 0.0,
        },
        false,
        LAND,
    );
    let mut ts = TransitionState::Ok;
    // Case 2 of edge sliding.
    assert!(!t.edge_slide(&mut ts, 0.75, FLOOR_Z));
    assert_eq!(ts, TransitionState::Adjusted);
    assert!(!t.info.contact.valid);
    (t.path.check_pos.origin() - before, t.info.collision.get())
}

#[test]
fn w28_cliff_slide_doubles_the_approach_from_behind() {
    let n = v(-0.9, 0.0, 0.4).normalize();
    let (offset, normal) = cliff(n, Settings::RETAIL);
    assert!(close(offset, v(0.1, 0.0, 0.0)) && close(normal.unwrap(), -Vec3::X));
    let (offset, normal) = cliff(v(0.9, 0.0, 0.4).normalize(), Settings::RETAIL);
    assert!(close(offset, v(-0.1, 0.0, 0.0)) && close(normal.unwrap(), -Vec3::X));
    let (offset, _) = cliff(
        n,
        Settings {
            cliff_slide_doubling: false,
            ..Settings::RETAIL
        },
    );
    assert!(close(offset, v(-0.1, 0.0, 0.0)));
}

#[test]
fn w22_a_walker_slides_along_a_wall_and_is_stopped_by_it_head_on() {
    let mut rig = Rig::with_faces(&[wall_facing_west(12.0, [4.0, 20.0], [-1.0, 8.0])]);
    let swept = rig.sweep(&walker(), &on_level(0.0), v(11.4, 12.0, 0.0), v(11.7, 12.2, 0.0));
    assert_eq!(
        (swept.collision_normal, swept.sliding_normal),
        (Some(-Vec3::X), Some(-Vec3::X))
    );
    assert!(
        (swept.position.origin() - v(11.4, 12.2, 0.0)).length() < 1e-3,
        "{}",
        swept.position.origin()
    );
    let swept = rig.sweep(&walker(), &on_level(0.0), v(11.4, 12.0, 0.0), v(11.7, 12.0, 0.0));
    assert_eq!(swept.position.origin(), v(11.4, 12.0, 0.0));
    assert!(swept.ok && swept.velocity_killed && swept.on_walkable);
}
