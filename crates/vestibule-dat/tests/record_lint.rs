//! What lint finds, and that it finds nothing in sound records.

mod generate;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use glam::{Quat, Vec3};
use proptest::prelude::*;
use vestibule_dat::primitive::{Bool32, Frame, Plane};
use vestibule_dat::record::lint::{Lint, lint, lint_references};
use vestibule_dat::record::*;
use vestibule_dat::{DatKind, DatSet, IterationRecord, RecordKind};

const CELL: u32 = 0x1234_0100;

fn cell() -> EnvCell {
    EnvCell {
        id: CELL,
        id_again: CELL,
        environment: 0x0D00_0001,
        surfaces: vec![0x0800_0001],
        ..EnvCell::default()
    }
}

/// A structure with one square that is both drawn and collided with, and is an opening.
fn shape() -> CellStruct {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let vertex = |(id, (x, y))| Vertex {
        id,
        origin: Vec3::new(x, y, 0.0),
        normal: Vec3::Z,
        uvs: vec![],
    };
    let square = Polygon {
        stippling: 0xC,
        neg_surface: -1,
        vertex_ids: vec![0, 1, 2, 3],
        ..Polygon::default()
    };
    let leaf = |physics| BspNode::Leaf { index: 0, physics };
    CellStruct {
        id: 0,
        vertices: VertexArray {
            vertices: (0..).zip(corners).map(vertex).collect(),
        },
        polygons: vec![square.clone()],
        portals: vec![0],
        cell_bsp: BspTree {
            kind: BspKind::Cell,
            nodes: vec![leaf(None)],
        },
        physics_polygons: vec![square],
        physics_bsp: BspTree {
            kind: BspKind::Physics,
            nodes: vec![leaf(Some(BspLeafPhysics::default()))],
        },
        has_drawing_bsp: Bool32(0),
        drawing_bsp: None,
    }
}

fn environment(shape: CellStruct) -> Record {
    Record::Environment(Environment {
        id: 0x0D00_0001,
        cell_structs: vec![shape],
    })
}

fn found(lints: &[Lint]) -> Vec<(&str, &str)> {
    lints
        .iter()
        .map(|lint| (lint.rule, lint.field.as_str()))
        .collect()
}

fn cell_with(change: impl FnOnce(&mut EnvCell)) -> Vec<Lint> {
    let mut cell = cell();
    change(&mut cell);
    lint(CELL, &Record::EnvCell(cell))
}

fn shape_with(change: impl FnOnce(&mut CellStruct)) -> Vec<Lint> {
    let mut shape = shape();
    change(&mut shape);
    lint(0x0D00_0001, &environment(shape))
}

#[test]
fn d4_cell_records() {
    assert!(cell_with(|_| ()).is_empty());
    assert_eq!(found(&cell_with(|cell| cell.id_again = 1)), [("D4", "id_again")]);
    assert_eq!(
        found(&cell_with(|cell| cell.id = 0x1234_0101)),
        [("F6", "id"), ("D4", "id_again")]
    );
    assert_eq!(
        found(&cell_with(|cell| cell.frame.origin.y = f32::NAN)),
        [("D4", "frame.origin")]
    );
    let turn = |w| move |cell: &mut EnvCell| cell.frame.rotation = Quat::from_xyzw(0.0, 0.0, 0.0, w);
    assert_eq!(found(&cell_with(turn(1.0011))), [("D4", "frame.rotation")]);
    assert_eq!(found(&cell_with(turn(f32::INFINITY))), [("D4", "frame.rotation")]);
    assert!(cell_with(turn(0.9995)).is_empty());
    let flag_only = CellPortal {
        flags: 4,
        other_cell_id: 0x1234_0101,
        ..CellPortal::default()
    };
    assert_eq!(
        found(&cell_with(|cell| cell.portals.push(flag_only))),
        [("L8", "portals[0]")]
    );
    let text = cell_with(|cell| cell.id_again = 1)[0].to_string();
    assert!(
        text.contains("12340100") && text.contains("id_again") && text.contains("D4"),
        "{text}"
    );
}

#[test]
fn d4_building_outside_its_landblock() {
    let info = |origin| {
        let frame = Frame {
            origin,
            ..Frame::IDENTITY
        };
        let building = Building {
            model_id: 0x0100_0001,
            frame,
            ..Building::default()
        };
        let info = LandBlockInfo {
            id: 0x1234_FFFE,
            buildings: vec![building],
            ..LandBlockInfo::default()
        };
        lint(info.id, &Record::LandBlockInfo(info))
    };
    assert!(info(Vec3::new(0.0, 191.9, 500.0)).is_empty());
    for origin in [Vec3::new(-0.1, 5.0, 0.0), Vec3::new(5.0, 192.0, 0.0)] {
        assert_eq!(found(&info(origin)), [("D4", "buildings[0].frame.origin")]);
    }
}

