//! Terrain types and how their textures merge.

use crate::primitive::{Argb, LegacyString};

/// Terrain types and textures.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TerrainDesc {
    /// Terrain types; a landblock's terrain word names one by position.
    pub terrain_types: Vec<TerrainType>,
    /// How textures merge.
    pub tex_merge: TexMerge,
}

/// One type of terrain.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TerrainType {
    /// Name.
    pub name: LegacyString,
    /// Colour on maps.
    pub color: Argb,
    /// For each scene index, a position in `SceneDesc::scene_types`, -1 none.
    pub scene_types: Vec<i32>,
}

/// How terrain textures merge.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TexMerge {
    /// Side of a merged texture, pixels.
    pub base_tex_size: u32,
    /// Blend maps with one corner.
    pub corner_maps: Vec<TerrainAlphaMap>,
    /// Blend maps with one side.
    pub side_maps: Vec<TerrainAlphaMap>,
    /// Blend maps of roads.
    pub road_maps: Vec<RoadMap>,
    /// Textures by terrain type.
    pub textures: Vec<TerrainTexture>,
}

/// A blend map between terrains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TerrainAlphaMap {
    /// Which corners are the other terrain's.
    pub tcode: u32,
    /// SurfaceTexture (0x05...).
    pub texture: u32,
}

/// A blend map of roads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RoadMap {
    /// Which corners are road.
    pub rcode: u32,
    /// SurfaceTexture (0x05...).
    pub texture: u32,
}

/// The texture of a terrain type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TerrainTexture {
    /// The terrain type.
    pub terrain_type: u32,
    /// SurfaceTexture (0x05...).
    pub texture: u32,
    /// Repeats per cell.
    pub tex_tiling: u32,
    /// Brightest.
    pub max_bright: u32,
    /// Darkest.
    pub min_bright: u32,
    /// Most saturated.
    pub max_saturate: u32,
    /// Least saturated.
    pub min_saturate: u32,
    /// Highest hue.
    pub max_hue: u32,
    /// Lowest hue.
    pub min_hue: u32,
    /// Repeats of the detail texture.
    pub detail_tiling: u32,
    /// Detail SurfaceTexture (0x05...).
    pub detail_texture: u32,
}
