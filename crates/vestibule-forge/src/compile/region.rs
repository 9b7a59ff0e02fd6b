//! The Region record: heights, sky and terrain textures.

use vestibule_dat::primitive::{Argb, Bool32, LegacyString};
use vestibule_dat::record::region::{
    DayGroup, GameTime, LandDefs, Region, RoadMap, Season, SkyDesc, SkyTime, TerrainAlphaMap, TerrainDesc,
    TerrainTexture, TerrainType, TexMerge, TimeOfDay,
};
use vestibule_dat::record::{PixelFormat, RecordError};

use super::texture::{Painter, blend_map};
use super::world::Records;
use crate::scene::{Pattern, TERRAIN_TYPES};

/// Seed of all ground textures: patterns of walls differ from those of the ground.
const GROUND_SEED: u32 = 400;

const REGION: u32 = 0x1300_0000;

/// Pattern, colours and repeats per land cell of each terrain type; 32 is the road.
fn look(kind: u8) -> (Pattern, [u8; 3], [u8; 3], u32) {
    use Pattern::{Cobbles, Grass, Rock, Soil, Water};
    match kind {
        0 => (Rock, [128, 122, 114], [96, 90, 84], 4),
        1 => (Grass, [98, 126, 58], [120, 142, 72], 6),
        2 => (Rock, [200, 214, 226], [170, 192, 214], 4),
        3 => (Grass, [72, 118, 50], [92, 138, 62], 6),
        4 => (Soil, [92, 98, 60], [70, 78, 52], 5),
        5 => (Soil, [92, 72, 50], [74, 58, 42], 5),
        6 => (Rock, [52, 50, 56], [36, 34, 40], 4),
        7 => (Soil, [142, 116, 82], [120, 96, 68], 5),
        8 => (Soil, [124, 112, 74], [102, 108, 62], 5),
        9 => (Grass, [112, 126, 66], [134, 122, 78], 6),
        10 => (Soil, [206, 184, 132], [188, 164, 114], 5),
        11 => (Soil, [166, 162, 152], [146, 142, 134], 5),
        12 => (Soil, [170, 154, 122], [132, 120, 98], 5),
        13 => (Rock, [148, 120, 96], [116, 94, 76], 3),
        14 => (Soil, [132, 124, 96], [110, 104, 82], 5),
        15 => (Soil, [232, 236, 242], [212, 220, 232], 5),
        16 | 17 => (Water, [62, 98, 112], [84, 124, 134], 3),
        18 | 19 => (Water, [52, 104, 126], [76, 132, 148], 3),
        20 | 22 => (Water, [36, 70, 102], [52, 90, 120], 3),
        21 => (Soil, [84, 80, 48], [104, 92, 54], 5),
        23 => (Water, [82, 112, 70], [102, 128, 84], 3),
        24 => (Soil, [162, 122, 92], [140, 102, 78], 5),
        25 | 26 => (Rock, [72, 58, 54], [104, 60, 46], 3),
        27 => (Rock, [160, 196, 222], [134, 172, 206], 4),
        28 => (Grass, [86, 112, 66], [104, 126, 78], 6),
        29 => (Grass, [60, 84, 52], [76, 98, 60], 6),
        30 => (Rock, [108, 92, 78], [84, 72, 62], 4),
        32 => (Cobbles, [152, 140, 120], [104, 94, 80], 5),
        _ => (Rock, [112, 104, 96], [90, 84, 78], 4),
    }
}

/// The sky over a day: begin, sun brightness, heading, pitch and colour, ambient brightness and colour, fog colour.
type Hour = (f32, f32, f32, f32, u32, f32, u32, u32);

const DAY: [Hour; 6] = [
    (0.0, 0.12, 20.0, 40.0, 0xFF8A_98C8, 0.30, 0xFF7C_88B4, 0xFF10_1626),
    (0.24, 0.45, 85.0, 8.0, 0xFFFF_B070, 0.36, 0xFFB0_A8B8, 0xFFC8_A898),
    (
        0.34,
        1.00,
        120.0,
        32.0,
        0xFFFF_F0D8,
        0.42,
        0xFFC8_D0DC,
        0xFFB4_C8DA,
    ),
    (
        0.50,
        1.20,
        180.0,
        58.0,
        0xFFFF_FAEE,
        0.45,
        0xFFD4_DCE6,
        0xFFAC_C6E0,
    ),
    (
        0.70,
        0.90,
        250.0,
        26.0,
        0xFFFF_E4B8,
        0.42,
        0xFFC8_C4C8,
        0xFFC4_BCB4,
    ),
    (
        0.80,
        0.30,
        275.0,
        5.0,
        0xFFFF_9858,
        0.34,
        0xFF98_90A8,
        0xFF70_6078,
    ),
];

