//! The operations `sweep` and `walk`.

use glam::Vec3;
use serde::Deserialize;
use serde::de::Error as _;
use serde_json::{Error, Value, json};
use vestibule_physics::{Carried, ContactPlane, Mover, sweep};
use vestibule_world::{CellId, Position};

use super::body_input::{BodyInput, BodyState};
use super::{Case, FieldDifference, Stage, exactly, within};

/// How far positions, normals and planes may be from what is expected, metres.
const TOLERANCE: f32 = 0.001;
/// The same for positions along walks.
const WALK_TOLERANCE: f32 = 0.002;
/// Steps shorter than this on every axis are not made, metres.
const NO_STEP: f32 = 0.0002;

#[derive(Deserialize)]
struct SweepIn {
    #[serde(flatten)]
    body: BodyInput,
    to: [f32; 3],
}

#[derive(Deserialize)]
struct SweepExpect {
    ok: bool,
    cell: u32,
    pos_cell: u32,
    pos: [f32; 3],
    contact: bool,
    contact_plane: Option<[f32; 4]>,
    #[serde(default)]
    contact_cell: u32,
    #[serde(default)]
    contact_water: bool,
    on_walkable: bool,
    collision_normal: Option<[f32; 3]>,
    sliding_normal: Option<[f32; 3]>,
    collided_env: bool,
    stationary: u8,
    cells: Vec<u32>,
}

fn mover(body: &BodyInput) -> Result<Mover, Error> {
    body.mover().map_err(Error::custom)
}

pub(super) fn sweep_case(stage: &mut Stage, case: &Case) -> Result<Vec<FieldDifference>, Error> {
    let (input, expect) = (
        SweepIn::deserialize(&case.input)?,
        SweepExpect::deserialize(&case.expect)?,
    );
    let (mover, from) = (mover(&input.body)?, input.body.start());
    let to = Position::new(from.cell, input.to.into());
    let Stage {
        world,
        population,
        scratch,
        ..
    } = stage;
    let swept = sweep(
        world,
        population,
        scratch,
        &mover,
        &input.body.carried(),
        &from,
        &to,
    );
    let swept = swept.map_err(Error::custom)?;
    let mut out = Vec::new();
    exactly(&mut out, "ok", json!(expect.ok), json!(swept.ok));
    exactly(
        &mut out,
        "cell",
        json!(expect.cell),
        json!(swept.cell.unwrap_or_default().0),
    );
    exactly(
        &mut out,
        "pos_cell",
        json!(expect.pos_cell),
        json!(swept.position.cell.0),
    );
    within(
        &mut out,
        "pos",
        &expect.pos,
        &swept.position.origin().to_array(),
        TOLERANCE,
    );
    exactly(
        &mut out,
        "contact",
        json!(expect.contact),
        json!(swept.contact.is_some()),
    );
    if let (Some(plane), Some(contact)) = (expect.contact_plane, swept.contact) {
        within(&mut out, "contact_plane", &plane, &plane_of(&contact), TOLERANCE);
        exactly(
            &mut out,
            "contact_cell",
            json!(expect.contact_cell),
            json!(contact.cell.0),
        );
        exactly(
            &mut out,
            "contact_water",
            json!(expect.contact_water),
            json!(contact.is_water),
        );
    }
    exactly(
        &mut out,
        "on_walkable",
        json!(expect.on_walkable),
        json!(swept.on_walkable),
    );
    normal(
        &mut out,
        "collision_normal",
        expect.collision_normal,
        swept.collision_normal,
    );
    normal(
        &mut out,
        "sliding_normal",
        expect.sliding_normal,
        swept.sliding_normal,
    );
    exactly(
        &mut out,
        "collided_env",
        json!(expect.collided_env),
        json!(swept.collided_with_environment),
    );
    exactly(
        &mut out,
        "stationary",
        json!(expect.stationary),
        json!(swept.stationary),
    );
    let cells: Vec<u32> = stage.scratch.cells().iter().map(|entry| entry.id.0).collect();
    exactly(&mut out, "cells", json!(expect.cells), json!(cells));
    Ok(out)
}

fn plane_of(contact: &ContactPlane) -> [f32; 4] {
    let n = contact.plane.normal;
    [n.x, n.y, n.z, contact.plane.d]
}

