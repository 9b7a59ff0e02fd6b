//! A hundred random scenes, compiled and read back as the engine reads them.

use std::fmt::Write;

use glam::Vec3;
use vestibule_world::{EnvCell, PortalTarget, World};

mod common;
use common::eye::{points_inside, portal_points, seen};
use common::random::Random;

/// A dungeon of rooms on a grid: boxes, octagons, bent halls and hulls, joined by passages, some sloping, turned as a
/// whole; and a house with a random door.
fn scene(random: &mut Random) -> String {
    let mut text = String::from("land 0x8080 0x8080\nterrain { base 20 }\n");
    let (columns, rows) = (2 + (random.next() * 3.0) as i32, 2 + (random.next() * 2.0) as i32);
    let turn = if random.chance(0.3) {
        0.0
    } else {
        random.rounded(-180.0, 180.0)
    };
    let tilt = if random.chance(0.7) {
        0.0
    } else {
        random.rounded(-20.0, 20.0)
    };
    writeln!(
        text,
        "dungeon d 0x0205 at (60 -40 -30) turn {turn} tilt {tilt} {{"
    )
    .unwrap();
    for x in 0..columns {
        for y in 0..rows {
            let (cx, cy) = (f64::from(x) * 12.0, f64::from(y) * 12.0);
            let height = random.rounded(3.0, 5.0);
            let body = match (random.next() * 4.0) as u32 {
                0 => format!(
                    "box ({} {} 0) ({} {} {height})",
                    cx - 4.0,
                    cy - 4.0,
                    cx + 4.0,
                    cy + 4.0
                ),
                1 => format!("column ({cx} {cy} 0) 4.3295688 {height} 8"),
                2 => format!(
                    "prism z 0 {height} ({} {}) ({} {}) ({} {}) ({cx} {}) ({cx} {cy}) ({} {})",
                    cx - 4.0,
                    cy - 4.0,
                    cx + 4.0,
                    cy - 4.0,
                    cx + 4.0,
                    cy + 4.0,
                    cy + 4.0,
                    cx - 4.0,
                    cy + 1.5
                ),
                _ => format!(
                    "box ({} {} 0) ({} {} 3); box ({} {} 0) ({} {} {height})",
                    cx - 4.0,
                    cy - 1.5,
                    cx + 4.0,
                    cy + 1.5,
                    cx - 1.5,
                    cy - 4.0,
                    cx + 1.5,
                    cy + 4.0
                ),
            };
            writeln!(text, "    room r{x}_{y} {{ {body} }}").unwrap();
            let (w, h) = (random.rounded(0.6, 1.3), random.rounded(2.0, 2.8));
            if x + 1 < columns && random.chance(0.8) {
                let (x0, x1) = (cx + 4.0, cx + 8.0);
                writeln!(
                    text,
                    "    room e{x}_{y} {{ box ({x0} {} 0) ({x1} {} {h}) }}",
                    cy - w,
                    cy + w
                )
                .unwrap();
                writeln!(
                    text,
                    "    opening r{x}_{y} e{x}_{y}\n    opening e{x}_{y} r{}_{y}",
                    x + 1
                )
                .unwrap();
            }
            if y + 1 < rows && random.chance(0.8) {
                let (y0, y1) = (cy + 4.0, cy + 8.0);
                writeln!(
                    text,
                    "    room n{x}_{y} {{ box ({} {y0} 0) ({} {y1} {h}) }}",
                    cx - w,
                    cx + w
                )
                .unwrap();
                writeln!(
                    text,
                    "    opening r{x}_{y} n{x}_{y}\n    opening n{x}_{y} r{x}_{}",
                    y + 1
                )
                .unwrap();
            }
        }
    }
    let (w, lean) = (random.rounded(0.7, 1.2), random.rounded(-0.2, 0.2));
    let turn = random.rounded(-180.0, 180.0);
    writeln!(
        text,
        "}}\nbuilding h at (12 12 ~0.05) turn {turn} {{
    shell {{ hull (-5 -5 -1) (5 -5 -1) (5 5 -1) (-5 5 -1) (-5 {a} 4) (5 {a} 4) (5 5 4) (-5 5 4); prism x -5.5 5.5 (-5.5 3.9) (5.5 3.9) (0 7) }}
    room hall {{ box (-4 -4 0) (4 4 3) }}
    room door {{ hull (-{w} {foot} 0) ({w} {foot} 0) (-{w} -4 0) ({w} -4 0) (-{w} {head} 2.4) ({w} {head} 2.4) (-{w} -4 2.4) ({w} -4 2.4) }}
    room back {{ box (-1 4 1) (1 5 2) }}
    opening hall door\n    opening hall back\n    exit door\n    window back\n}}",
        a = -5.0 + lean * 5.0,
        foot = -5.0 + lean,
        head = -5.0 + lean * 3.4,
    )
    .unwrap();
    text
}

