//! EnvCell, `xxyy0100` to `xxyyFFFD` (`dat-format.md` 9.3).

use super::short_id::{ENVIRONMENTS, SURFACES, read_cells, widen_cell, write_cell};
use super::{DatRecord, RecordError, Stab, inherent_parse_and_encode};
use crate::primitive::{Frame, Reader, Writer};

/// One indoor cell: a cell structure of an Environment placed in a landblock.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct EnvCell {
    /// Data id as stored.
    pub id: u32,
    /// Bit 0 seen outside, 1 static objects follow, 3 a restriction object follows.
    pub flags: u32,
    /// The id's second spelling, equal to `id` in sound records.
    pub id_again: u32,
    /// Surfaces that the structure's polygons select from, full ids (0x08...).
    pub surfaces: Vec<u32>,
    /// Environment, full id (0x0D...).
    pub environment: u32,
    /// Key of the cell structure inside the Environment (E2).
    pub cell_struct: u16,
    /// From the cell's own frame to the landblock's.
    pub frame: Frame,
    /// The ways out.
    pub portals: Vec<CellPortal>,
    /// Potentially visible cells of the same landblock, full ids; usually without the cell itself.
    pub stabs: Vec<u32>,
    /// Static objects, placed in the frame of the landblock (L12); present iff flags bit 1.
    pub statics: Vec<Stab>,
    /// The object (house) that restricts entry; present iff flags bit 3.
    pub restriction: Option<u32>,
}

/// A way out of an EnvCell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CellPortal {
    /// Bit 0 exact match; bit 1 clear: portal side 1; bit 2 leads outside.
    pub flags: u16,
    /// The opening: a polygon id in the cell structure.
    pub polygon_id: u16,
    /// The neighbour, full id; low word 0xFFFF when it leads outside. Prefer [`other_cell`](Self::other_cell).
    pub other_cell_id: u32,
    /// The matching portal of the neighbour; negative: none.
    pub other_portal_id: i16,
}

/// What is behind a cell portal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum OtherCell {
    /// The landscape.
    Outside,
    /// An EnvCell of the same landblock, full id.
    Cell(u32),
}

impl EnvCell {
    /// Flag: the outside can be seen from here.
    pub const SEEN_OUTSIDE: u32 = 1;
    /// Flag: static objects follow.
    pub const HAS_STATICS: u32 = 2;
    /// Flag: a restriction object follows.
    pub const HAS_RESTRICTION: u32 = 8;

    /// Whether the outside can be seen from here.
    pub fn seen_outside(&self) -> bool {
        self.flags & Self::SEEN_OUTSIDE != 0
    }
}

impl CellPortal {
    /// Flag: leads outside.
    pub const OUTSIDE: u16 = 4;
    /// The low word of `other_cell_id` that says "outside".
    pub const OUTSIDE_CELL: u16 = 0xFFFF;

    /// Whether it leads outside: flag bit 2 or the cell 0xFFFF (L8).
    pub fn leads_outside(&self) -> bool {
        self.flags & Self::OUTSIDE != 0 || self.other_cell_id as u16 == Self::OUTSIDE_CELL
    }

    /// What is behind.
    pub fn other_cell(&self) -> OtherCell {
        if self.leads_outside() {
            OtherCell::Outside
        } else {
            OtherCell::Cell(self.other_cell_id)
        }
    }

    /// Whether the openings on both sides are one and the same polygon.
    pub fn exact_match(&self) -> bool {
        self.flags & 1 != 0
    }

    /// Which side of the portal plane is the cell's: 1 when flag bit 1 is clear, 0 when it is set.
    pub fn portal_side(&self) -> u8 {
        u8::from(self.flags & 2 == 0)
    }

    /// Position of the matching portal in the neighbour, if there is one.
    pub fn other_portal(&self) -> Option<u16> {
        u16::try_from(self.other_portal_id).ok()
    }
}

impl DatRecord for EnvCell {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let flags = reader.u32("flags")?;
        let id_again = reader.u32("id_again")?;
        let [num_surfaces, num_portals] = reader.array("num_surfaces")?;
        let num_stabs = usize::from(reader.u16("num_stabs")?);
        let surfaces = read_cells(reader, usize::from(num_surfaces), SURFACES, "surfaces")?;
        let environment = widen_cell(reader.u16("environment")?, ENVIRONMENTS);
        let cell_struct = reader.u16("cell_struct")?;
        let frame = reader.frame("frame")?;
        let (words, _) = reader
            .take(CellPortal::SIZE * usize::from(num_portals), "portals")?
            .as_chunks();
        let portals = words
            .iter()
            .map(|word| CellPortal::from_bytes(word, id))
            .collect();
        let stabs = read_cells(reader, num_stabs, id, "stabs")?;
        let statics = if flags & Self::HAS_STATICS != 0 {
            reader.list32(Stab::SIZE, "statics", Stab::read)?
        } else {
            Vec::new()
        };
        let restriction = if flags & Self::HAS_RESTRICTION != 0 {
            Some(reader.u32("restriction")?)
        } else {
            None
        };
        Ok(Self {
            id,
            flags,
            id_again,
            surfaces,
            environment,
            cell_struct,
            frame,
            portals,
            stabs,
            statics,
            restriction,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.u32(self.flags);
        writer.u32(self.id_again);
        writer.count8(self.surfaces.len(), "num_surfaces")?;
        writer.count8(self.portals.len(), "num_portals")?;
        writer.count16(self.stabs.len(), "num_stabs")?;
        for &surface in &self.surfaces {
            write_cell(writer, surface, SURFACES, "surfaces")?;
        }
        write_cell(writer, self.environment, ENVIRONMENTS, "environment")?;
        writer.u16(self.cell_struct);
        writer.frame(&self.frame);
        for portal in &self.portals {
            writer.u16s(&[portal.flags, portal.polygon_id]);
            write_cell(writer, portal.other_cell_id, self.id, "portals.other_cell_id")?;
            writer.i16(portal.other_portal_id);
        }
        for &stab in &self.stabs {
            write_cell(writer, stab, self.id, "stabs")?;
        }
        if self.flags & Self::HAS_STATICS != 0 {
            writer.count32(self.statics.len(), "statics")?;
            self.statics.iter().for_each(|object| object.write(writer));
        } else {
            writer.require(
                self.statics.is_empty(),
                "statics",
                "static objects without flags bit 1",
            )?;
        }
        let has_restriction = self.flags & Self::HAS_RESTRICTION != 0;
        let what = "a restriction object exists iff flags bit 3 is set";
        writer.require(self.restriction.is_some() == has_restriction, "restriction", what)?;
        if let Some(restriction) = self.restriction {
            writer.u32(restriction);
        }
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(EnvCell);

impl CellPortal {
    const SIZE: usize = 8;

    #[inline]
    fn from_bytes(&[f0, f1, p0, p1, c0, c1, o0, o1]: &[u8; Self::SIZE], cell: u32) -> Self {
        Self {
            flags: u16::from_le_bytes([f0, f1]),
            polygon_id: u16::from_le_bytes([p0, p1]),
            other_cell_id: widen_cell(u16::from_le_bytes([c0, c1]), cell),
            other_portal_id: i16::from_le_bytes([o0, o1]),
        }
    }
}
