//! What the tests share: worlds and cases of `../shared/vectors`, when present.
#![allow(dead_code, reason = "each test uses its share")]

use std::collections::HashMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use glam::Vec3;
use serde_json::Value;
use vestibule_dat::DatSet;
use vestibule_physics::{Carried, ContactPlane, Mover, ObjectState};
use vestibule_world::{CellId, Plane, Position, Sphere, World};

/// The folder of vectors; says so when it is not there.
pub(crate) fn vectors() -> Option<PathBuf> {
    let dir = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/vectors"));
    if dir.is_dir() {
        return Some(dir.to_owned());
    }
    let _ = writeln!(std::io::stderr(), "skipped: {} is not there", dir.display());
    None
}

/// Opens a world of the vectors.
pub(crate) fn open_world(name: &str) -> Option<World> {
    let dir = vectors()?.join("worlds").join(name);
    Some(World::open(DatSet::open_in_memory(dir).unwrap()).unwrap())
}

/// Worlds, opened once each.
#[derive(Default)]
pub(crate) struct Worlds(HashMap<String, World>);

impl Worlds {
    pub(crate) fn get(&mut self, name: &str) -> &World {
        self.0
            .entry(name.to_owned())
            .or_insert_with(|| open_world(name).unwrap())
    }
}

pub(crate) fn cases(file: &str) -> Vec<Value> {
    let Some(dir) = vectors() else { return Vec::new() };
    let text = std::fs::read_to_string(dir.join(file)).unwrap();
    let cases: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert!(!cases.is_empty(), "{file}");
    cases
}

pub(crate) fn float(v: &Value) -> f32 {
    v.as_f64().unwrap() as f32
}

pub(crate) fn vec3(v: &Value) -> Vec3 {
    Vec3::new(float(&v[0]), float(&v[1]), float(&v[2]))
}

pub(crate) fn cell(v: &Value) -> CellId {
    CellId(u32::try_from(v.as_u64().unwrap()).unwrap())
}

pub(crate) fn plane(v: &Value) -> Plane {
    Plane {
        normal: vec3(v),
        d: float(&v[3]),
    }
}

pub(crate) fn spheres(input: &Value) -> Vec<Sphere> {
    let list = input["spheres"].as_array().unwrap();
    list.iter().map(|s| Sphere::new(vec3(s), float(&s[3]))).collect()
}

/// The mover of a `sweep` or `walk` case.
pub(crate) fn mover(input: &Value) -> Mover {
    let mut mover = Mover::new(&spheres(input))
        .unwrap()
        .with_steps(float(&input["step_up"]), float(&input["step_down"]));
    mover.state.set(
        ObjectState::EDGE_SLIDE,
        input["edge_slide"].as_bool().unwrap_or(true),
    );
    let flags = ObjectState(input["flags"].as_u64().unwrap_or(0) as u32);
    mover.state = mover.state | flags;
    mover
}

/// The state that a case's body carries.
pub(crate) fn carried(state: &Value) -> Carried {
    let truth = |v: &Value| v.as_bool().unwrap_or(false);
    let contact = truth(&state["contact"]).then(|| ContactPlane {
        plane: plane(&state["plane"]),
        cell: cell(&state["plane_cell"]),
        is_water: truth(&state["water"]),
    });
    Carried {
        contact,
        on_walkable: truth(&state["on_walkable"]),
        last_known: None,
        sliding_normal: state["sliding"].is_array().then(|| vec3(&state["sliding"])),
        stationary: state["stationary"].as_u64().unwrap_or(0) as u8,
    }
}

pub(crate) fn start(input: &Value) -> Position {
    Position::new(cell(&input["cell"]), vec3(&input["pos"]))
}

pub(crate) fn flagged(case: &Value) -> bool {
    case["sensitive"] == true || case["suspect"] == true
}
