//! The order of the draw list when finished rooms receive further views (`visibility.md` 6.2-6.4), and the rule that
//! makes every traversal end (6.5).

mod common;

use common::*;
use glam::Vec3;
use vestibule_view::{BlockOpenings, PView, potentially_visible};

const EYE: Vec3 = Vec3::new(0.0, 0.0, 1.5);
/// What a door shows of the view, as slopes: all of it, its left, its right.
const ALL: Span = (-0.5, 0.5);
const LEFT: Span = (-0.5, -0.1);
const RIGHT: Span = (0.1, 0.5);

/// The room of the eye, R, and others that are wherever their doors lead: what counts is the angle at which a door is
/// seen and, for the todo order, how far away it is. A door is from, to, distance, part of the view; it is only
/// looked through northwards.
fn rooms(names: &[&str], doors: &[(&str, &str, f32, Span)]) -> Rooms {
    let mut rooms = Rooms::new();
    for name in names {
        rooms.room(name, (-5.0, 5.0), (-1.0, 1.0));
    }
    let find = |name: &str| names.iter().position(|n| *n == name).unwrap();
    for &(from, to, y, (left, right)) in doors {
        let polygon = at_y(y, (left * y, right * y), (1.5 - 0.2 * y, 1.5 + 0.2 * y));
        rooms.door(find(from), find(to), &polygon);
    }
    rooms
}

/// The draw list from R, and how often a room was moved in it.
fn order(rooms: &mut Rooms) -> (String, u32) {
    let openings = rooms.build();
    seen(rooms, &openings, &mut PView::default())
}

fn seen(rooms: &Rooms, openings: &BlockOpenings, pview: &mut PView) -> (String, u32) {
    let flood = pview.look_in_block(Some(openings), &camera(0, EYE, Vec3::Y, 1.0));
    assert!(!flood.truncated());
    (rooms.list(&flood).concat(), flood.counters().moves)
}

#[test]
fn s6_2_the_finder_takes_the_place_and_the_rest_moves_back_by_one() {
    let mut rooms = rooms(
        &["R", "A", "B", "C"],
        &[
            ("R", "A", 10.0, ALL),
            ("R", "B", 20.0, ALL),
            ("R", "C", 30.0, ALL),
            ("C", "A", 9.0, ALL),
        ],
    );
    assert_eq!(order(&mut rooms), ("RCAB".into(), 1));
}

#[test]
fn s6_2_what_the_finder_is_seen_through_follows_it_in_the_order_of_its_portals() {
    let mut rooms = rooms(
        &["R", "A", "X", "Y", "C"],
        &[
            ("R", "A", 10.0, ALL),
            ("R", "X", 20.0, ALL),
            ("R", "Y", 30.0, ALL),
            ("R", "C", 40.0, ALL),
            ("X", "C", 21.0, ALL),
            ("Y", "C", 31.0, ALL),
            ("C", "A", 9.0, ALL),
        ],
    );
    // C before A; X, through which C is seen, before C; Y before C as well.
    assert_eq!(order(&mut rooms), ("RXYCA".into(), 3));
}

#[test]
fn s5_6c_a_queued_neighbour_that_received_nothing_new_is_not_seen_through() {
    // B has a door to C, which waits in the queue with a view from R; nothing of that door shows in B's view.
    let doors = |b: Span| {
        [
            ("R", "A", 10.0, ALL),
            ("R", "B", 20.0, b),
            ("R", "C", 30.0, RIGHT),
            ("B", "C", 15.0, RIGHT),
            ("C", "A", 9.0, ALL),
        ]
    };
    // C is moved before A; B, through which C is not seen, stays behind.
    let mut rooms_left = rooms(&["R", "A", "B", "C"], &doors(LEFT));
    assert_eq!(order(&mut rooms_left), ("RCAB".into(), 1));
    // Where it is, B is moved before C.
    let mut rooms_right = rooms(&["R", "A", "B", "C"], &doors(RIGHT));
    assert_eq!(order(&mut rooms_right), ("RBCA".into(), 2));
}

#[test]
fn s5_6c_a_door_that_nothing_came_through_is_still_looked_through() {
    // The eye is on the near side of both of the doors between B and C, as rooms that are not where they seem can have
    // it. B finds C in the queue and hands it nothing: C's door to B is no entry, and shows B what B's own door does not.
    let mut rooms = rooms(
        &["R", "B", "C"],
        &[
            ("R", "B", 20.0, LEFT),
            ("R", "C", 30.0, RIGHT),
            ("B", "C", 15.0, RIGHT),
            ("C", "B", 16.0, RIGHT),
        ],
    );
    // One pair instead of two: each of the portals looked through names the other as its other side.
    rooms.specs[1].portals.truncate(2);
    rooms.specs[2].portals.remove(1);
    rooms.specs[1].portals[1].other_portal = Some(1);
    rooms.specs[2].portals[1].other_portal = Some(1);
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, EYE, Vec3::Y, 1.0));
    assert_eq!(rooms.views(&flood), [("R", 1), ("B", 2), ("C", 1)].into());
}

#[test]
fn s6_2_a_portal_that_let_no_view_in_moves_nothing() {
    // B has a door to C, but from where B is seen only the left of it would show. The right of C is seen late,
    // through D, and A through that.
    let mut rooms = rooms(
        &["R", "A", "B", "C", "D"],
        &[
            ("R", "A", 10.0, ALL),
            ("R", "C", 20.0, LEFT),
            ("R", "B", 30.0, LEFT),
            ("R", "D", 40.0, RIGHT),
            ("B", "C", 15.0, RIGHT),
            ("D", "C", 16.0, RIGHT),
            ("C", "A", 9.0, RIGHT),
        ],
    );
    // D before C, then C before A; B stays behind.
    assert_eq!(order(&mut rooms), ("RCADB".into(), 2));
}

