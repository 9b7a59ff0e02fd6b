//! Bodies and which cells they are in.

use vestibule_world::CellId;

use crate::obj_collisions::Target;
use crate::settings::Settings;

/// Names a body of a [`Population`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyId {
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

/// Bodies, and which of them are in which cell.
#[derive(Debug, Default)]
pub struct Population {
    settings: Settings,
}

impl Population {
    /// No bodies, retail settings.
    pub fn new() -> Self {
        Self::default()
    }

    /// The settings of sweeps.
    #[inline]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    pub(crate) fn shadows_in(&self, _cell: CellId) -> &[BodyId] {
        &[]
    }
    pub(crate) fn target(&self, _id: BodyId) -> Option<Target<'_>> {
        None
    }
    pub(crate) fn may_enter(&self, _body: Option<BodyId>, _cell: CellId, _object: u32) -> bool {
        true
    }
}
