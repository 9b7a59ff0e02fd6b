//! The cell array (retail `CELLARRAY`, `world.md` 13): which cells spheres or parts touch, in order.

use crate::ids::CellId;

/// One entry of a [`CellArray`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellEntry {
    /// Full id of the cell.
    pub id: CellId,
    /// Whether the cell is resident; retail keeps entries without a cell (`world.md` 11.1).
    pub resident: bool,
}

/// An ordered set of cells. Reuse one: clearing keeps its memory, so look-ups do not allocate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellArray {
    entries: Vec<CellEntry>,
    /// The outdoor cells have been added (retail `added_outside`).
    pub added_outside: bool,
    /// Drop cells that are neither the seed cell nor in its stab list (retail `do_not_load_cells`): set for
    /// placements that ask for it, never by movement.
    pub do_not_load_cells: bool,
}

impl Default for CellArray {
    fn default() -> Self {
        CellArray {
            entries: Vec::with_capacity(32),
            added_outside: false,
            do_not_load_cells: false,
        }
    }
}

impl CellArray {
    /// An empty array.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets the entries and `added_outside`; `do_not_load_cells` is kept (`world.md` 13.1).
    #[inline]
    pub fn clear(&mut self) {
        self.entries.clear();
        self.added_outside = false;
    }

    /// The entries in the order found.
    #[inline]
    pub fn entries(&self) -> &[CellEntry] {
        &self.entries
    }

    /// Number of entries.
    #[inline]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is no entry.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The entry at `index`.
    #[inline]
    pub fn get(&self, index: usize) -> Option<CellEntry> {
        self.entries.get(index).copied()
    }

    /// Whether the cell is listed.
    #[inline]
    pub fn contains(&self, id: CellId) -> bool {
        self.entries.iter().any(|e| e.id == id)
    }

    /// Appends a cell unless it is listed (retail `add_cell`).
    #[inline]
    pub fn add(&mut self, id: CellId, resident: bool) {
        if !self.contains(id) {
            self.entries.push(CellEntry { id, resident });
        }
    }

    /// Clears the array and lists one cell.
    #[inline]
    pub fn start(&mut self, id: CellId, resident: bool) {
        self.clear();
        self.entries.push(CellEntry { id, resident });
    }

    /// Removes entry `index`; the **last** entry takes its place (retail `remove_cell`).
    pub fn remove(&mut self, index: usize) {
        if index < self.entries.len() {
            self.entries.swap_remove(index);
        }
    }
}
