//! Full traversals in the maze of the test vectors, and in one ten times as large.
//!
//! `cargo bench -p vestibule-view`. Needs `../shared/vectors`; without it there is nothing to measure.

#[path = "../tests/common/mod.rs"]
mod common;

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

/// Rounds of each measurement that is compared with another.
const ROUNDS: usize = 40;

/// Microseconds a traversal, the least and the median of rounds that take turns: what else the machine does then
/// disturbs all alike.
fn compare(all: &[(&BlockOpenings, &[Camera])]) -> Vec<(f64, f64)> {
    let mut times = vec![Vec::with_capacity(ROUNDS); all.len()];
    let mut pview = PView::default();
    for round in 0..=ROUNDS {
        for ((openings, eyes), times) in all.iter().zip(&mut times) {
            let start = Instant::now();
            black_box(run(&mut pview, openings, eyes));
            if round > 0 {
                times.push(start.elapsed().as_secs_f64() * 1.0e6 / eyes.len() as f64);
            }
        }
    }
    times
        .iter_mut()
        .map(|times| {
            times.sort_by(f64::total_cmp);
            (times[0], times[ROUNDS / 2])
        })
        .collect()
}

fn report(name: &str, rooms: usize, found: (usize, usize), eyes: usize, (least, median): (f64, f64)) {
    let mean = found.0 as f64 / eyes as f64;
    let _ = writeln!(
        std::io::stderr(),
        "{name}, {rooms} rooms: {least:.2} us a traversal at least, {median:.2} us in the median, {mean:.1} cells and {:.1} views each, {:.3} us a cell",
        found.1 as f64 / eyes as f64,
        least / mean,
    );
}

fn traversal(c: &mut Criterion) {
    town_house();
    let Some((rooms, eyes)) = maze() else {
        let _ = writeln!(std::io::stderr(), "skipped: no test vectors");
        return;
    };
    let block = rooms[0].id.block();
    let tenfold = ten_times(&rooms);
    let sizes = [
        ("maze-424, 1000 eyes", &rooms),
        ("the same ten times as large", &tenfold),
    ]
    .map(|(name, rooms)| (name, rooms.len(), BlockOpenings::from_rooms(block, rooms)));
    // The same eyes see the same in both.
    let mut pview = PView::default();
    let found = sizes
        .each_ref()
        .map(|(_, _, openings)| run(&mut pview, openings, &eyes));
    assert_eq!(found[0], found[1]);
    let times = compare(&sizes.each_ref().map(|(_, _, openings)| (openings, &eyes[..])));
    for (((name, rooms, _), found), times) in sizes.iter().zip(found).zip(&times) {
        report(name, *rooms, found, EYES, *times);
    }
    let _ = writeln!(
        std::io::stderr(),
        "ten times the rooms: {:+.1} % at least, {:+.1} % in the median (wanted: within 10 %)",
        100.0 * (times[1].0 / times[0].0 - 1.0),
        100.0 * (times[1].1 / times[0].1 - 1.0),
    );
    let mut group = c.benchmark_group("maze-424");
    group.throughput(Throughput::Elements(EYES as u64));
    for (name, _, openings) in &sizes {
        group.bench_function(*name, |b| b.iter(|| run(&mut pview, black_box(openings), &eyes)));
    }
    group.finish();
}

/// `visibility.md` 17.7: a house of 60 rooms, five by four on three floors, with a door in every wall between two rooms
/// and a hatch in every ceiling. From each room in 24 directions.
fn town_house() {
    let (across, deep, floors) = (5, 4, 3);
    let mut rooms = common::Rooms::new();
    let span = |i: usize, size: f32| (i as f32 * size, (i + 1) as f32 * size);
    let at = |x: usize, y: usize, z: usize| (z * deep + y) * across + x;
    for z in 0..floors {
        for y in 0..deep {
            for x in 0..across {
                rooms.tall_room("", span(x, 5.0), span(y, 5.0), span(z, 3.0));
            }
        }
    }
    let opening = |i: usize, size: f32| (i as f32 * size + 1.9, i as f32 * size + 3.1);
    for z in 0..floors {
        let height = (z as f32 * 3.0, z as f32 * 3.0 + 2.2);
        for y in 0..deep {
            for x in 0..across {
                if x + 1 < across {
                    let wall = common::at_x((x + 1) as f32 * 5.0, opening(y, 5.0), height);
                    rooms.door(at(x, y, z), at(x + 1, y, z), &wall);
                }
                if y + 1 < deep {
                    let wall = common::at_y((y + 1) as f32 * 5.0, opening(x, 5.0), height);
                    rooms.door(at(x, y, z), at(x, y + 1, z), &wall);
                }
                if z + 1 < floors {
                    let ceiling = common::at_z((z + 1) as f32 * 3.0, opening(x, 5.0), opening(y, 5.0));
                    rooms.door(at(x, y, z), at(x, y, z + 1), &ceiling);
                }
            }
        }
    }
    let openings = rooms.build();
    let mut eyes = Vec::new();
    for room in 0..across * deep * floors {
        let (x, y, z) = (room % across, room / across % deep, room / across / deep);
        let eye = Vec3::new(x as f32 * 5.0 + 2.3, y as f32 * 5.0 + 2.6, z as f32 * 3.0 + 1.6);
        for k in 0..24 {
            let yaw = k as f32 * core::f32::consts::TAU / 24.0;
            let look = Vec3::new(libm::sinf(yaw), libm::cosf(yaw), 0.0);
            let screen = Vec2::new(1280.0, 720.0);
            eyes.extend(Camera::new(common::id(room), eye, look, Vec3::Z, 0.936, screen));
        }
    }
    let found = run(&mut PView::default(), &openings, &eyes);
    let times = compare(&[(&openings, &eyes)]);
    report("town house", across * deep * floors, found, eyes.len(), times[0]);
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
