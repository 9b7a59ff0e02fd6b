//! Ambient sounds and scenery by kind of terrain.

use crate::primitive::{Reader, Writer};
use crate::record::RecordError;

/// Ambient sounds.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SoundDesc {
    /// Sets of sounds; a scene type names one by position.
    pub tables: Vec<AmbientSoundTable>,
}

/// One set of ambient sounds.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AmbientSoundTable {
    /// SoundTable.
    pub sound_table: u32,
    /// Its sounds.
    pub sounds: Vec<AmbientSound>,
}

/// An ambient sound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AmbientSound {
    /// Which sound of the table.
    pub sound: u32,
    /// Loudness, 0 to 1.
    pub volume: f32,
    /// How likely.
    pub base_chance: f32,
    /// Least seconds between two.
    pub min_rate: f32,
    /// Most seconds between two.
    pub max_rate: f32,
}

/// Scenery by kind of terrain.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SceneDesc {
    /// Scene types; a terrain type names them by position.
    pub scene_types: Vec<SceneType>,
}

/// One kind of scenery.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SceneType {
    /// Position in `SoundDesc::tables`, -1 none.
    pub stb_index: i32,
    /// Scenes (0x12...).
    pub scenes: Vec<u32>,
}

impl SoundDesc {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let tables = reader.list32(8, "sound.tables", |reader| {
            Ok(AmbientSoundTable {
                sound_table: reader.u32("sound_table.sound_table")?,
                sounds: reader.list32(20, "sound_table.sounds", AmbientSound::read)?,
            })
        })?;
        Ok(Self { tables })
    }

    pub(super) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.count32(self.tables.len(), "sound.tables")?;
        for table in &self.tables {
            writer.u32(table.sound_table);
            writer.count32(table.sounds.len(), "sound_table.sounds")?;
            for sound in &table.sounds {
                writer.u32(sound.sound);
                writer.f32s(&[sound.volume, sound.base_chance, sound.min_rate, sound.max_rate]);
            }
        }
        Ok(())
    }
}

impl AmbientSound {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            sound: reader.u32("sound.sound")?,
            volume: reader.f32("sound.volume")?,
            base_chance: reader.f32("sound.base_chance")?,
            min_rate: reader.f32("sound.min_rate")?,
            max_rate: reader.f32("sound.max_rate")?,
        })
    }
}

impl SceneDesc {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let scene_types = reader.list32(8, "scene.scene_types", |reader| {
            let stb_index = reader.i32("scene_type.stb_index")?;
            let count = reader.count32(4, "scene_type.scenes")?;
            Ok(SceneType {
                stb_index,
                scenes: reader.u32s(count, "scene_type.scenes")?,
            })
        })?;
        Ok(Self { scene_types })
    }

    pub(super) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.count32(self.scene_types.len(), "scene.scene_types")?;
        for scene_type in &self.scene_types {
            writer.i32(scene_type.stb_index);
            writer.count32(scene_type.scenes.len(), "scene_type.scenes")?;
            writer.u32s(&scene_type.scenes);
        }
        Ok(())
    }
}
