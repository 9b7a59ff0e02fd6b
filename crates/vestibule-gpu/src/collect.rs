//! From a walk over a frame's commands to what the GPU is told. Opaque things between two barriers (a punch, a seal, a
//! flush of see-through things, a clear of depth) may be drawn in any order; see-through things wait for the flushes
//! (`rendering.md` 9.3, 9.4, 14.7).

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec4};
use vestibule_render::{
    Blend, Canvas, DrawList, EyeFrame, LightDetail, Mesh, Owner, PUNCH_DEPTH, Piece, PixelKind, Placed,
    PortalDepth, RenderSettings, Scene, SkyThing,
};
use vestibule_view::Camera;
use vestibule_world::{BlockId, CellId};

use crate::ground::{Ground, list_cells};
use crate::items::{Draw, FrameStats, Item, Items};
use crate::mesh_light::MeshLight;
use crate::meshes::{Batch, Meshes};
use crate::pipelines::{Key, Kind, Pipelines, blend_key};
use crate::textures::Textures;
use crate::uniforms::{BY_POLYGON, Instance, LightKind};

/// Where assets are kept on the GPU.
pub(crate) struct Store<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) queue: &'a wgpu::Queue,
    pub(crate) meshes: &'a mut Meshes,
    pub(crate) textures: &'a mut Textures,
    pub(crate) ground: &'a mut Ground,
    pub(crate) pipelines: &'a mut Pipelines,
    pub(crate) stamp: u64,
}

pub(crate) struct Collector<'a> {
    scene: &'a Scene<'a>,
    settings: &'a RenderSettings,
    items: &'a mut Items,
    store: Store<'a>,
    pub(crate) stats: FrameStats,
    eye: EyeFrame,
    camera: &'a Camera,
    ids: bool,
    /// Only what lies behind the exits is drawn: the landscape seen from a room.
    behind_exits: bool,
    screen: Screen,
    planes: Vec<Vec4>,
    /// The last landblock with its stride: its place in the ground, and its cells with their base texture only. The
    /// cells of a landblock come together.
    last_land: Option<((BlockId, u8), usize, u64)>,
}

impl<'a> Collector<'a> {
    pub(crate) fn new(
        scene: &'a Scene<'a>,
        settings: &'a RenderSettings,
        camera: &'a Camera,
        items: &'a mut Items,
        store: Store<'a>,
        ids: bool,
    ) -> Self {
        items.clear();
        Collector {
            scene,
            settings,
            items,
            store,
            stats: FrameStats::default(),
            eye: EyeFrame::new(camera),
            camera,
            ids,
            behind_exits: false,
            screen: Screen::new(camera),
            planes: Vec::new(),
            last_land: None,
        }
    }

    fn pipeline(&mut self, key: Key) -> u32 {
        self.store.pipelines.prepare(self.store.device, key)
    }

    /// Draws what may be drawn in any order: before anything that must come later.
    fn barrier(&mut self) {
        self.items.draw_opaque(&mut self.stats);
        self.finish_ground();
    }

    fn finish_ground(&mut self) {
        if self.items.ground.is_empty() {
            return;
        }
        self.items.ground.sort_unstable();
        for plain in [true, false] {
            let out = &mut self.items.ground_indices.indices;
            let first = out.len() as u32;
            for &(slot, base, painted) in &self.items.ground {
                list_cells(slot, if plain { base } else { painted }, out);
            }
            let count = out.len() as u32 - first;
            if count == 0 {
                continue;
            }
            self.stats.draws += 1;
            self.stats.triangles += count / 3;
            let pipeline = self.pipeline(Key {
                cut: self.behind_exits,
                ids: self.ids,
                cull: if self.settings.cull_terrain { 0 } else { 2 },
                ..Key::opaque(Kind::Terrain { plain })
            });
            self.items.list.push(Item::Ground {
                pipeline,
                indices: (first, count),
            });
        }
        self.items.ground.clear();
        self.items.ground_slots.clear();
        self.last_land = None;
    }

    /// Land cells, one bit each, of a block.
    fn land(&mut self, block: BlockId, stride: u8, cells: u64) -> bool {
        let Some((at, plain)) = self.land_slot(block, stride) else {
            return false;
        };
        if let Some((_, base, painted)) = self.items.ground.get_mut(at) {
            *base |= cells & plain;
            *painted |= cells & !plain;
        }
        true
    }

