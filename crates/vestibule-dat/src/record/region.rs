//! Region, `13000000` (`dat-format.md` 10.4): the whole of a landscape's settings.

mod land_defs;
mod scene_types;
mod sky;
mod terrain;

pub use land_defs::LandDefs;
pub use scene_types::{AmbientSound, AmbientSoundTable, SceneDesc, SceneType, SoundDesc};
pub use sky::{DayGroup, GameTime, Season, SkyDesc, SkyObject, SkyObjectReplace, SkyTime, TimeOfDay};
pub use terrain::{RoadMap, TerrainAlphaMap, TerrainDesc, TerrainTexture, TerrainType, TexMerge};

use crate::primitive::LegacyString;

/// Settings of a landscape: its measures, time, sky, sounds, scenery and terrain.
#[derive(Debug, Clone, PartialEq)]
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
