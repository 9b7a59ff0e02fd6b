//! The worked examples V1-V34 of `visibility.md` 16 that need no landscape; the looks in are in `look_in.rs`.

mod common;

use common::*;
use glam::Vec3;
use vestibule_view::{FloodSettings, PView};

const EYE: Vec3 = Vec3::new(0.0, 0.0, 1.5);
const HALL: Span = (-5.0, 5.0);

fn two_rooms() -> Rooms {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", HALL, (-5.0, 5.0));
    let b = rooms.room("B", HALL, (5.0, 15.0));
    rooms.door(a, b, &at_y(5.0, (-1.0, 1.0), TALL));
    rooms
}

/// The names of the draw list for a camera in room `root`.
fn seen(rooms: &mut Rooms, root: usize, eye: Vec3, look: Vec3) -> Vec<String> {
    seen_with(rooms, root, eye, look, 1.0, FloodSettings::default())
}

fn seen_with(
    rooms: &mut Rooms,
    root: usize,
    eye: Vec3,
    look: Vec3,
    slope: f32,
    settings: FloodSettings,
) -> Vec<String> {
    let openings = rooms.build();
    let mut pview = PView::new(settings);
    let flood = pview.look_in_block(Some(&openings), &camera(root, eye, look, slope));
    rooms.list(&flood).into_iter().map(str::to_owned).collect()
}

#[test]
fn v1_one_sealed_room() {
    let mut rooms = Rooms::new();
    rooms.room("A", HALL, HALL);
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, EYE, Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A"]);
    assert_bounds(views_of(&rooms, &flood, &camera, "A")[0], [-1.0, 1.0, -1.0, 1.0]);
    assert!(!flood.sees_outside());
}

#[test]
fn v2_two_rooms_and_a_door() {
    let mut rooms = two_rooms();
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, EYE, Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B"]);
    assert_bounds(views_of(&rooms, &flood, &camera, "B")[0], [-0.2, 0.2, -0.3, 0.2]);
    let b = &flood.cells()[1];
    assert!((b.key - 28.25).abs() < 1e-4, "{}", b.key);
    assert_eq!(b.reached_from, Some(0));
    let (low, high) = flood.regions(b).next().unwrap().pixel_bounds(&camera);
    assert!((low - glam::Vec2::new(204.8, 204.8)).length() < 0.05, "{low}");
    assert!((high - glam::Vec2::new(307.2, 332.8)).length() < 0.05, "{high}");
    let view = flood.views(b)[0];
    assert_eq!((view.parent, view.portal), (Some(0), Some(0)));
}

#[test]
fn v3_v4_looking_away_sees_one_room() {
    assert_eq!(seen(&mut two_rooms(), 0, EYE, -Vec3::Y), ["A"]);
    assert_eq!(seen(&mut two_rooms(), 0, EYE, Vec3::X), ["A"]);
}

#[test]
fn v5_from_the_other_room() {
    let eye = v(0.0, 8.0, 1.5);
    assert_eq!(seen(&mut two_rooms(), 1, eye, Vec3::Y), ["B"]);
    let mut rooms = two_rooms();
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(1, eye, -Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["B", "A"]);
    assert_x(views_of(&rooms, &flood, &camera, "A")[0], -1.0 / 3.0, 1.0 / 3.0);
}

#[test]
fn v6_a_flipped_side_closes_the_door() {
    let mut rooms = two_rooms();
    rooms.specs[0].portals[0].interior_is_negative = false;
    assert_eq!(seen(&mut rooms, 0, EYE, Vec3::Y), ["A"]);
}

fn corridor(door: Span) -> Rooms {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", (-1.0, 1.0), (0.0, 10.0));
    let b = rooms.room("B", (-1.0, 1.0), (10.0, 12.0));
    let c = rooms.room("C", (1.0, 11.0), (10.0, 12.0));
    rooms.door(a, b, &at_y(10.0, door, (0.0, 3.0)));
    rooms.door(b, c, &at_x(1.0, (10.0, 12.0), (0.0, 3.0)));
    rooms
}

#[test]
fn v7_round_the_corner() {
    let mut rooms = corridor((-1.0, 1.0));
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, v(0.0, 1.0, 1.5), Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B", "C"]);
    assert_x(views_of(&rooms, &flood, &camera, "C")[0], 1.0 / 11.0, 1.0 / 9.0);
}

