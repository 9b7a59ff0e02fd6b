//! LandBlockInfo, `xxyyFFFE` (`dat-format.md` 9.2).

use super::short_id::{read_cells, widen_cell, write_cell};
use super::{DatRecord, RecordError, Stab, inherent_parse_and_encode};
use crate::primitive::{Frame, PackedHashTable, Reader, Writer};

/// What stands on a landblock: its static objects and buildings. Frames are relative to the landblock's south-west
/// corner (L4).
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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

impl LandBlockInfo {
    /// Pack-mask bit: a restriction table follows.
    pub const HAS_RESTRICTIONS: u16 = 1;
}

impl DatRecord for LandBlockInfo {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let num_cells = reader.u32("num_cells")?;
        let objects = reader.list32(Stab::SIZE, "objects", Stab::read)?;
        let num_buildings = reader.u16("num_buildings")?;
        let pack_mask = reader.u16("pack_mask")?;
        let num_buildings = reader.check_count(u64::from(num_buildings), 40, "num_buildings")?;
        let buildings = reader.items(num_buildings, |reader| Building::read(reader, id))?;
        let restrictions = if pack_mask & Self::HAS_RESTRICTIONS != 0 {
            Some(reader.packed_hash_table("restrictions")?)
        } else {
            None
        };
        reader.align4("padding")?;
        Ok(Self {
            id,
            num_cells,
            objects,
            pack_mask,
            buildings,
            restrictions,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.u32(self.num_cells);
        writer.count32(self.objects.len(), "objects")?;
        self.objects.iter().for_each(|object| object.write(writer));
        writer.count16(self.buildings.len(), "num_buildings")?;
        writer.u16(self.pack_mask);
        for building in &self.buildings {
            building.write(writer, self.id)?;
        }
        let has_table = self.pack_mask & Self::HAS_RESTRICTIONS != 0;
        let what = "a restriction table exists iff pack_mask bit 0 is set";
        writer.require(self.restrictions.is_some() == has_table, "restrictions", what)?;
        if let Some(restrictions) = &self.restrictions {
            writer.packed_hash_table(restrictions, "restrictions")?;
        }
        writer.align4();
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(LandBlockInfo);

impl Building {
    fn read(reader: &mut Reader<'_>, landblock: u32) -> Result<Self, RecordError> {
        Ok(Self {
            model_id: reader.u32("building.model_id")?,
            frame: reader.frame("building.frame")?,
            num_leaves: reader.u32("building.num_leaves")?,
            portals: reader.list32(8, "building.portals", |reader| {
                BuildingPortal::read(reader, landblock)
            })?,
        })
    }

    fn write(&self, writer: &mut Writer, landblock: u32) -> Result<(), RecordError> {
        writer.u32(self.model_id);
        writer.frame(&self.frame);
        writer.u32(self.num_leaves);
        writer.count32(self.portals.len(), "building.portals")?;
        self.portals
            .iter()
            .try_for_each(|portal| portal.write(writer, landblock))
    }
}

impl BuildingPortal {
    fn read(reader: &mut Reader<'_>, landblock: u32) -> Result<Self, RecordError> {
        let flags = reader.u16("building_portal.flags")?;
        let other_cell_id = widen_cell(reader.u16("building_portal.other_cell_id")?, landblock);
        let other_portal_id = reader.i16("building_portal.other_portal_id")?;
        let count = usize::from(reader.u16("building_portal.num_stabs")?);
        let stabs = read_cells(reader, count, landblock, "building_portal.stabs")?;
        reader.align4("building_portal.padding")?;
        Ok(Self {
            flags,
            other_cell_id,
            other_portal_id,
            stabs,
        })
    }

    fn write(&self, writer: &mut Writer, landblock: u32) -> Result<(), RecordError> {
        writer.u16(self.flags);
        write_cell(
            writer,
            self.other_cell_id,
            landblock,
            "building_portal.other_cell_id",
        )?;
        writer.i16(self.other_portal_id);
        writer.count16(self.stabs.len(), "building_portal.num_stabs")?;
        for &stab in &self.stabs {
            write_cell(writer, stab, landblock, "building_portal.stabs")?;
        }
        writer.align4();
        Ok(())
    }
}
