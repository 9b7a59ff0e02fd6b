//! Bad input never makes a panic, a runaway, or an empty answer without a counted reason.

mod common;

use common::maze::Random;
use common::*;
use glam::{Quat, Vec2, Vec3};
use proptest::prelude::*;
use vestibule_view::{BlockOpenings, Camera, FloodSettings, Openings, PView, PortalSpec, RoomSpec};
use vestibule_world::{BlockId, CellBsp, CellId, Frame, PortalTarget};

#[test]
fn a_cell_that_is_not_loaded_is_counted() {
    let mut rooms = Rooms::new();
    rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
    let openings = rooms.build();
    let mut pview = PView::default();
    for cell in [
        0xA9B4_0101,
        0xA9B4_0001,
        0xA9B4_FFFF,
        0xA9B4_FFFE,
        0xA9B5_0100,
        0,
        u32::MAX,
    ] {
        let camera = Camera::new(CellId(cell), v(0.0, 0.0, 1.5), Vec3::Y, Vec3::Z, 1.0, VIEWPORT).unwrap();
        let flood = pview.look_in_block(Some(&openings), &camera);
        assert!(flood.cells().is_empty() && !flood.sees_outside());
        assert_eq!(flood.counters().missing_root, 1, "{cell:08X}");
        assert_eq!(pview.look_in_block(None, &camera).counters().missing_root, 1);
    }
}

#[test]
fn an_eye_outside_every_cell_still_gets_its_root() {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
    let b = rooms.room("B", (-5.0, 5.0), (5.0, 15.0));
    rooms.door(a, b, &at_y(5.0, (-1.0, 1.0), TALL));
    let openings = rooms.build();
    let mut pview = PView::default();
    for eye in [
        v(500.0, 0.0, 1.5),
        v(0.0, 0.0, -40.0),
        v(0.0, 3.0e5, 0.0),
        v(0.0, 5.0, 0.0),
        v(1.0, 5.0, 2.5),
    ] {
        let flood = pview.look_in_block(Some(&openings), &camera(a, eye, Vec3::Y, 1.0));
        assert_eq!(flood.cells()[0].id, id(a));
    }
}

#[test]
fn a_point_that_is_no_number_sees_nothing_all_around() {
    let mut rooms = Rooms::new();
    rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_around(Some(&openings), id(0), Vec3::NAN);
    assert_eq!(flood.counters().missing_root, 1);
}

#[test]
fn s12_7_unusable_portals_are_closed_and_counted() {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
    let b = rooms.room("B", (-5.0, 5.0), (5.0, 15.0));
    for polygon in [
        vec![],
        vec![v(0.0, 5.0, 0.0)],
        vec![v(0.0, 5.0, 0.0); 4],
        vec![v(0.0, 5.0, 0.0), v(1.0, 5.0, 0.0), v(2.0, 5.0, 0.0)],
        vec![v(0.0, 5.0, f32::NAN), v(1.0, 5.0, 0.0), v(0.0, 5.0, 1.0)],
        vec![v(0.0, 5.0, f32::INFINITY), v(1.0, 5.0, 0.0), v(0.0, 5.0, 1.0)],
    ] {
        rooms.door(a, b, &polygon);
    }
    let openings = rooms.build();
    assert_eq!(openings.problems().closed_portals, 12);
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(a, v(0.0, 0.0, 1.5), Vec3::Y, 1.0));
    assert_eq!(rooms.list(&flood), ["A"]);
}

#[test]
fn s12_7_polygons_that_are_not_planar_or_not_convex_still_open() {
    let twisted = vec![
        v(1.0, 5.0, 0.0),
        v(-1.0, 5.05, 0.0),
        v(-1.0, 4.95, 2.0),
        v(1.0, 5.05, 2.0),
    ];
    let l_shape = vec![
        v(1.0, 5.0, 0.0),
        v(-1.0, 5.0, 0.0),
        v(-1.0, 5.0, 2.0),
        v(0.0, 5.0, 2.0),
        v(0.0, 5.0, 1.0),
        v(1.0, 5.0, 1.0),
    ];
    for (polygon, pieces) in [(twisted, 1), (l_shape, 2)] {
        let mut rooms = Rooms::new();
        let a = rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
        let b = rooms.room("B", (-5.0, 5.0), (5.0, 15.0));
        rooms.door(a, b, &polygon);
        let openings = rooms.build();
        let mut pview = PView::default();
        let camera = camera(a, v(0.0, 0.0, 1.0), Vec3::Y, 1.0);
        let flood = pview.look_in_block(Some(&openings), &camera);
        assert_eq!(rooms.list(&flood), ["A", "B"]);
        assert!(flood.regions(&flood.cells()[1]).len() >= pieces);
        let area: f32 = flood
            .regions(&flood.cells()[1])
            .map(|r| r.pixel_area(&camera))
            .sum();
        let whole = if pieces == 1 { 4.0 } else { 3.0 };
        let want = whole * (256.0 / 5.0) * (256.0 / 5.0);
        assert!((area - want).abs() < want * 0.03, "{area}, expected {want}");
    }
}