#[test]
fn v8_v9_what_the_corner_hides() {
    assert_eq!(
        seen(&mut corridor((-1.0, 0.5)), 0, v(0.0, 1.0, 1.5), Vec3::Y),
        ["A", "B"]
    );
    let mut rooms = corridor((-1.0, 1.0));
    let d = rooms.room("D", (11.0, 20.0), (10.0, 12.0));
    rooms.door(2, d, &at_x(11.0, (10.0, 12.0), (0.0, 3.0)));
    assert_eq!(seen(&mut rooms, 0, v(0.0, 1.0, 1.5), Vec3::Y), ["A", "B", "C"]);
}

#[test]
fn v10_a_room_seen_through_two_doors_is_listed_once() {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", HALL, (-5.0, 5.0));
    let b = rooms.room("B", HALL, (5.0, 15.0));
    rooms.door(a, b, &at_y(5.0, (-3.0, -1.0), TALL));
    rooms.door(a, b, &at_y(5.0, (1.0, 3.0), TALL));
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, EYE, Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B"]);
    let views = views_of(&rooms, &flood, &camera, "B");
    assert_x(views[0], -0.6, -0.2);
    assert_x(views[1], 0.2, 0.6);
    let hidden = |center: Vec3, radius: f32| {
        flood.regions(&flood.cells()[1]).all(|r| {
            r.sphere(center - EYE, radius, camera.forward(), camera.near()) == vestibule_view::InView::Outside
        })
    };
    assert!(hidden(v(0.0, 10.0, 1.5), 0.3));
    assert!(
        !hidden(v(0.0, 10.0, 1.5), 2.0),
        "1.96 m from the edges of both views"
    );
}

/// The rooms of V11; `top` is the height of the door from A to C.
fn late_view(top: f32) -> Rooms {
    let mut rooms = Rooms::new();
    let a = rooms.tall_room("A", HALL, (-5.0, 5.0), (0.0, 50.0));
    let b = rooms.room("B", (-5.0, 0.0), (5.0, 15.0));
    let c = rooms.tall_room("C", (0.0, 5.0), (5.0, 15.0), (0.0, 50.0));
    rooms.door(a, b, &at_y(5.0, (-4.0, -2.0), TALL));
    rooms.door(a, c, &at_y(5.0, (2.0, 4.0), (0.0, top)));
    rooms.door(b, c, &at_x(0.0, (8.0, 12.0), TALL));
    rooms
}

#[test]
fn v11_a_late_view_joins_a_queued_cell() {
    let mut rooms = late_view(2.5);
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, v(4.0, 0.0, 1.5), Vec3::Y, 2.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "C", "B"]);
    let views = views_of(&rooms, &flood, &camera, "B");
    assert_eq!(views.len(), 2);
    assert_x(views[0], -1.6, -1.2);
    assert_x(views[1], -0.4, -1.0 / 3.0);
    assert!((flood.cells()[1].key - 31.25).abs() < 1e-3 && (flood.cells()[2].key - 162.25).abs() < 1e-3);
    assert_eq!(
        (flood.counters().moves, flood.counters().incremental_clips),
        (0, 0)
    );
}

#[test]
fn v12_a_late_view_repairs_a_finished_cell() {
    let mut rooms = late_view(40.0);
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, v(4.0, 0.0, 1.5), Vec3::Y, 2.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "C", "B"]);
    assert!(
        (flood.cells()[1].key - 1511.25).abs() < 0.01,
        "{}",
        flood.cells()[1].key
    );
    assert_eq!(views_of(&rooms, &flood, &camera, "B").len(), 2);
    assert_eq!(
        (flood.counters().moves, flood.counters().incremental_clips),
        (1, 1)
    );
}

fn ring() -> Rooms {
    let mut rooms = Rooms::new();
    let s = rooms.room("S", (-4.0, 4.0), (-4.0, -2.0));
    let e = rooms.room("E", (2.0, 4.0), (-2.0, 2.0));
    let n = rooms.room("N", (-4.0, 4.0), (2.0, 4.0));
    let w = rooms.room("W", (-4.0, -2.0), (-2.0, 2.0));
    rooms.door(s, e, &at_y(-2.0, (2.0, 4.0), (0.0, 3.0)));
    rooms.door(s, w, &at_y(-2.0, (-4.0, -2.0), (0.0, 3.0)));
    rooms.door(e, n, &at_y(2.0, (2.0, 4.0), (0.0, 3.0)));
    rooms.door(w, n, &at_y(2.0, (-4.0, -2.0), (0.0, 3.0)));
    rooms
}

