//! 5.10: edges, cliffs and precipices, case by case.

use glam::{Quat, Vec3};
use vestibule_world::Plane;

use crate::constants::FLOOR_Z;
use crate::flags::ObjectState;
use crate::rig::*;
use crate::sweep::Carried;
use crate::transition::{Transition, TransitionState};

/// A platform 5 m over the ground.
fn platform() -> Rig {
    Rig::with_faces(&[level([10.0, 12.0], [11.0, 13.0], 5.0)])
}

/// What 5.10 says of a walker that went from `from` by `g` and was lowered by 0.5 m in the search for ground.
struct Search {
    ends: bool,
    ts: TransitionState,
    /// How far the candidate is from where it was before the search.
    moved: Vec3,
    contact: bool,
    walkable: bool,
    normal: Option<Vec3>,
}

fn search(
    rig: &mut Rig,
    state: ObjectState,
    from: Vec3,
    g: Vec3,
    prepare: impl Fn(&mut Transition<'_, '_>),
) -> Search {
    let mut t = rig.transition(&walker(), &on_level(from.z), from);
    t.path.add_offset_to_check_pos(g);
    t.info.clear_contact_plane();
    let before = t.path.check_pos.origin();
    t.path.save_check_pos();
    prepare(&mut t);
    t.path.add_offset_to_check_pos(v(0.0, 0.0, -0.5));
    t.object.state = state;
    let mut ts = TransitionState::Invalid;
    let ends = t.edge_slide(&mut ts, 0.75, FLOOR_Z);
    Search {
        ends,
        ts,
        moved: t.path.check_pos.origin() - before,
        contact: t.info.contact.valid,
        walkable: t.path.walkable.is_some(),
        normal: t.info.collision.get(),
    }
}

const WALKS: ObjectState = ObjectState(0x203);
const FROM: Vec3 = Vec3::new(11.95, 12.0, 5.0);
const OFF: Vec3 = Vec3::new(0.35, 0.2, 0.0);

fn touch(t: &mut Transition<'_, '_>, normal: Vec3) {
    t.info.set_contact(Plane { normal, d: 0.0 }, false, LAND);
}

const STEEP: Vec3 = Vec3::new(-0.8, 0.0, 0.6);

#[test]
fn s5_10_case_1_who_does_not_keep_off_edges_falls() {
    assert_eq!(
        WALKS,
        ObjectState::CONTACT | ObjectState::ON_WALKABLE | ObjectState::EDGE_SLIDE
    );
    for state in [
        ObjectState::NONE,
        ObjectState::EDGE_SLIDE,
        ObjectState::CONTACT | ObjectState::EDGE_SLIDE,
        ObjectState::CONTACT | ObjectState::ON_WALKABLE,
    ] {
        // Whatever else is known: a steep plane, a polygon.
        let got = search(&mut platform(), state, FROM, OFF, |t| {
            stand_on_polygon(t);
            touch(t, STEEP);
        });
        assert_eq!((got.ends, got.ts), (true, TransitionState::Ok), "{state:?}");
        assert_eq!((got.moved, got.contact, got.walkable), (Vec3::ZERO, false, false));
        assert_eq!(got.normal, None);
    }
}

#[test]
fn s5_10_case_2_steep_ground_deflects_and_the_insertion_goes_on() {
    let got = search(&mut platform(), WALKS, FROM, OFF, |t| {
        stand_on_polygon(t);
        touch(t, STEEP);
    });
    assert_eq!((got.ends, got.ts), (false, TransitionState::Adjusted));
    // n = (-1, 0, 0), a = -0.35: doubled, as in retail, from where the search began.
    assert!(close(got.moved, v(0.35, 0.0, 0.0)), "{}", got.moved);
    assert_eq!(
        (got.contact, got.walkable, got.normal),
        (false, false, Some(-Vec3::X))
    );
}

#[test]
fn s5_10_case_2_is_for_ground_below_the_threshold_only() {
    // A plane just level enough is no cliff: case 4.
    let z = FLOOR_Z;
    let got = search(&mut platform(), WALKS, FROM, OFF, |t| {
        touch(t, v(-libm::sqrtf(1.0 - z * z), 0.0, z));
    });
    assert_eq!(
        (got.ends, got.ts, got.moved),
        (true, TransitionState::Ok, Vec3::ZERO)
    );
    let z = 0.66;
    let got = search(&mut platform(), WALKS, FROM, OFF, |t| {
        touch(t, v(-libm::sqrtf(1.0 - z * z), 0.0, z));
    });
    assert_eq!((got.ends, got.ts), (false, TransitionState::Adjusted));
}