/// A, B and C are each seen through the last; D shows C once more, when all of them are finished.
fn cycle() -> Rooms {
    rooms(
        &["R", "A", "B", "C", "D"],
        &[
            ("R", "A", 10.0, LEFT),
            ("R", "B", 20.0, LEFT),
            ("R", "C", 30.0, LEFT),
            ("R", "D", 40.0, RIGHT),
            ("A", "B", 11.0, ALL),
            ("B", "C", 12.0, ALL),
            ("C", "A", 9.0, ALL),
            ("D", "C", 13.0, ALL),
        ],
    )
}

#[test]
fn s6_4_in_a_cycle_each_room_moves_once_a_repair_and_again_in_the_next() {
    // A finished, C finds it: C, B and A move, which is where they began. D then finds C and moves before it; C finds A
    // again: C, B and A move once more and stop, although C stands behind A.
    assert_eq!(order(&mut cycle()), ("RABCD".into(), 7));
}

#[test]
fn s6_4_nothing_is_moved_before_the_root() {
    // C is widened: more views than are kept. It then has no ancestors that would refuse its view of R.
    let mut rooms = rooms(&["R", "A", "C"], &[("R", "A", 10.0, ALL)]);
    for k in 0..100 {
        let left = -0.5 + 0.01 * k as f32;
        let polygon = at_y(20.0, (20.0 * left, 20.0 * (left + 0.008)), (0.0, 3.0));
        rooms.door(1, 2, &polygon);
    }
    rooms.door(2, 0, &at_y(30.0, (-15.0, 15.0), (0.0, 3.0)));
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, EYE, Vec3::Y, 1.0));
    assert_eq!(rooms.list(&flood), ["R", "A", "C"]);
    assert!(flood.cells()[2].saturated);
    // 6.5: the root is an ancestor of everything, also of the widened view.
    assert_eq!(flood.regions(&flood.cells()[0]).len(), 1);
    assert_eq!(flood.counters().ancestor_rejections, 1);
    assert_eq!(flood.counters().moves, 0);
}

/// `cycle` with a portal of C that leads to a room X and that the door from D names as its other side; E finds C
/// after that.
fn with_a_stranger(distance: f32, part: Span) -> Rooms {
    let mut rooms = cycle();
    let x = rooms.room("X", (-5.0, 5.0), (-1.0, 1.0));
    let at = |y: f32, (left, right): Span| at_y(y, (left * y, right * y), (1.5 - 0.2 * y, 1.5 + 0.2 * y));
    rooms.door(0, x, &at(distance, part));
    rooms.door(x, 3, &at(14.0, ALL));
    let e = rooms.room("E", (-5.0, 5.0), (-1.0, 1.0));
    rooms.door(0, e, &at(45.0, RIGHT));
    rooms.door(e, 3, &at(15.0, ALL));
    // D's door to C names the portal of C that belongs to X.
    let of_x = rooms.specs[3].portals.len() as u16 - 2;
    let of_d = rooms.specs[4].portals.last_mut().unwrap();
    of_d.other_portal = Some(of_x);
    rooms
}

#[test]
fn s6_2_a_portal_that_belongs_to_a_room_not_listed_yet_moves_nothing() {
    // X is seen farthest away: it is queued when C is repaired, and in no list.
    let (list, _) = order(&mut with_a_stranger(50.0, RIGHT));
    assert_eq!(list.len(), 7, "{list}");
    assert!(list.starts_with('R') && list.contains('X'), "{list}");
}

#[test]
fn s6_2_a_room_of_an_earlier_look_moves_nothing() {
    // X is seen to the left, and not at all when the eye looks right.
    let mut rooms = with_a_stranger(50.0, (-2.0, -1.5));
    let openings = rooms.build();
    let mut used = PView::default();
    let all = used
        .look_in_block(Some(&openings), &camera(0, EYE, Vec3::Y, 3.0))
        .cells()
        .len();
    assert_eq!(all, 7);
    let fresh = seen(&rooms, &openings, &mut PView::default());
    assert_eq!(fresh.0.len(), 6);
    assert_eq!(seen(&rooms, &openings, &mut used), fresh);
}

#[test]
fn s6_5_a_view_passes_no_room_twice_whatever_it_passed_between() {
    // R, A, B, C and back to A: the grandparent of C's view is A's.
    let mut rooms = rooms(
        &["R", "A", "B", "C"],
        &[
            ("R", "A", 10.0, ALL),
            ("A", "B", 11.0, ALL),
            ("B", "C", 12.0, ALL),
            ("C", "A", 13.0, ALL),
        ],
    );
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, EYE, Vec3::Y, 1.0));
    assert_eq!(rooms.list(&flood), ["R", "A", "B", "C"]);
    assert_eq!(flood.view_count(), 4);
    assert_eq!(
        (
            flood.counters().ancestor_rejections,
            flood.counters().incremental_clips
        ),
        (1, 0)
    );
}

#[test]
fn s13_4_a_line_of_sight_without_a_camera_passes_so_many_openings() {
    let mut hall = Rooms::new();
    for k in 0..200 {
        hall.room(&format!("R{k}"), (-5.0, 5.0), (k as f32, k as f32 + 1.0));
    }
    for k in 0..199 {
        hall.door(k, k + 1, &at_y(1.0 + k as f32, (-4.0, 4.0), TALL));
    }
    let seen = potentially_visible(&hall.build(), id(0));
    // The room itself and one for each of 128 openings.
    assert_eq!((seen.cells.len(), seen.truncated), (129, false));
}
