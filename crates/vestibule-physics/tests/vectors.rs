//! The movement vectors: independent results on worlds in real DAT format (`../shared/vectors`, when present).

mod common;

use common::*;
use glam::Vec3;
use serde_json::Value;
use vestibule_physics::{Carried, Population, Scratch, Swept, sweep};
use vestibule_world::{CellId, Position, World};

struct Report {
    agree: usize,
    flagged: usize,
    differ: Vec<String>,
}

impl Report {
    fn new() -> Self {
        Report {
            agree: 0,
            flagged: 0,
            differ: Vec::new(),
        }
    }

    fn case(&mut self, case: &Value, problems: Vec<String>) {
        if problems.is_empty() {
            self.agree += 1;
        } else if flagged(case) {
            self.flagged += 1;
        } else {
            self.differ.push(format!(
                "{} {}: {}",
                case["id"],
                case["tags"],
                problems.join("; ")
            ));
        }
    }

    fn finish(self) {
        println!("{} agree, {} flagged differ", self.agree, self.flagged);
        assert!(
            self.differ.is_empty(),
            "{} agree, {} flagged differ, {} differ:\n{}",
            self.agree,
            self.flagged,
            self.differ.len(),
            self.differ.join("\n")
        );
    }
}

fn near(a: Vec3, b: Vec3, tolerance: f32) -> bool {
    (a - b).abs().max_element() <= tolerance
}

fn compare_normal(problems: &mut Vec<String>, name: &str, ours: Option<Vec3>, expect: &Value) {
    let theirs = expect.is_array().then(|| vec3(expect));
    let same = match (ours, theirs) {
        (None, None) => true,
        (Some(a), Some(b)) => near(a, b, 0.001),
        _ => false,
    };
    if !same {
        problems.push(format!("{name} {ours:?}, expected {theirs:?}"));
    }
}

fn compare_sweep(swept: &Swept, scratch: &Scratch, expect: &Value) -> Vec<String> {
    let mut problems = Vec::new();
    let mut same = |name: &str, ours: String, theirs: String| {
        if ours != theirs {
            problems.push(format!("{name} {ours}, expected {theirs}"));
        }
    };
    same("ok", swept.ok.to_string(), expect["ok"].to_string());
    same(
        "cell",
        swept.cell.unwrap_or(CellId::NONE).to_string(),
        cell(&expect["cell"]).to_string(),
    );
    same(
        "pos_cell",
        swept.position.cell.to_string(),
        cell(&expect["pos_cell"]).to_string(),
    );
    same(
        "contact",
        swept.contact.is_some().to_string(),
        expect["contact"].to_string(),
    );
    same(
        "on_walkable",
        swept.on_walkable.to_string(),
        expect["on_walkable"].to_string(),
    );
    same(
        "collided_env",
        swept.collided_with_environment.to_string(),
        expect["collided_env"].to_string(),
    );
    same(
        "stationary",
        swept.stationary.to_string(),
        expect["stationary"].to_string(),
    );
    let cells: Vec<CellId> = scratch.cells().iter().map(|e| e.id).collect();
    let expected: Vec<CellId> = expect["cells"].as_array().unwrap().iter().map(cell).collect();
    same("cells", format!("{cells:?}"), format!("{expected:?}"));
    if !near(swept.position.origin(), vec3(&expect["pos"]), 0.001) {
        problems.push(format!(
            "pos {}, expected {}",
            swept.position.origin(),
            expect["pos"]
        ));
    }
    if let (Some(contact), true) = (&swept.contact, expect["contact"] == true) {
        let theirs = plane(&expect["contact_plane"]);
        if !near(contact.plane.normal, theirs.normal, 0.001) || (contact.plane.d - theirs.d).abs() > 0.001 {
            problems.push(format!("plane {:?}, expected {theirs:?}", contact.plane));
        }
        if contact.cell != cell(&expect["contact_cell"]) {
            problems.push(format!("contact cell {}", contact.cell));
        }
        if expect["contact_water"] != contact.is_water {
            problems.push(format!("water {}", contact.is_water));
        }
    }
    compare_normal(
        &mut problems,
        "collision normal",
        swept.collision_normal,
        &expect["collision_normal"],
    );
    compare_normal(
        &mut problems,
        "sliding normal",
        swept.sliding_normal,
        &expect["sliding_normal"],
    );
    problems
}