#[test]
fn v13_v14_a_ring_round_a_pillar_ends() {
    let mut rooms = ring();
    let openings = rooms.build();
    let mut pview = PView::default();
    let narrow = camera(0, v(3.0, -3.0, 1.5), Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &narrow);
    assert_eq!(rooms.list(&flood), ["S", "E", "N"]);
    assert_eq!(flood.view_count(), 3);
    assert_x(views_of(&rooms, &flood, &narrow, "E")[0], -1.0, 1.0);
    assert_x(views_of(&rooms, &flood, &narrow, "N")[0], -0.2, 0.2);
    let wide = camera(0, v(0.0, -3.0, 1.5), Vec3::Y, 5.0);
    let flood = pview.look_in_block(Some(&openings), &wide);
    assert_eq!(rooms.list(&flood), ["S", "E", "W"]);
    assert!((flood.cells()[1].key - 19.25).abs() < 1e-3 && (flood.cells()[2].key - 19.25).abs() < 1e-3);
    assert_x(views_of(&rooms, &flood, &wide, "E")[0], 2.0, 4.0);
}

#[test]
fn v15_v16_a_window() {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", HALL, HALL);
    rooms.exit(a, &at_y(5.0, (-1.0, 1.0), (1.0, 2.0)));
    let openings = rooms.build();
    let mut pview = PView::default();
    let north = camera(0, EYE, Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &north);
    assert_eq!(rooms.list(&flood), ["A"]);
    assert_eq!(flood.outside().len(), 1);
    assert_bounds(
        slopes(&north, flood.outside().next().unwrap()),
        [-0.2, 0.2, -0.1, 0.1],
    );
    assert_eq!(flood.seals().len(), 1);
    let flood = pview.look_in_block(Some(&openings), &camera(0, EYE, -Vec3::Y, 1.0));
    assert!(!flood.sees_outside());
    assert_eq!(
        flood.seals().len(),
        1,
        "seals are listed whether they face the eye or not"
    );
}

#[test]
fn v17_a_window_two_rooms_away() {
    for (span, want) in [((-0.5, 0.5), Some((-1.0 / 30.0, 1.0 / 30.0))), ((4.0, 5.0), None)] {
        let mut rooms = two_rooms();
        rooms.exit(1, &at_y(15.0, span, (1.0, 2.0)));
        let openings = rooms.build();
        let mut pview = PView::default();
        let camera = camera(0, EYE, Vec3::Y, 1.0);
        let flood = pview.look_in_block(Some(&openings), &camera);
        assert_eq!(rooms.list(&flood), ["A", "B"]);
        assert_eq!(flood.outside().len(), usize::from(want.is_some()));
        if let Some((low, high)) = want {
            assert_bounds(
                slopes(&camera, flood.outside().next().unwrap()),
                [low, high, low, high],
            );
        }
    }
}

#[test]
fn v21_v22_an_eye_in_the_door_plane_sees_through_it() {
    for (y, both) in [(5.0, false), (4.9999, false), (4.999, true)] {
        let eye = v(0.0, y, 1.5);
        let mut rooms = two_rooms();
        let openings = rooms.build();
        let mut pview = PView::default();
        let north = camera(0, eye, Vec3::Y, 1.0);
        let flood = pview.look_in_block(Some(&openings), &north);
        assert_eq!(rooms.list(&flood), ["A", "B"], "y {y}");
        assert_bounds(views_of(&rooms, &flood, &north, "B")[0], [-1.0, 1.0, -1.0, 1.0]);
        let retail = seen_with(&mut two_rooms(), 0, eye, Vec3::Y, 1.0, FloodSettings::retail());
        let want: &[&str] = if both { &["A", "B"] } else { &["A"] };
        assert_eq!(retail, want, "retail, y {y}");
    }
    assert_eq!(seen(&mut two_rooms(), 0, v(0.0, 5.0, 1.5), Vec3::X), ["A", "B"]);
    let from_b = seen(&mut two_rooms(), 1, v(0.0, 5.0, 1.5), Vec3::Y);
    assert_eq!(from_b, ["B", "A"]);
    // Beside the opening the plane is a wall.
    assert_eq!(seen(&mut two_rooms(), 0, v(3.0, 5.0, 1.5), Vec3::Y), ["A"]);
}

#[test]
fn v23_a_door_half_behind_the_eye() {
    let mut rooms = two_rooms();
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, v(0.9, 4.95, 1.5), Vec3::X, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B"]);
    let bounds = views_of(&rooms, &flood, &camera, "B")[0];
    assert_bounds(bounds, [-1.0, -0.5, -1.0, 1.0]);
}

