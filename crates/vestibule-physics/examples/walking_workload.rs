//! Runs the walking workload of the vectors: `walking_workload WORLD STEPS`, with the vectors in `../shared`.

use std::error::Error;

use glam::Vec3;
use serde_json::Value;
use vestibule_dat::DatSet;
use vestibule_physics::workload::{Workload, WorkloadBody};
use vestibule_physics::{Carried, ContactPlane, Mover};
use vestibule_world::{CellId, Plane, Position, Sphere, World};

const VECTORS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/vectors");

fn vec3(v: &Value) -> Vec3 {
    let at = |i: usize| v[i].as_f64().unwrap_or(f64::NAN) as f32;
    Vec3::new(at(0), at(1), at(2))
}

fn cell(v: &Value) -> CellId {
    CellId(v.as_u64().unwrap_or(0) as u32)
}

fn body(line: &str) -> Result<WorkloadBody, Box<dyn Error>> {
    let v: Value = serde_json::from_str(line)?;
    let spheres: Vec<Sphere> = v["spheres"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|s| Sphere::new(vec3(s), s[3].as_f64().unwrap_or(f64::NAN) as f32))
        .collect();
    let state = &v["state"];
    let contact = (state["contact"] == true).then(|| ContactPlane {
        plane: Plane {
            normal: vec3(&state["plane"]),
            d: state["plane"][3].as_f64().unwrap_or(0.0) as f32,
        },
        cell: cell(&state["plane_cell"]),
        is_water: state["water"] == true,
    });
    Ok(WorkloadBody {
        mover: Mover::new(&spheres)?.with_steps(0.6, 1.5),
        start: Position::new(cell(&v["cell"]), vec3(&v["pos"])),
        carried: Carried {
            contact,
            on_walkable: state["on_walkable"] == true,
            sliding_normal: state["sliding"].is_array().then(|| vec3(&state["sliding"])),
            stationary: state["stationary"].as_u64().unwrap_or(0) as u8,
            ..Carried::default()
        },
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let name = args.next().unwrap_or_else(|| "cottage-1".to_owned());
    let steps: u64 = args.next().map_or(Ok(25_000), |n| n.parse())?;
    let world = World::open(DatSet::open_in_memory(format!("{VECTORS}/worlds/{name}"))?)?;
    let lines = std::fs::read_to_string(format!("{VECTORS}/bench/{name}.jsonl"))?;
    let bodies = lines.lines().map(body).collect::<Result<Vec<_>, _>>()?;
    let mut workload = Workload::new(&world, bodies);
    workload.run(steps)?;
    let totals = workload.totals();
    println!(
        "{name}: {} steps, {:.4} collided, {:.4} changed cell, checksum {}",
        totals.steps,
        totals.collided_share(),
        totals.changed_cell_share(),
        totals.checksum
    );
    Ok(())
}
