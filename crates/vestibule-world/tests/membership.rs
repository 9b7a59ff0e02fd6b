//! Worked examples of `world.md` 22 about cells and who is in them, and `evidence.md` E1.

use glam::Vec3;
use vestibule_testing::doorway_e1;
use vestibule_testing::records::{Builder, Room};
use vestibule_world::{CellArray, CellId, Position, Sphere, World, adjust_position, find_cell_list};

fn list(world: &World, seed: u32, spheres: &[Sphere]) -> (Vec<u32>, Option<u32>, bool) {
    let mut array = CellArray::new();
    list_in(world, seed, spheres, &mut array)
}

fn list_in(
    world: &World,
    seed: u32,
    spheres: &[Sphere],
    array: &mut CellArray,
) -> (Vec<u32>, Option<u32>, bool) {
    let origin = spheres.first().map_or(Vec3::ZERO, |s| s.center);
    let found = find_cell_list(world, CellId(seed), origin, spheres, array, true);
    let ids = array.entries().iter().map(|e| e.id.0).collect();
    (ids, found.containing.map(|c| c.0), found.hits_interior)
}

fn sphere(x: f32, y: f32, z: f32, radius: f32) -> Sphere {
    Sphere::new(Vec3::new(x, y, z), radius)
}

/// Landblock A9B4 and the eight around it, and the corner block 0000, flat.
fn meadow() -> World {
    let mut b = Builder::new(0xA9B4);
    for x in 0xA8..=0xAA_u16 {
        for y in 0xB3..=0xB5 {
            b.flat_block(x << 8 | y);
        }
    }
    b.flat_block(0x0000);
    b.world()
}

#[test]
fn examples_22_11_to_22_16_outside_cells() {
    let world = meadow();
    let cells = |seed: u32, x: f32, y: f32, r: f32| list(&world, seed, &[sphere(x, y, 1.0, r)]).0;
    assert_eq!(cells(0xA9B4_0001, 12.0, 12.0, 0.48), [0xA9B4_0001]);
    assert_eq!(cells(0xA9B4_0001, 23.8, 12.0, 0.48), [0xA9B4_0001, 0xA9B4_0009]);
    assert_eq!(
        cells(0xA9B4_0001, 0.2, 0.2, 0.48),
        [0xA9B4_0001, 0xA8B4_0039, 0xA8B3_0040, 0xA9B3_0008]
    );
    assert_eq!(
        cells(0xA9B4_0040, 191.8, 191.8, 0.48),
        [0xA9B4_0040, 0xAAB4_0008, 0xAAB5_0001, 0xA9B5_0039]
    );
    assert_eq!(cells(0x0000_0001, 0.2, 0.2, 0.48), [0x0000_0001]);
    assert_eq!(
        cells(0xA9B4_0001, 12.0, 12.0, 13.0),
        [
            0xA9B4_0001,
            0xA9B4_0009,
            0xA9B4_000A,
            0xA9B3_0010,
            0xA8B4_0039,
            0xA8B4_003A,
            0xA8B3_0040,
            0xA9B4_0002,
            0xA9B3_0008
        ]
    );
}

#[test]
fn o1_a_sphere_that_just_touches_an_edge_does_not_add_the_neighbour() {
    let world = meadow();
    assert_eq!(
        list(&world, 0xA9B4_0001, &[sphere(23.5, 12.0, 1.0, 0.5)]).0,
        [0xA9B4_0001]
    );
}

#[test]
fn example_22_33_edge_ties_go_to_the_last_land_cell() {
    let world = meadow();
    let (cells, containing, interior) = list(&world, 0xA9B4_0001, &[sphere(24.0, 12.0, 1.0, 0.48)]);
    assert_eq!(
        (cells, containing, interior),
        (vec![0xA9B4_0009, 0xA9B4_0001], Some(0xA9B4_0001), false)
    );
    let (cells, containing, _) = list(&world, 0xA9B4_0001, &[sphere(24.0, 24.0, 1.0, 0.48)]);
    assert_eq!(cells, [0xA9B4_000A, 0xA9B4_0002, 0xA9B4_0001, 0xA9B4_0009]);
    assert_eq!(containing, Some(0xA9B4_0009));
}

/// Room 0100 at y 0…5 whose portal at y = 5 leads where `other` says, interior on the negative side.
fn room_to(other: Option<u16>, side: bool) -> World {
    let portal = [[2.0, 5.0, 0.0], [1.0, 5.0, 0.0], [1.0, 5.0, 2.0], [2.0, 5.0, 2.0]];
    let mut b = Builder::new(0xA9B4);
    b.room(Room::of_box(0x100, Vec3::ZERO, Vec3::new(5.0, 5.0, 3.0)).opening(other, 0, side, &portal));
    b.world()
}

