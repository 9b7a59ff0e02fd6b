//! The conformance tests 1, 2, 3 and 6 of `study.md` D16.

use glam::Vec3;
use vestibule_world::{CellId, Position};

use crate::body::Body;
use crate::flags::SetPositionFlags;
use crate::population::Population;
use crate::rig::*;
use crate::set_position::{Placed, Placement};
use crate::sweep::{Carried, Scratch, Swept, sweep};

const HALL: CellId = CellId(0xA9B4_0100);
/// The middle of the yard's doorway, on its sill; the hall lies to the north.
const DOOR: Vec3 = Vec3::new(19.75, 18.0, 0.0);

/// A walker in the yard, committed step by step.
struct Walk {
    rig: Rig,
    at: Position,
    carried: Carried,
}

impl Walk {
    fn from(at: Vec3) -> Self {
        let rig = Rig::yard();
        let at = rig.stand(at);
        Walk {
            rig,
            at,
            carried: on_level(0.0),
        }
    }

    fn step(&mut self, by: Vec3) -> Swept {
        let mut to = self.at;
        to.frame.origin += by;
        let rig = &mut self.rig;
        let swept = sweep(
            &rig.world,
            &rig.population,
            &mut rig.scratch,
            &walker(),
            &self.carried,
            &self.at,
            &to,
        )
        .unwrap();
        if swept.ok {
            self.at = swept.position;
            self.carried = swept.carried();
        }
        swept
    }
}

#[test]
fn d16_1_standing_in_a_doorway_for_a_hundred_ticks_changes_nothing() {
    // 8 cm inside, and 8 cm outside.
    for y in [0.08, -0.08] {
        let mut walk = Walk::from(DOOR + v(0.0, y, 0.0));
        assert_eq!(walk.at.cell == HALL, y > 0.0);
        let at = walk.at;
        for _ in 0..100 {
            let swept = walk.step(Vec3::ZERO);
            assert_eq!((swept.ok, swept.cell, walk.at), (true, Some(at.cell), at));
        }
        // Both cells are touched all the same.
        assert!(walk.rig.scratch.cells().len() > 1);
    }
}

#[test]
fn d16_2_walking_through_a_door_changes_the_cell_once_when_the_centre_is_inside() {
    let mut walk = Walk::from(DOOR - v(0.0, 1.0, 0.0));
    let land = walk.at.cell;
    let mut changes = Vec::new();
    let mut touched_before = false;
    for _ in 0..50 {
        let before = (walk.at.cell, walk.at.origin().y);
        let swept = walk.step(v(0.0, 0.04, 0.0));
        assert!(swept.ok);
        let now = (walk.at.cell, walk.at.origin().y);
        touched_before |= now.0 == land && walk.rig.scratch.cells().iter().any(|c| c.id == HALL);
        if now.0 != before.0 {
            changes.push((before, now));
        }
    }
    // Once; not when the sphere first overlaps the frame, but when the centre is accepted inside.
    let [((from, y0), (to, y1))] = changes[..] else {
        panic!("{changes:?}");
    };
    assert_eq!((from, to), (land, HALL));
    assert!(
        touched_before && y0 < DOOR.y && y1 >= DOOR.y - 0.0002,
        "{y0} {y1}"
    );
}

#[test]
fn d16_3_pressing_against_the_frame_of_a_door_never_changes_the_cell() {
    for y in [0.03, -0.03] {
        let mut walk = Walk::from(DOOR + v(0.0, y, 0.0));
        for _ in 0..5 {
            walk.step(v(0.2, 0.0, 0.0));
        }
        let at = walk.at;
        // The frame is at x = 20.5.
        assert!((at.origin().x - 20.02).abs() < 0.15, "{at}");
        for _ in 0..10 {
            walk.step(v(0.2, 0.0, 0.0));
            assert_eq!(walk.at.cell, at.cell);
            assert!((walk.at.origin() - at.origin()).length() < 1e-3);
        }
    }
}

#[test]
fn d16_6_a_placement_that_loads_no_cells_keeps_to_what_can_be_seen() {
    // Two rooms joined by a portal; the first does not list the second.
    let between = [[4.0, 1.0, 0.0], [4.0, 3.0, 0.0], [4.0, 3.0, 2.5], [4.0, 1.0, 2.5]];
    let room = |low, min: Vec3| {
        records::Room::of_box(low, min - Vec3::Z * 0.1, min + v(4.0, 4.0, 3.0)).walls(&[level(
            [min.x, min.x + 4.0],
            [min.y, min.y + 4.0],
            0.0,
        )])
    };
    let (near, far) = (CellId(0xA9B4_0100), CellId(0xA9B4_0101));
    for seen in [false, true] {
        let mut b = records::Builder::new(BLOCK);
        let stabs: &[u16] = if seen { &[0x101] } else { &[] };
        b.room(
            room(0x100, Vec3::ZERO)
                .opening(Some(0x101), 0, false, &between)
                .stabs(stabs),
        );
        b.room(
            room(0x101, v(4.0, 0.0, 0.0))
                .opening(Some(0x100), 0, true, &between)
                .stabs(&[0x100]),
        );
        let rig = Rig::of(b);
        // 20 cm from the portal: the sphere reaches through.
        let at = Position::new(near, v(3.8, 2.0, 0.0));
        let listed = |flags| {
            let (mut population, mut scratch) = (Population::new(), Scratch::new());
            let id = population.add(Body::player());
            let placement = Placement::at(at).with_flags(flags);
            let placed = population
                .set_position(&rig.world, &mut scratch, id, &placement)
                .unwrap();
            assert_eq!(placed, Ok(Placed::InCell(near)));
            population.body(id).unwrap().shadow_cells().contains(&far)
        };
        let placed = SetPositionFlags::PLACEMENT | SetPositionFlags::SLIDE;
        assert_eq!(listed(placed | SetPositionFlags::DONOTCREATECELLS), seen);
        assert!(listed(placed));
        // A move from there keeps its cells.
        let mut to = at;
        to.frame.origin.y += 0.01;
        let mut scratch = Scratch::new();
        sweep(
            &rig.world,
            &rig.population,
            &mut scratch,
            &walker(),
            &on_level(0.0),
            &at,
            &to,
        )
        .unwrap();
        assert!(scratch.cells().iter().any(|c| c.id == far));
    }
}