#[test]
fn g15_and_d4_polygons() {
    assert!(shape_with(|_| ()).is_empty());
    let twice = |shape: &mut CellStruct| {
        let square = shape.polygons[0].clone();
        shape.polygons.push(square);
    };
    assert_eq!(
        found(&shape_with(twice)),
        [("G15", "cell_structs[0].polygons[1].id")]
    );
    let line = |shape: &mut CellStruct| shape.polygons[0].vertex_ids.truncate(2);
    assert_eq!(
        found(&shape_with(line)),
        [("G15", "cell_structs[0].polygons[0].vertex_ids")]
    );
    let flat = |shape: &mut CellStruct| shape.physics_polygons[0].vertex_ids = vec![0, 1, 0];
    assert_eq!(
        found(&shape_with(flat)),
        [("D4", "cell_structs[0].physics_polygons[0]")]
    );
    let drawn_flat = |shape: &mut CellStruct| shape.polygons[0].vertex_ids = vec![0, 1, 0];
    assert!(
        shape_with(drawn_flat).is_empty(),
        "only physics polygons need an area"
    );
    let no_vertex = |shape: &mut CellStruct| shape.polygons[0].vertex_ids[3] = 9;
    assert_eq!(
        found(&shape_with(no_vertex)),
        [("G1", "cell_structs[0].polygons[0].vertex_ids[3]")]
    );
    let no_portal = |shape: &mut CellStruct| shape.portals[0] = 9;
    assert_eq!(
        found(&shape_with(no_portal)),
        [("D4", "cell_structs[0].portals[0]")]
    );
}

#[test]
fn g10_and_g14_trees() {
    let dangling = |shape: &mut CellStruct| {
        let leaf = BspLeafPhysics {
            polys: vec![7],
            ..BspLeafPhysics::default()
        };
        shape.physics_bsp.nodes[0] = BspNode::Leaf {
            index: 1,
            physics: Some(leaf),
        };
    };
    assert_eq!(
        found(&shape_with(dangling)),
        [("G10", "cell_structs[0].physics_bsp.nodes[0]")]
    );
    let negative = |shape: &mut CellStruct| {
        let leaf = shape.cell_bsp.nodes[0].clone();
        let root = BspNode::Inner {
            tag: BspTag::BP_LOWER_NN,
            plane: Plane {
                normal: Vec3::Z,
                d: f32::NAN,
            },
            pos: None,
            neg: Some(1),
            sphere: None,
            polys: vec![],
        };
        shape.cell_bsp.nodes = vec![root, leaf];
    };
    let expected = [
        ("D4", "cell_structs[0].cell_bsp.nodes[0].plane.d"),
        ("G14", "cell_structs[0].cell_bsp.nodes[0]"),
    ];
    assert_eq!(found(&shape_with(negative)), expected);
}

#[test]
fn d4_surface_index_out_of_range() {
    let mut drawing = GfxObjPolygons {
        polygons: shape().polygons,
        form: Default::default(),
        bsp: BspTree {
            kind: BspKind::Drawing,
            nodes: vec![BspNode::Leaf {
                index: 0,
                physics: None,
            }],
        },
    };
    drawing.polygons[0].pos_surface = 1;
    let model = GfxObj {
        id: 0x0100_0001,
        flags: 2,
        surfaces: vec![0x0800_0001],
        vertices: shape().vertices,
        drawing: Some(drawing),
        ..GfxObj::default()
    };
    let lints = lint(model.id, &Record::GfxObj(model));
    assert_eq!(found(&lints), [("D4", "drawing.polygons[0].pos_surface")]);
}

#[test]
fn x12_and_x15_textures() {
    let texture = |format: u32, width, pixels| {
        let pixels = vec![0; pixels];
        let texture = RenderSurface {
            id: 1,
            width,
            height: 1,
            format,
            pixels,
            ..RenderSurface::default()
        };
        lint(1, &Record::RenderSurface(texture))
    };
    assert!(texture(20, 2, 6).is_empty());
    assert_eq!(found(&texture(20, 2, 5)), [("X15", "pixels")]);
    assert_eq!(found(&texture(20, 2, 7)), [("X15", "pixels")]);
    assert_eq!(found(&texture(20, 0, 0)), [("X15", "width")]);
    assert_eq!(found(&texture(33, 2, 6)), [("X12", "format")]);
    assert!(texture(500, 2, 1).is_empty());
}

