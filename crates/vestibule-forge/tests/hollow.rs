//! The embedded world.

use std::collections::BTreeSet;
use std::io::Write as _;

use glam::{Vec2, Vec3};
use vestibule_forge::{CompiledWorld, embedded_world};
use vestibule_world::{BlockId, CellArray, CellId, EnvCell, PortalTarget, Sphere, World, find_cell_list};

mod common;
use common::Walker;
use common::eye::{points_inside, seen};

fn compiled() -> CompiledWorld {
    embedded_world().unwrap_or_else(|e| panic!("{e}"))
}

fn world(compiled: &CompiledWorld) -> World {
    World::open(compiled.memory_records()).unwrap()
}

fn cells<'w>(compiled: &CompiledWorld, world: &'w World) -> Vec<&'w EnvCell> {
    compiled
        .cell_names
        .keys()
        .map(|id| world.env_cell(*id).expect("every named cell is there"))
        .collect()
}

#[test]
fn it_compiles_without_warnings_and_loads_without_problems() {
    let compiled = compiled();
    assert_eq!(compiled.warnings, []);
    let world = world(&compiled);
    for x in 0xA8..=0xAAu8 {
        for y in 0xB3..=0xB5u8 {
            let block = world.block(BlockId::new(x, y)).expect("a landblock");
            assert!(block.land.is_some());
            for (id, _) in block.land_cells() {
                world.statics_in(id);
            }
        }
    }
    assert!(cells(&compiled, &world).len() > 50);
    assert_eq!(world.problems(), []);
    assert!(
        world
            .block(BlockId(0x0107))
            .is_some_and(|b| b.looks_like_a_dungeon())
    );
    assert!(compiled.start.is_some_and(|p| p.cell.is_land_cell()));
}

#[test]
fn two_builds_have_identical_bytes() {
    let [a, b] = [compiled(), compiled()];
    assert_eq!(a, b);
    let folder = std::env::temp_dir().join(format!("vestibule-forge-{}", std::process::id()));
    let read = |world: &CompiledWorld| {
        world.write_to(&folder).unwrap();
        ["client_portal.dat", "client_cell_1.dat"].map(|f| std::fs::read(folder.join(f)).unwrap())
    };
    let files = [read(&a), read(&b)];
    let _ = std::fs::remove_dir_all(&folder);
    assert_eq!(files[0], files[1]);
    let set = a.dat_set().unwrap();
    assert!(set.portal().contains(0x1300_0000).unwrap() && set.cell().contains(0xA9B4_0100).unwrap());
}

/// `evidence.md` E1: the vestibule stands where the recorded one stands, so the recorded look-ups hold here.
#[test]
fn e1_the_recorded_walk_holds_in_the_cottage() {
    let compiled = compiled();
    let world = world(&compiled);
    let [vestibule, hall] = ["cottage.vestibule", "cottage.hall"].map(|n| compiled.cell_named(n).unwrap());
    let outside = CellId(0xA9B4_0031);
    let (o, v, h) = (outside, vestibule, hall);
    let rows = [
        (o, 155.3717, 16.0283, v),
        (v, 155.3438, 15.1343, h),
        (h, 155.3463, 15.2186, v),
        (v, 155.3742, 16.1126, o),
        (o, 155.3723, 16.0516, v),
        (v, 155.3431, 15.1187, h),
        (h, 155.3445, 15.1641, v),
        (v, 155.3748, 16.1358, o),
        (o, 155.3692, 15.9583, v),
        (v, 155.3437, 15.142, h),
        (h, 155.3451, 15.1874, v),
        (v, 155.373, 16.0814, o),
        (o, 155.3721, 16.0571, v),
        (v, 155.3418, 15.0854, h),
        (h, 155.3456, 15.2085, v),
        (v, 155.3735, 16.1025, o),
        (v, 155.3435, 15.1454, h),
        (h, 155.3461, 15.2296, v),
        (v, 155.374, 16.1236, o),
    ];
    for (row, (seed, x, y, picked)) in rows.into_iter().enumerate() {
        let feet = Vec3::new(x, y, 94.005);
        let spheres = [0.475, 1.35].map(|z| Sphere::new(feet + Vec3::Z * z, 0.48));
        let found = find_cell_list(&world, seed, feet, &spheres, &mut CellArray::new(), true);
        assert_eq!(found.containing, Some(picked), "row {}", row + 1);
    }
}

#[test]
fn equal_rooms_share_structures() {
    let compiled = compiled();
    let world = world(&compiled);
    let structure = |name: &str| {
        let cell = world.env_cell(compiled.cell_named(name).unwrap()).unwrap();
        (cell.structure.environment, cell.structure.key)
    };
    assert_eq!(structure("deep.gallery"), structure("deep.north_gallery"));
    assert!(compiled.stats.structures < compiled.stats.cells);
}

