//! Which type of record an id names (`dat-format.md` 1.2).

use std::fmt;
use std::ops::RangeInclusive;

use crate::container::{DatKind, ITERATION_ID};

macro_rules! record_kinds {
    ($($(#[$doc:meta])* $name:ident = $text:literal, $db_type:expr, $ranges:expr;)*) => {
        /// The type of a record. Nothing in a file says it: it follows from the file and the id.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize))]
        #[non_exhaustive]
        pub enum RecordKind {
            $($(#[$doc])* $name,)*
        }

        impl RecordKind {
            /// Every kind.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The type's name, in the community's words.
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// The client's number of the type, where it is known.
            pub fn db_type(self) -> Option<u8> {
                match self { $(Self::$name => $db_type,)* }
            }

            /// The ids of the type in the files other than the cell file; `None` for the cell file's types.
            pub fn id_range(self) -> Option<RangeInclusive<u32>> {
                let range: Option<(u32, u32)> = match self { $(Self::$name => $ranges,)* };
                range.map(|(first, last)| first..=last)
            }
        }

        /// First id, last id and kind, ascending.
        const RANGES: &[(Option<(u32, u32)>, RecordKind)] = &[$(($ranges, RecordKind::$name),)*];
    };
}

const fn one(id: u32) -> Option<(u32, u32)> {
    Some((id, id))
}

record_kinds! {
    /// Terrain of a landblock; cell file.
    LandBlock = "LandBlock", Some(1), None;
    /// Objects and buildings of a landblock; cell file.
    LandBlockInfo = "LandBlockInfo", Some(2), None;
    /// An indoor cell; cell file.
    EnvCell = "EnvCell", Some(3), None;
    /// A rigid model.
    GfxObj = "GfxObj", Some(6), Some((0x0100_0000, 0x0100_FFFF));
    /// An object of several parts.
    Setup = "Setup", Some(7), Some((0x0200_0000, 0x0200_FFFF));
    /// An animation.
    Animation = "Animation", Some(8), Some((0x0300_0000, 0x0300_FFFF));
    /// Colours by index.
    Palette = "Palette", Some(10), Some((0x0400_0000, 0x0400_FFFF));
    /// The sizes of a texture.
    SurfaceTexture = "SurfaceTexture", Some(11), Some((0x0500_0000, 0x05FF_FFFF));
    /// Pixels of a texture.
    RenderSurface = "RenderSurface", Some(12), Some((0x0600_0000, 0x07FF_FFFF));
    /// How a polygon is painted.
    Surface = "Surface", Some(13), Some((0x0800_0000, 0x0800_FFFF));
    /// A motion table.
    MotionTable = "MotionTable", Some(14), Some((0x0900_0000, 0x0900_FFFF));
    /// A sound.
    Wave = "Wave", Some(15), Some((0x0A00_0000, 0x0A00_FFFF));
    /// Shapes of indoor cells.
    Environment = "Environment", Some(16), Some((0x0D00_0000, 0x0D00_FFFF));
    /// Character generation.
    CharGen = "CharGen", None, one(0x0E00_0002);
    /// Vitals.
    VitalTable = "VitalTable", None, one(0x0E00_0003);
    /// Skills.
    SkillTable = "SkillTable", None, one(0x0E00_0004);
    /// Chat poses.
    ChatPoseTable = "ChatPoseTable", None, one(0x0E00_0007);
    /// Object hierarchy.
    ObjectHierarchy = "ObjectHierarchy", None, one(0x0E00_000D);
    /// Spells.
    SpellTable = "SpellTable", None, one(0x0E00_000E);
    /// Spell components.
    SpellComponentTable = "SpellComponentTable", None, one(0x0E00_000F);
    /// Experience.
    XpTable = "XpTable", None, one(0x0E00_0018);
    /// Bad data.
    BadData = "BadData", None, one(0x0E00_001A);
    /// Contracts.
    ContractTable = "ContractTable", None, one(0x0E00_001D);
    /// Words not allowed.
    TabooTable = "TabooTable", None, one(0x0E00_001E);
    /// File names to ids.
    FileToId = "FileToId", None, one(0x0E00_001F);
    /// Names not allowed.
    NameFilterTable = "NameFilterTable", None, one(0x0E00_0020);
    /// A quality filter.
    QualityFilter = "QualityFilter", None, Some((0x0E01_0000, 0x0E01_FFFF));
    /// Monitored properties.
    MonitoredProperties = "MonitoredProperties", Some(23), Some((0x0E02_0000, 0x0E02_FFFF));
    /// A set of palettes.
    PalSet = "PalSet", Some(24), Some((0x0F00_0000, 0x0F00_FFFF));
    /// A clothing table.
    ClothingTable = "ClothingTable", Some(25), Some((0x1000_0000, 0x1000_FFFF));
    /// Coarser versions of a model.
    GfxObjDegradeInfo = "GfxObjDegradeInfo", Some(26), Some((0x1100_0000, 0x1100_FFFF));
    /// Scenery.
    Scene = "Scene", Some(27), Some((0x1200_0000, 0x1200_FFFF));
    /// Settings of a landscape.
    Region = "Region", Some(28), Some((0x1300_0000, 0x1300_FFFF));
    /// A keymap.
    KeyMap = "KeyMap", Some(29), Some((0x1400_0000, 0x1400_FFFF));
    /// A render texture.
    RenderTexture = "RenderTexture", Some(30), Some((0x1500_0000, 0x15FF_FFFF));
    /// A material.
    RenderMaterial = "RenderMaterial", Some(31), Some((0x1600_0000, 0x16FF_FFFF));
    /// A modifier of a material.
    MaterialModifier = "MaterialModifier", Some(32), Some((0x1700_0000, 0x17FF_FFFF));
    /// An instance of a material.
    MaterialInstance = "MaterialInstance", Some(33), Some((0x1800_0000, 0x18FF_FFFF));
    /// A sound table.
    SoundTable = "SoundTable", Some(34), Some((0x2000_0000, 0x2000_FFFF));
    /// A layout of the user interface; local file.
    UiLayout = "UiLayout", Some(35), Some((0x2100_0000, 0x21FF_FFFF));
    /// Names of an enumeration.
    EnumMapper = "EnumMapper", Some(36), Some((0x2200_0000, 0x22FF_FFFF));
    /// Strings; local file.
    StringTable = "StringTable", Some(37), Some((0x2300_0000, 0x24FF_FFFF));
    /// Names of ids.
    DidMapper = "DidMapper", Some(38), Some((0x2500_0000, 0x25FF_FFFF));
    /// A map of actions.
    ActionMap = "ActionMap", Some(39), Some((0x2600_0000, 0x2600_FFFF));
    /// Names of ids, both ways.
    DualDidMapper = "DualDidMapper", Some(40), Some((0x2700_0000, 0x27FF_FFFF));
    /// A combat table.
    CombatTable = "CombatTable", None, Some((0x3000_0000, 0x3000_FFFF));
    /// A string of a language.
    LanguageString = "LanguageString", Some(41), Some((0x3100_0000, 0x3100_FFFF));
    /// An emitter of particles.
    ParticleEmitter = "ParticleEmitter", Some(42), Some((0x3200_0000, 0x3200_FFFF));
    /// A physics script.
    PhysicsScript = "PhysicsScript", Some(43), Some((0x3300_0000, 0x3300_FFFF));
    /// A table of physics scripts.
    PhysicsScriptTable = "PhysicsScriptTable", Some(44), Some((0x3400_0000, 0x3400_FFFF));
    /// The master of properties.
    MasterProperty = "MasterProperty", Some(45), Some((0x3900_0000, 0x39FF_FFFF));
    /// A font.
    Font = "Font", Some(46), Some((0x4000_0000, 0x4000_0FFF));
    /// A font of a language.
    LocalFont = "LocalFont", Some(47), Some((0x4000_1000, 0x40FF_FFFF));
    /// States of strings; local file.
    StringState = "StringState", Some(48), Some((0x4100_0000, 0x41FF_FFFF));
    /// Properties.
    DbProperties = "DbProperties", Some(49), Some((0x7800_0000, 0x7FFF_FFFF));
    /// Which patch iterations a file holds; every file.
    Iteration = "Iteration", None, one(ITERATION_ID);
    /// An id outside all ranges.
    Unknown = "Unknown", None, None;
}

impl RecordKind {
    /// The type of record `id` in a file of this kind (F5).
    ///
    /// ```
    /// use vestibule_dat::{DatKind, RecordKind};
    ///
    /// assert_eq!(RecordKind::of(DatKind::Cell, 0x0100_FFFF), RecordKind::LandBlock);
    /// assert_eq!(RecordKind::of(DatKind::Portal, 0x0100_FFFF), RecordKind::GfxObj);
    /// ```
    pub fn of(file: DatKind, id: u32) -> Self {
        match file {
            _ if id == ITERATION_ID => Self::Iteration,
            DatKind::Cell => Self::of_cell_id(id),
            DatKind::Portal | DatKind::Local | DatKind::HighRes => Self::of_asset_id(id),
        }
    }

    /// The type of record `id` in the cell file, by its low word (F5).
    pub fn of_cell_id(id: u32) -> Self {
        match id & 0xFFFF {
            _ if id == ITERATION_ID => Self::Iteration,
            0xFFFF => Self::LandBlock,
            0xFFFE => Self::LandBlockInfo,
            _ => Self::EnvCell,
        }
    }

    /// The type of record `id` in any file but the cell file.
    pub fn of_asset_id(id: u32) -> Self {
        let place = RANGES.partition_point(|(range, _)| range.is_none_or(|(_, last)| last < id));
        match RANGES.get(place) {
            Some(&(Some((first, last)), kind)) if (first..=last).contains(&id) => kind,
            _ => Self::Unknown,
        }
    }
}

impl fmt::Display for RecordKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f5_cell_file_goes_by_the_low_word() {
        for (id, kind) in [
            (0xA9B4_FFFF, RecordKind::LandBlock),
            (0xA9B4_FFFE, RecordKind::LandBlockInfo),
            (0xA9B4_0100, RecordKind::EnvCell),
            (0xA9B4_FFFD, RecordKind::EnvCell),
            (0x0100_0100, RecordKind::EnvCell),
            (0xFFFF_0001, RecordKind::Iteration),
            (0xFFFF_FFFF, RecordKind::LandBlock),
        ] {
            assert_eq!(RecordKind::of(DatKind::Cell, id), kind, "{id:08X}");
        }
    }

    #[test]
    fn s1_2_every_range_ends_where_the_table_says() {
        let of = |id| RecordKind::of(DatKind::Portal, id);
        for &kind in RecordKind::ALL {
            let Some(range) = kind.id_range() else { continue };
            assert_eq!(of(*range.start()), kind);
            assert_eq!(of(*range.end()), kind);
            assert_ne!(of(range.start().wrapping_sub(1)), kind, "{kind} starts too late");
            assert_ne!(of(range.end().wrapping_add(1)), kind, "{kind} ends too early");
        }
        for id in [
            0,
            0x00FF_FFFF,
            0x0101_0000,
            0x0B00_0000,
            0x0E00_0001,
            0x0E00_0005,
            0x1301_0000,
            0xFFFF_FFFF,
        ] {
            assert_eq!(of(id), RecordKind::Unknown, "{id:08X}");
        }
        assert_eq!(
            RecordKind::of(DatKind::HighRes, 0x0600_127D),
            RecordKind::RenderSurface
        );
        assert_eq!(
            RecordKind::of(DatKind::Local, 0x2300_0000),
            RecordKind::StringTable
        );
        assert_eq!(of(0xFFFF_0001), RecordKind::Iteration);
    }

    #[test]
    fn s1_2_ranges_ascend_so_that_they_can_be_searched() {
        let ranges: Vec<_> = RANGES.iter().filter_map(|entry| entry.0).collect();
        assert!(ranges.is_sorted_by(|a, b| a.1 < b.0));
    }
}