#[test]
fn sweep_agrees_with_the_vectors() {
    let (mut worlds, mut report) = (Worlds::default(), Report::new());
    let (population, mut scratch) = (Population::new(), Scratch::new());
    for case in cases("sweep.jsonl") {
        let world = worlds.get(case["world"].as_str().unwrap());
        let input = &case["in"];
        let from = start(input);
        let to = Position::new(from.cell, vec3(&input["to"]));
        let (mover, state) = (mover(input), carried(&input["state"]));
        let swept = sweep(world, &population, &mut scratch, &mover, &state, &from, &to).unwrap();
        let problems = compare_sweep(&swept, &scratch, &case["expect"]);
        report.case(&case, problems);
    }
    report.finish();
}

/// A walk as the vectors define it: the trail's rows and what the body carries in the end.
fn walk(world: &World, input: &Value) -> (Vec<(CellId, Vec3, u32)>, Position, Carried) {
    let (population, mut scratch) = (Population::new(), Scratch::new());
    let mover = mover(input);
    let mut at = start(input);
    let mut state = carried(&input["state"]);
    let mut trail = Vec::new();
    for step in input["steps"].as_array().unwrap() {
        let step = vec3(step);
        let mut bits = 0;
        let to = Position::new(at.cell, at.origin() + step);
        let d = (to.origin() - at.origin()).abs();
        if !(d.x < 0.0002 && d.y < 0.0002 && d.z < 0.0002) {
            let swept = sweep(world, &population, &mut scratch, &mover, &state, &at, &to).unwrap();
            if let (true, Some(cell)) = (swept.ok, swept.cell) {
                at = Position {
                    cell,
                    ..swept.position
                };
                state = swept.carried();
                bits |= u32::from(swept.collided_with_environment) << 3;
                bits |= 16;
                bits |= u32::from(swept.collision_normal.is_some()) << 5;
            }
        }
        bits |= u32::from(state.contact.is_some());
        bits |= u32::from(state.contact.is_some() && state.on_walkable) << 1;
        bits |= u32::from(state.sliding_normal.is_some()) << 2;
        trail.push((at.cell, at.origin(), bits));
    }
    (trail, at, state)
}

fn compare_walk(world: &World, case: &Value) -> Vec<String> {
    let (trail, _, state) = walk(world, &case["in"]);
    let expect = &case["expect"];
    let rows = expect["trail"].as_array().unwrap();
    for (i, (row, (at, origin, bits))) in rows.iter().zip(&trail).enumerate() {
        let theirs = Vec3::new(float(&row[1]), float(&row[2]), float(&row[3]));
        if cell(&row[0]) != *at || !near(*origin, theirs, 0.002) || row[4] != *bits {
            return vec![format!(
                "step {i}: {at} {origin} {bits}, expected {} {row}",
                cell(&row[0])
            )];
        }
    }
    if rows.len() != trail.len() {
        return vec![format!("{} rows, expected {}", trail.len(), rows.len())];
    }
    let end = carried(&expect["state"]);
    let mut problems = Vec::new();
    if (state.contact.is_some(), state.stationary) != (end.contact.is_some(), end.stationary) {
        problems.push(format!("end state {state:?}, expected {end:?}"));
    }
    if let (Some(a), Some(b)) = (state.contact, end.contact) {
        let plane = near(a.plane.normal, b.plane.normal, 0.001) && (a.plane.d - b.plane.d).abs() <= 0.001;
        if !plane || a.cell != b.cell || a.is_water != b.is_water || state.on_walkable != end.on_walkable {
            problems.push(format!("end plane {a:?}, expected {b:?}"));
        }
    }
    compare_normal(
        &mut problems,
        "end sliding",
        state.sliding_normal,
        &expect["state"]["sliding"],
    );
    problems
}

fn walks_agree(file: &str) {
    let (mut worlds, mut report) = (Worlds::default(), Report::new());
    for case in cases(file) {
        let world = worlds.get(case["world"].as_str().unwrap());
        let problems = compare_walk(world, &case);
        report.case(&case, problems);
    }
    report.finish();
}

#[test]
fn walk_agrees_with_the_vectors() {
    walks_agree("walk.jsonl");
}

#[test]
fn walk_more_agrees_with_the_vectors() {
    walks_agree("walk_more.jsonl");
}
