//! Holds a recorded trail, or a log of cell look-ups, against a world.

use glam::Vec3;
use serde::{Deserialize, Serialize};
use vestibule_world::ids::block_offset;
use vestibule_world::{CellArray, CellId, Position, World, find_cell_list};

use crate::locate::player_spheres;
use crate::walker::{Footing, Walker};

/// A row of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Line in the file, from 1.
    pub line: usize,
    /// The cell the look-up started from; the row before, in trails.
    pub seed: Option<CellId>,
    /// The body was put here, not carried from the row before.
    pub teleported: bool,
    /// Foot point in the frame of the landblock of `cell`, metres.
    pub pos: Vec3,
    /// The cell that was recorded.
    pub cell: CellId,
}

/// A row whose cell this world answers otherwise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RowDifference {
    /// Line in the file.
    pub line: usize,
    /// Foot point.
    pub pos: [f32; 3],
    /// Cell the look-up started from.
    pub seed: String,
    /// The cell recorded.
    pub recorded: String,
    /// The cell found, `none` if no cell holds the point.
    pub found: String,
}

/// The outcome of a replay.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ReplayReport {
    /// Rows held against the world.
    pub rows: usize,
    /// Rows that agree.
    pub agree: usize,
    /// Rows that could not be asked: the first of a trail, and after a teleport.
    pub skipped: usize,
    /// Rows that differ.
    pub differences: Vec<RowDifference>,
}

/// Why a recording cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct ReplayError {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong.
    pub problem: String,
}

/// Reads a recording: JSON lines with `cell` and `pos` as tours and walks write them, or rows of a log in the form
/// `| # | seed | x | y | z | picked |` (`evidence.md` E1). In a log short cell ids are completed with `block`.
///
/// # Errors
/// Names the first line that is neither.
pub fn read(text: &str, block: u16) -> Result<Vec<Row>, ReplayError> {
    let is_table = text
        .lines()
        .find(|line| !line.trim().is_empty())
        .is_some_and(|line| !line.trim_start().starts_with('{'));
    if is_table {
        read_log(text, block)
    } else {
        read_trail(text)
    }
}

fn read_trail(text: &str) -> Result<Vec<Row>, ReplayError> {
    #[derive(Deserialize)]
    struct Step {
        cell: String,
        pos: [f32; 3],
        #[serde(default)]
        teleport: bool,
    }
    let mut out: Vec<Row> = Vec::new();
    for (line, text) in (1..)
        .zip(text.lines())
        .filter(|(_, text)| !text.trim().is_empty())
    {
        let fail = |problem: String| ReplayError { line, problem };
        let step: Step = serde_json::from_str(text).map_err(|e| fail(e.to_string()))?;
        let cell: CellId = step
            .cell
            .parse()
            .map_err(|e: vestibule_world::ParseCellIdError| fail(e.to_string()))?;
        if step.pos.iter().any(|v| !v.is_finite()) {
            return Err(fail(format!("the position {:?} is not finite", step.pos)));
        }
        let seed = out.last().map(|row| row.cell);
        out.push(Row {
            line,
            seed,
            teleported: step.teleport,
            pos: step.pos.into(),
            cell,
        });
    }
    Ok(out)
}

fn read_log(text: &str, block: u16) -> Result<Vec<Row>, ReplayError> {
    let mut out = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let split = |c: char| c == '|' || c == ',' || c.is_whitespace();
        let words: Vec<&str> = text.split(split).filter(|word| !word.is_empty()).collect();
        // Headings and rules of tables.
        let heading = words
            .iter()
            .all(|word| !word.contains(|c: char| c.is_ascii_digit()));
        if words.is_empty() || heading {
            continue;
        }
        let fields = match words.as_slice() {
            [_, rest @ ..] if rest.len() == 5 => rest,
            rest if rest.len() == 5 => rest,
            _ => {
                let problem =
                    "expected seed, x, y, z and picked cell, with or without a number in front".to_owned();
                return Err(ReplayError { line, problem });
            }
        };
        let [seed, x, y, z, picked] = fields else { continue };
        let cell = |word: &str| {
            let digits = word.strip_prefix("0x").unwrap_or(word);
            let id = u32::from_str_radix(digits, 16)
                .ok()
                .filter(|_| digits.len() == 4 || digits.len() == 8);
            let id = id.map(|id| {
                if digits.len() == 4 {
                    u32::from(block) << 16 | id
                } else {
                    id
                }
            });
            let problem = || format!("'{word}' is no cell id of four or eight hexadecimal digits");
            id.map(CellId).ok_or_else(|| ReplayError {
                line,
                problem: problem(),
            })
        };
        let number = |word: &str| match word.parse::<f32>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => Err(ReplayError {
                line,
                problem: format!("'{word}' is no finite number"),
            }),
        };
        let pos = Vec3::new(number(x)?, number(y)?, number(z)?);
        out.push(Row {
            line,
            seed: Some(cell(seed)?),
            teleported: false,
            pos,
            cell: cell(picked)?,
        });
    }
    Ok(out)
}

/// Looks every row up, seeded from the row's seed, and compares.
///
/// Rows of a trail are also walked: from one row to the next by a sweep. A row that either of the two explains agrees,
/// since a sweep may carry a body through a cell between two rows.
pub fn run(world: &World, rows: &[Row]) -> ReplayReport {
    let mut report = ReplayReport::default();
    let mut cells = CellArray::new();
    let mut walker = Walker::new(
        world,
        rows.first().map_or_else(Default::default, |row| row.cell.block()),
    );
    let mut before: Option<Row> = None;
    for row in rows {
        let last = before.replace(*row);
        let Some(seed) = row.seed else {
            report.skipped += 1;
            continue;
        };
        let local = row.pos + block_offset(seed.block(), row.cell.block());
        let jumped = last.is_some_and(|last| {
            let from = Position::new(last.cell, last.pos);
            row.seed == Some(last.cell) && from.offset_to(&Position::new(row.cell, row.pos)).length() > 2.0
        });
        if jumped || row.teleported {
            report.skipped += 1;
            continue;
        }
        report.rows += 1;
        let found = find_cell_list(world, seed, local, &player_spheres(local), &mut cells, true).containing;
        // A log's look-ups are single; a trail's rows follow from one another.
        let mut swept = || {
            let last = last.filter(|last| row.seed == Some(last.cell))?;
            let from = Footing {
                at: Position::new(last.cell, last.pos),
                carried: Default::default(),
                rise: 0.0,
            };
            let to = walker.local(last.cell.block(), walker.point(&Position::new(row.cell, row.pos)));
            Some(walker.sweep_to(&from, to).at.cell)
        };
        if found == Some(row.cell) || swept() == Some(row.cell) {
            report.agree += 1;
            continue;
        }
        report.differences.push(RowDifference {
            line: row.line,
            pos: row.pos.to_array(),
            seed: seed.to_string(),
            recorded: row.cell.to_string(),
            found: found.map_or_else(|| "none".to_owned(), |cell| cell.to_string()),
        });
    }
    report
}
