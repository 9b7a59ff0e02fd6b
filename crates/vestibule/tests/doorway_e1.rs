//! `evidence.md` E1: the doorway recorded from the retail client, 19 rows of 19.

use glam::{Quat, Vec3};
use vestibule::dat::primitive::{Bool32, Frame, Plane, Sphere};
use vestibule::dat::record::{
    BspKind, BspLeafPhysics, BspNode, BspTag, BspTree, Building, BuildingPortal, CellPortal, CellStruct,
    EnvCell, Environment, GfxObj, LandBlock, LandBlockInfo, Polygon, Region, Vertex, VertexArray,
};
use vestibule::locate::player_spheres;
use vestibule::replay;
use vestibule::walker::Walker;
use vestibule::world::{BlockId, CellArray, CellId, MemoryRecords, Position, Store, World, find_cell_list};

const BLOCK: u32 = 0xA9B4_0000;
const ENVIRONMENT: u32 = 0x0D00_0001;
const MODEL: u32 = 0x0100_0001;

/// The table of E1.
const LOG: &str = "\
| # | seed | x | y | z | picked |
|---|---|---|---|---|---|
| 1 | 0031 | 155.3717 | 16.0283 | 94.0050 | 0170 |
| 2 | 0170 | 155.3438 | 15.1343 | 94.0050 | 0171 |
| 3 | 0171 | 155.3463 | 15.2186 | 94.0050 | 0170 |
| 4 | 0170 | 155.3742 | 16.1126 | 94.0050 | 0031 |
| 5 | 0031 | 155.3723 | 16.0516 | 94.0050 | 0170 |
| 6 | 0170 | 155.3431 | 15.1187 | 94.0050 | 0171 |
| 7 | 0171 | 155.3445 | 15.1641 | 94.0050 | 0170 |
| 8 | 0170 | 155.3748 | 16.1358 | 94.0050 | 0031 |
| 9 | 0031 | 155.3692 | 15.9583 | 94.0050 | 0170 |
| 10 | 0170 | 155.3437 | 15.1420 | 94.0050 | 0171 |
| 11 | 0171 | 155.3451 | 15.1874 | 94.0050 | 0170 |
| 12 | 0170 | 155.3730 | 16.0814 | 94.0050 | 0031 |
| 13 | 0031 | 155.3721 | 16.0571 | 94.0050 | 0170 |
| 14 | 0170 | 155.3418 | 15.0854 | 94.0050 | 0171 |
| 15 | 0171 | 155.3456 | 15.2085 | 94.0050 | 0170 |
| 16 | 0170 | 155.3735 | 16.1025 | 94.0050 | 0031 |
| 17 | 0170 | 155.3435 | 15.1454 | 94.0050 | 0171 |
| 18 | 0171 | 155.3461 | 15.2296 | 94.0050 | 0170 |
| 19 | 0170 | 155.3740 | 16.1236 | 94.0050 | 0031 |
";

/// Width of the doorway in its own frame, and its height.
const X: (f32, f32) = (5.54731, 7.45189);
const HEIGHT: f32 = 2.5;
/// Where the plane to the room lies.
const INNER_Y: f32 = -7.65;

fn plane(normal: [f32; 3], d: f32) -> Plane {
    Plane {
        normal: normal.into(),
        d,
    }
}

/// A cell tree: inside is the positive side of every plane.
fn cell_tree(planes: &[Plane]) -> BspTree {
    let mut nodes: Vec<BspNode> = (1..)
        .zip(planes)
        .map(|(next, &plane)| BspNode::Inner {
            tag: BspTag::BPNN_LOWER,
            plane,
            pos: Some(next),
            neg: None,
            sphere: None,
            polys: Vec::new(),
        })
        .collect();
    nodes.push(BspNode::Leaf {
        index: 0,
        physics: None,
    });
    BspTree {
        kind: BspKind::Cell,
        nodes,
    }
}

/// A physics tree with nothing to collide with: a body falls, which no look-up minds.
fn no_physics() -> BspTree {
    let leaf = BspLeafPhysics {
        solid: 0,
        sphere: Sphere::default(),
        polys: Vec::new(),
    };
    BspTree {
        kind: BspKind::Physics,
        nodes: vec![BspNode::Leaf {
            index: 0,
            physics: Some(leaf),
        }],
    }
}

