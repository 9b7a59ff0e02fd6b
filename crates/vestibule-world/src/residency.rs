//! Which part of the world is resident for a viewer (`world.md` 17).

use crate::env_cell::EnvCell;
use crate::ids::{BlockId, CellId};
use crate::landblock::{Land, Landblock};
use crate::lscape::LandscapeWindow;
use crate::position::Position;
use crate::transit_hints::refresh_away;

/// How much of the world a [`crate::CellManager`] keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResidencySettings {
    /// Landblocks on each side of the load point's that are loaded, at least 1 (`world.md` 17.2 L1).
    pub radius: u8,
    /// Memory of landblocks and the assets they share, bytes, at most. Distant landscape is given up first; the
    /// current landblock and those around it are kept whatever they take.
    pub memory_ceiling: usize,
    /// Landblocks taken over from the loader in one update, at most.
    pub taken_per_update: usize,
    /// Landblocks asked of the loader at a time, at most: what is asked for cannot be taken back.
    pub in_flight: usize,
    /// Load on a thread of its own. Without, or where there are no threads, one landblock is loaded in each update.
    pub threaded: bool,
}

impl Default for ResidencySettings {
    fn default() -> Self {
        ResidencySettings {
            radius: crate::lscape::DEFAULT_RADIUS,
            memory_ceiling: 256 << 20,
            taken_per_update: 2,
            in_flight: 4,
            threaded: cfg!(not(target_family = "wasm")),
        }
    }
}

/// What is resident, and what it took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResidencyStats {
    /// Env cells that physics knows.
    pub env_cells: usize,
    /// Landblocks that physics knows.
    pub blocks: usize,
    /// Further landblocks, for drawing and in case they are needed.
    pub distant_blocks: usize,
    /// Landblocks the loader has been asked for.
    pub in_flight: usize,
    /// Memory of all of them and of the shared assets, bytes, about.
    pub bytes: usize,
    /// The most that was.
    pub peak_bytes: usize,
    /// Landblocks loaded so far.
    pub loaded: u64,
    /// Landblocks given up because of the memory ceiling.
    pub evicted: u64,
}

/// The landscape that goes with a position: `None` for a cell that does not see the outside (`world.md` W1, W4).
pub(crate) fn window_of(position: &Position, seen_outside: bool, radius: u8) -> Option<LandscapeWindow> {
    let center = if position.cell.is_indoor() {
        let outside = if seen_outside {
            position.adjusted_to_outside()?.cell
        } else {
            return None;
        };
        outside.block()
    } else {
        position.cell.block()
    };
    center.is_on_map().then_some(LandscapeWindow {
        center,
        radius: radius.max(1),
    })
}

/// Blocks between two blocks, the larger of the two directions.
pub(crate) fn apart(a: BlockId, b: BlockId) -> u8 {
    a.x().abs_diff(b.x()).max(a.y().abs_diff(b.y()))
}

/// The part of a landblock that physics does not know at present.
#[derive(Default)]
pub(crate) struct Hidden {
    land: Option<Land>,
    cells: Vec<Option<EnvCell>>,
    /// The block's stab list, ascending.
    pub(crate) stabs: Vec<CellId>,
}

impl Hidden {
    /// Takes everything out of a block.
    pub(crate) fn all_of(block: &mut Landblock) -> Self {
        let mut stabs = block.stab_list();
        stabs.sort_unstable();
        Hidden {
            land: block.land.take(),
            cells: block.env_cells.iter_mut().map(Option::take).collect(),
            stabs,
        }
    }

    /// Puts everything back.
    pub(crate) fn restore(self, block: &mut Landblock) {
        block.land = block.land.take().or(self.land);
        for (slot, cell) in block.env_cells.iter_mut().zip(self.cells) {
            *slot = slot.take().or(cell);
        }
    }

    /// Makes the land known or unknown; whether that changed.
    pub(crate) fn set_land(&mut self, block: &mut Landblock, known: bool) -> bool {
        let changes = if known {
            self.land.is_some()
        } else {
            block.land.is_some()
        };
        if changes {
            core::mem::swap(&mut self.land, &mut block.land);
        }
        changes
    }

    pub(crate) fn cell(&self, id: CellId) -> Option<&EnvCell> {
        self.cells.get(index_of(id)?)?.as_ref()
    }

    /// Makes env cells known or unknown.
    pub(crate) fn change_cells(&mut self, block: &mut Landblock, changed: &[CellId]) {
        for index in changed.iter().filter_map(|&id| index_of(id)) {
            if let (Some(here), Some(there)) = (self.cells.get_mut(index), block.env_cells.get_mut(index)) {
                core::mem::swap(here, there);
            }
        }
        // What leads to a changed cell must be asked anew.
        for &id in changed {
            let Some(index) = index_of(id) else { continue };
            refresh_away(&mut block.env_cells, index);
            let Some(cell) = self.cell(id).or(block.env_cell(id)) else {
                continue;
            };
            let around: Vec<usize> = cell
                .portals
                .iter()
                .filter_map(|portal| match portal.other {
                    crate::env_cell::PortalTarget::Cell(other) => index_of(other),
                    crate::env_cell::PortalTarget::Outside => None,
                })
                .collect();
            for neighbour in around {
                refresh_away(&mut block.env_cells, neighbour);
            }
        }
    }
}

fn index_of(id: CellId) -> Option<usize> {
    usize::from(id.low()).checked_sub(0x100)
}