#[test]
fn v24_a_door_edge_on() {
    let eye = v(-4.0, 4.9995, 1.5);
    assert_eq!(seen(&mut two_rooms(), 0, eye, Vec3::X), ["A", "B"]);
    let one_pixel = FloodSettings {
        min_px: 1.0,
        ..FloodSettings::default()
    };
    assert_eq!(
        seen_with(&mut two_rooms(), 0, eye, Vec3::X, 1.0, one_pixel),
        ["A"]
    );
}

#[test]
fn v25_a_link_that_is_no_exact_match_clips_twice() {
    let (p, q) = (at_y(5.0, (-1.0, 1.0), TALL), at_y(5.0, (0.0, 2.0), TALL));
    for (q, exact, want) in [
        (q.clone(), false, Some((0.0, 0.2))),
        (q, true, Some((-0.2, 0.2))),
        (at_y(5.0, (3.0, 4.0), TALL), false, None),
    ] {
        let mut rooms = Rooms::new();
        let a = rooms.room("A", HALL, (-5.0, 5.0));
        let b = rooms.room("B", HALL, (5.0, 15.0));
        rooms.mismatched_door(a, &p, b, &q, exact);
        let openings = rooms.build();
        let mut pview = PView::default();
        let camera = camera(0, EYE, Vec3::Y, 1.0);
        let flood = pview.look_in_block(Some(&openings), &camera);
        match want {
            Some((low, high)) => assert_x(views_of(&rooms, &flood, &camera, "B")[0], low, high),
            None => assert_eq!(rooms.list(&flood), ["A"]),
        }
    }
}

#[test]
fn v26_a_neighbour_that_is_not_loaded_is_counted() {
    let mut rooms = two_rooms();
    rooms.specs.pop();
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, EYE, Vec3::Y, 1.0));
    assert_eq!(flood.cells().len(), 1);
    assert_eq!(flood.counters().dead_portals, 1);
    assert_eq!(openings.problems().unresolved_portals, 1);
    // Out of view it is no hole.
    let flood = pview.look_in_block(Some(&openings), &camera(0, EYE, -Vec3::Y, 1.0));
    assert_eq!(flood.counters().dead_portals, 0);
}

#[test]
fn v27_the_stab_list_gates_only_in_strict_mode() {
    let mut rooms = two_rooms();
    let openings = vestibule_view::BlockOpenings::from_rooms(BLOCK, &rooms.specs);
    let camera = camera(0, EYE, Vec3::Y, 1.0);
    let mut strict = PView::new(FloodSettings::retail());
    assert_eq!(rooms.list(&strict.look_in_block(Some(&openings), &camera)), ["A"]);
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B"]);
    assert_eq!(flood.counters().entered_outside_stab, 1);
    let openings = rooms.build();
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(flood.counters().entered_outside_stab, 0);
}

#[test]
fn s5_7_the_order_of_a_stab_list_does_not_matter() {
    let mut rooms = corridor((-1.0, 1.0));
    let d = rooms.room("D", (-9.0, -1.0), (10.0, 12.0));
    rooms.door(d, 1, &at_x(-1.0, (10.0, 12.0), (0.0, 3.0)));
    rooms.full_stabs();
    let camera = camera(0, v(0.0, 1.0, 1.5), Vec3::Y, 1.0);
    let mut strict = PView::new(FloodSettings::retail());
    for turn in 0..3 {
        rooms.specs[0].stab_list.rotate_left(1);
        rooms.specs[0].stab_list.reverse();
        let openings = vestibule_view::BlockOpenings::from_rooms(BLOCK, &rooms.specs);
        let flood = strict.look_in_block(Some(&openings), &camera);
        assert_eq!(flood.cells().len(), 4, "turn {turn}");
    }
}

#[test]
fn v28_a_cellar_hatch() {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", HALL, HALL);
    let k = rooms.tall_room("K", (-2.0, 2.0), (0.0, 4.0), (-3.0, 0.0));
    rooms.door(k, a, &at_z(0.0, (-1.0, 1.0), (1.0, 3.0)));
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, EYE, -Vec3::Z, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "K"]);
    let bounds = views_of(&rooms, &flood, &camera, "K")[0];
    assert_bounds(bounds, [-2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 1.0]);
}

