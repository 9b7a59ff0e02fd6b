//! Runs test vectors: cases of inputs and expected answers, one JSON object a line, on the worlds beside them.
//!
//! A folder of vectors has `*.jsonl` files and `worlds/NAME/` with the DAT files that the cases name.
//! [`read_folder`] reads the cases, [`run`] runs them and says which agree:
//!
//! ```no_run
//! use vestibule::conform;
//!
//! let cases = conform::read_folder("vectors".as_ref())?;
//! let report = conform::run("vectors".as_ref(), &cases, &mut |_| ())?;
//! println!("{} of {} agree", report.agree(), report.counted());
//! # Ok::<(), conform::ConformError>(())
//! ```

mod body_input;
mod case;
mod look_ups;
mod moves;
mod report;
mod visible;

use std::path::Path;

use serde_json::Value;
use vestibule_physics::{Population, Scratch};
use vestibule_view::{Openings, PView};
use vestibule_world::World;

pub use body_input::BodyInput;
pub use case::{Case, ConformError, read_folder};
pub use report::{Difference, FieldDifference, OpReport, Report};

use crate::open::open_world;

/// A world to run cases on, with working memory for them.
struct Stage {
    world: World,
    openings: Openings,
    pview: PView,
    population: Population,
    scratch: Scratch,
}

impl Stage {
    fn new(world: World) -> Self {
        Stage {
            world,
            openings: Openings::new(),
            pview: PView::default(),
            population: Population::new(),
            scratch: Scratch::new(),
        }
    }
}

/// What an operation answers to one case: where it differs from what is expected.
type Check = fn(&mut Stage, &Case) -> Result<Vec<FieldDifference>, serde_json::Error>;

/// The operations that can be run, in the order of reports.
const OPS: &[(&str, Check)] = &[
    ("find_cell_list", look_ups::find_cell_list),
    ("point_in_cell", look_ups::point_in_cell),
    ("terrain_z", look_ups::terrain_z),
    ("sweep", moves::sweep_case),
    ("walk", moves::walk_case),
    ("visible", visible::visible),
];

/// Names of the operations that can be run, in the order of reports.
pub fn supported_ops() -> impl Iterator<Item = &'static str> {
    OPS.iter().map(|&(name, _)| name)
}

/// Runs cases on the worlds under `folder`. `progress` is called with the number of cases done.
///
/// # Errors
/// A world cannot be opened, or a case's input has not the form of its operation.
pub fn run(folder: &Path, cases: &[Case], progress: &mut dyn FnMut(u64)) -> Result<Report, ConformError> {
    let mut stage: Option<(&str, Stage)> = None;
    let mut report = Report::default();
    for (done, case) in (1..).zip(cases) {
        let Some(&(_, check)) = OPS.iter().find(|(name, _)| *name == case.op) else {
            report.of(&case.op).unsupported += 1;
            continue;
        };
        // Cases come world by world: one at a time is enough in memory.
        if stage.as_ref().is_none_or(|(name, _)| *name != case.world) {
            let path = folder.join("worlds").join(&case.world);
            let world = open_world(Some(&path)).map_err(|source| ConformError::World {
                name: case.world.clone(),
                source: Box::new(source),
            })?;
            stage = Some((&case.world, Stage::new(world)));
        }
        let Some((_, stage)) = &mut stage else { continue };
        let fields = check(stage, case).map_err(|source| case.bad(source))?;
        report.count(case, fields);
        progress(done);
    }
    report.sort_by(|op| OPS.iter().position(|(name, _)| *name == op));
    Ok(report)
}

/// Compares two values exactly and notes a difference.
fn exactly(out: &mut Vec<FieldDifference>, field: &str, expected: Value, actual: Value) {
    if expected != actual {
        out.push(FieldDifference {
            field: field.to_owned(),
            expected,
            actual,
        });
    }
}

/// Compares numbers within a tolerance and notes a difference.
fn within(out: &mut Vec<FieldDifference>, field: &str, expected: &[f32], actual: &[f32], tolerance: f32) {
    let close = expected.len() == actual.len()
        && expected
            .iter()
            .zip(actual)
            .all(|(a, b)| (a - b).abs() <= tolerance);
    if !close {
        out.push(FieldDifference {
            field: field.to_owned(),
            expected: expected.to_vec().into(),
            actual: actual.to_vec().into(),
        });
    }
}
