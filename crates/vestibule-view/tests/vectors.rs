//! The `visible` test vectors: independent ground truth for what a camera sees through openings.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use glam::Vec3;
use serde_json::Value;
use vestibule_dat::DatSet;
use vestibule_view::conform::{CellAreas, ExpectedCells, VisibleExpect, VisibleQuery};
use vestibule_view::{FloodSettings, Openings, PView};
use vestibule_world::{CellId, World};

fn vectors() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/vectors");
    if folder.join("visible.jsonl").exists() {
        return Some(folder);
    }
    let _ = writeln!(
        std::io::stderr(),
        "skipped: no test vectors at {}",
        folder.display()
    );
    None
}

fn vec3(v: &Value) -> Vec3 {
    let at = |k: usize| v[k].as_f64().unwrap() as f32;
    Vec3::new(at(0), at(1), at(2))
}

fn ids(v: &Value) -> Vec<u32> {
    v.as_array().map_or(Vec::new(), |a| {
        a.iter().map(|x| x.as_u64().unwrap() as u32).collect()
    })
}

fn cells(v: &Value) -> ExpectedCells {
    let areas: CellAreas = v["areas"]
        .as_object()
        .map(|o| {
            o.iter()
                .map(|(k, a)| (k.parse().unwrap(), a.as_f64().unwrap() as f32))
                .collect()
        })
        .unwrap_or_default();
    ExpectedCells {
        must: ids(&v["must"]),
        may: ids(&v["may"]),
        thin: ids(&v["thin"]),
        areas,
    }
}

fn query(v: &Value) -> VisibleQuery {
    let number = |k: &str| v[k].as_f64().unwrap() as f32;
    VisibleQuery {
        cell: CellId(v["cell"].as_u64().unwrap() as u32),
        eye: vec3(&v["eye"]),
        forward: vec3(&v["forward"]),
        up: vec3(&v["up"]),
        fov_y: number("fov_y"),
        aspect: number("aspect"),
    }
}

fn expect(v: &Value) -> VisibleExpect {
    VisibleExpect {
        first: v["first"].as_u64().unwrap() as u32,
        cells: cells(v),
        outside: v["outside"].as_bool().unwrap(),
        outside_area: v["outside_area"].as_f64().map(|a| a as f32),
        look_in: (!v["look_in"].is_null()).then(|| cells(&v["look_in"])),
    }
}

struct Loaded {
    world: World,
    openings: Openings,
}

fn run(settings: FloodSettings, allow_thin: bool) -> Option<(usize, Vec<String>, Vec<String>)> {
    let folder = vectors()?;
    let text = std::fs::read_to_string(folder.join("visible.jsonl")).unwrap();
    let mut worlds: BTreeMap<String, Loaded> = BTreeMap::new();
    let mut pview = PView::new(settings);
    let (mut count, mut wrong, mut areas) = (0, Vec::new(), Vec::new());
    for line in text.lines() {
        let case: Value = serde_json::from_str(line).unwrap();
        let name = case["world"].as_str().unwrap();
        let loaded = worlds.entry(name.to_owned()).or_insert_with(|| {
            let dats = DatSet::open(folder.join("worlds").join(name)).unwrap();
            Loaded {
                world: World::open(dats).unwrap(),
                openings: Openings::new(),
            }
        });
        let expected = expect(&case["expect"]);
        let answer = query(&case["in"])
            .answer(&loaded.world, &loaded.openings, &mut pview)
            .unwrap();
        let id = case["id"].as_str().unwrap();
        let found = expected.differences(&answer, allow_thin);
        if !found.is_empty() {
            wrong.push(format!("{id}: {}", found.join("; ")));
        }
        areas.extend(
            expected
                .area_differences(&answer)
                .into_iter()
                .map(|d| format!("{id}: {d}")),
        );
        count += 1;
    }
    Some((count, wrong, areas))
}

#[test]
fn all_visible_vectors_agree() {
    let Some((count, wrong, areas)) = run(FloodSettings::default(), false) else {
        return;
    };
    assert_eq!(count, 399);
    assert!(
        wrong.is_empty(),
        "{} of {count} differ:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    let _ = writeln!(
        std::io::stderr(),
        "{} areas differ:\n{}",
        areas.len(),
        areas.join("\n")
    );
}

#[test]
fn retail_mode_loses_only_thin_views() {
    // The vectors ignore stab lists, so the gate is off here; the rest is strict retail.
    let settings = FloodSettings {
        stab_gate: false,
        ..FloodSettings::retail()
    };
    let Some((count, wrong, _)) = run(settings, true) else {
        return;
    };
    assert!(
        wrong.is_empty(),
        "{} of {count} differ:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
