//! `transition.md` 11.7: objects made of spheres and cylinders.

use glam::Vec3;
use vestibule_world::{CylSphere, Frame, Sphere};

use crate::constants::Z_FOR_LANDING;
use crate::rig::*;
use crate::settings::Settings;
use crate::sweep::Carried;
use crate::transition::{Transition, TransitionState};

/// A transition next to a target, its foot centre `disp` from the point (12, 12, 5).
fn beside<'r>(
    rig: &'r mut Rig,
    mover: &crate::sweep::Mover,
    carried: &Carried,
    disp: Vec3,
) -> Transition<'r, 'r> {
    rig.transition(mover, carried, v(12.0, 12.0, 5.0 - 0.48) + disp)
}

const TARGET: Vec3 = Vec3::new(12.0, 12.0, 5.0);

#[test]
fn w42_overlap_of_spheres() {
    let target = Sphere::new(TARGET, 0.5);
    for (x, ts) in [(0.9797, TransitionState::Collided), (0.9801, TransitionState::Ok)] {
        let mut rig = Rig::flat();
        let mut t = beside(&mut rig, &walker(), &Carried::default(), v(x, 0.0, 0.0));
        t.path.check_walkable = true;
        assert_eq!(t.intersects_sphere(&target, false), ts, "{x}");
    }
}

#[test]
fn w44_step_down_onto_a_sphere() {
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &walker(), &on_level(0.0), v(0.3, 0.2, 0.5));
    t.info.clear_contact_plane();
    t.path.step_down = true;
    (t.path.step_down_amt, t.path.walk_interp) = (0.6, 1.0);
    let z = t.path.check_pos.origin().z;
    let target = Sphere::new(TARGET, 0.5);
    assert_eq!(t.intersects_sphere(&target, true), TransitionState::Ok);
    assert_eq!(t.intersects_sphere(&target, false), TransitionState::Adjusted);
    assert!((t.path.walk_interp - 0.314_561_9).abs() < 1e-4);
    assert!((t.path.check_pos.origin().z - z - 0.411_262_9).abs() < 1e-4);
    assert!((t.info.contact.plane.normal - v(0.306_122_4, 0.204_081_6, 0.929_860_1)).length() < 1e-4);
    assert!(t.info.contact.is_water);
    // Tangent to the sphere.
    assert!((t.info.contact.plane.dist(TARGET) + 0.5).abs() < 1e-4);
}

#[test]
fn w45_landing_on_a_sphere_rewinds() {
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &walker(), &Carried::default(), v(0.6, 0.0, 1.1));
    t.path.add_offset_to_check_pos(v(-0.1, 0.0, -0.3));
    t.path.collide = true;
    t.path.walk_interp = 1.0;
    t.path.walkable_allowance = Z_FOR_LANDING;
    let before = t.path.check_pos.origin();
    let target = Sphere::new(TARGET, 0.5);
    assert_eq!(t.intersects_sphere(&target, true), TransitionState::Ok);
    assert_eq!(t.intersects_sphere(&target, false), TransitionState::Adjusted);
    assert!((t.path.walk_interp - 0.881_059_8).abs() < 1e-4);
    assert!((t.path.check_pos.origin() - before - v(0.011_894_0, 0.0, 0.035_682_1)).length() < 1e-4);
    assert!((t.info.contact.plane.normal - v(0.522_340_8, 0.0, 0.852_736_8)).length() < 1e-4);
}

#[test]
fn w46_low_spheres_are_stepped_onto_and_high_ones_slid_along() {
    for (z, stepped) in [(0.40, true), (0.30, false)] {
        let mut rig = Rig::flat();
        let mut t = beside(&mut rig, &walker(), &on_level(0.0), v(-0.85, 0.0, z));
        t.path.add_offset_to_check_pos(v(0.1, 0.05, 0.0));
        let ts = t.intersects_sphere(&Sphere::new(TARGET, 0.5), false);
        // The step up finds no ground here, and ends as a slide with the normal that was tried.
        let tried = t.path.step_up_normal != Vec3::ZERO;
        assert_eq!(tried, stepped, "{z} {ts:?}");
    }
}

fn post(height: f32) -> CylSphere {
    CylSphere {
        low_point: TARGET,
        radius: 0.5,
        height,
    }
}

#[test]
fn w47_low_cylinders_are_stepped_onto_and_high_ones_slid_along() {
    for (h, stepped) in [(0.5, true), (0.7, false)] {
        let mut rig = Rig::flat();
        let mut t = beside(&mut rig, &walker(), &on_level(0.0), v(-1.2, 0.0, 0.48));
        t.path.add_offset_to_check_pos(v(0.3, 0.05, 0.0));
        t.intersects_cylsphere(&post(h), &Frame::IDENTITY);
        assert_eq!(t.path.step_up_normal != Vec3::ZERO, stepped, "{h}");
    }
}

#[test]
fn w48_step_down_onto_a_cylinder() {
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &walker(), &on_level(0.0), v(0.2, 0.0, 0.45));
    t.path.step_down = true;
    (t.path.step_down_amt, t.path.walk_interp) = (0.75, 1.0);
    assert_eq!(
        t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY),
        TransitionState::Adjusted
    );
    assert!((t.path.walk_interp - 0.293_333_3).abs() < 1e-4);
    assert!((t.info.contact.plane.d + 5.5).abs() < 1e-4 && t.info.contact.is_water);
}

