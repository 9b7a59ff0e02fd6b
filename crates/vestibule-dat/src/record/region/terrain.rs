//! Terrain types and how their textures merge.

use crate::primitive::{Argb, LegacyString, Reader, Writer};
use crate::record::{RecordError, RecordErrorKind};

/// Terrain types and textures.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TerrainDesc {
    /// Terrain types; a landblock's terrain word names one by position.
    pub terrain_types: Vec<TerrainType>,
    /// How textures merge.
    pub tex_merge: TexMerge,
}

/// One type of terrain.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TerrainAlphaMap {
    /// Which corners are the other terrain's.
    pub tcode: u32,
    /// SurfaceTexture (0x05...).
    pub texture: u32,
}

/// A blend map of roads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RoadMap {
    /// Which corners are road.
    pub rcode: u32,
    /// SurfaceTexture (0x05...).
    pub texture: u32,
}

/// The texture of a terrain type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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

/// The kind of LandSurf that is read: textures that merge.
const TEX_MERGE: u32 = 0;

impl TerrainDesc {
    pub(super) fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        let terrain_types = reader.list32(10, "terrain.terrain_types", |reader| {
            Ok(TerrainType {
                name: reader.legacy_string("terrain_type.name")?,
                color: reader.argb("terrain_type.color")?,
                scene_types: reader.list32(4, "terrain_type.scene_types", |reader| {
                    reader.i32("terrain_type.scene_types")
                })?,
            })
        })?;
        let start = reader.position();
        let kind = reader.u32("land_surf.kind")?;
        if kind != TEX_MERGE {
            let kind = RecordErrorKind::BadValue {
                value: kind,
                expected: "land surface kind 0 (TexMerge)",
            };
            return Err(reader.error_at(start, "land_surf.kind", kind));
        }
        Ok(Self {
            terrain_types,
            tex_merge: TexMerge::read(reader)?,
        })
    }

    pub(super) fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.count32(self.terrain_types.len(), "terrain.terrain_types")?;
        for terrain_type in &self.terrain_types {
            writer.legacy_string(&terrain_type.name, "terrain_type.name")?;
            writer.argb(terrain_type.color);
            writer.count32(terrain_type.scene_types.len(), "terrain_type.scene_types")?;
            terrain_type
                .scene_types
                .iter()
                .for_each(|&index| writer.i32(index));
        }
        writer.u32(TEX_MERGE);
        self.tex_merge.write(writer)
    }
}

impl TexMerge {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            base_tex_size: reader.u32("tex_merge.base_tex_size")?,
            corner_maps: reader.list32(8, "tex_merge.corner_maps", TerrainAlphaMap::read)?,
            side_maps: reader.list32(8, "tex_merge.side_maps", TerrainAlphaMap::read)?,
            road_maps: reader.list32(8, "tex_merge.road_maps", |reader| {
                Ok(RoadMap {
                    rcode: reader.u32("road_map.rcode")?,
                    texture: reader.u32("road_map.texture")?,
                })
            })?,
            textures: reader.list32(44, "tex_merge.textures", TerrainTexture::read)?,
        })
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        writer.u32(self.base_tex_size);
        for (maps, field) in [
            (&self.corner_maps, "tex_merge.corner_maps"),
            (&self.side_maps, "tex_merge.side_maps"),
        ] {
            writer.count32(maps.len(), field)?;
            maps.iter().for_each(|map| writer.u32s(&[map.tcode, map.texture]));
        }
        writer.count32(self.road_maps.len(), "tex_merge.road_maps")?;
        self.road_maps
            .iter()
            .for_each(|map| writer.u32s(&[map.rcode, map.texture]));
        writer.count32(self.textures.len(), "tex_merge.textures")?;
        self.textures.iter().for_each(|texture| texture.write(writer));
        Ok(())
    }
}

impl TerrainAlphaMap {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            tcode: reader.u32("alpha_map.tcode")?,
            texture: reader.u32("alpha_map.texture")?,
        })
    }
}

impl TerrainTexture {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        Ok(Self {
            terrain_type: reader.u32("terrain_texture.terrain_type")?,
            texture: reader.u32("terrain_texture.texture")?,
            tex_tiling: reader.u32("terrain_texture.tex_tiling")?,
            max_bright: reader.u32("terrain_texture.max_bright")?,
            min_bright: reader.u32("terrain_texture.min_bright")?,
            max_saturate: reader.u32("terrain_texture.max_saturate")?,
            min_saturate: reader.u32("terrain_texture.min_saturate")?,
            max_hue: reader.u32("terrain_texture.max_hue")?,
            min_hue: reader.u32("terrain_texture.min_hue")?,
            detail_tiling: reader.u32("terrain_texture.detail_tiling")?,
            detail_texture: reader.u32("terrain_texture.detail_texture")?,
        })
    }

    fn write(&self, writer: &mut Writer) {
        writer.u32s(&[
            self.terrain_type,
            self.texture,
            self.tex_tiling,
            self.max_bright,
            self.min_bright,
            self.max_saturate,
            self.min_saturate,
            self.max_hue,
            self.min_hue,
            self.detail_tiling,
            self.detail_texture,
        ]);
    }
}