    /// The place of a landblock in the ground, and which of its cells have their base texture only.
    fn land_slot(&mut self, block: BlockId, stride: u8) -> Option<(usize, u64)> {
        if let Some((last, at, plain)) = self.last_land
            && last == (block, stride)
        {
            return Some((at, plain));
        }
        let (eye, offset) = (&self.eye, self.settings.terrain_offset);
        let place = || {
            let low = DVec3::new(0.0, 0.0, -f64::from(offset));
            eye.turn(low - eye.eye_in(block)).as_vec3()
        };
        let store = &mut self.store;
        let (slot, plain) = store.ground.get(
            (store.device, store.queue),
            (self.scene.world, self.scene.assets),
            (block, stride),
            store.stamp,
            place,
        )?;
        let ground = &mut self.items.ground;
        let at = *self.items.ground_slots.entry(slot).or_insert_with(|| {
            ground.push((slot, 0, 0));
            ground.len() as u32 - 1
        });
        self.last_land = Some(((block, stride), at as usize, plain));
        Some((at as usize, plain))
    }

    /// Adds a polygon as triangles; `value` is the depth to write, below zero for its own. Returns which points.
    fn fan(&mut self, points: &[DVec3], value: f32) -> (u32, u32) {
        let first = self.items.points.len() as u32;
        if let [start, rest @ ..] = points {
            for pair in rest.windows(2) {
                for p in [*start, pair[0], pair[1]] {
                    self.items.points.push(p.as_vec3().extend(value).to_array());
                }
            }
        }
        (first, self.items.points.len() as u32 - first)
    }
}

/// The part of the screen that a camera shows, in camera axes.
#[derive(Clone, Copy, Debug)]
struct Screen {
    slopes: DVec2,
    /// Lengths of the normals of the planes through its sides.
    lengths: DVec2,
}

impl Screen {
    fn new(camera: &Camera) -> Self {
        let slopes = camera.slopes().as_dvec2();
        Screen {
            slopes,
            lengths: DVec2::new(
                (1.0 + slopes.x * slopes.x).sqrt(),
                (1.0 + slopes.y * slopes.y).sqrt(),
            ),
        }
    }

    /// Whether any of a sphere in camera axes can be on it.
    fn shows(&self, center: DVec3, radius: f64) -> bool {
        let (slopes, lengths) = (self.slopes, self.lengths);
        center.y >= -radius
            && slopes.x * center.y - center.x.abs() >= -radius * lengths.x
            && slopes.y * center.y - center.z.abs() >= -radius * lengths.y
    }
}

/// A placed mesh for shaders, but for its opacity.
fn instance(placed: &Placed, light: &MeshLight, owner: Option<Owner>) -> Instance {
    let id = owner.map_or([0; 2], |owner| {
        let code = match owner.kind {
            PixelKind::Building => 2,
            PixelKind::Room => 3,
            _ => 4u32,
        };
        [owner.cell.0, code << 28 | owner.item.unwrap_or(0) & 0x0FFF_FFFF]
    });
    let by_polygon = owner.is_some_and(|o| o.item.is_none());
    let flags = light.kind as u32 | if by_polygon { BY_POLYGON } else { 0 };
    Instance {
        rows: placed.rows(),
        fade: [light.own, 1.0],
        how: [
            flags | light.count << 8 | u32::from(light.planes.count) << 24,
            u32::from(light.lamps.first) | u32::from(light.planes.first) << 16,
            light.near[0],
            light.near[1],
        ],
        id,
    }
}

fn draw(pipeline: u32, batch: &Batch, light: &MeshLight, mut instance: Instance, opacity: f32) -> Draw {
    let listed = light.count > 0 || light.planes.count > 0;
    instance.fade[1] = opacity;
    Draw {
        pipeline,
        array: batch.way.array,
        window: listed.then_some(light.lamps.window),
        indices: (batch.first, batch.count),
        instance,
    }
}