#[test]
fn w49_landing_on_a_cylinder_rewinds() {
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &walker(), &Carried::default(), v(0.0, 0.0, 1.1));
    t.path.add_offset_to_check_pos(v(0.0, 0.0, -0.3));
    t.path.collide = true;
    t.path.walk_interp = 1.0;
    let before = t.path.check_pos.origin();
    assert_eq!(
        t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY),
        TransitionState::Adjusted
    );
    assert!((t.path.check_pos.origin() - before - v(0.0, 0.0, 0.18)).length() < 1e-4);
    assert!((t.path.walk_interp - 0.4).abs() < 1e-4);
    assert!((t.info.contact.plane.d + 5.5).abs() < 1e-4);
}

#[test]
fn s12_6_7_tops_of_objects_count_as_water_only_in_retail() {
    for water in [true, false] {
        let mut rig = Rig::flat().with_settings(Settings {
            object_tops_are_water: water,
            ..Settings::RETAIL
        });
        let mut t = beside(&mut rig, &walker(), &on_level(0.0), v(0.2, 0.0, 0.45));
        t.path.step_down = true;
        (t.path.step_down_amt, t.path.walk_interp) = (0.75, 1.0);
        t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY);
        assert_eq!(t.info.contact.is_water, water);
    }
}

#[test]
fn s8_3_9_a_path_clipped_mover_stops_at_the_sphere() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&missile(), &Carried::default(), TARGET - v(2.0, 0.0, 0.0));
    t.path.add_offset_to_check_pos(v(1.5, 0.0, 0.0));
    assert_eq!(
        t.intersects_sphere(&Sphere::new(TARGET, 0.5), false),
        TransitionState::Adjusted
    );
    assert!((t.path.check_pos.origin().x - 11.2).abs() < 1e-4);
    assert!(close(t.info.collision.normal, -Vec3::X));
}

#[test]
fn s8_4_9_a_path_clipped_mover_stops_at_the_cylinder() {
    for (from, to, at, n) in [
        (v(-2.0, 0.0, 1.0), v(-0.5, 0.0, 1.0), v(-0.8, 0.0, 1.0), -Vec3::X),
        (v(0.1, 0.0, 3.0), v(0.1, 0.0, 2.0), v(0.1, 0.0, 2.3), Vec3::Z),
        (v(0.1, 0.0, -1.0), v(0.1, 0.0, 0.2), v(0.1, 0.0, -0.3), -Vec3::Z),
    ] {
        let mut rig = Rig::flat();
        let mut t = rig.transition(&missile(), &Carried::default(), TARGET + from);
        t.path.add_offset_to_check_pos(to - from);
        let ts = t.intersects_cylsphere(&post(2.0), &Frame::IDENTITY);
        assert_eq!(ts, TransitionState::Adjusted, "{from}");
        assert!(
            (t.path.check_pos.origin() - TARGET - at).length() < 1e-4,
            "{from}: {}",
            t.path.check_pos.origin()
        );
        assert!(close(t.info.collision.normal, n), "{from}");
    }
}

#[test]
fn s8_3_7_s8_4_7_a_step_down_of_no_depth_ends_at_what_it_meets() {
    // As deep in the target as an overlap begins, 0.205 mm: a fraction of such a step, if that were asked.
    let gap = 0.000_205;
    let meet = |amount: f32, cylinder: bool| {
        let mut rig = Rig::flat();
        // The foot's radius and the sphere's, or the post's height.
        let over = 0.48 + 0.5;
        let mut t = beside(&mut rig, &walker(), &on_level(0.0), v(0.0, 0.0, over - gap));
        t.path.step_down = true;
        (t.path.step_down_amt, t.path.walk_interp) = (amount, 1.0);
        if cylinder {
            t.intersects_cylsphere(&post(0.5), &Frame::IDENTITY)
        } else {
            t.intersects_sphere(&Sphere::new(TARGET, 0.5), false)
        }
    };
    for cylinder in [false, true] {
        assert_eq!(meet(0.000_199, cylinder), TransitionState::Collided);
        assert_eq!(meet(0.000_21, cylinder), TransitionState::Adjusted);
    }
}

#[test]
fn s8_3_5_a_head_slides_by_its_own_way() {
    // The mover leans over as it goes: its head has come further than its foot.
    let mut rig = Rig::flat();
    let mut t = beside(&mut rig, &walker(), &on_level(0.0), v(-1.2, 0.0, -0.875));
    t.path.add_offset_to_check_pos(v(0.1, 0.05, 0.0));
    t.path.global_sphere[1] += v(0.2, 0.1, 0.0).into();
    let before = t.path.check_pos.origin();
    let ts = t.intersects_sphere(&Sphere::new(TARGET, 0.5), false);
    assert_eq!(ts, TransitionState::Slid);
    // What is left of 0.3 along the normal is nothing.
    let moved = t.path.check_pos.origin() - before;
    assert!((moved.x + 0.3).abs() < 1e-4, "{moved}");
}