/// Adds the region and the terrain textures of the types in `kinds`.
pub(crate) fn add_region(
    records: &mut Records,
    painter: &mut Painter,
    name: &str,
    step: f64,
    kinds: &[u8],
) -> Result<(), RecordError> {
    let mut merge = TexMerge {
        base_tex_size: 256,
        ..TexMerge::default()
    };
    let mut map = |code: u32, reach: f64, seed: u32| {
        super::surface::add_image(records, PixelFormat::LscapeAlpha, blend_map(code, reach, seed))
    };
    for seed in [1, 2] {
        merge.corner_maps.push(TerrainAlphaMap {
            tcode: 1,
            texture: map(1, 0.42, seed)?,
        });
        merge.side_maps.push(TerrainAlphaMap {
            tcode: 3,
            texture: map(3, 0.42, seed + 4)?,
        });
    }
    for (rcode, reach) in [(1, 0.12), (3, 0.12), (5, 0.12)] {
        merge.road_maps.push(RoadMap {
            rcode,
            texture: map(rcode, reach, 20 + rcode)?,
        });
    }
    for &kind in kinds {
        let (pattern, color, second, tiling) = look(kind);
        let pixels = painter.texture(pattern, color, second, GROUND_SEED);
        let pixels = pixels.into_iter().flatten().collect();
        let image = super::surface::add_image(records, PixelFormat::LscapeR8G8B8, pixels)?;
        merge.textures.push(TerrainTexture {
            terrain_type: u32::from(kind),
            texture: image,
            tex_tiling: tiling,
            max_bright: 100,
            min_bright: 100,
            max_saturate: 100,
            min_saturate: 100,
            max_hue: 0,
            min_hue: 0,
            detail_tiling: 1,
            detail_texture: 0,
        });
    }
    let terrain_types = TERRAIN_TYPES.iter().map(|(name, kind)| {
        let [r, g, b] = look(*kind).1.map(u32::from);
        let color = Argb(0xFF00_0000 | r << 16 | g << 8 | b);
        TerrainType {
            name: LegacyString::from(*name),
            color,
            scene_types: Vec::new(),
        }
    });
    let sky_times = DAY.iter().map(
        |&(begin, dir_bright, heading, pitch, sun, amb_bright, ambient, fog)| SkyTime {
            begin,
            dir_bright,
            dir_heading: heading,
            dir_pitch: pitch,
            dir_color: Argb(sun),
            amb_bright,
            amb_color: Argb(ambient),
            min_fog: 150.0,
            max_fog: 900.0,
            fog_color: Argb(fog),
            fog_type: 1,
            replaces: Vec::new(),
        },
    );
    let sky = DayGroup {
        chance: 1.0,
        name: "Clear".into(),
        sky_objects: Vec::new(),
        sky_times: sky_times.collect(),
    };
    let region = Region {
        id: REGION,
        region_number: 1,
        version: Region::VERSION,
        name: name.into(),
        land_defs: LandDefs {
            num_block_length: 255,
            num_block_width: 255,
            square_length: 24.0,
            lblock_length: 8,
            vertex_per_cell: 1,
            max_obj_height: 200.0,
            sky_height: 1000.0,
            road_width: 5.0,
            land_height_table: core::array::from_fn(|k| (k as f64 * step) as f32),
        },
        game_time: game_time(),
        parts_mask: Region::HAS_SKY,
        sky: Some(SkyDesc {
            tick_size: 0.8,
            light_tick_size: 15.0,
            day_groups: vec![sky],
        }),
        sound: None,
        scene: None,
        terrain: TerrainDesc {
            terrain_types: terrain_types.collect(),
            tex_merge: merge,
        },
        misc: None,
    };
    records.portal.insert(REGION, region.encode()?);
    Ok(())
}

fn game_time() -> GameTime {
    let part = |start, night, name: &str| TimeOfDay {
        start,
        is_night: Bool32::from(night),
        name: name.into(),
    };
    GameTime {
        zero_time_of_year: 0.0,
        zero_year: 1,
        day_length: 7200.0,
        days_per_year: 360,
        year_spec: "Year".into(),
        times_of_day: vec![
            part(0.0, true, "Night"),
            part(0.25, false, "Day"),
            part(0.8, true, "Evening"),
        ],
        days_of_week: ["First", "Second", "Third", "Fourth", "Fifth", "Sixth"]
            .map(LegacyString::from)
            .to_vec(),
        seasons: vec![Season {
            start: 0,
            name: "Summer".into(),
        }],
    }
}
