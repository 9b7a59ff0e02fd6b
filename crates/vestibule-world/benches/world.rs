//! Loading a landblock and finding cells, on the vectors' worlds (`../shared/vectors`, when present).

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use glam::Vec3;
use vestibule_dat::DatSet;
use vestibule_world::{BlockId, CellArray, CellId, PortalTarget, Sphere, World, find_cell_list};

fn dats(name: &str) -> Option<Arc<DatSet>> {
    let dir = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/vectors/worlds"
    ))
    .join(name);
    if !dir.is_dir() {
        eprintln!("skipped: {} is not there", dir.display());
        return None;
    }
    Some(Arc::new(DatSet::open_in_memory(dir).expect("the world opens")))
}

/// The first landblock with env cells.
fn interior_block(dats: &DatSet) -> BlockId {
    let entries = dats.cell().iter().flatten();
    let id = entries
        .map(|e| CellId(e.id))
        .find(|id| id.is_env_cell())
        .expect("an env cell");
    id.block()
}

fn loading(c: &mut Criterion) {
    let Some(dats) = dats("cottage-1") else { return };
    let block = interior_block(&dats);
    c.bench_function("load the cottage's landblock cold", |b| {
        b.iter_batched(
            || World::open(dats.clone()).expect("a region"),
            |world| {
                black_box(world.block(block).is_some());
                world
            },
            BatchSize::SmallInput,
        );
    });
}

fn look_ups(c: &mut Criterion) {
    for name in ["cottage-1", "dungeon-1", "maze-424"] {
        let Some(dats) = dats(name) else { return };
        let world = World::open(dats.clone()).expect("a region");
        let block = world.block(interior_block(&dats)).expect("a landblock");
        // A player's two spheres in the middle of each room, and in each of its inner doorways.
        let mut places: Vec<(CellId, [Sphere; 2])> = Vec::new();
        for cell in block.env_cells() {
            let Some(bounds) = cell.structure.bounds else {
                continue;
            };
            let mut stand = |local: Vec3| {
                let feet = cell.frame.local_to_global(local);
                let sphere = |z: f32| Sphere::new(feet + Vec3::new(0.0, 0.0, z), 0.48);
                places.push((cell.id, [sphere(0.475), sphere(1.35)]));
            };
            let middle = (bounds.min + bounds.max) * 0.5;
            stand(Vec3::new(middle.x, middle.y, bounds.min.z));
            for portal in cell.portals.iter().filter(|p| p.other != PortalTarget::Outside) {
                let corners = cell.portal_vertices(portal);
                let sum: Vec3 = corners.iter().sum();
                let lowest = corners.iter().fold(f32::INFINITY, |z, v| z.min(v.z));
                stand(Vec3::new(
                    sum.x / corners.len() as f32,
                    sum.y / corners.len() as f32,
                    lowest,
                ));
            }
        }
        let mut array = CellArray::new();
        let mut next = 0;
        c.bench_function(&format!("find_cell_list indoors, {name}"), |b| {
            b.iter(|| {
                let (cell, spheres) = &places[next];
                next = (next + 1) % places.len();
                find_cell_list(
                    &world,
                    *cell,
                    spheres[0].center,
                    black_box(spheres),
                    &mut array,
                    true,
                )
            });
        });
    }
}

criterion_group!(benches, loading, look_ups);
criterion_main!(benches);
