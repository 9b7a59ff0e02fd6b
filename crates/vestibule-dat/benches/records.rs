//! Parsing and writing single records of the size that retail's have.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{Vec2, Vec3};
use vestibule_dat::primitive::{Bool32, CompressedForm, Frame, Plane, Sphere};
use vestibule_dat::record::*;

const BLOCK: u32 = 0xA9B4_0000;

/// 4 surfaces, 3 portals, 17 visible cells (the median of retail), 2 static objects.
fn env_cell() -> EnvCell {
    EnvCell {
        id: BLOCK | 0x0170,
        flags: 3,
        id_again: BLOCK | 0x0170,
        surfaces: (0..4).map(|index| 0x0800_0034 + index).collect(),
        environment: 0x0D00_02E6,
        cell_struct: 2,
        frame: Frame {
            origin: Vec3::new(161.9, 7.5, 94.0),
            ..Frame::IDENTITY
        },
        portals: (0..3)
            .map(|index| CellPortal {
                flags: 3,
                polygon_id: index,
                other_cell_id: BLOCK | (0x0171 + u32::from(index)),
                other_portal_id: 0,
            })
            .collect(),
        stabs: (0..17).map(|index| BLOCK | (0x0171 + index)).collect(),
        statics: vec![
            Stab {
                id: 0x0200_029C,
                frame: Frame::IDENTITY
            };
            2
        ],
        restriction: None,
    }
}

fn vertices(count: u16) -> VertexArray {
    let vertex = |id: u16| Vertex {
        id,
        origin: Vec3::new(f32::from(id), 1.0, 2.0),
        normal: Vec3::Z,
        uvs: vec![Vec2::ZERO, Vec2::ONE],
    };
    VertexArray {
        vertices: (0..count).map(vertex).collect(),
    }
}

fn polygons(count: u16) -> Vec<Polygon> {
    let polygon = |id: u16| Polygon {
        id,
        neg_surface: -1,
        vertex_ids: vec![id, id + 1, id + 2, id + 3],
        pos_uv: vec![0; 4],
        ..Polygon::default()
    };
    (0..count).map(polygon).collect()
}

/// A chain of splitting planes with a leaf on each negative side.
fn tree(kind: BspKind, planes: u32) -> BspTree {
    let leaf = |index: u32| {
        let physics = (kind == BspKind::Physics).then(|| BspLeafPhysics {
            solid: 0,
            sphere: Sphere {
                center: Vec3::ZERO,
                radius: 5.0,
            },
            polys: vec![index as u16],
        });
        BspNode::Leaf {
            index: index as i32,
            physics,
        }
    };
    let inner = |index: u32| BspNode::Inner {
        tag: BspTag::BPIN,
        plane: Plane {
            normal: Vec3::Z,
            d: 1.0,
        },
        pos: Some(index + 1),
        neg: Some(2 * planes - index),
        sphere: (kind != BspKind::Cell).then_some(Sphere {
            center: Vec3::ZERO,
            radius: 5.0,
        }),
        polys: if kind == BspKind::Drawing {
            vec![index as u16]
        } else {
            vec![]
        },
    };
    let nodes = (0..planes).map(inner).chain((0..=planes).map(leaf)).collect();
    BspTree { kind, nodes }
}

/// Two rooms of 24 vertices, 20 drawn and 18 physics polygons.
fn environment() -> Environment {
    let cell_struct = |id| CellStruct {
        id,
        vertices: vertices(24),
        polygons: polygons(20),
        portals: vec![0, 1],
        cell_bsp: tree(BspKind::Cell, 6),
        physics_polygons: polygons(18),
        physics_bsp: tree(BspKind::Physics, 12),
        has_drawing_bsp: Bool32(1),
        drawing_bsp: Some(tree(BspKind::Drawing, 12)),
    };
    Environment {
        id: 0x0D00_02E6,
        cell_structs: (0..2).map(cell_struct).collect(),
    }
}

/// 200 vertices, 150 polygons of each kind.
fn gfx_obj() -> GfxObj {
    let part = |kind| GfxObjPolygons {
        polygons: polygons(150),
        form: CompressedForm::One,
        bsp: tree(kind, 60),
    };
    GfxObj {
        id: 0x0100_11A9,
        flags: 3,
        surfaces: vec![0x0800_0034; 8],
        vertices: vertices(200),
        physics: Some(part(BspKind::Physics)),
        drawing: Some(part(BspKind::Drawing)),
        ..GfxObj::default()
    }
}

fn records(c: &mut Criterion) {
    let block = LandBlock {
        id: BLOCK | 0xFFFF,
        has_objects: Bool32(1),
        terrain: [0x34; 81],
        height: [120; 81],
    };
    let all = [
        Record::EnvCell(env_cell()),
        Record::LandBlock(block),
        Record::Environment(environment()),
        Record::GfxObj(gfx_obj()),
    ];
    for record in all {
        let (kind, id) = (record.kind(), record.stored_id().expect("a record with an id"));
        let bytes = record.encode().expect("the record encodes");
        assert_eq!(round_trip(kind, id, &bytes), Ok(RoundTrip::Identical));
        c.bench_function(&format!("parse {kind} of {} bytes", bytes.len()), |b| {
            b.iter(|| Record::parse(kind, id, black_box(&bytes)));
        });
        c.bench_function(&format!("encode {kind} of {} bytes", bytes.len()), |b| {
            b.iter(|| black_box(&record).encode());
        });
    }
}

criterion_group!(benches, records);
criterion_main!(benches);
