//! From a walk over a frame's commands to what the GPU is told. Opaque things between two barriers (a punch, a seal, a
//! flush of see-through things, a clear of depth) are put in an order that changes little state; see-through things are put
//! aside and drawn at the flushes (`rendering.md` 9.3, 9.4, 14.7).

use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{DVec3, Vec4};
use vestibule_render::{
    Blend, Canvas, DrawList, EyeFrame, LightDetail, Mesh, NumberMap, Owner, PUNCH_DEPTH, Piece, PieceLight,
    PixelKind, Placed, PortalDepth, RenderSettings, Scene, SkyThing,
};
use vestibule_view::Camera;
use vestibule_world::{BlockId, CellId};

use crate::ground::{Ground, list_cells};
use crate::meshes::{Batch, Meshes};
use crate::pipelines::{Key, Kind, Pipelines, blend_key};
use crate::textures::{Slot, Textures};
use crate::uniforms::{
    ALPHA, BY_POLYGON, FOGGED, FrameUniform, IndexStream, Instance, LightKind, Lists, Part, Sent, Stream,
};

/// One thing the GPU is told to do.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Item {
    /// Instances of triangles of one material.
    Mesh {
        pipeline: u32,
        array: u16,
        /// Of the lists; `None` when it does not matter.
        window: Option<u16>,
        indices: (u32, u32),
        instances: (u32, u32),
    },
    /// Indices of the ground.
    Ground {
        pipeline: u32,
        indices: (u32, u32),
    },
    /// Columns and rows: from, to, from, to.
    Sky {
        pipeline: u32,
        bounds: [u32; 4],
    },
    /// Corners of a punch or a seal.
    Depth {
        pipeline: u32,
        points: (u32, u32),
    },
    ClearDepth,
}

/// A mesh's triangles of one material, not yet in order.
#[derive(Clone, Copy, Debug)]
struct Draw {
    pipeline: u32,
    texture: Slot,
    window: Option<u16>,
    indices: (u32, u32),
    instance: Instance,
}

impl Draw {
    /// What must be equal for two draws to be one, those first that cost the most to change.
    fn order(&self) -> (u32, u16, Option<u16>, u32) {
        (self.pipeline, self.texture.array, self.window, self.indices.0)
    }
}

#[derive(Clone, Copy, Debug)]
struct Deferred {
    cut_out: bool,
    distance: f64,
    draw: Draw,
}

/// The things of a frame in order, and what is sent with them. Kept from frame to frame for its memory.
#[derive(Debug)]
pub(crate) struct Items {
    pub(crate) list: Vec<Item>,
    pub(crate) stream: Stream,
    pub(crate) ground_indices: IndexStream,
    /// The exits that the landscape is kept behind, in the points.
    pub(crate) limits: (u32, u32),
    instances: Vec<Instance>,
    points: Vec<[f32; 4]>,
    lists: Lists,
    opaque: Vec<Draw>,
    order: Vec<((u32, u16, Option<u16>, u32), u32)>,
    deferred: Vec<Deferred>,
    /// Land cells in view by slot: those with their base texture only, and the others.
    ground: Vec<(u32, u64, u64)>,
    ground_slots: NumberMap<u32, u32>,
}

/// What a frame was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameStats {
    /// Draw calls.
    pub draws: u32,
    /// Triangles, behind or outside the screen included.
    pub triangles: u32,
    /// Things a command names that the world or the assets do not have.
    pub missing: u32,
    /// Rooms confined to their regions because they overlap another.
    pub confined: u32,
    /// Punches and seals.
    pub portals: u32,
}

impl Items {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Items {
            list: Vec::new(),
            stream: Stream::new(device),
            ground_indices: IndexStream::new(device),
            limits: (0, 0),
            instances: Vec::new(),
            points: Vec::new(),
            lists: Lists::default(),
            opaque: Vec::new(),
            order: Vec::new(),
            deferred: Vec::new(),
            ground: Vec::new(),
            ground_slots: NumberMap::default(),
        }
    }

    fn clear(&mut self) {
        self.list.clear();
        self.ground_indices.indices.clear();
        self.limits = (0, 0);
        self.instances.clear();
        self.points.clear();
        self.lists.clear();
        self.opaque.clear();
        self.deferred.clear();
        self.ground.clear();
        self.ground_slots.clear();
    }

    /// Sends everything. Returns whether the buffer is another one now.
    pub(crate) fn send(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        frame: &FrameUniform,
        lands: &[[f32; 4]],
    ) -> bool {
        self.ground_indices.send(device, queue);
        let sent = Sent {
            frame,
            lists: &self.lists,
            instances: &self.instances,
            points: &self.points,
            lands,
        };
        self.stream.send(device, queue, &sent)
    }

    /// Draws instances of triangles; those of the same as before, with it.
    fn mesh(&mut self, draw: &Draw, stats: &mut FrameStats) {
        let at = self.instances.len() as u32;
        self.instances.push(draw.instance);
        stats.triangles += draw.indices.1 / 3;
        if let Some(Item::Mesh {
            pipeline,
            array,
            window,
            indices,
            instances,
        }) = self.list.last_mut()
            && (*pipeline, *array, *window) == (draw.pipeline, draw.texture.array, draw.window)
            && *indices == draw.indices
        {
            instances.1 = at + 1;
            return;
        }
        stats.draws += 1;
        self.list.push(Item::Mesh {
            pipeline: draw.pipeline,
            array: draw.texture.array,
            window: draw.window,
            indices: draw.indices,
            instances: (at, at + 1),
        });
    }
}

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
    planes: Vec<Vec4>,
    /// The last key and its pipeline.
    last: Option<(Key, u32)>,
    /// The last landblock with its stride: its place in the ground, and its cells with their base texture only. The
    /// cells of a landblock come together.
    last_land: Option<((BlockId, u8), usize, u64)>,
}

