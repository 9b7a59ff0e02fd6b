//! Loading landblocks: what statics occupy, and what damaged or dangling records do (`world.md` 6-8, 14, 20).

use glam::{Quat, Vec3};
use vestibule_dat::primitive::{CylSphere, Frame};
use vestibule_dat::record::{EnvCell, Setup, Stab};
use vestibule_testing::records::{Builder, Room};
use vestibule_world::{
    BoundingBox, CellArray, CellId, Frame as WorldFrame, PartBounds, ProblemKind, REGION_RECORD, Sphere,
    Store, World, WorldError, find_bbox_cell_list,
};

const TREE: u32 = 0x0200_0001;

fn at(x: f32, y: f32, z: f32) -> Frame {
    Frame {
        origin: Vec3::new(x, y, z),
        rotation: Quat::IDENTITY,
    }
}

fn tree(radius: f32) -> Setup {
    let cylinder = CylSphere {
        low_point: Vec3::ZERO,
        radius,
        height: 5.0,
    };
    Setup {
        id: TREE,
        cyl_spheres: vec![cylinder],
        ..Default::default()
    }
}

fn statics(world: &World, cell: u32) -> Vec<u32> {
    world.statics_in(CellId(cell)).iter().map(|r| r.index).collect()
}

#[test]
fn h2_a_cylinder_on_a_border_shadows_both_landblocks() {
    let mut b = Builder::new(0xA9B4);
    b.setup(&tree(1.0)).flat_block(0xAAB4);
    b.info.objects.push(Stab {
        id: TREE,
        frame: at(191.5, 12.0, 0.0),
    });
    b.info.objects.push(Stab {
        id: TREE,
        frame: at(12.0, 12.0, 0.0),
    });
    let world = b.world();
    assert_eq!(statics(&world, 0xA9B4_0039), [0]);
    assert_eq!(
        statics(&world, 0xAAB4_0001),
        [0],
        "the neighbour's land cell is reached too"
    );
    assert_eq!(statics(&world, 0xA9B4_0001), [1]);
    assert_eq!(statics(&world, 0xA9B4_0002), [] as [u32; 0]);
}

#[test]
fn b2_a_static_whose_cell_is_in_another_block_is_discarded() {
    let mut b = Builder::new(0xA9B4);
    b.setup(&tree(1.0));
    b.info.objects.push(Stab {
        id: TREE,
        frame: at(192.5, 12.0, 0.0),
    });
    let world = b.world();
    assert!(
        world
            .block(CellId(0xA9B4_0001).block())
            .unwrap()
            .statics
            .is_empty()
    );
    assert!(matches!(
        world.problems()[0].kind,
        ProblemKind::OutsideBlock {
            what: "static object",
            ..
        }
    ));
}

/// Two rooms joined by a portal at y = 5, interior of 0100 on the negative side.
fn two_rooms(b: &mut Builder) {
    let portal = [[2.0, 5.0, 0.0], [1.0, 5.0, 0.0], [1.0, 5.0, 2.0], [2.0, 5.0, 2.0]];
    b.room(Room::of_box(0x100, Vec3::ZERO, Vec3::new(5.0, 5.0, 3.0)).opening(Some(0x101), 0, true, &portal));
    b.room(
        Room::of_box(0x101, Vec3::new(0.0, 5.0, 0.0), Vec3::new(5.0, 10.0, 3.0)).opening(
            Some(0x100),
            0,
            false,
            &portal,
        ),
    );
}

#[test]
fn example_22_29_parts_pass_a_portal_when_their_box_crosses_it() {
    let mut b = Builder::new(0xA9B4);
    two_rooms(&mut b);
    let world = b.world();
    let reached = |y_max: f32| {
        let part = PartBounds {
            frame: WorldFrame::IDENTITY,
            sphere: Some(Sphere::new(Vec3::new(1.5, 4.5, 1.0), 0.6)),
            bounds: BoundingBox {
                min: Vec3::new(1.0, 4.0, 0.5),
                max: Vec3::new(2.0, y_max, 1.5),
            },
        };
        let mut array = CellArray::new();
        find_bbox_cell_list(&world, CellId(0xA9B4_0100), &[part], &mut array);
        array.entries().iter().map(|e| e.id.low()).collect::<Vec<_>>()
    };
    assert_eq!(reached(4.9), [0x100]);
    assert_eq!(reached(5.1), [0x100, 0x101]);
}

