//! What is resident around a viewer (`world.md` 17), and what becomes of what is not.

use std::collections::BTreeSet;

use glam::{Quat, Vec3};
use vestibule_dat::primitive::{CylSphere, Frame};
use vestibule_dat::record::{Setup, Stab};
use vestibule_testing::records::{Builder, Room};
use vestibule_world::{
    BlockId, CellArray, CellId, CellManager, MemoryRecords, Position, ResidencySettings, Sphere, World,
    find_cell_list,
};

const TREE: u32 = 0x0200_0001;
const PORTAL: [[f32; 3]; 4] = [[2.0, 5.0, 0.0], [1.0, 5.0, 0.0], [1.0, 5.0, 2.0], [2.0, 5.0, 2.0]];
const HOME: u16 = 0xA9B4;

/// Rooms 0100 to 0103 in a row along y, joined by portals; each sees its neighbours. 0100 and 0101 belong to a
/// building and see the outside; 0103 is behind 0102, both sealed. A tree stands on the border to the east.
fn records() -> MemoryRecords {
    let mut b = Builder::new(HOME);
    let cylinder = CylSphere {
        low_point: Vec3::ZERO,
        radius: 1.0,
        height: 5.0,
    };
    b.setup(&Setup {
        id: TREE,
        cyl_spheres: vec![cylinder],
        ..Default::default()
    });
    for i in 0..4u16 {
        let y = 5.0 * f32::from(i);
        let at = |z: f32| PORTAL.map(|[x, _, pz]| [x, z, pz]);
        let mut room = Room::of_box(0x100 + i, Vec3::new(0.0, y, 0.0), Vec3::new(5.0, y + 5.0, 3.0));
        let mut stabs = Vec::new();
        if i > 0 {
            room = room.opening(Some(0xFF + i), u16::from(i > 1) as i16, false, &at(y));
            stabs.push(0xFF + i);
        }
        if i < 3 {
            room = room.opening(Some(0x101 + i), 0, true, &at(y + 5.0));
            stabs.push(0x101 + i);
        }
        if i == 0 {
            room = room.opening(None, -1, false, &at(0.0));
        }
        room.seen_outside = i < 2;
        room.statics.push(Stab {
            id: TREE,
            frame: frame(1.5, y + 2.0, 0.0),
        });
        b.room(room.stabs(&stabs));
    }
    b.building(Vec3::new(2.0, 2.0, 0.0), &[(0x100, 0)]);
    b.info.buildings[0].portals[0].stabs = vec![0xA9B4_0100, 0xA9B4_0101];
    b.info.objects.push(Stab {
        id: TREE,
        frame: frame(191.5, 100.0, 0.0),
    });
    for x in 0xA0..=0xB4u16 {
        for y in 0xAB..=0xBFu16 {
            if x << 8 | y != HOME {
                b.flat_block(x << 8 | y);
            }
        }
    }
    b.finish()
}

fn frame(x: f32, y: f32, z: f32) -> Frame {
    Frame {
        origin: Vec3::new(x, y, z),
        rotation: Quat::IDENTITY,
    }
}

fn settings(threaded: bool) -> ResidencySettings {
    ResidencySettings {
        threaded,
        ..Default::default()
    }
}

fn at(cell: u32, x: f32, y: f32) -> Position {
    Position::new(CellId(cell), Vec3::new(x, y, 0.5))
}

fn go(world: &mut World, cells: &mut CellManager, to: &Position) -> Vec<u16> {
    cells.change_position(world, to);
    cells.finish(world);
    assert!(cells.is_complete());
    let known: Vec<u16> = (0x100..0x104)
        .filter(|&low| world.env_cell(CellId::new(BlockId(HOME), low)).is_some())
        .collect();
    let listed: Vec<u16> = cells.resident_cells().iter().map(|c| c.low()).collect();
    assert_eq!(known, listed);
    known
}

#[test]
fn r5_env_cells_are_the_current_one_its_stabs_and_the_blocks_stabs() {
    for threaded in [false, true] {
        let mut world = World::open(records()).unwrap();
        let mut cells = CellManager::new(&mut world, settings(threaded));
        assert!(!world.is_resident(CellId(0xA9B4_0001)) && !world.loads_on_touch());
        let outdoors = at(0xA9B4_0001, 20.0, 20.0);
        assert_eq!(go(&mut world, &mut cells, &outdoors), [0x100, 0x101]);
        // Sees the outside: its stabs and the block's.
        assert_eq!(
            go(&mut world, &mut cells, &at(0xA9B4_0101, 2.0, 7.0)),
            [0x100, 0x101, 0x102]
        );
        // Sealed: its stabs only, and no landscape.
        assert_eq!(
            go(&mut world, &mut cells, &at(0xA9B4_0102, 2.0, 12.0)),
            [0x101, 0x102, 0x103]
        );
        assert!(cells.window().is_none() && world.land_cell(CellId(0xA9B4_0001)).is_none());
        assert_eq!(
            go(&mut world, &mut cells, &at(0xA9B4_0103, 2.0, 17.0)),
            [0x102, 0x103]
        );
        assert_eq!(go(&mut world, &mut cells, &outdoors), [0x100, 0x101]);
        // Two landblocks away nothing of the house is known, but it is drawn from afar.
        assert_eq!(
            go(&mut world, &mut cells, &at(0xABB4_0001, 3.0, 3.0)),
            [] as [u16; 0]
        );
        assert!(world.land_cell(CellId(0xA9B4_0001)).is_none());
        assert!(world.loaded_block(BlockId(HOME)).is_some());
    }
}

