//! `transition.md` 11.6: the answers of terrain.

use glam::Vec3;
use vestibule_world::CellId;

use crate::flags::ObjectKind;
use crate::rig::*;
use crate::sweep::Carried;
use crate::transition::{Transition, TransitionState};

/// Inserts a walker at a height over ground z = 0 and tells what terrain did.
fn terrain(
    carried: &Carried,
    z: f32,
    tweak: impl Fn(&mut Transition<'_, '_>),
) -> (TransitionState, f32, bool, bool) {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), carried, v(12.0, 6.0, z));
    t.info.clear_contact_plane();
    tweak(&mut t);
    let cell = t.path.check_cell.unwrap();
    let ts = t.find_collisions_in_cell(cell);
    (
        ts,
        t.path.check_pos.origin().z - z,
        t.info.contact.valid,
        t.info.collision.valid,
    )
}

#[test]
fn w36_terrain_in_contact() {
    let none = |_: &mut Transition<'_, '_>| {};
    assert_eq!(
        terrain(&on_level(0.0), 0.0001, none),
        (TransitionState::Ok, 0.0, true, false)
    );
    assert_eq!(
        terrain(&on_level(0.0), 0.0003, none),
        (TransitionState::Ok, 0.0, false, false)
    );
    // In the air touching is a collision.
    let falling = terrain(&Carried::default(), 0.0001, none);
    assert_eq!(falling, (TransitionState::Ok, 0.0, true, true));
}

#[test]
fn w37_w38_penetrating_terrain_is_left_vertically() {
    for (carried, collides) in [(on_level(0.0), false), (Carried::default(), true)] {
        let mut rig = Rig::slope(14);
        let mut t = rig.transition(&walker(), &carried, v(12.0, 6.0, 7.0 - 0.05));
        let cell = t.path.check_cell.unwrap();
        assert_eq!(t.find_collisions_in_cell(cell), TransitionState::Adjusted);
        assert!((t.path.check_pos.origin().z - 7.0).abs() < 1e-4);
        assert_eq!(
            (t.info.collision.valid, t.info.collided_with_environment),
            (collides, collides)
        );
        assert!(!collides || close(t.info.collision.normal, t.info.contact.plane.normal));
    }
}

#[test]
fn w39_too_steep_terrain_is_not_noticed_by_a_walker() {
    // 48 m over 24 m: N.z = 0.447.
    let check = |step_down: bool| {
        let mut rig = Rig::slope(48);
        let mut t = rig.transition(&walker(), &on_level(24.0), v(12.0, 6.0, 24.0 - 0.05));
        t.info.clear_contact_plane();
        t.path.step_down = step_down;
        (t.path.step_down_amt, t.path.walk_interp) = (0.75, 1.0);
        let cell = t.path.check_cell.unwrap();
        (t.find_collisions_in_cell(cell), t.info.contact.valid)
    };
    assert_eq!(check(false), (TransitionState::Ok, false));
    assert_eq!(check(true), (TransitionState::Adjusted, true));
}

#[test]
fn s7_3_terrain_under_a_step_down_is_bounded() {
    // W15: 0.66 of 0.6 gives w = -0.1, 0.67 is refused with the plane left set.
    for (depth, ts) in [
        (0.65, TransitionState::Adjusted),
        (0.67, TransitionState::Collided),
    ] {
        let got = terrain(&on_level(0.0), -depth, |t| {
            t.path.step_down = true;
            (t.path.step_down_amt, t.path.walk_interp) = (0.6, 1.0);
        });
        assert_eq!((got.0, got.2), (ts, true), "{depth}");
    }
    let got = terrain(&on_level(0.0), -0.1, |t| t.path.check_walkable = true);
    assert_eq!((got.0, got.2), (TransitionState::Collided, false));
}

