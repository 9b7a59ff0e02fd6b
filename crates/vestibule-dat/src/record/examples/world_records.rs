//! Examples 12.12 to 12.14: the cell file's records.

use glam::{Quat, Vec3};

use super::*;
use crate::primitive::{Bool32, Frame, PackedHashTable};

#[test]
fn example_12_12_land_block() {
    let mut bytes = vec![0; 252];
    for (offset, run) in [
        (0x00, "FF FF B4 A9 01 00 00 00 34 48 05 00"),
        (0x10, "00 00 00 00 00 00 00 00 00 00 50 00"),
        (0xA0, "00 00 00 00 00 00 00 00 7F F8 78 8B"),
        (0xB0, "00 00 00 07"),
        (0xF0, "00 00 00 00 00 00 00 00 00 00 6E 00"),
    ] {
        let run = hex(run);
        bytes[offset..offset + run.len()].copy_from_slice(&run);
    }
    let Record::LandBlock(block) = record(RecordKind::LandBlock, 0xA9B4_FFFF, &bytes) else {
        panic!()
    };
    assert_eq!(block.has_objects, Bool32(1));
    let at = |x, y| block.terrain[LandBlock::index(x, y).unwrap()];
    let parts = |terrain| {
        (
            LandBlock::terrain_type(terrain),
            LandBlock::scene(terrain),
            LandBlock::road(terrain),
        )
    };
    assert_eq!(parts(at(0, 0)), (0x0D, 9, 0));
    assert_eq!(parts(at(0, 1)), (1, 0, 1));
    assert_eq!(parts(at(1, 0)), (0x14, 0, 0));
    assert_eq!(at(8, 8), 0xF87F);
    assert_eq!(parts(at(8, 8)), (31, 31, 3));
    assert_eq!(block.height[..2], [120, 139]);
    assert_eq!((block.height[9], block.height[80]), (7, 110));
    assert_eq!(LandBlock::index(9, 0), None);
    assert_eq!(LandBlock::index(0, 9), None);
}

#[test]
fn example_12_13_land_block_info() {
    let bytes = hex("FE FF 34 12 03 00 00 00 01 00 00 00 55 01 00 02
         00 00 C0 41 00 00 40 42 00 00 20 41 00 00 80 3F
         00 00 00 00 00 00 00 00 00 00 00 00 01 00 01 00
         A9 11 00 01 00 00 C8 42 00 00 70 42 00 00 40 41
         00 00 80 3F 00 00 00 00 00 00 00 00 00 00 00 00
         05 00 00 00 01 00 00 00 03 00 00 01 00 00 03 00
         00 01 01 01 02 01 00 00 01 00 08 00 09 00 34 12
         0C 20 26 75");
    let Record::LandBlockInfo(info) = record(RecordKind::LandBlockInfo, 0x1234_FFFE, &bytes) else {
        panic!()
    };
    let place = |x, y, z| Frame {
        origin: Vec3::new(x, y, z),
        rotation: Quat::IDENTITY,
    };
    let portal = BuildingPortal {
        flags: 3,
        other_cell_id: 0x1234_0100,
        other_portal_id: 0,
        stabs: vec![0x1234_0100, 0x1234_0101, 0x1234_0102],
    };
    assert!(portal.exact_match());
    assert_eq!((portal.portal_side(), portal.other_portal()), (0, Some(0)));
    let restrictions = PackedHashTable::new(vec![(0x1234_0009, 0x7526_200C)]);
    assert_eq!(restrictions.get(0x1234_0009), Some(0x7526_200C));
    assert_eq!(
        info,
        LandBlockInfo {
            id: 0x1234_FFFE,
            num_cells: 3,
            objects: vec![Stab {
                id: 0x0200_0155,
                frame: place(24.0, 48.0, 10.0)
            }],
            pack_mask: 1,
            buildings: vec![Building {
                model_id: 0x0100_11A9,
                frame: place(100.0, 60.0, 12.0),
                num_leaves: 5,
                portals: vec![portal],
            }],
            restrictions: Some(restrictions),
        }
    );
}

#[test]
fn example_12_14_env_cell() {
    let bytes = hex("00 01 34 12 03 00 00 00 00 01 34 12 02 02 02 00
         34 00 0C 01 E6 02 02 00 00 00 C8 42 00 00 70 42
         00 00 40 41 F3 04 35 3F 00 00 00 00 00 00 00 00
         F3 04 35 3F 03 00 03 00 01 01 01 00 05 00 04 00
         FF FF FF FF 01 01 02 01 01 00 00 00 9C 02 00 02
         00 00 80 3F 00 00 00 40 00 00 00 00 00 00 80 3F
         00 00 00 00 00 00 00 00 00 00 00 00");
    let Record::EnvCell(cell) = record(RecordKind::EnvCell, 0x1234_0100, &bytes) else {
        panic!()
    };
    assert!(cell.seen_outside());
    assert_eq!(cell.surfaces, [0x0800_0034, 0x0800_010C]);
    assert_eq!((cell.environment, cell.cell_struct), (0x0D00_02E6, 2));
    assert_eq!(cell.frame.origin, Vec3::new(100.0, 60.0, 12.0));
    assert_eq!(
        cell.frame.rotation,
        Quat::from_xyzw(0.0, 0.0, 0.70710677, 0.70710677)
    );
    let [inner, exit] = cell.portals[..] else { panic!() };
    assert_eq!((inner.polygon_id, exit.polygon_id), (3, 4));
    assert_eq!((inner.exact_match(), inner.portal_side()), (true, 0));
    assert_eq!(
        (inner.other_cell(), inner.other_portal()),
        (OtherCell::Cell(0x1234_0101), Some(1))
    );
    assert_eq!((exit.exact_match(), exit.portal_side()), (true, 1));
    assert_eq!(
        (exit.other_cell(), exit.other_portal()),
        (OtherCell::Outside, None)
    );
    assert_eq!(cell.stabs, [0x1234_0101, 0x1234_0102]);
    let place = Frame {
        origin: Vec3::new(1.0, 2.0, 0.0),
        rotation: Quat::IDENTITY,
    };
    assert_eq!(
        cell.statics,
        [Stab {
            id: 0x0200_029C,
            frame: place
        }]
    );
    assert_eq!((cell.id_again, cell.restriction), (0x1234_0100, None));
}
