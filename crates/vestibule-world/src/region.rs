//! What the world needs of the Region record (`dat-format.md` 10.4).

use vestibule_dat::record;

use crate::error::WorldError;
use crate::source::{RecordSource, Store};

/// Id of the one Region record.
pub const REGION_RECORD: u32 = 0x1300_0000;

/// Land definitions of the region.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Height in metres for each of the 256 height indices (`world.md` T1).
    pub heights: Box<[f32; 256]>,
    /// Height reserved for objects over the highest ground, metres.
    pub max_object_height: f32,
    /// Width of a road, metres.
    pub road_width: f32,
    /// Scenes (0x12…) of each scene type.
    scene_types: Box<[Box<[u32]>]>,
    /// For each terrain type, the scene type of each scene index (`world.md` 21.1).
    terrain_scenes: Box<[Box<[i32]>]>,
}

impl Region {
    /// Reads the Region record.
    ///
    /// # Errors
    /// When it is missing or damaged: no terrain height would then be known.
    pub fn read(source: &dyn RecordSource) -> Result<Self, WorldError> {
        let fail = |reason: String| WorldError::Region {
            file: source.file_of(Store::Portal, REGION_RECORD),
            id: REGION_RECORD,
            reason,
        };
        let bytes = source
            .record(Store::Portal, REGION_RECORD)
            .map_err(|e| fail(e.to_string()))?;
        let bytes =
            bytes.ok_or_else(|| fail("not found; a world needs it for the height table".to_owned()))?;
        let region = record::Region::parse(REGION_RECORD, &bytes).map_err(|e| fail(e.to_string()))?;
        let defs = region.land_defs;
        Ok(Region {
            heights: Box::new(defs.land_height_table),
            max_object_height: defs.max_obj_height,
            road_width: defs.road_width,
            scene_types: region
                .scene
                .iter()
                .flat_map(|desc| &desc.scene_types)
                .map(|t| t.scenes.as_slice().into())
                .collect(),
            terrain_scenes: region
                .terrain
                .terrain_types
                .iter()
                .map(|t| t.scene_types.as_slice().into())
                .collect(),
        })
    }

    /// The scenes that terrain of this type and scene index may carry; empty for none.
    pub fn scenes(&self, terrain_type: u8, scene: u8) -> &[u32] {
        let scene_type = self
            .terrain_scenes
            .get(usize::from(terrain_type))
            .and_then(|s| s.get(usize::from(scene)));
        let index = scene_type.and_then(|&i| usize::try_from(i).ok());
        index
            .and_then(|i| self.scene_types.get(i))
            .map_or(&[], |scenes| scenes)
    }
}