#[test]
fn example_22_27_outside_portals_are_checked_by_their_plane() {
    let world = room_to(None, true);
    for (y, checked) in [(4.6, true), (4.5, false), (5.4, true), (5.5, false)] {
        let (cells, ..) = list(&world, 0xA9B4_0100, &[sphere(1.5, y, 1.0, 0.48)]);
        assert_eq!(cells.len() > 1, checked, "{y}: {cells:08X?}");
    }
}

#[test]
fn example_22_28_absent_neighbours_are_listed_without_a_cell() {
    for (side, y, listed) in [
        (true, 4.6, true),
        (true, 4.5, false),
        (true, 7.0, true),
        (false, 4.6, true),
        (false, 5.4, true),
        (false, 5.5, false),
        (false, 3.0, true),
    ] {
        let world = room_to(Some(0x101), side);
        let mut array = CellArray::new();
        let (cells, ..) = list_in(&world, 0xA9B4_0100, &[sphere(1.5, y, 1.0, 0.48)], &mut array);
        assert_eq!(cells.contains(&0xA9B4_0101), listed, "side {side}, y {y}");
        assert!(array.entries().iter().all(|e| e.id.low() == 0x100 || !e.resident));
    }
}

const HOUSE: u32 = 0xA9B4_0100;

/// A house over land cell A9B40012 (x 48…72, y 24…48): room 0100 with a door to the south.
fn house() -> World {
    let door = [
        [60.0, 30.0, 0.0],
        [61.5, 30.0, 0.0],
        [61.5, 30.0, 2.2],
        [60.0, 30.0, 2.2],
    ];
    let mut b = Builder::new(0xA9B4);
    let mut room = Room::of_box(0x100, Vec3::new(55.0, 30.0, 0.0), Vec3::new(65.0, 40.0, 3.0))
        .opening(None, -1, true, &door);
    room.seen_outside = true;
    b.room(room).building(Vec3::new(60.0, 35.0, 0.0), &[(0x100, 0)]);
    b.world()
}

#[test]
fn example_22_30_a_building_is_entered_from_its_land_cell() {
    let world = house();
    let (cells, containing, interior) = list(&world, 0xA9B4_0012, &[sphere(60.7, 30.5, 0.5, 0.48)]);
    assert_eq!(cells, [0xA9B4_0012, HOUSE]);
    assert_eq!((containing, interior), (Some(HOUSE), true));
}

#[test]
fn example_22_31_leaving_through_the_outside_portal() {
    let world = house();
    let (cells, containing, interior) = list(&world, HOUSE, &[sphere(60.7, 29.8, 0.5, 0.48)]);
    assert_eq!(cells, [HOUSE, 0xA9B4_0012]);
    assert_eq!((containing, interior), (Some(0xA9B4_0012), true));
}

#[test]
fn d5_a_room_away_from_every_portal_is_not_found_from_outdoors() {
    let mut b = Builder::new(0xA9B4);
    b.room(
        Room::of_box(0x100, Vec3::new(55.0, 30.0, 0.0), Vec3::new(65.0, 40.0, 3.0)).opening(
            Some(0x101),
            0,
            true,
            &[[55.0, 31.0, 0.0], [55.0, 32.0, 0.0], [55.0, 32.0, 2.0]],
        ),
    );
    let world = b.world();
    assert!(world.point_in_cell(CellId(HOUSE), Vec3::new(60.0, 35.0, 1.0)));
    assert_eq!(
        list(&world, 0xA9B4_0012, &[sphere(60.0, 35.0, 1.0, 0.48)]).0,
        [0xA9B4_0012]
    );
}

#[test]
fn p3_a_cell_without_portals_contains_no_point() {
    let mut b = Builder::new(0xA9B4);
    b.room(Room::of_box(0x100, Vec3::ZERO, Vec3::splat(5.0)));
    assert!(!b.world().point_in_cell(CellId(HOUSE), Vec3::ONE));
}

/// Rooms 0100, 0101, 0102 in a ring of three around one corner, all reachable from 0100.
fn three_rooms(stabs: &[u16]) -> World {
    let m = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let portal = |x: f32, y: f32| [[x, y, 0.0], [x + 0.5, y, 0.0], [x + 0.5, y, 2.0], [x, y, 2.0]];
    let mut b = Builder::new(0x1234);
    b.room(
        Room::of_box(0x100, m(0.0, 0.0), Vec3::new(5.0, 5.0, 3.0))
            .opening(Some(0x102), 0, true, &portal(4.4, 5.0))
            .opening(Some(0x101), 0, true, &portal(4.0, 5.0))
            .stabs(stabs),
    );
    for low in [0x101, 0x102] {
        b.room(Room::of_box(low, m(0.0, 5.0), Vec3::new(5.0, 10.0, 3.0)).opening(
            Some(0x100),
            0,
            false,
            &portal(4.0, 5.0),
        ));
    }
    b.world()
}

