//! Properties that hold for every id, position and world.

use glam::{Quat, Vec3};
use proptest::prelude::*;
use vestibule_testing::records::{Builder, Room};
use vestibule_world::{
    BlockId, CellArray, CellId, Frame, Lanes, MapCoordinates, Position, Sphere, World, add_land_cells,
    find_cell_list, ids::block_offset, transit::add_all_outside_cells,
};

fn block() -> impl Strategy<Value = BlockId> {
    (0u8..255, 0u8..255).prop_map(|(x, y)| BlockId::new(x, y))
}

fn finite() -> impl Strategy<Value = f32> {
    any::<u32>()
        .prop_map(f32::from_bits)
        .prop_filter("finite", |v| v.is_finite())
}

/// Two rooms and a house over one landblock, with another landblock beside it.
fn small_world() -> World {
    let portal = [[2.0, 5.0, 0.0], [1.0, 5.0, 0.0], [1.0, 5.0, 2.0], [2.0, 5.0, 2.0]];
    let door = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 2.0], [1.0, 0.0, 2.0]];
    let mut b = Builder::new(0xA9B4);
    b.flat_block(0xA8B4);
    b.room(
        Room::of_box(0x100, Vec3::ZERO, Vec3::new(5.0, 5.0, 3.0))
            .opening(Some(0x101), 0, true, &portal)
            .opening(None, -1, true, &door)
            .stabs(&[0x101]),
    );
    b.room(
        Room::of_box(0x101, Vec3::new(0.0, 5.0, 0.0), Vec3::new(5.0, 10.0, 3.0)).opening(
            Some(0x100),
            0,
            false,
            &portal,
        ),
    );
    b.building(Vec3::new(2.0, 2.0, 0.0), &[(0x100, 1)]);
    b.world()
}