#[test]
fn s5_10_case_3_a_polygon_stood_on_is_slid_along() {
    for level_plane in [false, true] {
        let got = search(&mut platform(), WALKS, FROM, OFF, |t| {
            stand_on_polygon(t);
            if level_plane {
                touch(t, Vec3::Z);
            }
        });
        assert_eq!((got.ends, got.ts), (false, TransitionState::Slid));
        assert!(close(got.moved, v(-0.35, 0.0, 0.0)), "{}", got.moved);
        assert_eq!(
            (got.contact, got.walkable, got.normal),
            (false, false, Some(-Vec3::X))
        );
    }
}

#[test]
fn s5_10_case_3_ends_the_insertion_when_the_slide_is_too_short() {
    let got = search(&mut platform(), WALKS, FROM, v(0.35, 0.01, 0.0), stand_on_polygon);
    assert_eq!((got.ends, got.ts), (true, TransitionState::Collided));
    assert_eq!((got.moved, got.contact), (Vec3::ZERO, false));
}

#[test]
fn s5_10_case_4_level_ground_that_was_refused_is_left() {
    let got = search(&mut platform(), WALKS, FROM, OFF, |t| touch(t, Vec3::Z));
    assert_eq!((got.ends, got.ts), (true, TransitionState::Ok));
    assert_eq!((got.moved, got.contact, got.walkable), (Vec3::ZERO, false, false));
    assert_eq!(got.normal, None);
}

#[test]
fn s5_10_case_5_the_edge_is_found_from_the_last_accepted_place() {
    let got = search(&mut platform(), WALKS, FROM, v(0.47, 0.2, 0.0), |_| {});
    assert_eq!((got.ends, got.ts), (false, TransitionState::Slid));
    assert!(close(got.moved, v(-0.47, 0.0, 0.0)), "{}", got.moved);
    assert_eq!(
        (got.contact, got.walkable, got.normal),
        (false, false, Some(-Vec3::X))
    );
}

#[test]
fn s5_10_case_5_stops_where_there_never_was_a_polygon() {
    let got = search(&mut Rig::flat(), WALKS, FROM, OFF, |_| {});
    assert_eq!((got.ends, got.ts), (true, TransitionState::Collided));
    assert_eq!((got.moved, got.contact, got.walkable), (Vec3::ZERO, false, false));
}

#[test]
fn s5_10_case_5_looks_back_across_the_border_of_a_landblock() {
    // A platform that ends 8 cm before the border at x = 192.
    let face = level([180.0, 191.92], [11.0, 13.0], 5.0);
    let mut rig = Rig::with_turned_faces(v(188.0, 12.0, 0.0), Quat::IDENTITY, &[face]);
    let from = rig.stand(v(191.9, 12.0, 5.0));
    let mut to = from;
    to.frame.origin += v(0.45, 0.15, 0.0);
    let swept = crate::sweep::sweep(
        &rig.world,
        &rig.population,
        &mut rig.scratch,
        &walker(),
        &on_level(5.0),
        &from,
        &to,
    )
    .unwrap();
    assert!(swept.ok && swept.on_walkable, "{swept:?}");
    assert_eq!(swept.collision_normal, Some(-Vec3::X));
    assert!(
        (swept.position.origin() - v(191.9, 12.15, 5.0)).length() < 1e-3,
        "{}",
        swept.position
    );
}

/// Slides along the edge of the platform: what is said, by how much, along what.
fn precipice(rig: &mut Rig, at: Vec3, g: Vec3) -> (TransitionState, Vec3, Option<Vec3>, bool) {
    let mut t = rig.transition(&walker(), &on_level(5.0), at - g);
    t.path.add_offset_to_check_pos(g);
    t.path.save_check_pos();
    stand_on_polygon(&mut t);
    t.info.clear_contact_plane();
    let mut ts = TransitionState::Invalid;
    t.edge_slide(&mut ts, 0.75, FLOOR_Z);
    let moved = t.path.check_pos.origin() - at;
    (ts, moved, t.info.collision.get(), t.path.walkable.is_some())
}