#[test]
fn w40_water_bears_a_body_below_its_surface() {
    let mut builder = records::Builder::new(BLOCK);
    // Water at the south-west corner of the first cell only: 0.45 m deep there.
    builder.terrain[0] = 0x14 << 2;
    let mut rig = Rig::of(builder);
    for (z, ts, lift) in [
        (-0.30, TransitionState::Ok, 0.0),
        (-0.60, TransitionState::Adjusted, 0.15),
    ] {
        let mut t = rig.transition(&walker(), &on_level(0.0), v(3.0, 2.0, z));
        t.info.clear_contact_plane();
        let cell = t.path.check_cell.unwrap();
        assert_eq!(t.find_collisions_in_cell(cell), ts);
        assert!((t.path.check_pos.origin().z - z - lift).abs() < 1e-5);
        assert_eq!(
            (t.info.contact.valid, t.info.contact.is_water),
            (lift > 0.0, lift > 0.0)
        );
    }
}

#[test]
fn s7_1_4_a_block_all_of_water_may_not_be_entered_but_by_cameras_and_missiles() {
    let mut builder = records::Builder::new(BLOCK);
    builder.terrain = [0x14 << 2; 81];
    let mut rig = Rig::of(builder);
    let mut test = |mover| {
        let mut t = rig.transition(&mover, &Carried::default(), v(3.0, 2.0, 1.0));
        let cell = t.path.check_cell.unwrap();
        (t.find_collisions_in_cell(cell), t.info.collision.valid)
    };
    assert_eq!(test(walker()), (TransitionState::Collided, false));
    assert_eq!(test(missile()).0, TransitionState::Ok);
    assert_eq!(
        test(crate::viewer::viewer_mover(&walker())).0,
        TransitionState::Ok
    );
}

#[test]
fn w41_the_camera_stops_over_the_ground() {
    let mut rig = Rig::flat();
    let camera = crate::viewer::viewer_mover(&walker());
    let mut test = |z: f32| {
        let mut t = rig.transition(&camera, &Carried::default(), v(12.0, 6.0, 1.2));
        t.path.add_offset_to_check_pos(v(0.0, 0.0, z - 1.2));
        let cell = t.path.check_cell.unwrap();
        (
            t.find_collisions_in_cell(cell),
            t.path.check_pos.origin().z,
            t.info.collision.get(),
        )
    };
    let (ts, z, n) = test(0.2);
    assert_eq!((ts, n), (TransitionState::Adjusted, Some(Vec3::Z)));
    assert!((z - 0.3).abs() < 1e-5);
    assert_eq!(test(0.31), (TransitionState::Ok, 0.31, None));
}

#[test]
fn s7_5_restricted_cells_keep_players_out() {
    #[derive(Debug)]
    struct Nobody;
    impl crate::population::EntryRestrictions for Nobody {
        fn may_enter(&self, _: Option<crate::population::BodyId>, _: CellId, _: u32) -> bool {
            false
        }
    }
    let mut rig = Rig::flat();
    rig.population.set_restrictions(Some(std::sync::Arc::new(Nobody)));
    let mut player = walker();
    player.kind = ObjectKind::PLAYER;
    let ask = |t: &mut Transition<'_, '_>| {
        t.handle_move_restriction(LAND);
        (t.may_enter(LAND, 7), t.info.collision.normal)
    };
    // Y2: the wall by where the mover stands against the cell's centre.
    for (x, y, n) in [
        (-1.0, 12.0, -Vec3::X),
        (25.0, 12.0, Vec3::X),
        (12.0, 25.0, Vec3::Y),
        (30.0, -1.0, -Vec3::Y),
    ] {
        let mut t = rig.transition(&player, &Carried::default(), v(x, y, 0.0));
        assert_eq!(ask(&mut t), (false, n));
    }
    let mut t = rig.transition(&walker(), &Carried::default(), v(12.0, 12.0, 0.0));
    assert!(t.may_enter(LAND, 7));
    player.kind = ObjectKind::PLAYER | ObjectKind::BYPASSES_RESTRICTIONS;
    t = rig.transition(&player, &Carried::default(), v(12.0, 12.0, 0.0));
    assert!(t.may_enter(LAND, 7));
}
