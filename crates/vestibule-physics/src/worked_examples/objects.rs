//! `transition.md` 11.7: which objects are in the way of whom.

use glam::Vec3;
use vestibule_world::Frame;

use crate::flags::{ObjectKind, PhysicsState};
use crate::obj_collisions::{ObjectRef, Target};
use crate::rig::*;
use crate::transition::{InsertType, TransitionState};

/// What a player meets in another object with these bits.
fn meets(kind: ObjectKind, state: PhysicsState, mover: ObjectKind) -> (TransitionState, usize, bool) {
    let mut rig = Rig::flat();
    let body = rig.population.add(crate::body::Body::player());
    let shape = rig.population.body(body).unwrap().shape().clone();
    let mut player = walker();
    player.kind = mover;
    let frame = Frame::at(v(12.0, 12.0, 4.5));
    let target = Target {
        object: ObjectRef::Body(body),
        cell: LAND,
        frame: &frame,
        scale: 1.0,
        state,
        kind,
        shape: &shape,
        part_frames: &[],
    };
    let at = crate::sweep::begin(
        &rig.world,
        &rig.population,
        &mut rig.scratch,
        &player,
        &on_level(4.52),
        &vestibule_world::Position::new(LAND, v(11.1, 12.0, 4.52)),
        InsertType::Transition,
    );
    let mut t = at;
    t.path.add_offset_to_check_pos(v(0.1, 0.0, 0.0));
    t.info.set_collision_normal(Vec3::Y);
    let ts = t.find_object_collisions(&target);
    let collision = t.info.collision.valid;
    (ts, t.touched.len(), collision)
}

#[test]
fn w51_players_pass_through_players_unless_both_fight() {
    let player = ObjectKind::PLAYER | ObjectKind::CREATURE;
    let state = PhysicsState::DEFAULT;
    assert_eq!(meets(player, state, player), (TransitionState::Ok, 0, true));
    let blocked =
        |a: ObjectKind, b: ObjectKind| meets(player | a, state, player | b).0 != TransitionState::Ok;
    assert!(blocked(ObjectKind::PK, ObjectKind::PK));
    assert!(!blocked(ObjectKind::PKLITE, ObjectKind::PK));
    assert!(blocked(ObjectKind::PKLITE, ObjectKind::PKLITE));
    assert!(blocked(ObjectKind::IMPENETRABLE, ObjectKind::NONE));
    assert!(meets(ObjectKind::CREATURE, state, player).0 != TransitionState::Ok);
}

#[test]
fn w52_an_open_door_is_touched_but_does_not_stop() {
    let open = PhysicsState::DEFAULT | PhysicsState::ETHEREAL;
    assert_eq!(
        meets(ObjectKind::NONE, open, ObjectKind::PLAYER),
        (TransitionState::Ok, 1, false)
    );
    // Ethereal and ignoring collisions: not even touched.
    let ghost = open | PhysicsState::IGNORE_COLLISIONS;
    assert_eq!(
        meets(ObjectKind::NONE, ghost, ObjectKind::PLAYER),
        (TransitionState::Ok, 0, true)
    );
}
