//! The operations `find_cell_list`, `point_in_cell` and `terrain_z`.

use glam::Vec3;
use serde::Deserialize;
use serde_json::{Error, json};
use vestibule_world::{CellArray, CellId, Sphere};

use super::{Case, FieldDifference, Stage, exactly, within};

/// How far floats may be from what is expected: metres, and components of normals.
const TOLERANCE: f32 = 0.001;

/// Spheres relative to the foot point `pos`, as `[x, y, z, radius]`.
fn spheres_at(pos: Vec3, spheres: &[[f32; 4]]) -> Vec<Sphere> {
    spheres
        .iter()
        .map(|&[x, y, z, radius]| Sphere::new(pos + Vec3::new(x, y, z), radius))
        .collect()
}

pub(super) fn find_cell_list(stage: &mut Stage, case: &Case) -> Result<Vec<FieldDifference>, Error> {
    #[derive(Deserialize)]
    struct In {
        cell: u32,
        pos: [f32; 3],
        spheres: Vec<[f32; 4]>,
    }
    #[derive(Deserialize)]
    struct Expect {
        cells: Vec<u32>,
        containing: u32,
        hits_interior: bool,
    }
    let (input, expect) = (In::deserialize(&case.input)?, Expect::deserialize(&case.expect)?);
    let pos = Vec3::from(input.pos);
    let spheres = spheres_at(pos, &input.spheres);
    let mut array = CellArray::new();
    let found =
        vestibule_world::find_cell_list(&stage.world, CellId(input.cell), pos, &spheres, &mut array, true);
    let mut out = Vec::new();
    let cells: Vec<u32> = array.entries().iter().map(|entry| entry.id.0).collect();
    exactly(&mut out, "cells", json!(expect.cells), json!(cells));
    exactly(
        &mut out,
        "containing",
        json!(expect.containing),
        json!(found.containing.unwrap_or_default().0),
    );
    exactly(
        &mut out,
        "hits_interior",
        json!(expect.hits_interior),
        json!(found.hits_interior),
    );
    Ok(out)
}

#[derive(Deserialize)]
struct Place {
    cell: u32,
    pos: [f32; 3],
}

pub(super) fn point_in_cell(stage: &mut Stage, case: &Case) -> Result<Vec<FieldDifference>, Error> {
    #[derive(Deserialize)]
    struct Expect {
        inside: bool,
    }
    let (input, expect) = (
        Place::deserialize(&case.input)?,
        Expect::deserialize(&case.expect)?,
    );
    let inside = stage.world.point_in_cell(CellId(input.cell), input.pos.into());
    let mut out = Vec::new();
    exactly(&mut out, "inside", json!(expect.inside), json!(inside));
    Ok(out)
}

pub(super) fn terrain_z(stage: &mut Stage, case: &Case) -> Result<Vec<FieldDifference>, Error> {
    #[derive(Deserialize)]
    struct Expect {
        cell: u32,
        z: f32,
        plane: [f32; 4],
        water_depth: f32,
    }
    let (input, expect) = (
        Place::deserialize(&case.input)?,
        Expect::deserialize(&case.expect)?,
    );
    let mut out = Vec::new();
    let Some(ground) = stage.world.ground_at(CellId(input.cell), input.pos.into()) else {
        exactly(&mut out, "cell", json!(expect.cell), json!(0));
        return Ok(out);
    };
    let (normal, d) = (ground.polygon.plane.normal, ground.polygon.plane.d);
    exactly(&mut out, "cell", json!(expect.cell), json!(ground.cell.0));
    within(&mut out, "z", &[expect.z], &[ground.z], TOLERANCE);
    within(
        &mut out,
        "plane",
        &expect.plane,
        &[normal.x, normal.y, normal.z, d],
        TOLERANCE,
    );
    within(
        &mut out,
        "water_depth",
        &[expect.water_depth],
        &[ground.water_depth()],
        TOLERANCE,
    );
    Ok(out)
}
