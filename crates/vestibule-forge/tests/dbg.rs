mod common;
use common::Walker;
use glam::{Vec2, Vec3};
use vestibule_world::{CellId, World};
#[test]
fn dbg() {
    let w = vestibule_forge::embedded_world().unwrap_or_else(|e| panic!("{e}"));
    let world = World::open(w.memory_records()).unwrap();
    for (k, v) in &w.cell_names { eprint!("{k:?}={v} "); }
    // tower: turn -90: (x,y) -> (y, -x)
    let c = |x: f32, y: f32| Vec2::new(156.0 + y, 108.0 - x);
    let b = w.cell_named("tower.ground").unwrap();
    let mut p = Walker::new(&world, b, c(-2.9, 0.3).extend(96.5));
    for (x, y) in [(-2.9, 1.9), (-2.4, 1.9), (-2.0, 1.9), (-1.5, 1.9), (-1.0, 1.9), (0.0, 1.9), (1.0, 1.9), (2.0, 1.9), (2.7, 1.9), (2.7, 0.5)] {
        let ok = p.walk_to(b, c(x, y));
        eprintln!("{x} {y} {ok} {:?} z {} stand {}", p.at.cell, p.at.origin(), p.standing());
        if !ok { break; }
    }
    let b = w.cell_named("mine.cavern").unwrap();
    let c = |x: f32, y: f32| Vec2::new(14.0 + x, 108.0 + y);
    let mut p = Walker::new(&world, b, c(-32.8, 29.0).extend(91.3));
    for y in [30.0, 31.0, 31.5, 32.0, 32.5, 33.0, 34.0, 35.0, 34.0, 33.0, 32.0, 31.0, 30.0] {
        let ok = p.walk_to(b, c(-32.8, y));
        eprintln!("{y} {ok} {:?} z {} stand {}", p.at.cell, p.at.origin(), p.standing());
        if !ok { break; }
    }
    let _ = Vec3::ZERO;
}