fn cells(world: &World) -> impl Iterator<Item = &EnvCell> {
    [0x0205u16, 0x8080]
        .into_iter()
        .filter_map(|b| world.block(vestibule_world::BlockId(b)))
        .flat_map(|b| b.env_cells())
}

/// Everything the checks below need is asked of the records, through the engine's own loader.
fn each_scene(count: usize, seed: u64, mut check: impl FnMut(usize, &World)) {
    let mut random = Random(seed);
    for k in 0..count {
        let text = scene(&mut random);
        let compiled =
            vestibule_forge::compile_scene("random.scene", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let world = World::open(compiled.memory_records()).unwrap();
        assert!(cells(&world).count() >= 3);
        check(k, &world);
        assert_eq!(world.problems(), [], "scene {k}");
    }
}

#[test]
fn portals_of_100_random_scenes_are_reciprocal() {
    let mut checked = 0;
    each_scene(100, 11, |k, world| {
        for cell in cells(world) {
            let points = cell.structure.polygons.all_vertices();
            let middle: Vec3 = points.iter().sum::<Vec3>() / points.len() as f32;
            for portal in &cell.portals {
                let dist = portal.plane.dist(middle);
                assert_eq!(
                    dist < 0.0,
                    portal.interior_is_negative,
                    "p1: scene {k}, {:?}",
                    cell.id
                );
                assert!(portal.exact_match);
                let PortalTarget::Cell(other) = portal.other else {
                    continue;
                };
                let other = world.env_cell(other).expect("no portal leads nowhere");
                let back = other
                    .portal(portal.other_portal.expect("a partner"))
                    .expect("the partner exists");
                assert_eq!(back.other, PortalTarget::Cell(cell.id));
                assert_eq!(back.other_portal, Some(portal.record_index));
                let (here, there) = (portal_points(cell, portal), portal_points(other, back));
                assert_eq!(here.len(), there.len());
                for p in &here {
                    assert!(
                        there.iter().any(|q| p.distance(*q) < 1.0e-3),
                        "scene {k}: openings differ"
                    );
                }
                assert!(cell.stab_list.contains(&other.id), "a neighbour is always listed");
                checked += 1;
            }
        }
    });
    assert!(checked > 1000, "{checked}");
}

#[test]
fn building_portals_of_100_random_scenes_are_the_exits() {
    each_scene(100, 12, |k, world| {
        let block = world.block(vestibule_world::BlockId(0x8080)).unwrap();
        let building = &block.buildings[0];
        let model = building.shape.parts[0].model.as_ref().expect("a shell");
        let named: Vec<u16> = model.apertures.iter().map(|a| a.portal).collect();
        assert_eq!(
            named,
            (0..building.portals.len() as u16).collect::<Vec<_>>(),
            "g12: scene {k}"
        );
        for (portal, aperture) in building.portals.iter().zip(&model.apertures) {
            let cell = block.env_cell(portal.other).unwrap();
            let inner = cell.portal(portal.other_portal.unwrap()).unwrap();
            assert_eq!(inner.other, PortalTarget::Outside);
            assert!(
                portal.stab_list.contains(&cell.id),
                "the entry cell is in the stab list"
            );
            let polygon = model.polygons.get(aperture.polygon as usize).unwrap();
            let outer = model
                .polygons
                .vertices(polygon)
                .iter()
                .map(|v| building.frame.local_to_global(*v));
            let inner = portal_points(cell, inner);
            for p in outer {
                assert!(
                    inner.iter().any(|q| p.as_dvec3().distance(*q) < 1.0e-3),
                    "scene {k}"
                );
            }
        }
    });
}

/// Whether a ray from `p` crosses a cell's drawn polygons and portals an odd number of times.
fn parity(cell: &EnvCell, p: Vec3, ray: Vec3) -> Option<bool> {
    let set = &cell.structure.polygons;
    let mut crossed = 0;
    for polygon in set.polygons() {
        let (dist, speed) = (polygon.plane.dist(p), polygon.plane.normal.dot(ray));
        if dist.abs() < 1.0e-3 || speed.abs() < 1.0e-3 {
            return None;
        }
        if dist / speed > 0.0 {
            continue;
        }
        let hit = p - ray * (dist / speed);
        let v = set.vertices(polygon);
        let margin = (0..v.len())
            .filter_map(|i| {
                let edge = v[(i + 1) % v.len()] - v[i];
                let inward = polygon.plane.normal.cross(edge).normalize_or_zero();
                (inward != Vec3::ZERO).then(|| inward.dot(hit - v[i]))
            })
            .fold(f32::INFINITY, |a, b| if b < a { b } else { a });
        if margin.abs() < 1.0e-4 {
            return None;
        }
        crossed += usize::from(margin > 0.0);
    }
    Some(crossed % 2 == 1)
}

#[test]
fn cell_trees_of_100_random_scenes_hold_what_their_polygons_enclose() {
    let mut checked = 0;
    each_scene(100, 13, |k, world| {
        let mut random = Random(k as u64);
        for cell in cells(world) {
            let bounds = cell.structure.bounds.unwrap();
            for _ in 0..12 {
                let t = Vec3::new(random.next() as f32, random.next() as f32, random.next() as f32);
                let p = bounds.min - 0.5 + (bounds.max - bounds.min + 1.0) * t;
                let ray = Vec3::new(random.next() as f32 - 0.5, random.next() as f32 - 0.5, 0.37).normalize();
                let Some(expected) = parity(cell, p, ray) else {
                    continue;
                };
                let found = cell.structure.cell_bsp.contains_point(p);
                assert_eq!(found, expected, "scene {k}, cell {:?} at {p}", cell.id);
                checked += 1;
            }
        }
    });
    assert!(checked > 10_000, "{checked}");
}

#[test]
fn no_wall_area_is_lost_in_100_random_scenes() {
    each_scene(100, 14, |k, world| {
        for cell in cells(world) {
            let set = &cell.structure.polygons;
            // The area vectors of a closed surface add up to nothing.
            let (mut sum, mut area) = (Vec3::ZERO, 0.0);
            for polygon in set.polygons() {
                let v = set.vertices(polygon);
                let cross: Vec3 = (1..v.len() - 1)
                    .map(|i| (v[i] - v[0]).cross(v[i + 1] - v[0]))
                    .sum();
                let outwards = cell.portals.iter().any(|p| {
                    p.interior_is_negative && set.get(p.polygon as usize).is_some_and(|q| q.id == polygon.id)
                });
                sum += if outwards { -cross } else { cross };
                area += cross.length();
            }
            assert!(
                sum.length() < 1.0e-3 * area,
                "scene {k}, cell {:?}: {sum} of {area}",
                cell.id
            );
            let physics = cell.structure.physics.as_ref().unwrap();
            assert!(
                physics.leaves().iter().all(|leaf| !leaf.solid),
                "walls are not solid: the next cell may be there"
            );
        }
    });
}

#[test]
fn stab_lists_of_random_scenes_hold_all_that_10000_eyes_see() {
    let mut eyes = 0;
    each_scene(60, 15, |k, world| {
        for cell in cells(world) {
            for p in points_inside(cell, 8, k as u64 + 1) {
                let (cells, outside) = seen(world, cell, p.as_dvec3());
                for id in cells {
                    assert!(
                        cell.stab_list.contains(&id),
                        "scene {k}: {id:?} seen from {p} in {:?}",
                        cell.id
                    );
                }
                assert!(
                    cell.seen_outside || !outside,
                    "p5: scene {k}: the outside seen from {p} in {:?}",
                    cell.id
                );
                eyes += 1;
            }
        }
    });
    assert!(eyes > 5_000, "{eyes}");
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let text = scene(&mut Random(16));
    let [a, b] = [0, 1].map(|_| vestibule_forge::compile_scene("random.scene", &text).unwrap());
    assert_eq!(a, b);
}