#[test]
fn v2_incompletely_patched() {
    let list = |runs: Vec<(i32, i32)>| {
        let total = runs.iter().map(|run| run.1).sum();
        lint(0xFFFF_0001, &Record::Iteration(IterationRecord { total, runs }))
    };
    assert!(list(vec![(1, 982)]).is_empty());
    assert_eq!(found(&list(vec![(1, 10), (15, 2)])), [("V2", "runs")]);
}

/// Checks the references of `id` among these records.
fn cross(records: &[(u32, Record)], id: u32) -> Vec<Lint> {
    let records: BTreeMap<u32, Arc<Record>> = records
        .iter()
        .map(|(id, record)| (*id, Arc::new(record.clone())))
        .collect();
    lint_references(id, &records[&id], &mut |_, id| records.get(&id).cloned())
}

fn two_cells() -> Vec<(u32, Record)> {
    let portal = |other_cell_id, other_portal_id| CellPortal {
        flags: 1,
        polygon_id: 0,
        other_cell_id,
        other_portal_id,
    };
    let first = EnvCell {
        portals: vec![portal(CELL + 1, 0)],
        stabs: vec![CELL + 1],
        ..cell()
    };
    let second = EnvCell {
        id: CELL + 1,
        id_again: CELL + 1,
        portals: vec![portal(CELL, 0)],
        ..first.clone()
    };
    let paint = Paint::Color(Default::default());
    let surface = Surface {
        surface_type: 1,
        paint,
        translucency: 0.0,
        luminosity: 0.0,
        diffuse: 0.0,
    };
    vec![
        (CELL, Record::EnvCell(first)),
        (CELL + 1, Record::EnvCell(second)),
        (0x0D00_0001, environment(shape())),
        (0x0800_0001, Record::Surface(surface)),
    ]
}

#[test]
fn d4_and_e3_neighbours() {
    assert_eq!(cross(&two_cells(), CELL), []);
    let with = |change: fn(&mut EnvCell)| {
        let mut records = two_cells();
        let (_, Record::EnvCell(cell)) = &mut records[0] else {
            panic!()
        };
        change(cell);
        records
    };
    let lints = cross(&with(|cell| cell.portals[0].other_portal_id = 1), CELL);
    assert_eq!(found(&lints), [("D4", "portals[0]")]);
    let lints = cross(&with(|cell| cell.portals.insert(0, cell.portals[0])), CELL);
    assert_eq!(
        found(&lints),
        [("D4", "portals[1]")],
        "the neighbour points back to the first of the two"
    );
    let lints = cross(&with(|cell| cell.portals[0].polygon_id = 5), CELL);
    assert_eq!(found(&lints), [("E3", "portals[0].polygon_id")]);
    let lints = cross(&with(|cell| cell.stabs.push(0x1234_0155)), CELL);
    assert_eq!(found(&lints), [("D4", "stabs")]);
    let lints = cross(&with(|cell| cell.cell_struct = 3), CELL);
    assert_eq!(found(&lints), [("E2", "cell_struct")]);
    let lints = cross(&with(|cell| cell.surfaces.clear()), CELL);
    assert_eq!(found(&lints), [("D4", "surfaces, polygon 0")]);
    let lints = cross(&two_cells()[..3], CELL);
    assert_eq!(found(&lints), [("D4", "surfaces")]);
}

#[test]
fn l3_land_block_and_its_info() {
    let block = |has_objects| {
        let block = LandBlock {
            id: 0x1234_FFFF,
            has_objects,
            terrain: [0; 81],
            height: [0; 81],
        };
        (block.id, Record::LandBlock(block))
    };
    let info = LandBlockInfo {
        id: 0x1234_FFFE,
        ..LandBlockInfo::default()
    };
    let info = (info.id, Record::LandBlockInfo(info));
    let check = |records: &[(u32, Record)]| found(&cross(records, 0x1234_FFFF)).len();
    assert_eq!(check(&[block(Bool32(1)), info.clone()]), 0);
    assert_eq!(check(&[block(Bool32(0))]), 0);
    assert_eq!(
        found(&cross(&[block(Bool32(1))], 0x1234_FFFF)),
        [("L3", "has_objects")]
    );
    assert_eq!(
        found(&cross(&[block(Bool32(0)), info], 0x1234_FFFF)),
        [("L3", "has_objects")]
    );
}

