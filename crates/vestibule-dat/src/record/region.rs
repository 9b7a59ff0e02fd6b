//! Region, `13000000` (`dat-format.md` 10.4): the whole of a landscape's settings.

mod land_defs;
mod scene_types;
mod sky;
mod terrain;

pub use land_defs::LandDefs;
pub use scene_types::{AmbientSound, AmbientSoundTable, SceneDesc, SceneType, SoundDesc};
pub use sky::{DayGroup, GameTime, Season, SkyDesc, SkyObject, SkyObjectReplace, SkyTime, TimeOfDay};
pub use terrain::{RoadMap, TerrainAlphaMap, TerrainDesc, TerrainTexture, TerrainType, TexMerge};

use super::{DatRecord, RecordError, RecordErrorKind, inherent_parse_and_encode};
use crate::primitive::{LegacyString, Reader, Writer};

/// Settings of a landscape: its measures, time, sky, sounds, scenery and terrain.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Region {
    /// Data id as stored.
    pub id: u32,
    /// Number of the region; the cell file's subset.
    pub region_number: u32,
    /// Layout version; 3.
    pub version: u32,
    /// Name.
    pub name: LegacyString,
    /// Measures of the land.
    pub land_defs: LandDefs,
    /// Calendar.
    pub game_time: GameTime,
    /// Which of the optional parts follow.
    pub parts_mask: u32,
    /// Skies; present iff mask & 0x10.
    pub sky: Option<SkyDesc>,
    /// Ambient sounds; present iff mask & 0x01.
    pub sound: Option<SoundDesc>,
    /// Scenery by kind of terrain; present iff mask & 0x02.
    pub scene: Option<SceneDesc>,
    /// Terrain types and their textures.
    pub terrain: TerrainDesc,
    /// Maps and the like; present iff mask & 0x200.
    pub misc: Option<RegionMisc>,
}

/// Odds and ends of a region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RegionMisc {
    /// Version.
    pub version: u32,
    /// RenderSurface of the map.
    pub game_map: u32,
    /// RenderSurface of a test map.
    pub autotest_map: u32,
    /// Its size.
    pub autotest_map_size: u32,
    /// Model that marks a clear cell.
    pub clear_cell: u32,
    /// Model that marks a clear monster.
    pub clear_monster: u32,
}

impl Region {
    /// Mask bit: ambient sounds follow.
    pub const HAS_SOUND: u32 = 0x01;
    /// Mask bit: scenery follows.
    pub const HAS_SCENE: u32 = 0x02;
    /// Mask bit: skies follow.
    pub const HAS_SKY: u32 = 0x10;
    /// Mask bit: the odds and ends follow.
    pub const HAS_MISC: u32 = 0x200;
    /// The only layout version that is read.
    pub const VERSION: u32 = 3;
}

impl DatRecord for Region {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let id = reader.u32("id")?;
        let region_number = reader.u32("region_number")?;
        let start = reader.position();
        let version = reader.u32("version")?;
        if version != Self::VERSION {
            let kind = RecordErrorKind::BadValue {
                value: version,
                expected: "region version 3",
            };
            return Err(reader.error_at(start, "version", kind));
        }
        let name = reader.legacy_string("name")?;
        let land_defs = LandDefs::read(reader)?;
        let game_time = GameTime::read(reader)?;
        let parts_mask = reader.u32("parts_mask")?;
        let has = |bit| parts_mask & bit != 0;
        let sky = if has(Self::HAS_SKY) {
            Some(SkyDesc::read(reader)?)
        } else {
            None
        };
        let sound = if has(Self::HAS_SOUND) {
            Some(SoundDesc::read(reader)?)
        } else {
            None
        };
        let scene = if has(Self::HAS_SCENE) {
            Some(SceneDesc::read(reader)?)
        } else {
            None
        };
        let terrain = TerrainDesc::read(reader)?;
        let misc = if has(Self::HAS_MISC) {
            Some(RegionMisc::read(reader)?)
        } else {
            None
        };
        Ok(Self {
            id,
            region_number,
            version,
            name,
            land_defs,
            game_time,
            parts_mask,
            sky,
            sound,
            scene,
            terrain,
            misc,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        let has = |bit| self.parts_mask & bit != 0;
        let what = "a part exists iff its bit in parts_mask is set";
        writer.u32s(&[self.id, self.region_number, self.version]);
        writer.legacy_string(&self.name, "name")?;
        self.land_defs.write(writer);
        self.game_time.write(writer)?;
        writer.u32(self.parts_mask);
        writer.require(self.sky.is_some() == has(Self::HAS_SKY), "sky", what)?;
        if let Some(sky) = &self.sky {
            sky.write(writer)?;
        }
        writer.require(self.sound.is_some() == has(Self::HAS_SOUND), "sound", what)?;
        if let Some(sound) = &self.sound {
            sound.write(writer)?;
        }
        writer.require(self.scene.is_some() == has(Self::HAS_SCENE), "scene", what)?;
        if let Some(scene) = &self.scene {
            scene.write(writer)?;
        }
        self.terrain.write(writer)?;
        writer.require(self.misc.is_some() == has(Self::HAS_MISC), "misc", what)?;
        if let Some(misc) = &self.misc {
            misc.write(writer);
        }
        Ok(())
    }

    fn stored_id(&self) -> Option<u32> {
        Some(self.id)
    }
}

inherent_parse_and_encode!(Region);

impl RegionMisc {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            version: reader.u32("misc.version")?,
            game_map: reader.u32("misc.game_map")?,
            autotest_map: reader.u32("misc.autotest_map")?,
            autotest_map_size: reader.u32("misc.autotest_map_size")?,
            clear_cell: reader.u32("misc.clear_cell")?,
            clear_monster: reader.u32("misc.clear_monster")?,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.u32s(&[
            self.version,
            self.game_map,
            self.autotest_map,
            self.autotest_map_size,
            self.clear_cell,
            self.clear_monster,
        ]);
    }
}
