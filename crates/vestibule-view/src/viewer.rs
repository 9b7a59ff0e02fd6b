//! The viewer's cell and the player's: the same graph, different holders (`study.md` C13).

use vestibule_world::CellId;

/// The cell the camera is in: from the camera's own sweep, never from coordinates. The frame is decided by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ViewerCell(pub CellId);

/// The cell the player's body is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PlayerCell(pub CellId);