#[test]
fn h7_a_torch_in_a_doorway_is_found_from_both_sides() {
    let mut b = Builder::new(0xA9B4);
    b.setup(&tree(0.2));
    let portal = [[2.0, 5.0, 0.0], [1.0, 5.0, 0.0], [1.0, 5.0, 2.0], [2.0, 5.0, 2.0]];
    let mut first = Room::of_box(0x100, Vec3::ZERO, Vec3::new(5.0, 5.0, 3.0))
        .opening(Some(0x101), 0, true, &portal)
        .stabs(&[0x101]);
    first.statics.push(Stab {
        id: TREE,
        frame: at(1.5, 4.9, 1.0),
    });
    b.room(first);
    b.room(
        Room::of_box(0x101, Vec3::new(0.0, 5.0, 0.0), Vec3::new(5.0, 10.0, 3.0)).opening(
            Some(0x100),
            0,
            false,
            &portal,
        ),
    );
    let world = b.world();
    assert_eq!(statics(&world, 0xA9B4_0100), [0]);
    assert_eq!(statics(&world, 0xA9B4_0101), [0]);
}

#[test]
fn c1_c2_a_building_stands_on_one_land_cell_and_the_first_wins() {
    let mut b = Builder::new(0xA9B4);
    two_rooms(&mut b);
    b.building(Vec3::new(30.0, 30.0, 0.0), &[(0x100, 0)])
        .building(Vec3::new(31.0, 30.0, 0.0), &[(0x101, 9)]);
    let world = b.world();
    let block = world.block(CellId(0xA9B4_0001).block()).unwrap();
    let cell = block.buildings[0].cell;
    assert_eq!(cell, CellId(0xA9B4_000A));
    assert_eq!(
        block.building_on(cell).unwrap().portals[0].other,
        CellId(0xA9B4_0100)
    );
    assert_eq!(block.stab_list(), [CellId(0xA9B4_0100), CellId(0xA9B4_0101)]);
    let kinds: Vec<_> = world.problems().into_iter().map(|p| p.kind).collect();
    assert!(
        kinds
            .iter()
            .any(|k| matches!(k, ProblemKind::SecondBuilding { index: 1, .. })),
        "{kinds:?}"
    );
    assert!(
        kinds
            .iter()
            .any(|k| matches!(k, ProblemKind::NoOppositePortal { building: 1, .. })),
        "{kinds:?}"
    );
}

#[test]
fn a_missing_region_is_an_error_that_names_the_record() {
    let mut records = Builder::new(0xA9B4).finish();
    records.remove(Store::Portal, REGION_RECORD);
    let Err(WorldError::Region { id, .. }) = World::open(records) else {
        panic!("opened without a Region")
    };
    assert_eq!(id, REGION_RECORD);
}

#[test]
fn b5_without_its_record_a_landblock_is_not_loaded() {
    let world = Builder::new(0xA9B4).world();
    assert!(world.land_cell(CellId(0xA9B4_0001)).is_some());
    assert!(world.block(CellId(0x0101_0001).block()).is_none());
    assert!(!world.is_resident(CellId(0x0101_0001)));
    assert_eq!(world.problem_count(), 0, "an absent landblock is no damage");
}

/// The records of two rooms with one of them changed by `edit`.
fn edited(edit: impl Fn(&mut EnvCell)) -> World {
    let mut b = Builder::new(0xA9B4);
    two_rooms(&mut b);
    let mut records = b.finish();
    let id = 0xA9B4_0100;
    let bytes = records
        .iter()
        .find(|r| r.0 == Store::Cell && r.1 == id)
        .unwrap()
        .2
        .to_vec();
    let mut cell = EnvCell::parse(id, &bytes).unwrap();
    edit(&mut cell);
    records.insert(Store::Cell, id, cell.encode().unwrap());
    World::open(records).unwrap()
}

#[test]
fn dangling_ids_cost_their_own_cell_only() {
    type Edit = fn(&mut EnvCell);
    let edits: [(Edit, &str); 4] = [
        (
            |c| c.environment = 0x0D00_0BAD,
            "record 0x0D000BAD: missing, needed by record 0xA9B40100",
        ),
        (
            |c| c.cell_struct = 7,
            "record 0xA9B40100: environment 0x0D000001 has no cell structure 7",
        ),
        (
            |c| c.portals[0].polygon_id = 99,
            "record 0xA9B40100: portal 0 names polygon 99",
        ),
        (
            |c| c.frame.origin.x = f32::NAN,
            "record 0xA9B40100: cell frame is not a finite number",
        ),
    ];
    for (edit, message) in edits {
        let world = edited(edit);
        assert!(world.env_cell(CellId(0xA9B4_0101)).is_some());
        world.env_cell(CellId(0xA9B4_0100));
        let problems: Vec<String> = world.problems().iter().map(ToString::to_string).collect();
        assert!(
            problems.iter().any(|p| p.contains(message)),
            "{message}: {problems:?}"
        );
    }
}

