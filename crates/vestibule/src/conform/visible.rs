//! The operation `visible`.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::Error as _;
use serde_json::{Error, json};
use vestibule_view::conform::{ExpectedCells, VisibleExpect, VisibleQuery};
use vestibule_world::CellId;

use super::{Case, FieldDifference, Stage};

#[derive(Deserialize)]
struct In {
    cell: u32,
    eye: [f32; 3],
    forward: [f32; 3],
    up: [f32; 3],
    fov_y: f32,
    aspect: f32,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Cells {
    must: Vec<u32>,
    may: Vec<u32>,
    thin: Vec<u32>,
    areas: BTreeMap<u32, f32>,
}

impl From<Cells> for ExpectedCells {
    fn from(cells: Cells) -> Self {
        ExpectedCells {
            must: cells.must,
            may: cells.may,
            thin: cells.thin,
            areas: cells.areas,
        }
    }
}

pub(super) fn visible(stage: &mut Stage, case: &Case) -> Result<Vec<FieldDifference>, Error> {
    let input = In::deserialize(&case.input)?;
    let expect = expectation(case)?;
    let query = VisibleQuery {
        cell: CellId(input.cell),
        eye: input.eye.into(),
        forward: input.forward.into(),
        up: input.up.into(),
        fov_y: input.fov_y,
        aspect: input.aspect,
    };
    let Stage {
        world,
        openings,
        pview,
        ..
    } = stage;
    let answer = query.answer(world, openings, pview).map_err(Error::custom)?;
    // The traversal keeps every view, however thin, so thin cells must be there.
    let differences = expect.differences(&answer, false);
    if differences.is_empty() {
        return Ok(Vec::new());
    }
    Ok(vec![FieldDifference {
        field: "cells".to_owned(),
        expected: json!({ "must": expect.cells.must, "may": expect.cells.may, "first": expect.first }),
        actual: json!({ "first": answer.first, "areas": answer.cells, "differences": differences }),
    }])
}

fn expectation(case: &Case) -> Result<VisibleExpect, Error> {
    #[derive(Deserialize)]
    struct Rest {
        first: u32,
        outside: bool,
        outside_area: Option<f32>,
        look_in: Option<Cells>,
    }
    let rest = Rest::deserialize(&case.expect)?;
    Ok(VisibleExpect {
        first: rest.first,
        cells: Cells::deserialize(&case.expect)?.into(),
        outside: rest.outside,
        outside_area: rest.outside_area,
        look_in: rest.look_in.map(Into::into),
    })
}