#[test]
fn example_22_32_the_prune_keeps_the_seed_and_its_stabs() {
    let world = three_rooms(&[0x101]);
    let touching = [sphere(4.4, 4.9, 1.0, 0.48)];
    let mut array = CellArray::new();
    assert_eq!(
        list_in(&world, 0x1234_0100, &touching, &mut array).0,
        [0x1234_0100, 0x1234_0102, 0x1234_0101]
    );
    array.do_not_load_cells = true;
    assert_eq!(
        list_in(&world, 0x1234_0100, &touching, &mut array).0,
        [0x1234_0100, 0x1234_0101]
    );
}

#[test]
fn s5_the_prune_runs_after_an_interior_hit_and_the_result_stays() {
    let world = three_rooms(&[]);
    let mut array = CellArray::new();
    array.do_not_load_cells = true;
    let (cells, containing, _) = list_in(&world, 0x1234_0100, &[sphere(4.4, 5.1, 1.0, 0.48)], &mut array);
    assert_eq!(cells, [0x1234_0100]);
    assert_eq!(containing, Some(0x1234_0102), "S8: chosen before the prune");
}

#[test]
fn s2_a_point_in_two_cells_stays_in_the_seed_cell() {
    let world = three_rooms(&[]);
    let overlap = [sphere(4.4, 5.0001, 1.0, 0.48)];
    assert_eq!(list(&world, 0x1234_0100, &overlap).1, Some(0x1234_0100));
    assert_eq!(list(&world, 0x1234_0101, &overlap).1, Some(0x1234_0101));
}

#[test]
fn example_22_33_an_absent_indoor_seed_is_listed_alone() {
    let world = three_rooms(&[]);
    let (cells, containing, interior) = list(&world, 0x1234_01AA, &[sphere(1.0, 1.0, 1.0, 0.48)]);
    assert_eq!((cells, containing, interior), (vec![0x1234_01AA], None, true));
}

#[test]
fn z2_no_cell_no_spheres_and_no_numbers_are_answered() {
    let world = three_rooms(&[]);
    assert_eq!(
        list(&world, 0, &[sphere(1.0, 1.0, 1.0, 0.48)]),
        (vec![], None, false)
    );
    assert_eq!(list(&world, 0x1234_0001, &[]).0, [0x1234_0001]);
    for bad in [f32::NAN, f32::INFINITY, -1.0e30] {
        list(&world, 0x1234_0001, &[sphere(bad, 1.0, bad, bad)]);
        list(&world, 0x1234_0100, &[sphere(1.0, bad, bad, bad)]);
        let p = Position::new(CellId(0x1234_0100), Vec3::splat(bad));
        adjust_position(&world, &p, Vec3::ZERO, true);
    }
}

#[test]
fn v4_adjust_position_locates_the_centre_indoors_and_the_origin_outdoors() {
    let world = house();
    let low_point = Vec3::new(0.0, 0.0, 0.475);
    let adjust = |cell: u32, x: f32, y: f32| {
        let p = Position::new(CellId(cell), Vec3::new(x, y, 0.0));
        adjust_position(&world, &p, low_point, true).map(|a| a.position.cell.0)
    };
    assert_eq!(adjust(HOUSE, 60.0, 35.0), Some(HOUSE));
    assert_eq!(
        adjust(HOUSE, 60.0, 20.0),
        Some(0xA9B4_0011),
        "seen_outside falls back outdoors"
    );
    assert_eq!(
        adjust(0xA9B4_0012, 60.0, 35.0),
        Some(0xA9B4_0012),
        "outdoors never looks indoors"
    );
    assert_eq!(adjust(0xA9B4_0101, 60.0, 35.0), None, "not resident");
    assert_eq!(adjust(0xA9B4_0041, 60.0, 35.0), None, "not a cell");
    let sealed = three_rooms(&[0x101]);
    let p = |y: f32| Position::new(CellId(0x1234_0100), Vec3::new(4.0, y, 1.0));
    let cell =
        |y: f32, search| adjust_position(&sealed, &p(y), Vec3::ZERO, search).map(|a| a.position.cell.0);
    assert_eq!(cell(6.0, true), Some(0x1234_0101), "stab list");
    assert_eq!(cell(6.0, false), Some(0x1234_0102), "first portal neighbour");
    assert_eq!(cell(20.0, true), None, "sealed: no fallback");
}

#[test]
fn e1_nineteen_rows_of_the_doorway_recording() {
    let world = doorway_e1::doorway(47).world();
    // Which point of the body is tested is what the recording settles: centre of the first sphere, not the feet.
    let picked = |height: f32| {
        doorway_e1::rows()
            .iter()
            .filter(|row| {
                let center = Sphere::new(row.feet + Vec3::Z * height, 0.48);
                list(&world, row.seed.0, &[center]).1 == Some(row.picked.0)
            })
            .count()
    };
    assert_eq!(picked(0.475), 19, "centre of the first sphere");
    assert_eq!(picked(0.0), 17, "feet");
    assert_eq!(picked(1.35), 16, "centre of the second sphere");
}
