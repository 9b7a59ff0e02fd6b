//! What a tour records: a row a tick, and every change of cell.

use glam::Vec3;
use serde::Serialize;
use vestibule_world::{CellId, PortalTarget, Position, World};

use super::TourRecord;
use crate::route::{self, Opening};

/// One tick of the walk, as in `trail.jsonl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrailStep {
    /// Seconds since the start.
    pub t: f32,
    /// The player's cell.
    pub cell: CellId,
    /// Its foot point in the frame of the cell's landblock, metres.
    pub pos: Vec3,
    /// It stands still in a doorway.
    pub standing: bool,
    /// It was put here, not carried by a sweep.
    pub teleported: bool,
}

impl Serialize for TrailStep {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut out = serializer.serialize_struct("TrailStep", 5)?;
        // Ticks are thirtieths of a second: hundredths would not be even.
        out.serialize_field("t", &(f64::from((self.t * 1e4).round()) / 1e4))?;
        out.serialize_field("cell", &self.cell.to_string())?;
        out.serialize_field("pos", &self.pos.to_array())?;
        if self.standing {
            out.serialize_field("standing", &true)?;
        } else {
            out.skip_field("standing")?;
        }
        if self.teleported {
            out.serialize_field("teleport", &true)?;
        } else {
            out.skip_field("teleport")?;
        }
        out.end()
    }
}

/// Writes a trail as JSON lines: `t`, `cell`, `pos`, and where it holds `standing` and `teleport`; of the camera
/// `viewer` (its cell), `eye`, and where the draw list is another than in the row before `rooms` and `outside`.
///
/// # Errors
/// As `out` has them.
pub fn write_trail(record: &TourRecord, out: &mut impl std::io::Write) -> std::io::Result<()> {
    #[derive(Serialize)]
    struct Row<'a> {
        #[serde(flatten)]
        step: &'a TrailStep,
        #[serde(flatten)]
        eye: Option<EyeRow>,
    }
    #[derive(Serialize)]
    struct EyeRow {
        viewer: Option<String>,
        eye: [f32; 3],
        #[serde(skip_serializing_if = "Option::is_none")]
        rooms: Option<Vec<String>>,
        #[serde(skip_serializing_if = "Option::is_none")]
        outside: Option<bool>,
    }
    let mut last = None;
    for (i, step) in record.trail.iter().enumerate() {
        let eye = record.eyes.get(i).map(|eye| {
            let is_new = last.replace(eye.list) != Some(eye.list);
            let list = record.lists.get(eye.list).filter(|_| is_new);
            EyeRow {
                viewer: eye.cell.map(|cell| cell.to_string()),
                eye: eye.position.origin().to_array(),
                rooms: list.map(|list| list.rooms.iter().map(ToString::to_string).collect()),
                outside: list.map(|list| list.outside),
            }
        });
        serde_json::to_writer(&mut *out, &Row { step, eye })?;
        writeln!(out)?;
    }
    Ok(())
}

/// A change of cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Seconds since the start.
    pub t: f32,
    /// Where the player was after it.
    pub position: String,
    /// The cell before.
    pub from: String,
    /// The cell after.
    pub to: String,
    /// What was crossed.
    pub by: String,
    /// An opening was crossed, not a line between land cells.
    pub portal: bool,
    /// It happened while the player stood still.
    pub standing: bool,
}

/// A position to the centimetre, without rotation.
pub(super) fn short(at: &Position) -> String {
    let p = at.origin();
    format!("{} [{:.2} {:.2} {:.2}]", at.cell, p.x, p.y, p.z)
}

/// Which opening lies between two cells, nearest to where the player is now.
pub(super) fn crossed(world: &World, from: CellId, now: &Position) -> Option<String> {
    let to = now.cell;
    let nearest = |openings: Vec<Opening>, leads: &dyn Fn(&Opening) -> bool| {
        let distance = |o: &Opening| route::distance_to(o, to.block(), now.origin());
        openings
            .into_iter()
            .filter(leads)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let found = match (from.is_indoor(), to.is_indoor()) {
        (true, true) => nearest(route::openings(world, from), &|o| o.to == PortalTarget::Cell(to)),
        (true, false) => nearest(route::openings(world, from), &|o| o.to == PortalTarget::Outside),
        (false, true) => nearest(route::openings(world, to), &|o| o.to == PortalTarget::Outside),
        (false, false) => None,
    }?;
    let own = if found.id.cell == to { "its" } else { "portal" };
    let text = match own {
        "its" => format!("portal {} of {}", found.id.portal, found.id.cell),
        _ => format!("portal {}", found.id.portal),
    };
    Some(format!("{text}, {}", found.in_words()))
}