/// The light on a mesh.
#[derive(Clone, Copy, Debug)]
struct MeshLight {
    kind: LightKind,
    lamps: Part,
    planes: Part,
    count: u32,
    near: [u32; 2],
    /// Of its own, in place of the material's.
    own: Option<f32>,
}

impl MeshLight {
    fn plain(kind: LightKind) -> Self {
        MeshLight {
            kind,
            lamps: Part::default(),
            planes: Part::default(),
            count: 0,
            near: [0; 2],
            own: None,
        }
    }
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
            planes: Vec::new(),
            last: None,
            last_land: None,
        }
    }

    fn pipeline(&mut self, key: Key) -> u32 {
        if let Some((last, code)) = self.last
            && last == key
        {
            return code;
        }
        let code = self.store.pipelines.prepare(self.store.device, key);
        self.last = Some((key, code));
        code
    }

    /// Draws what may be drawn in any order: before anything that must come later.
    fn barrier(&mut self) {
        let items = &mut *self.items;
        let (opaque, mut order) = (
            core::mem::take(&mut items.opaque),
            core::mem::take(&mut items.order),
        );
        order.clear();
        order.extend(opaque.iter().zip(0..).map(|(d, k)| (d.order(), k)));
        order.sort_unstable();
        for &(_, k) in &order {
            items.mesh(&opaque[k as usize], &mut self.stats);
        }
        (items.opaque, items.order) = (opaque, order);
        items.opaque.clear();
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

    fn batches(&mut self, mesh: &Arc<Mesh>) -> Arc<[Batch]> {
        let store = &mut self.store;
        let from = (store.device, store.queue);
        store.meshes.get(from, store.textures, mesh, store.stamp)
    }

    fn draw(
        &mut self,
        key: Key,
        batch: &Batch,
        placed: &[[f32; 4]; 3],
        opacity: f32,
        light: &MeshLight,
        owner: Option<Owner>,
    ) -> Draw {
        let material = &batch.material;
        let mut flags = light.kind as u32;
        if material.fogged && light.kind != LightKind::Own {
            flags |= FOGGED;
        }
        if material.list != DrawList::Now || light.kind == LightKind::Own {
            flags |= ALPHA;
        }
        let mut instance = Instance {
            rows: *placed,
            material: [
                light.own.unwrap_or(material.luminosity),
                material.diffuse,
                material
                    .alpha_test
                    .map_or(0.0, |limit| (f32::from(limit) - 0.25) / 255.0),
                opacity,
            ],
            ..Instance::zeroed()
        };
        if let Some(owner) = owner {
            let code = match owner.kind {
                PixelKind::Building => 2,
                PixelKind::Room => 3,
                _ => 4u32,
            };
            instance.id = [owner.cell.0, code << 28 | owner.item.unwrap_or(0) & 0x0FFF_FFFF];
            if owner.item.is_none() {
                flags |= BY_POLYGON;
            }
        }
        let layer = u32::from(batch.texture.layer);
        instance.how = [
            flags | light.count << 8 | layer << 16 | u32::from(light.planes.count) << 24,
            u32::from(light.lamps.first) | u32::from(light.planes.first) << 16,
            light.near[0],
            light.near[1],
        ];
        let listed = light.count > 0 || light.planes.count > 0;
        Draw {
            pipeline: self.pipeline(Key {
                wrap: batch.wrap,
                ..key
            }),
            texture: batch.texture,
            window: listed.then_some(light.lamps.window),
            indices: (batch.first, batch.count),
            instance,
        }
    }

    /// Whether any of a sphere in camera axes can be on the screen.
    fn on_screen(&self, center: DVec3, radius: f64) -> bool {
        let slopes = self.camera.slopes().as_dvec2();
        let (lx, ly) = (
            (1.0 + slopes.x * slopes.x).sqrt(),
            (1.0 + slopes.y * slopes.y).sqrt(),
        );
        center.y >= -radius
            && slopes.x * center.y - center.x.abs() >= -radius * lx
            && slopes.y * center.y - center.z.abs() >= -radius * ly
    }

    fn light(&mut self, piece: &Piece<'_>) -> MeshLight {
        let (slopes, size) = (self.camera.slopes(), self.camera.viewport());
        self.planes.clear();
        self.planes.extend(piece.edges.iter().map(|n| {
            let n = n.as_vec3();
            // A hundredth of a pixel more, as the reference has it.
            let across = (n.x * 2.0 * slopes.x / size.x).abs() + (n.z * 2.0 * slopes.y / size.y).abs();
            n.extend(across * (2.0 / 256.0))
        }));
        let lists = &mut self.items.lists;
        match piece.light {
            PieceLight::Sun => MeshLight {
                planes: lists.add(CellId(0), &[], &self.planes).1,
                ..MeshLight::plain(LightKind::Sun)
            },
            PieceLight::Shell { cell, lamps } => {
                let (lamps, planes) = lists.add(cell, lamps, &self.planes);
                MeshLight {
                    lamps,
                    planes,
                    count: u32::from(lamps.count),
                    ..MeshLight::plain(LightKind::Shell)
                }
            }
            PieceLight::Indoor { cell, lamps, near } => {
                let (lamps, planes) = lists.add(cell, lamps, &self.planes);
                let mut light = MeshLight {
                    lamps,
                    planes,
                    count: near.len() as u32,
                    ..MeshLight::plain(LightKind::Indoor)
                };
                for (k, &lamp) in near.iter().enumerate() {
                    light.near[(k / 4) & 1] |= u32::from(lamp) << (8 * (k % 4));
                }
                light
            }
        }
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
            own: Some(thing.luminosity),
            ..MeshLight::plain(LightKind::Own)
        };
        let rows = placed.rows();
        for batch in self.batches(mesh).iter() {
            let key = Key {
                blend: blend_key(batch.material.blend),
                test: false,
                write: false,
                ..Key::opaque(Kind::Mesh { pixel_lit: false })
            };
            let opacity = batch.material.opacity * (1.0 - thing.translucency);
            let draw = self.draw(key, batch, &rows, opacity, &light, None);
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
        if !self.on_screen(middle, f64::from(mesh.sphere.radius) * placed.reach() + 0.01) {
            return;
        }
        let batches = self.batches(mesh);
        let light = self.light(piece);
        let lit = matches!(light.kind, LightKind::Shell | LightKind::Indoor);
        let pixel_lit = lit && self.settings.light == LightDetail::PerPixel && !self.ids;
        let opaque = Key {
            cull: u8::from(placed.mirrors()),
            cut: !piece.edges.is_empty() || self.behind_exits,
            ids: self.ids,
            ..Key::opaque(Kind::Mesh { pixel_lit })
        };
        let rows = placed.rows();
        let owner = Some(piece.owner);
        let faded = piece.opacity < 1.0;
        for batch in batches.iter() {
            let material = &batch.material;
            if material.list == DrawList::Now && !faded {
                let draw = self.draw(opaque, batch, &rows, 1.0, &light, owner);
                self.items.opaque.push(draw);
                continue;
            }
            let cut_out = material.list == DrawList::CutOut && !faded;
            if self.ids && !cut_out {
                continue;
            }
            let blend = match (self.ids, faded && material.list == DrawList::Now) {
                (true, _) => Blend::OPAQUE,
                (_, true) => Blend::ALPHA,
                _ => material.blend,
            };
            let key = Key {
                kind: Kind::Mesh { pixel_lit: false },
                blend: blend_key(blend),
                write: material.writes_depth() && !faded,
                ..opaque
            };
            let opacity = material.opacity * piece.opacity;
            let draw = self.draw(key, batch, &rows, opacity, &light, owner);
            self.items.deferred.push(Deferred {
                cut_out,
                distance: middle.length(),
                draw,
            });
        }
    }

    fn flush(&mut self) {
        if self.items.deferred.is_empty() {
            return;
        }
        self.barrier();
        let mut list = core::mem::take(&mut self.items.deferred);
        list.sort_by(|a, b| match (a.cut_out, b.cut_out) {
            (true, true) => core::cmp::Ordering::Equal,
            (true, false) => core::cmp::Ordering::Less,
            (false, true) => core::cmp::Ordering::Greater,
            (false, false) => b.distance.total_cmp(&a.distance),
        });
        for d in &list {
            self.items.mesh(&d.draw, &mut self.stats);
        }
        list.clear();
        self.items.deferred = list;
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