proptest! {
    #[test]
    fn e2_outdoor_cells_follow_from_the_position(block in block(), x in 0f32..192.0, y in 0f32..192.0) {
        let (id, q) = CellId::new(block, 0xFFFF).adjust_to_outside(Vec3::new(x, y, 0.0)).unwrap();
        let expected = 8.0 * (x / 24.0).floor() + (y / 24.0).floor() + 1.0;
        prop_assert_eq!(f32::from(id.low()), expected);
        prop_assert_eq!(id.block(), block);
        prop_assert!((q.x - x).abs() < 0.0002 && (q.y - y).abs() < 0.0002);
    }

    #[test]
    fn m3_adjusting_keeps_the_place_in_the_world(
        block in block(), x in -5000f32..5000.0, y in -5000f32..5000.0,
    ) {
        let p = Vec3::new(x, y, 1.0);
        if let Some((id, q)) = CellId::new(block, 0x0100).adjust_to_outside(p) {
            prop_assert!((0.0..192.0).contains(&q.x) && (0.0..192.0).contains(&q.y));
            prop_assert!((block_offset(block, id.block()) + q - p).length() < 0.001);
            let again = id.adjust_to_outside(q).unwrap();
            prop_assert_eq!(again.0, id);
        }
    }

    #[test]
    fn land_coordinates_and_ids_are_inverse(block in block(), low in 1u16..=0x40) {
        let id = CellId::new(block, low);
        prop_assert_eq!(id.land_coord().unwrap().cell_id(), id);
    }

    #[test]
    fn positions_read_back_to_the_bit(
        cell in any::<u32>(), o in [finite(), finite(), finite()], q in [finite(), finite(), finite(), finite()],
    ) {
        let frame = Frame::new(Vec3::from_array(o), Quat::from_xyzw(q[0], q[1], q[2], q[3]));
        let p = Position { cell: CellId(cell), frame };
        let back: Position = p.to_string().parse().unwrap();
        prop_assert_eq!(back.cell, p.cell);
        prop_assert_eq!(back.origin().to_array().map(f32::to_bits), o.map(f32::to_bits));
        prop_assert_eq!(back.frame.rotation().to_array().map(f32::to_bits), q.map(f32::to_bits));
    }

    #[test]
    fn no_text_panics_as_a_position(text in "\\PC{0,60}") {
        let _ = text.parse::<Position>();
        let _ = text.parse::<CellId>();
        let _ = text.parse::<MapCoordinates>();
    }

    #[test]
    fn map_coordinates_lead_back_within_a_tenth(block in block(), x in 0f32..192.0, y in 0f32..192.0) {
        let p = Position::new(CellId::new(block, 0xFFFF), Vec3::new(x, y, 0.0));
        let shown: MapCoordinates = MapCoordinates::of(&p).to_string().parse().unwrap();
        if let Some(back) = shown.to_position(0.0) {
            prop_assert!(p.offset_to(&back).abs().max_element() < 24.0);
        }
    }

    #[test]
    fn s2_the_quick_list_of_land_cells_is_the_exact_one(
        (cx, cy) in (0u16..8, 0u16..8),
        foot in prop_oneof![Just([0.3f32, 12.0]), Just([12.0, 23.7]), [0.0f32..24.0, 0.0f32..24.0], [0.0f32..1.0, 0.0f32..1.0]],
        radii in prop_oneof![Just([0.5f32, 0.5]), [0.01f32..1.0, 0.01f32..1.0], [5.0f32..20.0, 5.0f32..20.0]],
        turned in any::<bool>(),
    ) {
        let world = small_world();
        let seed = CellId(0xA9B4_0001 + u32::from(8 * cx + cy));
        let [x, y] = if turned { foot.map(|v| 24.0 - v) } else { foot };
        let foot = Vec3::new(24.0 * f32::from(cx) + x, 24.0 * f32::from(cy) + y, 0.0);
        let spheres = radii.map(|r| Sphere::new(foot, r));
        let (mut quick, mut exact) = (CellArray::new(), CellArray::new());
        if add_land_cells(seed, world.land_cell(seed).unwrap(), spheres.map(Lanes::from), &mut quick) {
            add_all_outside_cells(&world, seed, foot, &spheres, &mut exact);
            prop_assert_eq!(quick.entries(), exact.entries());
        } else {
            let far = |v: f32, r: f32| v > 0.02 && v < 23.98 && (v - r).abs() > 0.02 && (24.0 - v - r).abs() > 0.02;
            let plain = radii[0] == radii[1] && radii[0] < 12.0 && far(x, radii[0]) && far(y, radii[0]);
            let at_rim = [cx, cy].iter().any(|c| [0, 7].contains(c));
            prop_assert!(!plain || at_rim, "given up without need");
        }
    }

    #[test]
    fn find_cell_list_is_ordered_by_rule_and_repeatable(
        seed in prop_oneof![Just(0x100u16), Just(0x101), Just(0x102), 1u16..=0x40],
        x in -3f32..8.0, y in -3f32..13.0, z in -1f32..4.0, r in 0.05f32..2.0,
    ) {
        let world = small_world();
        let seed = CellId(0xA9B4_0000 | u32::from(seed));
        let sphere = [Sphere::new(Vec3::new(x, y, z), r)];
        let mut array = CellArray::new();
        let found = find_cell_list(&world, seed, sphere[0].center, &sphere, &mut array, true);
        let ids: Vec<CellId> = array.entries().iter().map(|e| e.id).collect();
        if seed.is_indoor() {
            prop_assert_eq!(ids[0], seed);
        }
        let mut unique = ids.clone();
        unique.sort();
        unique.dedup();
        prop_assert_eq!(unique.len(), ids.len());
        if let Some(cell) = found.containing {
            prop_assert!(ids.contains(&cell));
            let q = sphere[0].center - block_offset(seed.block(), cell.block());
            prop_assert!(world.point_in_cell(cell, q));
            // S1: no land cell is chosen while a listed room contains the centre.
            if !cell.is_indoor() {
                prop_assert!(!ids.iter().any(|&id| id.is_indoor() && world.point_in_cell(id, sphere[0].center)));
            }
        }
        let mut again = CellArray::new();
        let second = find_cell_list(&world, seed, sphere[0].center, &sphere, &mut again, true);
        prop_assert_eq!(second, found);
        prop_assert_eq!(again.entries(), array.entries());
    }
}
