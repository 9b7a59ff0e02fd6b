//! `transition.md` 11.8, 11.9: bodies without progress, borders and placement.

use glam::Vec3;
use vestibule_world::CellId;

use crate::flags::ObjectState;
use crate::rig::*;
use crate::sweep::Carried;
use crate::transition::TransitionState;

#[test]
fn w59_a_body_that_makes_no_progress_is_held_after_three_frames() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &Carried::default(), v(12.0, 12.0, 5.0));
    for expected in [1, 2, 3] {
        assert_eq!(
            t.validate_transition(TransitionState::Collided),
            TransitionState::Ok
        );
        assert_eq!(t.info.frames_stationary_fall, expected);
    }
    assert!((t.info.contact.plane.d + 5.0).abs() < 1e-5 && t.info.contact.plane.normal == Vec3::Z);
    assert!(
        t.object
            .state
            .has(ObjectState::CONTACT | ObjectState::ON_WALKABLE)
    );
    assert!(t.info.collided_with_environment);
}

#[test]
fn w61_crossing_a_border_rebases_the_candidate() {
    let mut rig = Rig::flat();
    let mut t = rig.transition(&walker(), &Carried::default(), v(192.5, 12.0, 5.0));
    t.path.adjust_check_pos(CellId(0xAAB4_0001));
    assert!(close(t.path.check_pos.origin(), v(0.5, 12.0, 5.0)));
    assert!(close(t.path.center(0), v(0.5, 12.0, 5.48)));
    // I15: an interior id never moves the origin.
    t.path.adjust_check_pos(CellId(0xABB4_0100));
    assert!(close(t.path.check_pos.origin(), v(0.5, 12.0, 5.0)));
}

#[test]
fn w65_placement_without_sliding_keeps_to_the_place() {
    use crate::population::Population;
    use crate::set_position::{Placed, Placement, SetPositionError};
    let mut rig = Rig::with_faces(&[wall_facing_west(12.0, [4.0, 20.0], [-1.0, 8.0])]);
    let mut population = Population::new();
    let id = population.add(crate::body::Body::player());
    let here = |x: f32| Placement::at(vestibule_world::Position::new(LAND, v(x, 12.0, 0.1)));
    let mut put = |placement: &Placement| {
        population
            .set_position(&rig.world, &mut rig.scratch, id, placement)
            .unwrap()
    };
    let exact = crate::flags::SetPositionFlags::PLACEMENT;
    assert_eq!(put(&here(10.0).with_flags(exact)), Ok(Placed::InCell(LAND)));
    // In the wall there is no room; sliding finds some beside it.
    assert_eq!(
        put(&here(12.0).with_flags(exact)),
        Err(SetPositionError::NoValidPosition)
    );
    assert_eq!(put(&here(12.0)), Ok(Placed::InCell(LAND)));
    let body = population.body(id).unwrap();
    assert!((body.position().origin().x - 12.0).abs() >= 0.479 && body.is_on_walkable());
    // Nowhere: the body waits.
    let nowhere = Placement::at(vestibule_world::Position::new(
        CellId(0xA9B4_0100),
        v(1.0, 1.0, 0.0),
    ));
    let placed = population
        .set_position(&rig.world, &mut rig.scratch, id, &nowhere)
        .unwrap();
    assert_eq!(placed, Ok(Placed::Lost));
    assert_eq!(population.lost().collect::<Vec<_>>(), [(id, CellId(0xA9B4_0100))]);
}