#[test]
fn an_opening_drawn_larger_on_one_side_is_no_exact_match() {
    let compiled = compiled();
    let world = world(&compiled);
    let cell = |name: &str| world.env_cell(compiled.cell_named(name).unwrap()).unwrap();
    let (arrival, alcove) = (cell("deep.arrival"), cell("deep.alcove"));
    let leads = |from: &EnvCell, to: CellId| {
        from.portals
            .iter()
            .find(|p| p.other == PortalTarget::Cell(to))
            .copied()
    };
    let there = leads(arrival, alcove.id).expect("a portal");
    let back = leads(alcove, arrival.id).expect("a portal");
    assert!(!there.exact_match && !back.exact_match);
    assert_eq!(
        (there.other_portal, back.other_portal),
        (Some(back.record_index), Some(there.record_index))
    );
    let gate = cell("mine.gate_tunnel");
    assert!(gate.portals.iter().all(|p| p.exact_match));
}

/// An eye in a cellar that looks out must not see the underside of its own house.
#[test]
fn shells_are_not_drawn_below_the_ground() {
    let compiled = compiled();
    let world = world(&compiled);
    let block = world.block(BlockId(0xA9B4)).unwrap();
    assert_eq!(block.buildings.len(), 5);
    for building in &block.buildings {
        let model = building.shape.parts[0].model.as_ref().expect("a shell");
        let openings: Vec<u32> = model.apertures.iter().map(|a| a.polygon).collect();
        for (k, polygon) in (0u32..).zip(model.polygons.polygons()) {
            let depth = |v: &Vec3| {
                let p = building.frame.local_to_global(*v);
                world.ground_at(building.cell, p).unwrap().z - p.z
            };
            let buried = model.polygons.vertices(polygon).iter().all(|v| depth(v) > 0.06);
            assert!(
                !buried || openings.contains(&k),
                "{:?}: {polygon:?}",
                building.cell
            );
        }
    }
}

#[test]
fn p5_who_sees_the_outside_and_who_does_not() {
    let compiled = compiled();
    let world = world(&compiled);
    let sees = |name: &str| {
        world
            .env_cell(compiled.cell_named(name).unwrap())
            .unwrap()
            .seen_outside
    };
    for name in [
        "cottage.vestibule",
        "cottage.hall",
        "barn.barn",
        "shop.shop",
        "tower.lookout",
        "mine.mouth",
        "mine.adit",
    ] {
        assert!(sees(name), "{name}");
    }
    for (id, name) in &compiled.cell_names {
        let sealed = name.starts_with("deep.") || name.starts_with("mine.cavern") || name == "mine.vault";
        assert!(!sealed || !world.env_cell(*id).unwrap().seen_outside, "{name}");
    }
}

#[test]
fn stab_lists_hold_all_that_10000_eyes_see() {
    let compiled = compiled();
    let world = world(&compiled);
    let (mut eyes, mut listed, mut never) = (0, 0, 0);
    for cell in cells(&compiled, &world) {
        let mut all: BTreeSet<CellId> = BTreeSet::new();
        let mut outside = false;
        for p in points_inside(cell, 180, u64::from(cell.id.0)) {
            let (cells, out) = seen(&world, cell, p.as_dvec3());
            for id in &cells {
                assert!(
                    cell.stab_list.contains(id),
                    "{id:?} is seen from {p} in {:?}",
                    cell.id
                );
            }
            all.extend(cells);
            outside |= out;
            eyes += 1;
        }
        assert!(cell.seen_outside || !outside, "{:?}", cell.id);
        listed += cell.stab_list.len();
        never += cell.stab_list.iter().filter(|id| !all.contains(id)).count();
    }
    let share = 100.0 * never as f64 / listed as f64;
    writeln!(
        std::io::stderr(),
        "{eyes} eyes; {never} of {listed} listed cells never seen: {share:.1} %"
    )
    .unwrap();
    assert!(eyes >= 10_000, "{eyes}");
    assert!(share < 25.0, "the lists are loose: {share} %");
}

/// Walks from point to point given in the coordinates of a site that stands at `origin`, turned.
fn tour(
    name: &str,
    start: (f32, f32, f32),
    origin: Vec3,
    turn: f32,
    points: &[(f32, f32)],
    through: &[&str],
) {
    let compiled = compiled();
    let world = world(&compiled);
    let (sin, cos) = (libm::sinf(turn.to_radians()), libm::cosf(turn.to_radians()));
    let place = |x: f32, y: f32| origin.truncate() + Vec2::new(cos * x - sin * y, sin * x + cos * y);
    let base = compiled.cell_named(name).unwrap();
    let mut walker = Walker::new(&world, base, place(start.0, start.1).extend(origin.z + start.2));
    for (x, y) in points {
        assert!(
            walker.walk_to(base, place(*x, *y)),
            "stuck at {} on the way to {x} {y}",
            walker.at.origin()
        );
    }
    for wanted in through {
        let id = compiled.cell_named(wanted).unwrap();
        assert!(
            walker.trail.contains(&id),
            "{wanted} was not entered: {:?}",
            walker.trail
        );
    }
}