#[test]
fn a_stab_list_that_names_absent_cells_is_counted() {
    let mut rooms = Rooms::new();
    rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
    rooms.specs[0].stab_list = vec![CellId(0xA9B4_0105), CellId(0x0001_0100), CellId(0xA9B4_FFFF)];
    let openings = BlockOpenings::from_rooms(BLOCK, &rooms.specs);
    assert_eq!(openings.problems().absent_stabs, 3);
    let mut pview = PView::new(FloodSettings::retail());
    let flood = pview.look_in_block(Some(&openings), &camera(0, v(0.0, 0.0, 1.5), Vec3::Y, 1.0));
    assert_eq!(rooms.list(&flood), ["A"]);
}

#[test]
fn rooms_that_do_not_belong_are_left_out() {
    let mut rooms = Rooms::new();
    rooms.room("A", (-5.0, 5.0), (-5.0, 5.0));
    rooms.room("twin", (-5.0, 5.0), (-5.0, 5.0));
    rooms.room("elsewhere", (-5.0, 5.0), (-5.0, 5.0));
    rooms.specs[1].id = id(0);
    rooms.specs[2].id = CellId(0x0000_0100);
    assert_eq!(BlockOpenings::from_rooms(BLOCK, &rooms.specs).room_count(), 1);
}

/// `visibility.md` 13.4: more views than a cell may have become one that bounds them.
#[test]
fn s13_4_a_cell_with_a_thousand_portals() {
    let mut rooms = Rooms::new();
    let a = rooms.room("A", (-50.0, 50.0), (-5.0, 5.0));
    let b = rooms.room("B", (-50.0, 50.0), (5.0, 15.0));
    for k in 0..500 {
        let x = -25.0 + 0.1 * k as f32;
        rooms.door(a, b, &at_y(5.0, (x, x + 0.08), TALL));
        rooms.exit(a, &at_y(5.0, (x, x + 0.08), (2.6, 2.9)));
    }
    let openings = rooms.build();
    let mut pview = PView::default();
    let camera = camera(a, v(0.0, -4.0, 1.5), Vec3::Y, 5.0);
    let flood = pview.look_in_block(Some(&openings), &camera);
    assert_eq!(rooms.list(&flood), ["A", "B"]);
    assert_eq!(
        (flood.regions(&flood.cells()[1]).len(), flood.outside().len()),
        (1, 1)
    );
    assert!(flood.cells()[1].saturated && !flood.truncated());
    assert_eq!(flood.counters().saturated_cells, 2);
    let bounds = views_of(&rooms, &flood, &camera, "B")[0];
    // The first 65 doors at least lie inside the one view.
    assert!(
        bounds[0] <= -25.0 / 9.0 + 1e-3 && bounds[1] >= -18.6 / 9.0 - 1e-3,
        "{bounds:?}"
    );
}

/// Every room linked to every other by openings in the same place: chains without end but for the rules.
#[test]
fn s13_4_a_clique_of_coincident_links_ends_and_drops_no_room() {
    for count in [8, 40] {
        let mut rooms = Rooms::new();
        for k in 0..count {
            rooms.room(&format!("R{k}"), (-5.0, 5.0), (-5.0, 15.0));
        }
        let link = at_y(5.0, (-1.0, 1.0), TALL);
        for a in 0..count {
            for b in 0..count {
                if a != b {
                    rooms.door(a, b, &link);
                }
            }
        }
        let openings = rooms.build();
        let mut pview = PView::default();
        let flood = pview.look_in_block(Some(&openings), &camera(0, v(0.0, 0.0, 1.5), Vec3::Y, 1.0));
        assert_eq!(flood.cells().len(), count);
        assert!(flood.view_count() <= 4096 + count);
        assert!(count == 8 || flood.truncated() || flood.counters().saturated_cells > 0);
    }
}

/// `visibility.md` 13.4: a chain longer than the limit is widened, not cut.
#[test]
fn s13_4_a_very_long_hall_keeps_its_far_end() {
    let mut rooms = Rooms::new();
    for k in 0..300 {
        let south = k as f32;
        rooms.room(&format!("R{k}"), (-5.0, 5.0), (south, south + 1.0));
    }
    for k in 0..299 {
        rooms.door(k, k + 1, &at_y(1.0 + k as f32, (-1.0, 1.0), TALL));
    }
    let openings = rooms.build();
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, v(0.0, 0.2, 1.5), Vec3::Y, 1.0));
    assert_eq!(flood.cells().len(), 300);
    assert!(flood.truncated());
}