#[test]
fn damaged_bytes_are_a_problem_with_file_record_and_offset() {
    let mut b = Builder::new(0xA9B4);
    two_rooms(&mut b);
    let mut records = b.finish();
    let bytes = records.iter().find(|r| r.1 == 0xA9B4_0101).unwrap().2.to_vec();
    records.insert(Store::Cell, 0xA9B4_0101, bytes[..30].to_vec());
    let world = World::open(records).unwrap();
    assert!(world.env_cell(CellId(0xA9B4_0100)).is_some());
    assert!(world.env_cell(CellId(0xA9B4_0101)).is_none());
    let text = world.problems()[0].to_string();
    assert!(text.contains("0xA9B40101") && text.contains("byte 0x"), "{text}");
}

#[test]
fn a_cell_count_beyond_all_ids_ends() {
    let mut b = Builder::new(0xA9B4);
    two_rooms(&mut b);
    b.info.num_cells = u32::MAX;
    let world = b.world();
    let block = world.block(CellId(0xA9B4_0001).block()).unwrap();
    assert_eq!(block.env_cells().count(), 2);
    assert_eq!(block.env_cells.len(), 2, "absent cells at the end are not kept");
}

#[test]
fn landblocks_load_once_from_many_threads() {
    let mut b = Builder::new(0xA9B4);
    two_rooms(&mut b);
    let world = b.world();
    let addresses: Vec<usize> = std::thread::scope(|scope| {
        let find = || std::ptr::from_ref(world.env_cell(CellId(0xA9B4_0101)).unwrap()) as usize;
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(find)).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    assert!(addresses.windows(2).all(|w| w[0] == w[1]));
}

/// Found by fuzzing: a model whose corners lie at the end of the numbers.
#[test]
fn a_model_as_wide_as_the_numbers_is_listed_in_its_own_cell() {
    let mut b = Builder::new(0xA9B4);
    let far = 3.0e38;
    b.model(
        0x0100_0009,
        &[vec![
            Vec3::new(-far, -far, 0.0),
            Vec3::new(far, -far, 0.0),
            Vec3::new(0.0, far, 1.0),
        ]],
        true,
    );
    b.info.objects.push(Stab {
        id: 0x0100_0009,
        frame: at(100.0, 100.0, 0.0),
    });
    let world = b.world();
    assert_eq!(statics(&world, 0xA9B4_0025), [0]);
    assert_eq!(statics(&world, 0xA9B4_0001), [] as [u32; 0]);
}

/// Polygons and vertices by ids in falling order: looking each up by search would take minutes.
#[test]
fn ids_in_falling_order_load_in_no_time() {
    use vestibule_dat::record::{BspKind, BspLeafPhysics, BspNode, BspTree, GfxObj, GfxObjPolygons};
    let count = 30_000u16;
    let vertices: Vec<_> = (0..count)
        .map(|i| vestibule_dat::record::Vertex {
            id: count - i,
            origin: Vec3::new(f32::from(i % 7), f32::from(i % 11), f32::from(i % 3)),
            normal: Vec3::Z,
            uvs: Vec::new(),
        })
        .collect();
    let polygons: Vec<_> = (0..count - 3)
        .map(|i| vestibule_testing::records::polygon(count - i, vec![1 + i, 2 + i, 3 + i]))
        .collect();
    let leaf = BspNode::Leaf {
        index: 0,
        physics: Some(BspLeafPhysics {
            solid: 0,
            sphere: vestibule_dat::primitive::Sphere {
                center: Vec3::ZERO,
                radius: 20.0,
            },
            polys: (0..30u16).flat_map(|_| 4..count).collect(),
        }),
    };
    let model = GfxObj {
        id: 0x0100_0009,
        flags: 1,
        physics: Some(GfxObjPolygons {
            polygons,
            form: Default::default(),
            bsp: BspTree {
                kind: BspKind::Physics,
                nodes: vec![leaf],
            },
        }),
        vertices: vestibule_dat::record::VertexArray { vertices },
        ..Default::default()
    };
    let mut b = Builder::new(0xA9B4);
    b.records.insert(Store::Portal, model.id, model.encode().unwrap());
    let world = b.world();
    let compiled = world.model(model.id, 0).expect("a model");
    assert!(compiled.physics.is_some());
}