#[test]
fn the_cottage_can_be_walked_from_cellar_to_loft() {
    let origin = Vec3::new(161.929, 7.50315, 94.0);
    let points = [
        (6.5, -9.5),
        (6.5, -5.6),
        (8.8, -5.6),
        (9.4, -6.15),
        (12.0, -6.9),
        (14.0, -7.1),
        (14.0, -5.0),
        (14.0, 0.0),
        (11.0, 2.4),
        (14.0, 0.0),
        (14.0, -6.8),
        (12.0, -6.7),
        (9.5, -6.15),
        (9.5, -4.3),
        (4.2, -4.3),
        (3.5, -4.3),
        (3.55, -5.6),
        (8.0, -5.6),
    ];
    let rooms = [
        "cottage.vestibule",
        "cottage.passage",
        "cottage.ramp",
        "cottage.cellar",
        "cottage.hall.2",
        "cottage.loft",
    ];
    tour(
        "cottage.vestibule",
        (6.5, -8.0, 0.02),
        origin,
        180.0,
        &points,
        &rooms,
    );
}

#[test]
fn the_tower_can_be_climbed_and_left() {
    let points = [
        (0.0, -2.0),
        (-2.9, 0.3),
        (-2.9, 1.9),
        (2.7, 1.9),
        (2.7, -1.9),
        (-2.6, -1.9),
        (-2.6, 0.0),
        (-2.6, -1.9),
        (3.2, -1.9),
        (2.7, 1.9),
        (-2.9, 1.9),
        (-2.9, 0.3),
        (0.0, -2.0),
        (0.0, -6.5),
    ];
    let rooms = ["tower.ground", "tower.chamber", "tower.lookout"];
    tour(
        "tower.gate",
        (0.0, -4.5, 0.02),
        Vec3::new(156.0, 108.0, 96.45),
        -90.0,
        &points,
        &rooms,
    );
}

#[test]
fn the_mine_can_be_walked_over_the_bridge_and_out_of_the_pit() {
    let points = [
        (-13.0, 0.0),
        (-16.0, 0.0),
        (-16.0, 12.0),
        (-8.0, 12.0),
        (3.0, 12.0),
        (9.5, 12.0),
        (6.5, 12.0),
        (6.5, 8.0),
        (-5.45, 8.0),
        (-5.45, 10.2),
        (4.0, 15.0),
        (-4.0, 15.0),
        (-5.45, 10.0),
        (-5.45, 8.0),
        (6.5, 8.0),
    ];
    let rooms = ["mine.adit", "mine.junction", "mine.pit", "mine.overseer"];
    tour(
        "mine.mouth",
        (0.0, 0.0, 0.02),
        Vec3::new(14.0, 108.0, 96.2),
        0.0,
        &points,
        &rooms,
    );
}

#[test]
fn the_ridge_is_too_steep_to_walk() {
    let compiled = compiled();
    let world = world(&compiled);
    let base = CellId(0xA9B4_0031);
    let ground = world.ground_at(base, Vec3::new(250.0, 60.0, 0.0)).unwrap();
    let mut walker = Walker::new(
        &world,
        ground.cell,
        ground.point + Vec3::Z * (ground.z + 0.05 - ground.point.z),
    );
    assert!(
        !walker.walk_to(base, Vec2::new(288.0, 60.0)),
        "one walks over it: {}",
        walker.at.origin()
    );
}

#[test]
fn furniture_is_stepped_on_or_not() {
    for (model, reached) in [("crate", true), ("big_crate", false)] {
        let scene = format!(
            "model crate {{ box (-0.25 -0.25 0) (0.25 0.25 0.5) }}
             model big_crate {{ box (-0.5 -0.5 0) (0.5 0.5 1) }}
             dungeon d 0x0101 at (0 0 0) {{
                 room a {{ box (0 0 0) (8 4 4) }}
                 room b {{ box (8 0 0) (12 4 4) }}
                 opening a b
                 static {model} in a at (4 2 0)
             }}"
        );
        let compiled = vestibule_forge::compile_scene("crate.scene", &scene).unwrap();
        let world = World::open(compiled.memory_records()).unwrap();
        let mut walker = Walker::new(&world, CellId(0x0101_0100), Vec3::new(2.0, 2.0, 0.02));
        walker.walk_to(walker.at.cell, Vec2::new(4.0, 2.0));
        assert_eq!(
            walker.at.origin().z > 0.4,
            reached,
            "{model}: {}",
            walker.at.origin()
        );
    }
}
