//! `AdjustPosition` and `find_visible_child_cell` (`world.md` 15 V3, V4).

use glam::Vec3;

use crate::env_cell::{EnvCell, PortalTarget};
use crate::ids::CellId;
use crate::position::Position;
use crate::world::World;

/// A position whose cell has been found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdjustedPosition {
    /// The position with the cell that holds it.
    pub position: Position,
    /// Whether that cell is resident.
    pub resident: bool,
}

/// The cell of `start`'s neighbourhood that contains `q`, a point in the frame of its landblock: `start` itself,
/// else the first resident cell of its stab list (`search_cells`) or of its portals that does (`world.md` V3).
pub fn find_visible_child_cell<'w>(
    world: &'w World,
    start: &'w EnvCell,
    q: Vec3,
    search_cells: bool,
) -> Option<&'w EnvCell> {
    if start.contains_point(q) {
        return Some(start);
    }
    let containing = |id: CellId| world.env_cell(id).filter(|cell| cell.contains_point(q));
    if search_cells {
        start.stab_list.iter().find_map(|&id| containing(id))
    } else {
        start.portals.iter().find_map(|portal| match portal.other {
            PortalTarget::Cell(id) => containing(id),
            PortalTarget::Outside => None,
        })
    }
}

/// Finds the cell of a position that names one nearby: for placements, teleports and the camera's fallback,
/// never for a body that moves (`world.md` V4, retail `AdjustPosition`).
///
/// Indoors the point `low_point` (object space: sphere 0's centre) is located, outdoors the **origin**
/// (`world.md` V5). `None` when the cell named is not resident indoors, nothing contains the point and the cell
/// does not see the outside, or the position is off the map.
pub fn adjust_position(
    world: &World,
    position: &Position,
    low_point: Vec3,
    search_cells: bool,
) -> Option<AdjustedPosition> {
    if !position.cell.has_valid_low() {
        return None;
    }
    if position.cell.is_indoor() {
        let start = world.env_cell(position.cell)?;
        let q = position.frame.local_to_global(low_point);
        if let Some(found) = find_visible_child_cell(world, start, q, search_cells) {
            return Some(AdjustedPosition {
                position: Position {
                    cell: found.id,
                    frame: position.frame,
                },
                resident: true,
            });
        }
        if !start.seen_outside {
            return None;
        }
    }
    let position = position.adjusted_to_outside()?;
    Some(AdjustedPosition {
        resident: world.is_resident(position.cell),
        position,
    })
}
