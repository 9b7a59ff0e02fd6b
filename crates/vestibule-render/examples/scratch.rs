#[path = "../tests/common/mod.rs"]
mod common;
use common::*;
use glam::Vec3;
use vestibule_world::CellId;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let v = |s: &str| {
        let f: Vec<f32> = s.split(',').map(|x| x.trim().parse().unwrap()).collect();
        Vec3::new(f[0], f[1], f[2])
    };
    let mut stage = Stage::vectors(&a[1]).unwrap();
    let cell = CellId(u32::from_str_radix(a[2].trim_start_matches("0x"), 16).unwrap());
    let size: Vec<u32> = a[5].split('x').map(|x| x.parse().unwrap()).collect();
    let c = camera(cell, v(&a[3]), v(&a[4]), (size[0], size[1]), 1.2);
    stage.update(c);
    if let Some(f) = stage.frame.interior() {
        println!("cells {:?}", f.cells().iter().map(|c| c.id).collect::<Vec<_>>());
    }
    let i = stage.ids(c);
    let px: Vec<u32> = std::env::var("DBGPX")
        .unwrap()
        .split(',')
        .map(|x| x.parse().unwrap())
        .collect();
    println!(
        "{:?}",
        i.get(px[0], px[1]).map(|i| (i.kind(), i.cell(), i.item()))
    );
    if let Ok(l) = std::env::var("CELLS") {
        let l: Vec<u32> = l
            .split(',')
            .map(|x| u32::from_str_radix(x, 16).unwrap())
            .collect();
        cells(&stage, v(&a[3]), &l);
    }
    if std::env::var("CMD").is_ok() {
        for c in stage.frame.commands() {
            if !matches!(c, vestibule_view::Command::Terrain(_)) {
                println!("{c:?}");
            }
        }
    }
    println!("everything:");
    if a.len() > 6 {
        let i = stage.everything(&c);
        println!(
            "{:?}",
            i.get(px[0], px[1]).map(|i| (i.kind(), i.cell(), i.item()))
        );
    }
}
#[allow(dead_code)]
fn cells(stage: &Stage, eye: Vec3, ids: &[u32]) {
    for &id in ids {
        let c = stage.world.env_cell(CellId(id)).unwrap();
        println!(
            "{:x} contains {} seen_outside {}",
            id,
            c.contains_point(eye),
            c.seen_outside
        );
        for p in &c.portals {
            let l = c.frame.global_to_local(eye);
            println!(
                "   -> {:?} neg {} exact {} dist {} poly {:?}",
                p.other,
                p.interior_is_negative,
                p.exact_match,
                p.plane.dist(l),
                c.portal_vertices(p)
                    .iter()
                    .map(|v| c.frame.local_to_global(*v))
                    .collect::<Vec<_>>()
            );
        }
    }
}