fn cell_struct(id: u32, planes: &[Plane], portals: &[[[f32; 3]; 4]]) -> CellStruct {
    let corners = portals.iter().flatten().enumerate();
    let vertices = corners
        .map(|(i, &at)| Vertex {
            id: i as u16,
            origin: at.into(),
            normal: Vec3::Z,
            uvs: Vec::new(),
        })
        .collect();
    let polygons: Vec<Polygon> = (0..portals.len() as u16)
        .map(|i| Polygon {
            id: i,
            stippling: Polygon::NO_POS_UVS,
            vertex_ids: (4 * i..4 * i + 4).collect(),
            ..Polygon::default()
        })
        .collect();
    CellStruct {
        id,
        vertices: VertexArray { vertices },
        portals: polygons.iter().map(|p| p.id).collect(),
        polygons,
        cell_bsp: cell_tree(planes),
        physics_polygons: Vec::new(),
        physics_bsp: no_physics(),
        has_drawing_bsp: Bool32(0),
        drawing_bsp: None,
    }
}

fn doorway() -> World {
    let (low, high) = X;
    let sides = [
        plane([1.0, 0.0, 0.0], -low),
        plane([-1.0, 0.0, 0.0], high),
        plane([0.0, 0.0, 1.0], 0.0),
        plane([0.0, 0.0, -1.0], HEIGHT),
    ];
    // The exit's plane as recorded, turned inwards.
    let exit = plane([0.0, 0.994_518_64, -0.104_559_82], 8.561_810_5);
    let inner = plane([0.0, -1.0, 0.0], INNER_Y);
    let vestibule_planes: Vec<Plane> = sides.iter().copied().chain([exit, inner]).collect();
    let exit_polygon = [
        [low, -8.609, 0.0],
        [high, -8.609, 0.0],
        [high, -8.346_16, HEIGHT],
        [low, -8.346_16, HEIGHT],
    ];
    let inner_polygon = [
        [low, INNER_Y, 0.0],
        [high, INNER_Y, 0.0],
        [high, INNER_Y, HEIGHT],
        [low, INNER_Y, HEIGHT],
    ];
    let back = {
        let mut turned = inner_polygon;
        turned.reverse();
        turned
    };
    let room_planes = [
        plane([1.0, 0.0, 0.0], -3.0),
        plane([-1.0, 0.0, 0.0], 10.0),
        plane([0.0, 0.0, 1.0], 0.0),
        plane([0.0, 0.0, -1.0], 3.0),
        plane([0.0, 1.0, 0.0], -INNER_Y),
        plane([0.0, -1.0, 0.0], 0.0),
    ];
    let environment = Environment {
        id: ENVIRONMENT,
        cell_structs: vec![
            cell_struct(0, &vestibule_planes, &[exit_polygon, inner_polygon]),
            cell_struct(1, &room_planes, &[back]),
        ],
    };
    // Half a turn about z.
    let frame = Frame {
        origin: Vec3::new(161.929, 7.503_15, 94.0),
        rotation: Quat::from_xyzw(0.0, 0.0, 1.0, 0.0),
    };
    let cell = |low: u32, cell_struct: u16, portals: Vec<CellPortal>| EnvCell {
        id: BLOCK | low,
        flags: EnvCell::SEEN_OUTSIDE,
        id_again: BLOCK | low,
        environment: ENVIRONMENT,
        cell_struct,
        frame,
        portals,
        ..EnvCell::default()
    };
    let portal = |flags: u16, polygon_id: u16, other: u32, other_portal_id: i16| CellPortal {
        flags,
        polygon_id,
        other_cell_id: BLOCK | other,
        other_portal_id,
    };
    let mut records = MemoryRecords::new();
    let mut put = |store, id, bytes: Vec<u8>| records.insert(store, id, bytes);
    let vestibule = cell(0x170, 0, vec![portal(5, 0, 0xFFFF, -1), portal(3, 1, 0x171, 0)]);
    put(Store::Cell, BLOCK | 0x170, vestibule.encode().unwrap());
    put(
        Store::Cell,
        BLOCK | 0x171,
        cell(0x171, 1, vec![portal(3, 0, 0x170, 1)]).encode().unwrap(),
    );
    // Ids run without gaps: rooms without portals, which contain nothing.
    for low in 0x100..0x170 {
        put(
            Store::Cell,
            BLOCK | low,
            cell(low, 1, Vec::new()).encode().unwrap(),
        );
    }
    let building = Building {
        model_id: MODEL,
        frame,
        num_leaves: 1,
        portals: vec![BuildingPortal {
            flags: 3,
            other_cell_id: BLOCK | 0x170,
            other_portal_id: 0,
            stabs: Vec::new(),
        }],
    };
    let info = LandBlockInfo {
        id: BLOCK | 0xFFFE,
        num_cells: 0x72,
        buildings: vec![building],
        ..Default::default()
    };
    put(Store::Cell, BLOCK | 0xFFFE, info.encode().unwrap());
    let land = LandBlock {
        id: BLOCK | 0xFFFF,
        has_objects: Bool32(1),
        terrain: [0; 81],
        height: [0; 81],
    };
    put(Store::Cell, BLOCK | 0xFFFF, land.encode().unwrap());
    put(Store::Portal, ENVIRONMENT, environment.encode().unwrap());
    put(
        Store::Portal,
        MODEL,
        GfxObj {
            id: MODEL,
            ..GfxObj::default()
        }
        .encode()
        .unwrap(),
    );
    put(Store::Portal, 0x1300_0000, region());
    World::open(records).unwrap()
}