#[test]
fn l1_l3_the_window_follows_the_load_point_and_only_nine_blocks_are_known() {
    let mut world = World::open(records()).unwrap();
    let mut cells = CellManager::new(&mut world, settings(true));
    for block in [0xA9B4u16, 0xAAB4, 0xABB5, 0xA9B4] {
        go(&mut world, &mut cells, &at(u32::from(block) << 16 | 1, 3.0, 3.0));
        let center = BlockId(block);
        assert_eq!(cells.window().unwrap().center, center);
        for x in 0xA0..=0xB4u8 {
            for y in 0xAB..=0xBFu8 {
                let id = BlockId::new(x, y);
                let apart = x.abs_diff(center.x()).max(y.abs_diff(center.y()));
                assert_eq!(world.is_resident(CellId::new(id, 1)), apart <= 1, "{id}");
                assert_eq!(world.loaded_block(id).is_some(), apart <= 5, "{id}");
            }
        }
        assert_eq!(cells.stats().blocks, 9);
    }
}

#[test]
fn w1_new_cells_are_grabbed_before_old_ones_are_released() {
    let mut world = World::open(records()).unwrap();
    let mut cells = CellManager::new(&mut world, settings(true));
    go(&mut world, &mut cells, &at(0xA9B4_0001, 20.0, 20.0));
    // A teleport to where nothing is loaded: until it is, everything stays as it was.
    cells.change_position(&mut world, &at(0xA2AD_0001, 5.0, 5.0));
    assert_eq!(cells.load_position().unwrap().cell, CellId(0xA9B4_0001));
    assert!(world.is_resident(CellId(0xA9B4_0100)) && !cells.is_complete());
    cells.finish(&mut world);
    assert!(world.is_resident(CellId(0xA2AD_0001)) && !world.is_resident(CellId(0xA9B4_0100)));
    // Inside the house a cell that both need is the same one before and after.
    go(&mut world, &mut cells, &at(0xA9B4_0101, 2.0, 7.0));
    cells.change_position(&mut world, &at(0xA9B4_0102, 2.0, 12.0));
    assert!(cells.is_complete(), "what is loaded is resident at once");
}

#[test]
fn w3_reset_releases_everything() {
    let mut world = World::open(records()).unwrap();
    let mut cells = CellManager::new(&mut world, settings(true));
    go(&mut world, &mut cells, &at(0xA9B4_0001, 20.0, 20.0));
    cells.change_position(&mut world, &at(0, 0.0, 0.0));
    assert!(cells.load_position().is_none() && cells.resident_cells().is_empty());
    assert!((0..=u16::MAX).all(|id| world.loaded_block(BlockId(id)).is_none()));
    // A block that was still on its way does not come back.
    cells.finish(&mut world);
    assert!((0..=u16::MAX).all(|id| world.loaded_block(BlockId(id)).is_none()));
    assert_eq!(
        go(&mut world, &mut cells, &at(0xA9B4_0001, 20.0, 20.0)),
        [0x100, 0x101]
    );
}

#[test]
fn w4_a_sealed_cell_never_loads_landscape() {
    let mut world = World::open(records()).unwrap();
    let mut cells = CellManager::new(&mut world, settings(true));
    assert_eq!(
        go(&mut world, &mut cells, &at(0xA9B4_0103, 2.0, 17.0)),
        [0x102, 0x103]
    );
    let stats = cells.stats();
    assert_eq!((stats.blocks, stats.distant_blocks, stats.loaded), (1, 0, 1));
}