/// 10 000 rooms in a ring of coincident links: deep repairs must not exhaust the stack.
#[test]
fn a_huge_chain_of_rooms_ends() {
    let mut rooms = Rooms::new();
    let count = 10_000;
    for k in 0..count {
        rooms.room(&format!("R{k}"), (-5.0, 5.0), (-5.0, 15.0));
    }
    let link = at_y(5.0, (-1.0, 1.0), TALL);
    for k in 0..count {
        for step in [1, 7, 101] {
            rooms.door(k, (k + step) % count, &link);
        }
    }
    let openings = BlockOpenings::from_rooms(BLOCK, &rooms.specs);
    let mut pview = PView::default();
    let flood = pview.look_in_block(Some(&openings), &camera(0, v(0.0, 0.0, 1.5), Vec3::Y, 1.0));
    assert_eq!(flood.cells().len(), count, "no known room is dropped");
    assert!(flood.truncated());
}

#[test]
fn openings_of_a_landblock_that_is_not_there() {
    let world = vestibule_world::World::open(vestibule_world::MemoryRecords::new());
    // Without a Region record there is no world at all, and the error says so.
    assert!(world.is_err());
    assert!(BlockOpenings::from_rooms(BlockId(0xFFFF), &[]).is_empty());
    drop(Openings::new());
}

fn number(random: &mut Random) -> f32 {
    match random.below(40) {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => -1.0e30,
        3 => 1.0e-30,
        4..=12 => 0.0,
        13..=20 => 5.0,
        _ => random.within(-12.0, 12.0),
    }
}

fn wild_rooms(seed: u64) -> Vec<RoomSpec> {
    let mut random = Random(seed);
    let count = 1 + random.below(8);
    (0..count)
        .map(|k| RoomSpec {
            id: id(k),
            frame: Frame::new(
                Vec3::new(number(&mut random), number(&mut random), number(&mut random)),
                Quat::from_xyzw(number(&mut random), 0.0, number(&mut random), number(&mut random)),
            ),
            bsp: CellBsp::default(),
            portals: (0..random.below(6))
                .map(|_| PortalSpec {
                    target: if random.chance(0.2) {
                        PortalTarget::Outside
                    } else {
                        PortalTarget::Cell(id(random.below(count + 1)))
                    },
                    other_portal: random.chance(0.8).then(|| random.below(6) as u16),
                    vertices: (0..random.below(70))
                        .map(|_| v(number(&mut random), number(&mut random), number(&mut random)))
                        .collect(),
                    interior_is_negative: random.chance(0.5),
                    exact_match: random.chance(0.5),
                })
                .collect(),
            stab_list: (0..random.below(4))
                .map(|_| id(random.below(count + 2)))
                .collect(),
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the data, a traversal ends with the root listed first, each room once, finite unit corners.
    #[test]
    fn wild_rooms_never_hurt(seed: u64, x in -10.0f32..10.0, yaw in 0.0f32..6.3, retail: bool) {
        let specs = wild_rooms(seed);
        let openings = BlockOpenings::from_rooms(BLOCK, &specs);
        let settings = if retail { FloodSettings::retail() } else { FloodSettings::default() };
        let mut pview = PView::new(settings);
        let look = Vec3::new(libm::sinf(yaw), libm::cosf(yaw), 0.1);
        let camera = Camera::new(id(0), v(x, 5.0, 0.0), look, Vec3::Z, 1.5, Vec2::new(800.0, 600.0)).unwrap();
        let flood = pview.look_in_block(Some(&openings), &camera);
        prop_assert!(!flood.cells().is_empty());
        let mut ids: Vec<CellId> = flood.cells().iter().map(|c| c.id).collect();
        ids.sort_unstable();
        ids.dedup();
        prop_assert_eq!(ids.len(), flood.cells().len());
        for cell in flood.cells() {
            for region in flood.regions(cell) {
                for e in region.edges() {
                    prop_assert!(e.corner.is_finite() && e.normal.is_finite());
                    prop_assert!((e.corner.length() - 1.0).abs() < 1e-3);
                }
            }
        }
        pview.look_around(Some(&openings), id(0), v(x, 5.0, 0.0));
    }

    /// No numbers make a camera that is not one.
    #[test]
    fn wild_cameras_are_errors_or_finite(seed: u64) {
        let mut r = Random(seed);
        let mut vec = || Vec3::new(number(&mut r), number(&mut r), number(&mut r));
        let (eye, look, up) = (vec(), vec(), vec());
        let (fov, width) = (number(&mut r), number(&mut r));
        if let Ok(camera) = Camera::new(id(0), eye, look, up, fov, Vec2::new(width, 480.0)) {
            for axis in camera.axes() {
                prop_assert!((axis.length() - 1.0).abs() < 1e-3, "{axis}");
            }
            prop_assert!(camera.slopes().is_finite());
        }
    }
}
