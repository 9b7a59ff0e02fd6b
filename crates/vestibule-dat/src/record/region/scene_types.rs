//! Ambient sounds and scenery by kind of terrain.

/// Ambient sounds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SoundDesc {
    /// Sets of sounds; a scene type names one by position.
    pub tables: Vec<AmbientSoundTable>,
}

/// One set of ambient sounds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AmbientSoundTable {
    /// SoundTable.
    pub sound_table: u32,
    /// Its sounds.
    pub sounds: Vec<AmbientSound>,
}

/// An ambient sound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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
pub struct SceneDesc {
    /// Scene types; a terrain type names them by position.
    pub scene_types: Vec<SceneType>,
}

/// One kind of scenery.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SceneType {
    /// Position in `SoundDesc::tables`, -1 none.
    pub stb_index: i32,
    /// Scenes (0x12...).
    pub scenes: Vec<u32>,
}
