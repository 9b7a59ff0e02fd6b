//! An eye on the plane of an opening (`visibility.md` 12.2): within 0.2 mm of it, and inside it grown by 1 cm, all of
//! the view goes through.

mod common;

use common::*;
use glam::Vec3;
use vestibule_view::constants::{EPSILON, ON_PLANE_MARGIN};
use vestibule_view::{Camera, PView};

/// Two rooms and a door in the plane y = 0, which numbers near 0 can be exactly at any distance from.
fn at_the_origin() -> Rooms {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", (-5.0, 5.0), (-10.0, 0.0));
    let b = rooms.room("B", (-5.0, 5.0), (0.0, 10.0));
    rooms.door(a, b, &at_y(0.0, (-1.0, 1.0), TALL));
    rooms
}

/// The regions of the room that is not the root, how many openings the eye was in, and the whole view.
fn through(rooms: &mut Rooms, camera: &Camera) -> (Vec<[f32; 4]>, u32) {
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), camera);
    let other = flood.cells().get(1);
    let regions = other.map(|cell| flood.regions(cell).map(|r| slopes(camera, r)).collect());
    (regions.unwrap_or_default(), flood.counters().on_plane)
}

/// The camera stands a little off the door's plane and looks along it.
fn along(root: usize, x: f32, y: f32) -> Camera {
    camera(root, v(x, y, 1.5), Vec3::X, 1.0)
}

#[test]
fn s12_2_the_plane_reaches_0_2_mm_to_either_side_and_no_farther() {
    let beyond = f32::from_bits(EPSILON.to_bits() + 1);
    for root in [0, 1] {
        for (y, on) in [
            (0.0, true),
            (EPSILON, true),
            (-EPSILON, true),
            (0.5 * EPSILON, true),
            (-0.5 * EPSILON, true),
            (beyond, false),
            (-beyond, false),
        ] {
            let camera = along(root, 0.0, y);
            let (regions, on_plane) = through(&mut at_the_origin(), &camera);
            assert_eq!(on_plane, u32::from(on), "root {root}, y {y}");
            if on {
                // All of the view, and that once.
                assert_eq!(regions.len(), 1, "root {root}, y {y}");
                assert_bounds(regions[0], [-1.0, 1.0, -1.0, 1.0]);
            } else {
                // Half of it, unless the eye has passed the door.
                assert_eq!(
                    regions.len(),
                    usize::from((y < 0.0) == (root == 0)),
                    "root {root}, y {y}"
                );
            }
        }
    }
}

#[test]
fn s12_2_the_opening_is_grown_by_a_centimetre() {
    for (x, inside) in [
        (1.0 + 0.9 * ON_PLANE_MARGIN, true),
        (-1.0 - 0.9 * ON_PLANE_MARGIN, true),
        (1.0 + 1.1 * ON_PLANE_MARGIN, false),
        (-1.0 - 1.1 * ON_PLANE_MARGIN, false),
    ] {
        let (regions, on_plane) = through(&mut at_the_origin(), &along(0, x, 0.0));
        assert_eq!(on_plane, u32::from(inside), "{x}");
        if inside {
            assert_eq!(regions.len(), 1, "{x}");
            assert_bounds(regions[0], [-1.0, 1.0, -1.0, 1.0]);
        }
    }
}

#[test]
fn s12_2_an_opening_that_several_views_reach_is_counted_once() {
    // A is seen through two doors, and the eye is in the plane of the door from A to B.
    let mut rooms = Rooms::new();
    let r = rooms.room("R", (-5.0, 5.0), (-5.0, 5.0));
    let a = rooms.room("A", (-5.0, 5.0), (5.0, 15.0));
    let b = rooms.room("B", (-5.0, 5.0), (0.0, 15.0));
    rooms.door(r, a, &at_y(5.0, (-3.0, -1.0), TALL));
    rooms.door(r, a, &at_y(5.0, (1.0, 3.0), TALL));
    rooms.door(a, b, &at_y(0.0, (-1.0, 1.0), TALL));
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(r, v(0.0, 0.0, 1.5), Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["R", "A", "B"]);
    assert_eq!(views_of(&rooms, &flood, &camera, "B").len(), 2);
    assert_eq!(flood.counters().on_plane, 1);
}

#[test]
fn s12_2_an_eye_on_the_plane_of_the_far_polygon_is_not_clipped_by_it() {
    // The two sides of the door do not match: the far room's polygon stands 10 cm nearer, where the eye is.
    for y in [-0.1, -0.1 + 0.5 * EPSILON, -0.1 - 0.5 * EPSILON] {
        let mut rooms = Rooms::new();
        let a = rooms.room("A", (-5.0, 5.0), (-10.0, 0.0));
        let b = rooms.room("B", (-5.0, 5.0), (0.0, 10.0));
        let (near, far) = (at_y(-0.1, (-1.0, 1.0), TALL), at_y(0.0, (-0.05, 0.05), TALL));
        rooms.mismatched_door(a, &far, b, &near, false);
        let camera = camera(a, v(0.0, y, 1.5), Vec3::Y, 1.0);
        let (regions, on_plane) = through(&mut rooms, &camera);
        assert_eq!((regions.len(), on_plane), (1, 1), "{y}");
        assert!(
            (regions[0][0] + 0.5).abs() < 2e-3 && (regions[0][1] - 0.5).abs() < 2e-3,
            "{regions:?}"
        );
    }
}

#[test]
fn s12_1_nothing_is_cut_off_just_ahead_of_the_eye() {
    // A third of a millimetre before the door and looking along it, with a wide view: the door begins beside the eye.
    let camera = camera(0, v(0.0, -0.0003, 1.5), Vec3::X, 5.0);
    let (regions, on_plane) = through(&mut at_the_origin(), &camera);
    assert_eq!((regions.len(), on_plane), (1, 0));
    assert!(regions[0][0] < -4.99, "{regions:?}");
}