impl Canvas for Collector<'_> {
    fn sky(&mut self, bounds: [u32; 4]) {
        self.barrier();
        let pipeline = self.pipeline(Key {
            test: false,
            write: false,
            cull: 2,
            ids: self.ids,
            ..Key::opaque(Kind::Sky)
        });
        self.stats.draws += 1;
        self.items.list.push(Item::Sky { pipeline, bounds });
    }

    fn sky_thing(&mut self, mesh: &Arc<Mesh>, placed: &Placed, thing: &SkyThing) {
        if self.ids {
            return;
        }
        self.barrier();
        let light = MeshLight {
            own: thing.luminosity,
            ..MeshLight::plain(LightKind::Own)
        };
        let instance = instance(placed, &light, None);
        let store = &mut self.store;
        let from = (store.device, store.queue);
        for batch in store.meshes.get(from, store.textures, mesh, store.stamp) {
            let way = &batch.way;
            let key = Key {
                blend: blend_key(way.blend),
                test: false,
                write: false,
                wrap: way.wrap,
                ..Key::opaque(Kind::Mesh { pixel_lit: false })
            };
            let opacity = way.opacity * (1.0 - thing.translucency);
            let pipeline = store.pipelines.prepare(store.device, key);
            let draw = draw(pipeline, batch, &light, instance, opacity);
            self.items.mesh(&draw, &mut self.stats);
        }
    }

    fn land_cell(&mut self, cell: CellId) -> bool {
        let index = u32::from(cell.low()).wrapping_sub(1);
        index < 64 && self.land(cell.block(), 0, 1 << index)
    }

    fn land_block(&mut self, block: BlockId, stride: u8) -> bool {
        self.land(block, stride, u64::MAX)
    }

    fn behind_exit(&mut self, points: &[DVec3]) {
        self.fan(points, -1.0);
        let count = self.items.points.len() as u32;
        self.items.limits = (0, count);
        self.behind_exits = count > 0;
    }

    fn portal(&mut self, points: &[DVec3], depth: PortalDepth) {
        let value = match depth {
            PortalDepth::Punch => PUNCH_DEPTH,
            PortalDepth::Own => -1.0,
            PortalDepth::Nearest => 1.0,
        };
        let points = self.fan(points, value);
        if points.1 == 0 {
            return;
        }
        self.barrier();
        self.stats.portals += 1;
        // Punches, or seals, after each other are one draw: their depths do not depend on what is there.
        if let Some(Item::Depth { points: last, .. }) = self.items.list.last_mut() {
            last.1 += points.1;
            return;
        }
        let pipeline = self.pipeline(Key {
            test: false,
            cull: 2,
            ids: self.ids,
            ..Key::opaque(Kind::Depth)
        });
        self.stats.draws += 1;
        self.items.list.push(Item::Depth { pipeline, points });
    }

    fn piece(&mut self, piece: &Piece<'_>) {
        let (mesh, placed) = (piece.mesh, piece.placed);
        let middle = placed.point(mesh.sphere.center);
        let radius = f64::from(mesh.sphere.radius) * placed.reach() + 0.01;
        if !self.screen.shows(middle, radius) {
            return;
        }
        let light = MeshLight::of(piece, self.camera, &mut self.items.lists, &mut self.planes);
        let lit = matches!(light.kind, LightKind::Shell | LightKind::Indoor);
        let pixel_lit = lit && self.settings.light == LightDetail::PerPixel && !self.ids;
        let opaque = Key {
            cull: u8::from(placed.mirrors()),
            cut: !piece.edges.is_empty() || self.behind_exits,
            ids: self.ids,
            ..Key::opaque(Kind::Mesh { pixel_lit })
        };
        let instance = instance(placed, &light, Some(piece.owner));
        let faded = piece.opacity < 1.0;
        let store = &mut self.store;
        let from = (store.device, store.queue);
        for batch in store.meshes.get(from, store.textures, mesh, store.stamp) {
            let way = &batch.way;
            let wrap = way.wrap;
            if way.list == DrawList::Now && !faded {
                let pipeline = store.pipelines.prepare(store.device, Key { wrap, ..opaque });
                self.items
                    .add_opaque(draw(pipeline, batch, &light, instance, 1.0));
                continue;
            }
            let cut_out = way.list == DrawList::CutOut && !faded;
            if self.ids && !cut_out {
                continue;
            }
            let blend = match (self.ids, faded && way.list == DrawList::Now) {
                (true, _) => Blend::OPAQUE,
                (_, true) => Blend::ALPHA,
                _ => way.blend,
            };
            let key = Key {
                kind: Kind::Mesh { pixel_lit: false },
                blend: blend_key(blend),
                write: way.writes_depth && !faded,
                wrap,
                ..opaque
            };
            let pipeline = store.pipelines.prepare(store.device, key);
            let opacity = way.opacity * piece.opacity;
            let draw = draw(pipeline, batch, &light, instance, opacity);
            self.items.add_deferred(draw, (!cut_out).then(|| middle.length()));
        }
    }

    fn flush(&mut self) {
        if self.items.has_deferred() {
            self.barrier();
            self.items.draw_deferred(&mut self.stats);
        }
    }

    fn clear_depth(&mut self) {
        self.barrier();
        self.items.list.push(Item::ClearDepth);
        self.behind_exits = false;
    }
}

impl Collector<'_> {
    /// Draws what is left.
    pub(crate) fn finish(&mut self) {
        self.barrier();
    }

    /// Whether exits keep the landscape behind them, whose pipeline is then there.
    pub(crate) fn prepare_limits(&mut self) {
        if self.items.limits.1 > 0 {
            self.store.pipelines.prepare(self.store.device, Key::limit());
        }
    }
}