#[test]
fn r6_a_portal_to_an_unknown_cell_is_the_third_case() {
    let mut world = World::open(records()).unwrap();
    let everything = World::open(records()).unwrap();
    let mut cells = CellManager::new(&mut world, settings(true));
    go(&mut world, &mut cells, &at(0xA9B4_0103, 2.0, 17.0));
    // In the doorway between 0102 and 0101, which is not resident.
    let sphere = Sphere::new(Vec3::new(1.5, 10.1, 0.5), 0.48);
    let seed = CellId(0xA9B4_0102);
    let look = |world: &World| {
        let mut array = CellArray::new();
        let found = find_cell_list(world, seed, sphere.center, &[sphere], &mut array, true);
        let list: Vec<_> = array.entries().iter().map(|e| (e.id.low(), e.resident)).collect();
        (found.containing, list)
    };
    assert_eq!(look(&world), (Some(seed), vec![(0x102, true), (0x101, false)]));
    assert_eq!(
        look(&everything),
        (Some(seed), vec![(0x102, true), (0x101, true)])
    );
    // Far to the side the plane of the portal still counts for an unknown cell.
    let aside = Sphere::new(Vec3::new(4.5, 10.1, 2.5), 0.3);
    let beside = |world: &World| {
        let mut array = CellArray::new();
        find_cell_list(world, seed, aside.center, &[aside], &mut array, true);
        array.len()
    };
    assert_eq!(beside(&world), 2);
    go(&mut world, &mut cells, &at(0xA9B4_0102, 2.0, 12.0));
    assert_eq!(look(&world), look(&everything));
}

#[test]
fn h4_statics_reach_cells_again_when_those_become_resident() {
    let mut world = World::open(records()).unwrap();
    let everything = World::open(records()).unwrap();
    let mut cells = CellManager::new(&mut world, settings(true));
    let east = CellId(0xAAB4_0005);
    let border = CellId(0xA9B4_003D);
    for turn in 0..3 {
        go(&mut world, &mut cells, &at(0xA9B4_0001, 20.0, 20.0));
        assert_eq!(
            world.statics_in(border),
            everything.statics_in(border),
            "turn {turn}"
        );
        assert_eq!(world.statics_in(east), everything.statics_in(east), "turn {turn}");
        assert_eq!(world.statics_in(east).len(), 1);
        for low in [0x100, 0x101] {
            let cell = CellId::new(BlockId(HOME), low);
            assert_eq!(
                world.statics_in(cell),
                everything.statics_in(cell),
                "turn {turn}, {cell}"
            );
        }
        // From two blocks further east the tree's own block is unknown, and so is the tree.
        go(&mut world, &mut cells, &at(0xABB4_0001, 3.0, 3.0));
        assert!(
            world.is_resident(east) && world.statics_in(east).is_empty(),
            "turn {turn}"
        );
        // In a sealed room the statics of its own resident cells only.
        go(&mut world, &mut cells, &at(0xA9B4_0103, 2.0, 17.0));
        assert_eq!(world.statics_in(CellId(0xA9B4_0103)).len(), 1);
        assert!(world.statics_in(CellId(0xA9B4_0100)).is_empty());
    }
}

#[test]
fn memory_stays_under_the_ceiling_and_the_near_blocks_stay() {
    let mut world = World::open(records()).unwrap();
    let ceiling = 600 << 10;
    let tight = ResidencySettings {
        memory_ceiling: ceiling,
        ..Default::default()
    };
    let mut cells = CellManager::new(&mut world, tight);
    for x in 0xA2..0xB2u32 {
        go(&mut world, &mut cells, &at(x << 24 | 0xB4_0001, 5.0, 5.0));
        let stats = cells.stats();
        assert!(stats.bytes <= ceiling, "{stats:?}");
        assert_eq!(stats.blocks, 9);
    }
    let roomy = go_all(&ResidencySettings::default());
    assert!(
        roomy > ceiling,
        "the ceiling of this test is above what is needed: {roomy}"
    );
}

fn go_all(settings: &ResidencySettings) -> usize {
    let mut world = World::open(records()).unwrap();
    let mut cells = CellManager::new(&mut world, *settings);
    go(&mut world, &mut cells, &at(0xA9B4_0001, 5.0, 5.0));
    cells.stats().bytes
}

#[test]
fn what_is_known_is_the_same_whatever_the_loader_does() {
    let walk: Vec<Position> = (0..60)
        .map(|i| {
            let x = 0xA4 + (i * 7 % 13) as u32;
            at(x << 24 | 0xB4_0001, 5.0, 5.0)
        })
        .collect();
    let run = |threaded| {
        let mut world = World::open(records()).unwrap();
        let mut cells = CellManager::new(&mut world, settings(threaded));
        let mut seen = Vec::new();
        for (i, position) in walk.iter().enumerate() {
            cells.change_position(&mut world, position);
            for _ in 0..i % 3 {
                cells.update(&mut world);
            }
            if i % 5 == 0 {
                cells.finish(&mut world);
                let known: BTreeSet<BlockId> = (0..=u16::MAX)
                    .map(BlockId)
                    .filter(|&id| world.is_resident(CellId::new(id, 1)))
                    .collect();
                seen.push((known, cells.resident_cells().to_vec()));
            }
        }
        seen
    };
    assert_eq!(run(true), run(false));
}
