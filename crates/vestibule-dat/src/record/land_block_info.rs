//! LandBlockInfo, `xxyyFFFE` (`dat-format.md` 9.2).

use super::Stab;
use crate::primitive::{Frame, PackedHashTable};

/// What stands on a landblock: its static objects and buildings. Frames are relative to the landblock's south-west
/// corner (L4).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LandBlockInfo {
    /// Data id as stored.
    pub id: u32,
    /// The block's EnvCells are 0x0100 to 0x0100 + num_cells - 1.
    pub num_cells: u32,
    /// Static objects.
    pub objects: Vec<Stab>,
    /// Bit 0: a restriction table is present.
    pub pack_mask: u16,
    /// Buildings.
    pub buildings: Vec<Building>,
    /// Land-cell id to the id of the object (house) that restricts it; present iff `pack_mask` bit 0.
    pub restrictions: Option<PackedHashTable>,
}

/// A building: a model whose portals lead into EnvCells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Building {
    /// GfxObj or Setup.
    pub model_id: u32,
    /// Place in the landblock.
    pub frame: Frame,
    /// Capacity of a render cache; kept, not interpreted (L6).
    pub num_leaves: u32,
    /// The ways in. A PORT node of the model names them by position (G12).
    pub portals: Vec<BuildingPortal>,
}

/// A way into a building.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BuildingPortal {
    /// Bit 0 exact match; bit 1 clear: portal side 1.
    pub flags: u16,
    /// EnvCell behind it, full id.
    pub other_cell_id: u32,
    /// The matching portal of that EnvCell; negative: none (L7).
    pub other_portal_id: i16,
    /// EnvCells that must be resident with this portal, full ids.
    pub stabs: Vec<u32>,
}

impl BuildingPortal {
    /// Whether the openings on both sides are one and the same polygon.
    pub fn exact_match(&self) -> bool {
        self.flags & 1 != 0
    }

    /// Which side of the portal plane is this side's: 1 when flag bit 1 is clear, 0 when it is set.
    pub fn portal_side(&self) -> u8 {
        u8::from(self.flags & 2 == 0)
    }

    /// Position of the matching portal in the EnvCell behind, if there is one (L7).
    pub fn other_portal(&self) -> Option<u16> {
        u16::try_from(self.other_portal_id).ok()
    }
}
