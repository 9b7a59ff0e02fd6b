//! Two ways of saying which cell a body is in, counted side by side.

use std::collections::BTreeMap;

use glam::Vec3;
use serde::Serialize;
use vestibule_world::{CellId, Position, World};

/// A way of saying which cell a body is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Membership {
    /// Retail's: the cell that the last accepted sweep ended in.
    #[default]
    Sweep,
    /// As other clients did: derived anew from where the body rests, see [`derive_cell`].
    Static,
}

/// How often a way of saying which cell a body is in changed its mind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MembershipCount {
    /// Changes of cell, teleports left out.
    pub changes: usize,
    /// Changes that were taken back within [`FLICKER_TICKS`], or that came while the body stood still.
    pub flickers: usize,
    /// Changes while the body stood still.
    pub while_standing: usize,
    /// Changes between two cells that no opening or land border joins.
    pub through_walls: usize,
    /// Ticks with another cell than the sweep says.
    pub ticks_off: usize,
    #[serde(skip)]
    last: Option<(CellId, CellId, usize)>,
    #[serde(skip)]
    now: Option<CellId>,
}

/// Ticks within which a change that is taken back counts as flicker: a third of a second.
pub const FLICKER_TICKS: usize = 10;

/// What a tick was like for the count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tick {
    /// Number of the tick.
    pub(super) number: usize,
    /// The body stands still in a doorway.
    pub(super) standing: bool,
    /// The body was put here.
    pub(super) teleported: bool,
}

impl MembershipCount {
    /// Counts a tick. Answers the cell before when it changed, and not by a teleport.
    pub(super) fn count(&mut self, world: &World, cell: CellId, swept: CellId, tick: Tick) -> Option<CellId> {
        self.ticks_off += usize::from(cell != swept);
        let before = self.now.replace(cell)?;
        if before == cell {
            return None;
        }
        if tick.teleported {
            self.last = None;
            return None;
        }
        self.changes += 1;
        self.while_standing += usize::from(tick.standing);
        self.through_walls += usize::from(!are_joined(world, before, cell));
        let taken_back = self
            .last
            .is_some_and(|(from, to, at)| from == cell && to == before && tick.number - at <= FLICKER_TICKS);
        self.flickers += usize::from(taken_back || tick.standing);
        self.last = Some((before, cell, tick.number));
        Some(before)
    }

    /// The cell of the last tick.
    pub(super) fn now(&self) -> Option<CellId> {
        self.now
    }
}

/// Whether one can get from one cell to the other without passing through a third.
fn are_joined(world: &World, a: CellId, b: CellId) -> bool {
    use vestibule_world::PortalTarget;
    let leads = |from: CellId, to: PortalTarget| {
        world
            .env_cell(from)
            .is_some_and(|cell| cell.portals.iter().any(|portal| portal.other == to))
    };
    match (a.is_indoor(), b.is_indoor()) {
        (true, true) => leads(a, PortalTarget::Cell(b)) || leads(b, PortalTarget::Cell(a)),
        (true, false) => leads(a, PortalTarget::Outside),
        (false, true) => leads(b, PortalTarget::Outside),
        (false, false) => true,
    }
}

/// The cell of a resting position without regard to where the body came from: the first env cell of its landblock that
/// holds its foot point, else the land cell under it. This is how other clients said it; retail does not.
pub fn derive_cell(world: &World, at: &Position) -> CellId {
    let inside = world.block(at.cell.block()).and_then(|block| {
        let found = block.env_cells().find(|cell| cell.contains_point(at.origin()));
        found.map(|cell| cell.id)
    });
    let outside = || at.cell.adjust_to_outside(at.origin()).map(|(cell, _)| cell);
    inside.or_else(outside).unwrap_or(at.cell)
}

/// Where the two ways say different things.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Disagreement {
    /// The cell the sweep carried the body into.
    pub cell: String,
    /// The cell derived from where it rests.
    #[serde(rename = "static")]
    pub derived: String,
    /// For how many ticks.
    pub ticks: usize,
    /// Where that was first, in the frame of the cell's landblock, metres.
    pub first_at: [f32; 3],
}

/// Ticks and first place of each pair of cells that the two ways gave.
#[derive(Clone, Debug, Default)]
pub(super) struct Disagreements(BTreeMap<(CellId, CellId), (usize, Vec3)>);

impl Disagreements {
    pub(super) fn note(&mut self, at: &Position, derived: CellId) {
        if derived != at.cell {
            let entry = self.0.entry((at.cell, derived));
            entry.or_insert_with(|| (0, at.origin())).0 += 1;
        }
    }

    /// The pairs, most frequent first.
    pub(super) fn list(&self) -> Vec<Disagreement> {
        let mut out: Vec<Disagreement> = self
            .0
            .iter()
            .map(|(&(cell, derived), &(ticks, first))| Disagreement {
                cell: cell.to_string(),
                derived: derived.to_string(),
                ticks,
                first_at: first.to_array(),
            })
            .collect();
        out.sort_by_key(|d| std::cmp::Reverse(d.ticks));
        out
    }
}