/// A region whose lowest ground is well below the doorway, so that only cells matter.
fn region() -> Vec<u8> {
    let dats = vestibule::open_dats(None).unwrap();
    let bytes = dats.get_asset(0x1300_0000).unwrap().unwrap();
    let mut region = Region::parse(0x1300_0000, &bytes).unwrap();
    for (i, height) in region.land_defs.land_height_table.iter_mut().enumerate() {
        *height = 90.0 + i as f32;
    }
    region.encode().unwrap()
}

#[test]
fn e1_nineteen_of_nineteen_rows() {
    let world = doorway();
    let rows = replay::read(LOG, 0xA9B4).unwrap();
    assert_eq!(rows.len(), 19);
    assert_eq!(world.problems(), []);
    let report = replay::run(&world, &rows);
    assert_eq!((report.agree, report.rows), (19, 19), "{:#?}", report.differences);
}

/// What the rows settle: the point is the centre of the first sphere, neither the feet nor the second sphere's centre.
#[test]
fn e1_other_points_explain_fewer_rows() {
    let world = doorway();
    let rows = replay::read(LOG, 0xA9B4).unwrap();
    let explained = |which: fn(Vec3) -> Vec3| {
        let mut cells = CellArray::new();
        rows.iter()
            .filter(|row| {
                let mut spheres = player_spheres(row.pos);
                spheres[0].center = which(row.pos);
                let seed = row.seed.unwrap();
                find_cell_list(&world, seed, row.pos, &spheres, &mut cells, true).containing == Some(row.cell)
            })
            .count()
    };
    assert_eq!(explained(|feet| feet + Vec3::new(0.0, 0.0, 0.475)), 19);
    assert_eq!(explained(|feet| feet), 17);
    assert_eq!(explained(|feet| feet + Vec3::new(0.0, 0.0, 1.35)), 16);
}

/// Walking from row to row by sweeps ends in the same cells, the row that the log lacks included.
#[test]
fn e1_as_a_sequence_of_sweeps() {
    let world = doorway();
    let rows = replay::read(LOG, 0xA9B4).unwrap();
    let mut walker = Walker::new(&world, BlockId(0xA9B4));
    let outside = Position::new(CellId(BLOCK | 0x31), Vec3::new(155.38, 16.4, 94.005));
    let mut footing = vestibule::walker::Footing {
        at: outside,
        carried: Default::default(),
        rise: 0.0,
    };
    for row in &rows {
        // Nothing to stand on was recorded: without contact the body does not look for ground.
        footing.carried = Default::default();
        footing = walker.sweep_to(&footing, row.pos);
        assert_eq!(footing.at.cell, row.cell, "line {}", row.line);
        assert!(
            footing.at.origin().distance(row.pos) < 0.01,
            "line {}: {}",
            row.line,
            footing.at
        );
    }
}