#[test]
fn s5_10_precipice_over_the_polygon_there_is_no_edge() {
    let got = precipice(&mut platform(), v(11.5, 12.0, 5.0), v(0.2, 0.1, 0.0));
    assert_eq!(got, (TransitionState::Collided, Vec3::ZERO, None, false));
}

#[test]
fn s5_10_precipice_the_normal_is_turned_against_the_movement() {
    // Beyond the edge x = 12, coming back: the inward normal would be along the movement.
    let (ts, moved, n, _) = precipice(&mut platform(), v(12.3, 12.2, 5.0), v(-0.1, 0.2, 0.0));
    assert_eq!((ts, n), (TransitionState::Slid, Some(Vec3::X)));
    assert!(close(moved, v(0.1, 0.0, 0.0)), "{moved}");
    // At right angles to it, it stays as it is.
    let (ts, _, n, _) = precipice(&mut platform(), v(12.3, 12.2, 5.0), v(0.0, 0.2, 0.0));
    assert_eq!((ts, n), (TransitionState::Slid, Some(-Vec3::X)));
}

#[test]
fn s5_10_precipice_the_normal_is_turned_with_the_object() {
    let h = core::f32::consts::FRAC_1_SQRT_2;
    let quarter = Quat::from_xyzw(0.0, 0.0, h, h);
    let face = level([10.0, 12.0], [11.0, 13.0], 5.0);
    let mut rig = Rig::with_turned_faces(v(12.0, 12.0, 0.0), quarter, &[face]);
    let (ts, moved, n, _) = precipice(&mut rig, v(12.3, 12.2, 5.0), v(0.35, 0.2, 0.0));
    assert_eq!(ts, TransitionState::Slid);
    assert!(
        close(n.unwrap(), -Vec3::X) && (moved - v(-0.35, 0.0, 0.0)).length() < 1e-4,
        "{moved} {n:?}"
    );
}

/// Deflects a walker that moved by `g` from ground with the normal `cliff`, having stood on `floor`.
fn cliff(cliff: Vec3, floor: Vec3, g: Vec3) -> (TransitionState, Vec3, Option<Vec3>) {
    let mut rig = Rig::flat();
    let carried = Carried {
        on_walkable: true,
        ..on_plane(floor, 100.0)
    };
    let mut t = rig.transition(&walker(), &carried, v(12.0, 12.0, 5.0));
    t.path.add_offset_to_check_pos(g);
    let before = t.path.check_pos.origin();
    t.path.save_check_pos();
    touch(&mut t, cliff);
    let mut ts = TransitionState::Invalid;
    assert!(!t.edge_slide(&mut ts, 0.75, FLOOR_Z));
    (ts, t.path.check_pos.origin() - before, t.info.collision.get())
}

#[test]
fn s5_10_cliff_parallel_to_the_old_ground_deflects_nothing() {
    let (ts, moved, n) = cliff(STEEP, STEEP, v(0.1, 0.05, 0.0));
    assert_eq!((ts, moved, n), (TransitionState::Ok, Vec3::ZERO, None));
}

#[test]
fn s5_10_cliff_deflects_on_the_level() {
    // A crease that rises: the old ground slopes to the south.
    let floor = v(0.0, -0.6, 0.8);
    let (ts, moved, n) = cliff(v(0.8, 0.0, 0.6), floor, v(0.1, 0.05, 0.03));
    assert_eq!(ts, TransitionState::Adjusted);
    let n = n.unwrap();
    assert!(moved.z == 0.0 && n.z == 0.0, "{moved} {n}");
    // C = (0.8, 0, 0.6) x (0, -0.6, 0.8) = (0.36, -0.64, -0.48): n = (0.64, 0.36, 0) / 0.734302.
    let expected = v(0.64, 0.36, 0.0).normalize();
    let a = expected.dot(v(0.1, 0.05, 0.0));
    assert!(close(n, -expected) && close(moved, -a * expected), "{moved} {n}");
}

#[test]
fn s5_10_cliff_at_right_angles_is_adjusted_all_the_same() {
    // a = 0 counts as behind (`a <= 0`): nothing moves, and the normal is n.
    let (ts, moved, n) = cliff(v(0.8, 0.0, 0.6), Vec3::Z, v(0.0, 0.05, 0.0));
    assert_eq!((ts, moved), (TransitionState::Adjusted, Vec3::ZERO));
    assert!(close(n.unwrap(), Vec3::X), "{n:?}");
}