fn normal(out: &mut Vec<FieldDifference>, field: &str, expected: Option<[f32; 3]>, actual: Option<Vec3>) {
    match (expected, actual) {
        (None, None) => {}
        (Some(expected), Some(actual)) => within(out, field, &expected, &actual.to_array(), TOLERANCE),
        (expected, actual) => exactly(out, field, json!(expected), json!(actual.map(|n| n.to_array()))),
    }
}

#[derive(Deserialize)]
struct WalkIn {
    #[serde(flatten)]
    body: BodyInput,
    steps: Vec<[f32; 3]>,
}

#[derive(Deserialize)]
struct WalkExpect {
    trail: Vec<(u32, f32, f32, f32, u32)>,
    state: BodyState,
}

pub(super) fn walk_case(stage: &mut Stage, case: &Case) -> Result<Vec<FieldDifference>, Error> {
    let (input, expect) = (
        WalkIn::deserialize(&case.input)?,
        WalkExpect::deserialize(&case.expect)?,
    );
    let (trail, state) = walk(stage, &input)?;
    let mut out = Vec::new();
    exactly(&mut out, "rows", json!(expect.trail.len()), json!(trail.len()));
    for (i, (want, got)) in expect.trail.iter().zip(&trail).enumerate() {
        let expected = Vec3::new(want.1, want.2, want.3);
        let close = (got.1 - expected).abs().max_element() <= WALK_TOLERANCE;
        if want.0 != got.0.0 || want.4 != got.2 || !close {
            let p = got.1;
            let row: Value = json!([got.0.0, p.x, p.y, p.z, got.2]);
            out.push(FieldDifference {
                field: format!("trail[{i}]"),
                expected: json!(want),
                actual: row,
            });
            // What follows differs because of this.
            return Ok(out);
        }
    }
    let end = expect.state.carried();
    exactly(
        &mut out,
        "state.contact",
        json!(end.contact.is_some()),
        json!(state.contact.is_some()),
    );
    if let (Some(expected), Some(actual)) = (end.contact, state.contact) {
        within(
            &mut out,
            "state.plane",
            &plane_of(&expected),
            &plane_of(&actual),
            TOLERANCE,
        );
        exactly(
            &mut out,
            "state.plane_cell",
            json!(expected.cell.0),
            json!(actual.cell.0),
        );
        exactly(
            &mut out,
            "state.water",
            json!(expected.is_water),
            json!(actual.is_water),
        );
        exactly(
            &mut out,
            "state.on_walkable",
            json!(end.on_walkable),
            json!(state.on_walkable),
        );
    }
    normal(
        &mut out,
        "state.sliding",
        end.sliding_normal.map(|n| n.to_array()),
        state.sliding_normal,
    );
    exactly(
        &mut out,
        "state.stationary",
        json!(end.stationary),
        json!(state.stationary),
    );
    Ok(out)
}

/// A row of a walk: cell, foot point and the bits of the vectors' README.
type Row = (CellId, Vec3, u32);

fn walk(stage: &mut Stage, input: &WalkIn) -> Result<(Vec<Row>, Carried), Error> {
    let mover = mover(&input.body)?;
    let mut at = input.body.start();
    let mut state = input.body.carried();
    let mut trail = Vec::with_capacity(input.steps.len());
    for &step in &input.steps {
        let mut bits = 0;
        let to = Position::new(at.cell, at.origin() + Vec3::from(step));
        let moved = (to.origin() - at.origin()).abs();
        if !(moved.x < NO_STEP && moved.y < NO_STEP && moved.z < NO_STEP) {
            let Stage {
                world,
                population,
                scratch,
                ..
            } = &mut *stage;
            let swept = sweep(world, population, scratch, &mover, &state, &at, &to).map_err(Error::custom)?;
            if let (true, Some(cell)) = (swept.ok, swept.cell) {
                at = Position {
                    cell,
                    ..swept.position
                };
                state = swept.carried();
                bits |= 16;
                bits |= u32::from(swept.collided_with_environment) << 3;
                bits |= u32::from(swept.collision_normal.is_some()) << 5;
            }
        }
        bits |= u32::from(state.contact.is_some());
        bits |= u32::from(state.contact.is_some() && state.on_walkable) << 1;
        bits |= u32::from(state.sliding_normal.is_some()) << 2;
        trail.push((at.cell, at.origin(), bits));
    }
    Ok((trail, state))
}
