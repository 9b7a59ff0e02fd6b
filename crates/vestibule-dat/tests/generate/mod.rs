//! Makes records out of entropy, so that property tests can vary and shrink them.

use glam::{Quat, Vec2, Vec3};
use vestibule_dat::IterationRecord;
use vestibule_dat::primitive::{
    Argb, Bool32, CompressedForm, CylSphere, Frame, LegacyString, PackedHashTable, Plane, Sphere,
};
use vestibule_dat::record::region::*;
use vestibule_dat::record::*;

/// Random bytes, then zeros.
pub(crate) struct Entropy<'a>(pub(crate) &'a [u8]);

impl Entropy<'_> {
    fn u8(&mut self) -> u8 {
        match self.0.split_first() {
            Some((&byte, rest)) => {
                self.0 = rest;
                byte
            }
            None => 0,
        }
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes([self.u8(), self.u8()])
    }

    fn i16(&mut self) -> i16 {
        self.u16() as i16
    }

    fn u32(&mut self) -> u32 {
        u32::from(self.u16()) << 16 | u32::from(self.u16())
    }

    fn i32(&mut self) -> i32 {
        self.u32() as i32
    }

    /// Any bits at all: NaN payloads and negative zero must survive too.
    fn f32(&mut self) -> f32 {
        f32::from_bits(self.u32())
    }

    fn f64(&mut self) -> f64 {
        f64::from_bits(u64::from(self.u32()) << 32 | u64::from(self.u32()))
    }

    fn flag(&mut self) -> bool {
        self.u8() & 1 != 0
    }

    fn below(&mut self, end: u8) -> u8 {
        self.u8() % end
    }

    fn list<T>(&mut self, end: u8, mut make: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..self.below(end)).map(|_| make(self)).collect()
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.f32(), self.f32(), self.f32())
    }

    fn frame(&mut self) -> Frame {
        let origin = self.vec3();
        Frame {
            origin,
            rotation: Quat::from_xyzw(self.f32(), self.f32(), self.f32(), self.f32()),
        }
    }

    fn plane(&mut self) -> Plane {
        Plane {
            normal: self.vec3(),
            d: self.f32(),
        }
    }

    fn sphere(&mut self) -> Sphere {
        Sphere {
            center: self.vec3(),
            radius: self.f32(),
        }
    }

    fn argb(&mut self) -> Argb {
        Argb(self.u32())
    }

    fn bool32(&mut self) -> Bool32 {
        Bool32(self.u32())
    }

    fn form(&mut self) -> CompressedForm {
        [CompressedForm::One, CompressedForm::Two, CompressedForm::Four][usize::from(self.below(3))]
    }

    fn string(&mut self) -> LegacyString {
        LegacyString {
            bytes: self.list(9, Self::u8),
            long_form: self.flag(),
        }
    }

    fn stab(&mut self) -> Stab {
        Stab {
            id: self.u32(),
            frame: self.frame(),
        }
    }

    fn cell(&mut self, block: u32) -> u32 {
        block & 0xFFFF_0000 | u32::from(self.u16())
    }

    fn vertices(&mut self) -> VertexArray {
        let vertices = self.list(5, |e| Vertex {
            id: e.u16(),
            origin: e.vec3(),
            normal: e.vec3(),
            uvs: e.list(4, |e| Vec2::new(e.f32(), e.f32())),
        });
        VertexArray { vertices }
    }

    fn polygon(&mut self) -> Polygon {
        let (stippling, sides_type) = (self.u8(), i32::from(self.below(5)) - 1);
        let vertex_ids = self.list(7, Self::u16);
        let mut uv = |wanted: bool| {
            if wanted {
                vertex_ids.iter().map(|_| self.u8()).collect()
            } else {
                vec![]
            }
        };
        let pos_uv = uv(stippling & 4 == 0);
        let neg_uv = uv(sides_type == 2 && stippling & 8 == 0);
        let (id, pos_surface, neg_surface) = (self.u16(), self.i16(), self.i16());
        Polygon {
            id,
            stippling,
            sides_type,
            pos_surface,
            neg_surface,
            vertex_ids,
            pos_uv,
            neg_uv,
        }
    }

    fn tree(&mut self, kind: BspKind) -> BspTree {
        let mut nodes = Vec::new();
        self.node(kind, &mut nodes, 5);
        BspTree { kind, nodes }
    }

    fn node(&mut self, kind: BspKind, nodes: &mut Vec<BspNode>, levels: u8) -> u32 {
        const INNER: [u32; 8] = [
            BspTag::BPNN_LOWER,
            BspTag::BPIN_LOWER,
            BspTag::BP_LOWER_IN,
            BspTag::BP_LOWER_NN,
            BspTag::BPIN,
            BspTag::BPNN,
            BspTag::BPOL,
            0x4258_5858,
        ];
        let drawing = kind == BspKind::Drawing;
        let index = nodes.len();
        nodes.push(BspNode::Leaf {
            index: 0,
            physics: None,
        });
        let choice = if levels == 0 { 0 } else { self.below(10) };
        let polys = |e: &mut Self| if drawing { e.list(4, Self::u16) } else { vec![] };
        nodes[index] = match choice {
            0 => {
                let physics = (kind == BspKind::Physics).then(|| BspLeafPhysics {
                    solid: self.u32(),
                    sphere: self.sphere(),
                    polys: self.list(4, Self::u16),
                });
                BspNode::Leaf {
                    index: self.i32(),
                    physics,
                }
            }
            1 => BspNode::Portal {
                plane: self.plane(),
                pos: self.node(kind, nodes, levels - 1),
                neg: self.node(kind, nodes, levels - 1),
                sphere: drawing.then(|| self.sphere()),
                polys: polys(self),
                portal_polys: if drawing {
                    self.list(3, |e| (e.u16(), e.u16()))
                } else {
                    vec![]
                },
            },
            _ => {
                let tag = INNER[usize::from(choice - 2)];
                let (pos, neg) = BspTag::children(tag);
                BspNode::Inner {
                    tag,
                    plane: self.plane(),
                    pos: pos.then(|| self.node(kind, nodes, levels - 1)),
                    neg: neg.then(|| self.node(kind, nodes, levels - 1)),
                    sphere: (kind != BspKind::Cell).then(|| self.sphere()),
                    polys: polys(self),
                }
            }
        };
        index as u32
    }

    /// One record of any type that has a layout here.
    pub(crate) fn record(&mut self) -> Record {
        match self.below(14) {
            0 => Record::LandBlock(self.land_block()),
            1 => Record::LandBlockInfo(self.land_block_info()),
            2 => Record::EnvCell(self.env_cell()),
            3 => Record::Environment(self.environment()),
            4 => Record::GfxObj(self.gfx_obj()),
            5 => Record::Setup(self.setup()),
            6 => Record::Region(Box::new(self.region())),
            7 => Record::Surface(self.surface()),
            8 => Record::SurfaceTexture(SurfaceTexture {
                id: self.u32(),
                data_category: self.u32(),
                texture_type: self.u8(),
                textures: self.list(5, Self::u32),
            }),
            9 => Record::RenderSurface(self.render_surface()),
            10 => Record::Palette(Palette {
                id: self.u32(),
                colors: self.list(9, Self::argb),
            }),
            11 => Record::Scene(Scene {
                id: self.u32(),
                objects: self.list(4, Self::object_desc),
            }),
            12 => Record::GfxObjDegradeInfo(GfxObjDegradeInfo {
                id: self.u32(),
                degrades: self.list(4, |e| Degrade {
                    gfx_obj: e.u32(),
                    degrade_mode: e.u32(),
                    min_dist: e.f32(),
                    ideal_dist: e.f32(),
                    max_dist: e.f32(),
                }),
            }),
            _ => {
                let runs = self.list(4, |e| (e.i32(), i32::from(e.u16()) + 1));
                Record::Iteration(IterationRecord {
                    total: runs.iter().map(|run| run.1).sum(),
                    runs,
                })
            }
        }
    }

    fn land_block(&mut self) -> LandBlock {
        LandBlock {
            id: self.u32(),
            has_objects: self.bool32(),
            terrain: std::array::from_fn(|_| self.u16()),
            height: std::array::from_fn(|_| self.u8()),
        }
    }

    fn land_block_info(&mut self) -> LandBlockInfo {
        let (id, pack_mask) = (self.u32(), self.u16());
        LandBlockInfo {
            id,
            num_cells: self.u32(),
            objects: self.list(4, Self::stab),
            pack_mask,
            buildings: self.list(4, |e| Building {
                model_id: e.u32(),
                frame: e.frame(),
                num_leaves: e.u32(),
                portals: e.list(4, |e| BuildingPortal {
                    flags: e.u16(),
                    other_cell_id: e.cell(id),
                    other_portal_id: e.i16(),
                    stabs: e.list(6, |e| e.cell(id)),
                }),
            }),
            restrictions: (pack_mask & 1 != 0).then(|| PackedHashTable {
                bucket_count: self.u16(),
                entries: self.list(4, |e| (e.u32(), e.u32())),
            }),
        }
    }

    fn env_cell(&mut self) -> EnvCell {
        let (id, flags) = (self.u32(), self.u32());
        EnvCell {
            id,
            flags,
            id_again: self.u32(),
            surfaces: self.list(6, |e| e.cell(0x0800_0000)),
            environment: self.cell(0x0D00_0000),
            cell_struct: self.u16(),
            frame: self.frame(),
            portals: self.list(6, |e| CellPortal {
                flags: e.u16(),
                polygon_id: e.u16(),
                other_cell_id: e.cell(id),
                other_portal_id: e.i16(),
            }),
            stabs: self.list(9, |e| e.cell(id)),
            statics: if flags & 2 != 0 {
                self.list(4, Self::stab)
            } else {
                vec![]
            },
            restriction: (flags & 8 != 0).then(|| self.u32()),
        }
    }

    fn environment(&mut self) -> Environment {
        let id = self.u32();
        let cell_structs = self.list(3, |e| {
            let has_drawing_bsp = if e.flag() { e.bool32() } else { Bool32(0) };
            CellStruct {
                id: e.u32(),
                vertices: e.vertices(),
                polygons: e.list(4, Self::polygon),
                portals: e.list(4, Self::u16),
                cell_bsp: e.tree(BspKind::Cell),
                physics_polygons: e.list(4, Self::polygon),
                physics_bsp: e.tree(BspKind::Physics),
                has_drawing_bsp,
                drawing_bsp: has_drawing_bsp.is_true().then(|| e.tree(BspKind::Drawing)),
            }
        });
        Environment { id, cell_structs }
    }

    fn gfx_obj(&mut self) -> GfxObj {
        let flags = self.u32();
        let part = |e: &mut Self, kind| GfxObjPolygons {
            polygons: e.list(4, Self::polygon),
            form: e.form(),
            bsp: e.tree(kind),
        };
        GfxObj {
            id: self.u32(),
            flags,
            surfaces: self.list(4, Self::u32),
            surfaces_form: self.form(),
            vertices: self.vertices(),
            physics: (flags & 1 != 0).then(|| part(self, BspKind::Physics)),
            sort_center: self.vec3(),
            drawing: (flags & 2 != 0).then(|| part(self, BspKind::Drawing)),
            degrade_id: (flags & 8 != 0).then(|| self.u32()),
        }
    }

    fn setup(&mut self) -> Setup {
        let (id, flags) = (self.u32(), self.u32());
        let parts = self.list(4, Self::u32);
        let per_part = parts.len();
        let location = |e: &mut Self| Location {
            location: e.i32(),
            part: e.i32(),
            frame: e.frame(),
        };
        Setup {
            id,
            flags,
            parent_indices: (flags & 1 != 0).then(|| (0..per_part).map(|_| self.u32()).collect()),
            default_scales: (flags & 2 != 0).then(|| (0..per_part).map(|_| self.vec3()).collect()),
            parts,
            holding_locations: self.list(3, location),
            connection_points: self.list(3, location),
            placement_frames: self.list(3, |e| PlacementFrame {
                placement: e.i32(),
                frames: (0..per_part).map(|_| e.frame()).collect(),
                hooks: e.list(3, Self::hook),
            }),
            cyl_spheres: self.list(3, |e| CylSphere {
                low_point: e.vec3(),
                radius: e.f32(),
                height: e.f32(),
            }),
            spheres: self.list(3, Self::sphere),
            height: self.f32(),
            radius: self.f32(),
            step_up_height: self.f32(),
            step_down_height: self.f32(),
            sorting_sphere: self.sphere(),
            selection_sphere: self.sphere(),
            lights: self.list(3, |e| Light {
                key: e.i32(),
                frame: e.frame(),
                color: e.argb(),
                intensity: e.f32(),
                falloff: e.f32(),
                cone_angle: e.f32(),
            }),
            default_animation: self.u32(),
            default_script: self.u32(),
            default_motion_table: self.u32(),
            default_sound_table: self.u32(),
            default_script_table: self.u32(),
        }
    }

    fn hook(&mut self) -> Hook {
        const LENGTHS: [u8; 0x1A] = [
            0, 4, 4, 28, 0, 4, 4, 16, 12, 16, 12, 16, 8, 40, 4, 4, 4, 0, 4, 8, 12, 16, 12, 8, 12, 4,
        ];
        let hook_type = self.below(0x1A);
        let mut payload: Vec<u8> = (0..LENGTHS[usize::from(hook_type)]).map(|_| self.u8()).collect();
        if hook_type == 5 && payload[3] & 0x80 != 0 {
            payload.extend([self.u8(), self.u8()]);
        }
        Hook {
            hook_type: u32::from(hook_type),
            direction: self.i32(),
            payload,
        }
    }

    fn surface(&mut self) -> Surface {
        let surface_type = self.u32();
        let paint = if surface_type & 6 != 0 {
            Paint::Image {
                texture: self.u32(),
                palette: self.u32(),
            }
        } else {
            Paint::Color(self.argb())
        };
        Surface {
            surface_type,
            paint,
            translucency: self.f32(),
            luminosity: self.f32(),
            diffuse: self.f32(),
        }
    }

    fn render_surface(&mut self) -> RenderSurface {
        let format = match self.below(16) {
            choice @ 0..14 => PixelFormat::ALL[usize::from(choice)] as u32,
            _ => self.u32(),
        };
        RenderSurface {
            id: self.u32(),
            data_category: self.u32(),
            width: self.i32(),
            height: self.i32(),
            format,
            pixels: self.list(50, Self::u8),
            palette: matches!(format, 41 | 101).then(|| self.u32()),
        }
    }

    fn object_desc(&mut self) -> ObjectDesc {
        ObjectDesc {
            object_id: self.u32(),
            base_loc: self.frame(),
            frequency: self.f32(),
            displace_x: self.f32(),
            displace_y: self.f32(),
            min_scale: self.f32(),
            max_scale: self.f32(),
            max_rotation: self.f32(),
            min_slope: self.f32(),
            max_slope: self.f32(),
            align: self.u32(),
            orient: self.u32(),
            weenie_obj: self.u32(),
        }
    }

    fn region(&mut self) -> Region {
        let parts_mask = self.u32();
        let has = |bit| parts_mask & bit != 0;
        Region {
            id: self.u32(),
            region_number: self.u32(),
            version: 3,
            name: self.string(),
            land_defs: LandDefs {
                num_block_length: self.i32(),
                num_block_width: self.i32(),
                square_length: self.f32(),
                lblock_length: self.i32(),
                vertex_per_cell: self.i32(),
                max_obj_height: self.f32(),
                sky_height: self.f32(),
                road_width: self.f32(),
                land_height_table: std::array::from_fn(
                    |index| {
                        if index < 8 { self.f32() } else { index as f32 }
                    },
                ),
            },
            game_time: GameTime {
                zero_time_of_year: self.f64(),
                zero_year: self.u32(),
                day_length: self.f32(),
                days_per_year: self.u32(),
                year_spec: self.string(),
                times_of_day: self.list(3, |e| TimeOfDay {
                    start: e.f32(),
                    is_night: e.bool32(),
                    name: e.string(),
                }),
                days_of_week: self.list(3, Self::string),
                seasons: self.list(3, |e| Season {
                    start: e.u32(),
                    name: e.string(),
                }),
            },
            parts_mask,
            sky: has(0x10).then(|| self.sky()),
            sound: has(1).then(|| SoundDesc {
                tables: self.list(3, |e| AmbientSoundTable {
                    sound_table: e.u32(),
                    sounds: e.list(3, |e| AmbientSound {
                        sound: e.u32(),
                        volume: e.f32(),
                        base_chance: e.f32(),
                        min_rate: e.f32(),
                        max_rate: e.f32(),
                    }),
                }),
            }),
            scene: has(2).then(|| SceneDesc {
                scene_types: self.list(3, |e| SceneType {
                    stb_index: e.i32(),
                    scenes: e.list(3, Self::u32),
                }),
            }),
            terrain: TerrainDesc {
                terrain_types: self.list(3, |e| TerrainType {
                    name: e.string(),
                    color: e.argb(),
                    scene_types: e.list(3, Self::i32),
                }),
                tex_merge: TexMerge {
                    base_tex_size: self.u32(),
                    corner_maps: self.list(3, |e| TerrainAlphaMap {
                        tcode: e.u32(),
                        texture: e.u32(),
                    }),
                    side_maps: self.list(3, |e| TerrainAlphaMap {
                        tcode: e.u32(),
                        texture: e.u32(),
                    }),
                    road_maps: self.list(3, |e| RoadMap {
                        rcode: e.u32(),
                        texture: e.u32(),
                    }),
                    textures: self.list(3, |e| TerrainTexture {
                        terrain_type: e.u32(),
                        texture: e.u32(),
                        tex_tiling: e.u32(),
                        max_bright: e.u32(),
                        min_bright: e.u32(),
                        max_saturate: e.u32(),
                        min_saturate: e.u32(),
                        max_hue: e.u32(),
                        min_hue: e.u32(),
                        detail_tiling: e.u32(),
                        detail_texture: e.u32(),
                    }),
                },
            },
            misc: has(0x200).then(|| RegionMisc {
                version: self.u32(),
                game_map: self.u32(),
                autotest_map: self.u32(),
                autotest_map_size: self.u32(),
                clear_cell: self.u32(),
                clear_monster: self.u32(),
            }),
        }
    }

    fn sky(&mut self) -> SkyDesc {
        SkyDesc {
            tick_size: self.f64(),
            light_tick_size: self.f64(),
            day_groups: self.list(3, |e| DayGroup {
                chance: e.f32(),
                name: e.string(),
                sky_objects: e.list(3, |e| SkyObject {
                    begin_time: e.f32(),
                    end_time: e.f32(),
                    begin_angle: e.f32(),
                    end_angle: e.f32(),
                    tex_velocity_x: e.f32(),
                    tex_velocity_y: e.f32(),
                    gfx_obj: e.u32(),
                    pes: e.u32(),
                    properties: e.u32(),
                }),
                sky_times: e.list(3, |e| SkyTime {
                    begin: e.f32(),
                    dir_bright: e.f32(),
                    dir_heading: e.f32(),
                    dir_pitch: e.f32(),
                    dir_color: e.argb(),
                    amb_bright: e.f32(),
                    amb_color: e.argb(),
                    min_fog: e.f32(),
                    max_fog: e.f32(),
                    fog_color: e.argb(),
                    fog_type: e.u32(),
                    replaces: e.list(3, |e| SkyObjectReplace {
                        object_index: e.u32(),
                        gfx_obj: e.u32(),
                        rotate: e.f32(),
                        transparent: e.f32(),
                        luminosity: e.f32(),
                        max_bright: e.f32(),
                    }),
                }),
            }),
        }
    }
}
