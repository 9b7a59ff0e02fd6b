//! What is known beforehand of the world that is built in.

use std::collections::BTreeMap;

use vestibule_dat::DatSet;
use vestibule_world::{CellId, Position};

/// Where to begin in the embedded world, and what its cells are called.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guide {
    /// Where visitors begin.
    pub start: Option<Position>,
    /// Names of env cells, as `cottage.hall`.
    pub names: BTreeMap<CellId, String>,
}

/// Records that only the embedded world has like this: the lists of its village and of its dungeon.
const MARKS: [u32; 2] = [0xA9B4_FFFE, 0x0107_FFFE];

impl Guide {
    /// The guide to the embedded world, if these files hold it: built in or written to a folder.
    pub fn of(dats: &DatSet) -> Option<Guide> {
        if MARKS.iter().any(|&id| !matches!(dats.get_cell(id), Ok(Some(_)))) {
            return None;
        }
        let compiled = vestibule_forge::embedded_world().ok()?;
        // A world that was changed by hand may lack what the guide speaks of.
        let rooms = compiled.cell_names.keys().map(|cell| cell.0);
        let same = MARKS.into_iter().chain(rooms).all(|id| {
            let stored = dats.get_cell(id).ok().flatten();
            stored.is_some() && compiled.cell.get(&id).map(Vec::as_slice) == stored.as_deref()
        });
        same.then_some(Guide {
            start: compiled.start,
            names: compiled.cell_names,
        })
    }

    /// The first cell of this name.
    pub fn cell(&self, name: &str) -> Option<CellId> {
        self.names
            .iter()
            .find(|(_, other)| *other == name)
            .map(|(&id, _)| id)
    }

    /// A cell's name; its id when it has none.
    pub fn name(&self, id: CellId) -> String {
        self.names.get(&id).cloned().unwrap_or_else(|| id.to_string())
    }
}