#[test]
fn v29_a_root_that_is_not_convex_is_not_entered_again() {
    let mut rooms = Rooms::new();
    let u = rooms.room("U", (-6.0, 6.0), (-4.0, 10.0));
    let m = rooms.room("M", (-2.0, 2.0), (0.0, 10.0));
    rooms.door(u, m, &at_x(-2.0, (4.0, 6.0), TALL));
    rooms.door(m, u, &at_x(2.0, (4.0, 6.0), TALL));
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, v(-4.0, 5.0, 1.5), Vec3::X, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["U", "M"]);
    assert_eq!(rooms.views(&flood).into_values().collect::<Vec<_>>(), [1, 1]);
    assert_eq!(flood.counters().ancestor_rejections, 1);
    assert_x(views_of(&rooms, &flood, &camera, "M")[0], -0.5, 0.5);
}

fn overlapping() -> Rooms {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", HALL, (-5.0, 5.0));
    let b = rooms.room("B", HALL, (5.0, 15.0));
    let c = rooms.room("B'", HALL, (5.0, 15.0));
    rooms.door(a, b, &at_y(5.0, (-3.0, -1.0), TALL));
    rooms.door(a, c, &at_y(5.0, (1.0, 3.0), TALL));
    rooms
}

#[test]
fn v30_rooms_in_the_same_place_show_only_through_their_doors() {
    let mut rooms = overlapping();
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, EYE, Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B", "B'"]);
    assert_x(views_of(&rooms, &flood, &camera, "B")[0], -0.6, -0.2);
    assert_x(views_of(&rooms, &flood, &camera, "B'")[0], 0.2, 0.6);
}

#[test]
fn v31_a_two_cycle_ends() {
    let mut rooms = overlapping();
    let link = at_y(10.0, HALL, (0.0, 3.0));
    rooms.door(1, 2, &link);
    rooms.door(2, 1, &link);
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(0, EYE, Vec3::Y, 1.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B", "B'"]);
    let (b, c) = (
        views_of(&rooms, &flood, &camera, "B"),
        views_of(&rooms, &flood, &camera, "B'"),
    );
    assert_eq!((b.len(), c.len()), (2, 2));
    assert_x(b[1], 0.2, 0.5);
    assert_x(c[1], -0.5, -0.2);
    assert_eq!(flood.counters().ancestor_rejections, 2);
}

#[test]
fn v32_a_hall_of_doors() {
    let mut rooms = Rooms::new();
    for k in 0..41 {
        let south = -5.0 + 10.0 * k as f32;
        rooms.room(&format!("R{k}"), HALL, (south, south + 10.0));
    }
    for k in 0..40 {
        rooms.door(k, k + 1, &at_y(5.0 + 10.0 * k as f32, (-1.0, 1.0), TALL));
    }
    let openings = rooms.build();
    let look = |settings: FloodSettings, pixels: f32| {
        let mut pview = PView::new(settings);
        let full = core::f32::consts::FRAC_PI_2;
        let viewport = glam::Vec2::splat(pixels);
        let camera = vestibule_view::Camera::new(id(0), EYE, Vec3::Y, Vec3::Z, full, viewport).unwrap();
        pview.look_in_block(Some(&openings), &camera).cells().len()
    };
    assert_eq!(look(FloodSettings::default(), 512.0), 41);
    assert_eq!(look(FloodSettings::default(), 256.0), 41);
    assert_eq!(look(FloodSettings::retail(), 512.0), 41);
    assert_eq!(look(FloodSettings::retail(), 256.0), 27);
}

#[test]
fn v33_an_eye_one_cell_ahead_of_its_root() {
    let eye = v(0.0, 5.5, 1.5);
    let no_guard = FloodSettings {
        guard_wrong_cell: false,
        ..FloodSettings::default()
    };
    assert_eq!(seen_with(&mut two_rooms(), 0, eye, Vec3::Y, 1.0, no_guard), ["A"]);
    let mut rooms = two_rooms();
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, eye, Vec3::Y, 1.0));
    assert_eq!(rooms.list(&flood), ["B"]);
    assert_eq!(flood.counters().wrong_cell, 1);
}

#[test]
fn s5_3a_the_portal_a_view_comes_in_by_is_never_looked_back_through() {
    // The eye is in the door's plane, so the far side's portal would count as an out portal by itself (4.2).
    let mut rooms = two_rooms();
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, v(0.0, 5.0, 1.5), Vec3::Y, 1.0));
    assert_eq!(rooms.list(&flood), ["A", "B"]);
    assert_eq!(flood.counters().ancestor_rejections, 0);
    // It is an in portal, and so it counts for the key (5.4).
    assert!(flood.cells()[1].key > 1.0, "{}", flood.cells()[1].key);
}
