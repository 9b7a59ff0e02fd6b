//! Full traversals in the maze of the test vectors, and in one ten times as large.
//!
//! `cargo bench -p vestibule-view`. Needs `../shared/vectors`; without it there is nothing to measure.

use std::hint::black_box;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{Vec2, Vec3};
use vestibule_dat::DatSet;
use vestibule_view::{
    BlockOpenings, Camera, FrameInput, FrameView, Openings, PView, PortalSpec, RoomSpec, WorldObjects,
};
use vestibule_world::{CellId, PortalTarget, World};

const EYES: usize = 1_000;

/// The rooms of the maze, and eyes 1.6 m above the floor's centre of random rooms with random yaw.
fn maze() -> Option<(Vec<RoomSpec>, Vec<Camera>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/vectors/worlds/maze-424");
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("world.json")).ok()?).ok()?;
    let world = World::open(DatSet::open(&folder).ok()?).ok()?;
    let cells = json["cells"].as_array()?;
    let block = CellId(cells.first()?["id"].as_u64()? as u32).block();
    let rooms = world.block(block)?.env_cells().map(room_spec).collect();
    let mut state = 1u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut eyes = Vec::new();
    while eyes.len() < EYES {
        let cell = &cells[(random() * cells.len() as f32) as usize % cells.len()];
        let Some(floor) = cell["floor"][0].as_array() else {
            continue;
        };
        let mut centre = Vec3::ZERO;
        for p in floor {
            let at = |k: usize| p[k].as_f64().unwrap_or(0.0) as f32;
            centre += Vec3::new(at(0), at(1), at(2)) / floor.len() as f32;
        }
        let yaw = random() * core::f32::consts::TAU;
        let look = Vec3::new(libm::sinf(yaw), libm::cosf(yaw), 0.0);
        let id = CellId(cell["id"].as_u64()? as u32);
        let eye = centre + Vec3::new(0.0, 0.0, 1.6);
        eyes.push(Camera::new(id, eye, look, Vec3::Z, 0.936, Vec2::new(1280.0, 720.0)).ok()?);
    }
    Some((rooms, eyes))
}

fn room_spec(cell: &vestibule_world::EnvCell) -> RoomSpec {
    RoomSpec {
        id: cell.id,
        frame: cell.frame,
        bsp: cell.structure.cell_bsp.clone(),
        portals: cell
            .portals
            .iter()
            .map(|p| PortalSpec {
                target: p.other,
                other_portal: p.other_portal,
                vertices: cell.portal_vertices(p).to_vec(),
                interior_is_negative: p.interior_is_negative,
                exact_match: p.exact_match,
            })
            .collect(),
        stab_list: cell.stab_list.to_vec(),
    }
}

/// The same rooms and nine more copies of them, each far from the others.
fn ten_times(rooms: &[RoomSpec]) -> Vec<RoomSpec> {
    let count = rooms.len() as u16;
    let moved = |id: CellId, copy: u16| CellId::new(id.block(), id.low() + copy * count);
    (0..10)
        .flat_map(|copy| rooms.iter().map(move |r| (copy, r)))
        .map(|(copy, room)| {
            let mut room = room.clone();
            room.id = moved(room.id, copy);
            room.frame.origin.z += 500.0 * f32::from(copy);
            for portal in &mut room.portals {
                if let PortalTarget::Cell(id) = &mut portal.target {
                    *id = moved(*id, copy);
                }
            }
            room.stab_list.iter_mut().for_each(|id| *id = moved(*id, copy));
            room
        })
        .collect()
}

fn run(pview: &mut PView, openings: &BlockOpenings, eyes: &[Camera]) -> (usize, usize) {
    let (mut cells, mut views) = (0, 0);
    for camera in eyes {
        let flood = pview.look_in_block(Some(openings), camera);
        cells += flood.cells().len();
        views += flood.view_count();
    }
    (cells, views)
}

fn traversal(c: &mut Criterion) {
    let Some((rooms, eyes)) = maze() else {
        let _ = writeln!(std::io::stderr(), "skipped: no test vectors");
        return;
    };
    let block = rooms[0].id.block();
    let mut group = c.benchmark_group("maze-424");
    group.throughput(Throughput::Elements(EYES as u64));
    for (name, rooms) in [
        ("1000 eyes", rooms.clone()),
        ("1000 eyes, ten times the rooms", ten_times(&rooms)),
    ] {
        let openings = BlockOpenings::from_rooms(block, &rooms);
        let mut pview = PView::default();
        let (cells, views) = run(&mut pview, &openings, &eyes);
        let start = Instant::now();
        for _ in 0..20 {
            black_box(run(&mut pview, &openings, &eyes));
        }
        let micros = start.elapsed().as_secs_f64() * 1.0e6 / (20 * EYES) as f64;
        let mean = cells as f64 / EYES as f64;
        let _ = writeln!(
            std::io::stderr(),
            "{name}, {} rooms: {micros:.2} us a traversal, {mean:.1} cells and {:.1} views each, {:.3} us a cell",
            rooms.len(),
            views as f64 / EYES as f64,
            micros / mean,
        );
        group.bench_function(name, |b| b.iter(|| run(&mut pview, black_box(&openings), &eyes)));
    }
    group.finish();
}

/// Whole frames of a town house, from its yard and from inside: rooms, doors, terrain, objects.
fn frames(c: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/vectors/worlds/cottage-1");
    let Some(world) = DatSet::open(folder).ok().and_then(|dats| World::open(dats).ok()) else {
        return;
    };
    let openings = Openings::new();
    let objects = WorldObjects::new(&world);
    let yard = (CellId(0xA9B4_001C), Vec3::new(84.0, 74.0, 41.6), Vec3::Y);
    let room = (CellId(0xA9B4_0101), Vec3::new(84.0, 85.0, 41.6), -Vec3::Y);
    let mut group = c.benchmark_group("frame of cottage-1");
    for (name, (cell, eye, look)) in [("from the yard", yard), ("from the room", room)] {
        let screen = Vec2::new(1280.0, 720.0);
        let Ok(camera) = Camera::new(cell, eye, look, Vec3::Z, 0.936, screen) else {
            return;
        };
        let input = FrameInput::new(camera);
        let mut frame = FrameView::default();
        group.bench_function(name, |b| {
            b.iter(|| frame.update(&world, &openings, &objects, black_box(&input)));
        });
    }
    group.finish();
}

fn config() -> Criterion {
    Criterion::default()
        .warm_up_time(std::time::Duration::from_secs(1))
        .measurement_time(std::time::Duration::from_secs(3))
        .sample_size(20)
}

criterion_group!(name = benches; config = config(); targets = traversal, frames);
criterion_main!(benches);