#[test]
fn g12_building_portals_and_the_models_openings() {
    let node = |portal_polys| BspNode::Portal {
        plane: Plane {
            normal: Vec3::Z,
            d: 0.0,
        },
        pos: 1,
        neg: 2,
        sphere: Some(Default::default()),
        polys: vec![],
        portal_polys,
    };
    let leaf = BspNode::Leaf {
        index: 0,
        physics: None,
    };
    let world = |portal_polys| {
        let bsp = BspTree {
            kind: BspKind::Drawing,
            nodes: vec![node(portal_polys), leaf.clone(), leaf.clone()],
        };
        let drawing = Some(GfxObjPolygons {
            polygons: vec![],
            form: Default::default(),
            bsp,
        });
        let model = GfxObj {
            id: 0x0100_0001,
            flags: 2,
            drawing,
            ..GfxObj::default()
        };
        let portal = BuildingPortal {
            flags: 3,
            other_cell_id: CELL,
            other_portal_id: 0,
            stabs: vec![CELL],
        };
        let building = Building {
            model_id: model.id,
            portals: vec![portal],
            ..Building::default()
        };
        let info = LandBlockInfo {
            id: 0x1234_FFFE,
            num_cells: 1,
            buildings: vec![building],
            ..LandBlockInfo::default()
        };
        let exit = CellPortal {
            flags: 5,
            polygon_id: 0,
            other_cell_id: 0x1234_FFFF,
            other_portal_id: -1,
        };
        let cell = EnvCell {
            portals: vec![exit],
            ..cell()
        };
        vec![
            (info.id, Record::LandBlockInfo(info)),
            (model.id, Record::GfxObj(model)),
            (CELL, Record::EnvCell(cell)),
        ]
    };
    assert_eq!(cross(&world(vec![(0, 0)]), 0x1234_FFFE), []);
    assert_eq!(
        found(&cross(&world(vec![]), 0x1234_FFFE)),
        [("G12", "buildings[0].portals")]
    );
    assert_eq!(
        found(&cross(&world(vec![(0, 0), (1, 1)]), 0x1234_FFFE)),
        [("G12", "buildings[0].portals")]
    );
    let mut inward = world(vec![(0, 0)]);
    let (_, Record::EnvCell(cell)) = &mut inward[2] else {
        panic!()
    };
    cell.portals[0] = CellPortal {
        other_cell_id: CELL,
        ..CellPortal::default()
    };
    assert_eq!(
        found(&cross(&inward, 0x1234_FFFE)),
        [("D4", "buildings[0].portals[0]")]
    );
}

#[test]
fn references_name_kind_and_field() {
    let records = two_cells();
    let references = records[0].1.references();
    let named: Vec<_> = references
        .iter()
        .map(|reference| (reference.kind, reference.field))
        .collect();
    let expected = [
        (RecordKind::Surface, "surfaces"),
        (RecordKind::Environment, "environment"),
        (RecordKind::EnvCell, "portals.other_cell_id"),
        (RecordKind::EnvCell, "stabs"),
    ];
    assert_eq!(named, expected);
}

#[test]
fn d4_of_the_vectors_only_the_worlds_with_a_missing_cell_are_linted() {
    let worlds = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/vectors/worlds");
    let Ok(folders) = Path::new(worlds).read_dir() else {
        writeln!(std::io::stderr(), "skipped: {worlds} is not there").unwrap();
        return;
    };
    for folder in folders {
        let folder = folder.unwrap().path();
        let dats = DatSet::open(&folder).unwrap();
        let mut look_up = |kind: RecordKind, id| {
            let cell = matches!(
                kind,
                RecordKind::LandBlock | RecordKind::LandBlockInfo | RecordKind::EnvCell
            );
            let bytes = if cell {
                dats.get_cell(id)
            } else {
                dats.get_asset(id)
            };
            Record::parse(kind, id, &bytes.ok()??).ok().map(Arc::new)
        };
        let mut lints = Vec::new();
        for file_kind in [DatKind::Cell, DatKind::Portal] {
            for entry in dats.file(file_kind).unwrap().iter() {
                let id = entry.unwrap().id;
                let record = look_up(RecordKind::of(file_kind, id), id).unwrap();
                lints.extend(lint(id, &record));
                lints.extend(lint_references(id, &record, &mut look_up));
            }
        }
        let cell_is_missing = folder.to_string_lossy().ends_with("-miss");
        assert_eq!(
            !lints.is_empty(),
            cell_is_missing,
            "{}: {lints:?}",
            folder.display()
        );
    }
}

proptest! {
    #[test]
    fn lint_takes_any_record(entropy in prop::collection::vec(any::<u8>(), 0..3000)) {
        let record = generate::Entropy(&entropy).record();
        lint(0, &record);
        let other = Arc::new(record.clone());
        lint_references(0, &record, &mut |_, id| (id % 2 == 0).then(|| other.clone()));
    }
}
