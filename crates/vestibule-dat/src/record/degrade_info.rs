//! GfxObjDegradeInfo, `11......` (`dat-format.md` 10.10).

use super::{DatRecord, RecordError, inherent_parse_and_encode};
use crate::primitive::{Reader, Writer};

/// The coarser versions of a model, by distance.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct GfxObjDegradeInfo {
    /// Data id as stored.
    pub id: u32,
    /// From near to far.
    pub degrades: Vec<Degrade>,
}

/// One version of a model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Degrade {
    /// GfxObj, 0 none.
    pub gfx_obj: u32,
    /// How it is drawn.
    pub degrade_mode: u32,
    /// Metres.
    pub min_dist: f32,
    /// Metres.
    pub ideal_dist: f32,
    /// Metres.
    pub max_dist: f32,
}

impl DatRecord for GfxObjDegradeInfo {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let degrades = reader.list32(20, "degrades", |reader| {
            Ok(Degrade {
                gfx_obj: reader.u32("degrade.gfx_obj")?,
                degrade_mode: reader.u32("degrade.degrade_mode")?,
                min_dist: reader.f32("degrade.min_dist")?,
                ideal_dist: reader.f32("degrade.ideal_dist")?,
                max_dist: reader.f32("degrade.max_dist")?,
            })
        })?;
        Ok(Self { id, degrades })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.id);
        writer.count32(self.degrades.len(), "degrades")?;
        for degrade in &self.degrades {
            writer.u32s(&[degrade.gfx_obj, degrade.degrade_mode]);
            writer.f32s(&[degrade.min_dist, degrade.ideal_dist, degrade.max_dist]);
        }
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(GfxObjDegradeInfo);
