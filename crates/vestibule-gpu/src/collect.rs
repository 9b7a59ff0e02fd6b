//! From a frame's commands to what the GPU is told: the order of `rendering.md` 5 and 6, see-through things put aside
//! and drawn at the flushes.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{DVec3, Vec3, Vec4};
use vestibule_physics::{BodyId, ObjectRef};
use vestibule_render::{
    Blend, Daylight, DrawList, FIGURE_HEIGHT, Lamp, LightDetail, LightLevels, MAX_OBJECT_LAMPS, Mesh,
    OBJECT_RANGE, PUNCH_DEPTH, RenderSettings, Scene, figure, overlapping_cells, turned,
};
use vestibule_view::{Camera, Command, LightSet, PolygonRef, Region, SealDepth, Views};
use vestibule_world::{BlockId, CellId, EnvCell, Frame, StaticRef};

use crate::ground::{Ground, PER_CELL};
use crate::meshes::Meshes;
use crate::picture::Picture;
use crate::pipelines::{Key, Kind, blend_key};
use crate::place::{EyeFrame, Placed};
use crate::textures::Textures;
use crate::uniforms::{ALPHA, DrawUniform, FOGGED, LightKind, LightUniform, Stream};

/// One thing the GPU is told to do.
#[derive(Clone, Debug)]
pub(crate) enum Item {
    Mesh(MeshItem),
    Terrain {
        key: Key,
        land: (BlockId, u8),
        /// Ranges of [`Items::ranges`].
        ranges: (u32, u32),
        draw: u32,
    },
    /// From and to column, from and to row.
    Sky([u32; 4]),
    /// Corners of [`Items::points`].
    Depth {
        first: u32,
        count: u32,
    },
    ClearDepth,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshItem {
    pub(crate) key: Key,
    pub(crate) mesh: usize,
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) draw: u32,
    pub(crate) lights: u32,
    pub(crate) texture: usize,
    pub(crate) wrap: bool,
}

/// The things of a frame in order, and the buffers they refer to.
#[derive(Debug)]
pub(crate) struct Items {
    pub(crate) list: Vec<Item>,
    pub(crate) ranges: Vec<(u32, u32)>,
    pub(crate) draws: Stream,
    pub(crate) lights: Stream,
    pub(crate) points: Stream,
    /// The exits that the landscape is kept behind, in the points.
    pub(crate) limits: (u32, u32),
    deferred: Vec<Deferred>,
    ground: Vec<(BlockId, u8, u32)>,
    shared_lights: HashMap<CellId, u32>,
}

#[derive(Clone, Copy, Debug)]
struct Deferred {
    cut_out: bool,
    distance: f64,
    item: MeshItem,
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
            ranges: Vec::new(),
            draws: Stream::new(device, "draws", wgpu::BufferUsages::UNIFORM),
            lights: Stream::new(device, "lights", wgpu::BufferUsages::UNIFORM),
            points: Stream::new(device, "points", wgpu::BufferUsages::VERTEX),
            limits: (0, 0),
            deferred: Vec::new(),
            ground: Vec::new(),
            shared_lights: HashMap::new(),
        }
    }

    fn clear(&mut self) {
        self.list.clear();
        self.ranges.clear();
        self.draws.bytes.clear();
        self.lights.bytes.clear();
        self.points.bytes.clear();
        self.limits = (0, 0);
        self.deferred.clear();
        self.ground.clear();
        self.shared_lights.clear();
        // The first entry: no lamps, no planes.
        self.lights.push(&LightUniform::new(&[], None, &[]));
    }
}

/// Where assets are kept on the GPU.
pub(crate) struct Store<'a> {
    pub(crate) device: &'a wgpu::Device,
    pub(crate) queue: &'a wgpu::Queue,
    pub(crate) meshes: &'a mut Meshes,
    pub(crate) textures: &'a mut Textures,
    pub(crate) ground: &'a mut Ground,
    pub(crate) stamp: u64,
}

pub(crate) struct Collector<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) settings: &'a RenderSettings,
    pub(crate) items: &'a mut Items,
    pub(crate) store: Store<'a>,
    pub(crate) stats: FrameStats,
    eye: EyeFrame,
    camera: &'a Camera,
    sealed: bool,
    ids: bool,
    light: LightSet,
    viewer_lamp: Option<Lamp>,
    overlaps: Vec<Vec<CellId>>,
    /// Only what lies behind the exits is drawn: the landscape seen from a room.
    behind_exits: bool,
}

/// Who a mesh belongs to, for its ids.
#[derive(Clone, Copy, Debug)]
struct Owner {
    cell: u32,
    code: u32,
    /// The item of every face; `None` takes the polygon's key.
    item: Option<u32>,
}

/// The light on a mesh.
#[derive(Clone, Copy, Debug)]
struct MeshLight {
    kind: LightKind,
    /// Entry of the lamps.
    lights: u32,
    /// Lamps of an object.
    picks: [u32; 8],
    count: u32,
    /// Of its own, in place of the material's.
    own: Option<f32>,
}

impl MeshLight {
    fn plain(kind: LightKind) -> Self {
        MeshLight {
            kind,
            lights: 0,
            picks: [0; 8],
            count: 0,
            own: None,
        }
    }
}

impl<'a> Collector<'a> {
    pub(crate) fn new(
        scene: &'a Scene<'a>,
        settings: &'a RenderSettings,
        picture: &Picture<'a>,
        items: &'a mut Items,
        store: Store<'a>,
        ids: bool,
    ) -> Self {
        items.clear();
        let mut out = Collector {
            scene,
            settings,
            items,
            store,
            stats: FrameStats::default(),
            eye: EyeFrame::new(picture.camera),
            camera: picture.camera,
            sealed: picture.sealed,
            ids,
            light: LightSet::Sun,
            viewer_lamp: None,
            overlaps: Vec::new(),
            behind_exits: false,
        };
        out.viewer_lamp = out.find_viewer_lamp();
        if let Some(frame) = picture.frame.filter(|_| settings.confine_overlaps) {
            let floods = frame.floods().iter();
            out.overlaps = floods.map(|f| overlapping_cells(scene.world, &f)).collect();
        }
        out
    }

    /// Light and fog of the frame.
    pub(crate) fn levels(&self, day: &Daylight) -> LightLevels {
        LightLevels::new(day, self.sealed, self.settings.light)
    }

    /// The light the viewer carries, camera axes (`rendering.md` 12.7).
    fn find_viewer_lamp(&self) -> Option<Lamp> {
        if !self.settings.viewer_light {
            return None;
        }
        let player = self.scene.player.zip(self.scene.population);
        let body = player.and_then(|(id, population)| population.body(id));
        let position = body.map_or(DVec3::ZERO, |body| {
            let p = body.position();
            let placed = self.eye.place_block(p.cell.block());
            placed.point(p.frame.origin + Vec3::new(0.0, 0.0, 2.0))
        });
        let mut lamp = Lamp::of_viewer(position.as_vec3());
        if self.settings.light == LightDetail::PerPixel && !self.sealed {
            // By daylight it would drown what the room's own lamps do.
            lamp.intensity *= 0.3;
        }
        Some(lamp)
    }

    fn missing(&mut self) {
        self.stats.missing += 1;
    }

    pub(crate) fn run(&mut self, picture: &Picture<'a>) {
        if let Some(frame) = picture.frame
            && self.settings.only_behind_exits
            && frame.interior().is_some()
        {
            let first = self.point_count();
            for command in picture.commands {
                if let Command::Seal {
                    polygon,
                    depth: SealDepth::True,
                    ..
                } = *command
                {
                    self.fan(picture, polygon, -1.0);
                }
            }
            self.items.limits = (first, self.point_count() - first);
            self.behind_exits = self.items.limits.1 > 0;
        }
        for command in picture.commands {
            self.command(picture, command);
        }
        self.finish_ground();
        self.flush();
    }

    fn command(&mut self, picture: &Picture<'a>, command: &Command) {
        match *command {
            Command::Terrain(cell) => {
                let index = u32::from(cell.low()).wrapping_sub(1);
                self.items.ground.push((cell.block(), 0, index.min(63)));
                return;
            }
            Command::TerrainBlock { block, stride } => {
                self.items.ground.push((block, stride.clamp(1, 8), 64));
                return;
            }
            _ => self.finish_ground(),
        }
        match *command {
            Command::Light(light) => self.light = light,
            Command::Sky => {
                self.items.list.push(Item::Sky(picture.sky_bounds()));
                self.sky_things(false);
            }
            Command::FlushAlpha => self.flush(),
            Command::Punch { polygon, .. } => self.depth(picture, polygon, PUNCH_DEPTH),
            Command::Seal { polygon, depth, .. } => {
                let value = if depth == SealDepth::Nearest { 1.0 } else { -1.0 };
                self.depth(picture, polygon, value);
            }
            Command::Building {
                block,
                building,
                model,
            } => self.building(block, building, model),
            Command::Room { cell, views } => match self.confined(picture, cell, views) {
                Some(regions) => {
                    self.stats.confined += 1;
                    for region in regions {
                        self.room(cell, &region);
                    }
                }
                None => self.room(cell, &[]),
            },
            Command::Object { id, cell, views } => match self.confined(picture, cell, views) {
                Some(regions) => {
                    for region in regions {
                        self.object(id, cell, &region);
                    }
                }
                None => self.object(id, cell, &[]),
            },
            Command::ClearDepth => {
                self.items.list.push(Item::ClearDepth);
                self.behind_exits = false;
            }
            Command::Weather => self.sky_things(true),
            Command::NextStamp | Command::Terrain(_) | Command::TerrainBlock { .. } => {}
        }
    }

    fn point_count(&self) -> u32 {
        (self.items.points.bytes.len() / 16) as u32
    }

    /// Adds a polygon as triangles; `value` is the depth to write, below zero for its own.
    fn fan(&mut self, picture: &Picture<'a>, polygon: PolygonRef, value: f32) {
        let Some(frame) = picture.frame else { return };
        let points = frame.polygon(polygon);
        let [first, rest @ ..] = points else { return };
        for pair in rest.windows(2) {
            for p in [*first, pair[0], pair[1]] {
                let seen = self.eye.turn(p.as_dvec3()).as_vec3();
                self.items.points.push(&seen.extend(value).to_array());
            }
        }
    }

    fn depth(&mut self, picture: &Picture<'a>, polygon: PolygonRef, value: f32) {
        let first = self.point_count();
        self.fan(picture, polygon, value);
        let count = self.point_count() - first;
        if count > 0 {
            self.stats.portals += 1;
            self.items.list.push(Item::Depth { first, count });
        }
    }

    /// The regions of a room that overlaps others, as planes through the eye (`rendering.md` 9.5).
    fn confined(&self, picture: &Picture<'a>, cell: CellId, views: Views) -> Option<Vec<Vec<Vec4>>> {
        let (Views::Cell { flood, .. }, Some(frame)) = (views, picture.frame) else {
            return None;
        };
        if !self.overlaps.get(flood as usize)?.contains(&cell) {
            return None;
        }
        let (slopes, size) = (self.camera.slopes(), self.camera.viewport());
        let planes = |region: Region<'_>| {
            let edges = region.edges().iter();
            edges
                .map(|e| {
                    let n = self.eye.turn(e.normal.as_dvec3()).as_vec3();
                    // A hundredth of a pixel more, as the reference has it.
                    let across =
                        (n.x * 2.0 * slopes.x / size.x).abs() + (n.z * 2.0 * slopes.y / size.y).abs();
                    n.extend(across * (2.0 / 256.0))
                })
                .collect()
        };
        Some(frame.regions(views).map(planes).collect())
    }

    fn opaque(&self, kind: Kind) -> Key {
        Key {
            cut: self.behind_exits,
            ids: self.ids,
            ..Key::opaque(kind)
        }
    }

    // Ground.

    fn finish_ground(&mut self) {
        if self.items.ground.is_empty() {
            return;
        }
        let mut list = core::mem::take(&mut self.items.ground);
        // Opaque and of one pass: the order is free (`rendering.md` 9.4).
        list.sort_unstable();
        let low = Vec3::new(0.0, 0.0, -self.settings.terrain_offset);
        let lowered = Frame::new(low, glam::Quat::IDENTITY);
        let mut rest = list.as_slice();
        while let Some(&(block, stride, _)) = rest.first() {
            let end = rest.partition_point(|c| (c.0, c.1) == (block, stride));
            let (cells, later) = rest.split_at(end);
            rest = later;
            let store = &mut self.store;
            let from = (self.scene.world, self.scene.assets);
            let there = store
                .ground
                .prepare(store.device, store.queue, from, (block, stride), store.stamp);
            if !there {
                self.stats.missing += 1;
                continue;
            }
            let plain = store.ground.land((block, stride)).map_or(0, |l| l.plain);
            let mut wanted = 0u64;
            for &(.., cell) in cells {
                wanted |= if cell == 64 { u64::MAX } else { 1 << cell };
            }
            let mut draw = DrawUniform::zeroed();
            draw.rows = self.eye.place(block, &lowered, Vec3::ONE).rows();
            let draw = self.items.draws.push(&draw);
            for (is_plain, cells) in [(true, wanted & plain), (false, wanted & !plain)] {
                self.ground_item(is_plain, cells, (block, stride), draw);
            }
        }
        list.clear();
        self.items.ground = list;
    }

    /// Draws the land cells whose bits are set.
    fn ground_item(&mut self, plain: bool, cells: u64, land: (BlockId, u8), draw: u32) {
        if cells == 0 {
            return;
        }
        let first = self.items.ranges.len() as u32;
        let mut rest = cells;
        while rest != 0 {
            let from = rest.trailing_zeros();
            let count = (rest >> from).trailing_ones();
            let range = (from * PER_CELL, (from + count) * PER_CELL);
            self.stats.triangles += count * PER_CELL / 3;
            self.items.ranges.push(range);
            rest &= u64::MAX.checked_shl(from + count).unwrap_or(0);
        }
        let ranges = (first, self.items.ranges.len() as u32);
        self.stats.draws += ranges.1 - ranges.0;
        let mut key = self.opaque(Kind::Terrain { plain });
        key.cull = if self.settings.cull_terrain { 0 } else { 2 };
        self.items.list.push(Item::Terrain {
            key,
            land,
            ranges,
            draw,
        });
    }

    // Meshes.

    fn sky_things(&mut self, after: bool) {
        if self.ids {
            return;
        }
        let scene = self.scene;
        let table = scene.assets.sky(scene.world);
        for thing in table.things(scene.day_group, scene.time_of_day) {
            if thing.after != after {
                continue;
            }
            let Some(mesh) = scene.assets.model(scene.world, thing.model, None) else {
                self.missing();
                continue;
            };
            let rotation =
                glam::Quat::from_rotation_z(-thing.heading) * glam::Quat::from_rotation_y(-thing.angle);
            // Around the eye: endlessly far away.
            let frame = Frame::new(self.camera.eye(), rotation);
            let placed = self.eye.place(self.camera.cell().block(), &frame, Vec3::ONE);
            let Some(key) = self.store.meshes.get(self.store.device, &mesh, self.store.stamp) else {
                continue;
            };
            let light = MeshLight {
                own: Some(thing.luminosity),
                ..MeshLight::plain(LightKind::Own)
            };
            let owner = Owner {
                cell: 0,
                code: 0,
                item: None,
            };
            for batch in self.batches(key).iter() {
                let material = &batch.material;
                let pipeline = Key {
                    blend: blend_key(material.blend),
                    test: false,
                    write: false,
                    ..Key::opaque(Kind::Mesh { pixel_lit: false })
                };
                let opacity = material.opacity * (1.0 - thing.translucency);
                let flags = ALPHA;
                let draw = self.draw_of(&placed, material, opacity, flags, &light, owner);
                let item = self.item(pipeline, key, batch, draw, 0);
                self.push(item);
            }
        }
    }

    fn batches(&self, mesh: usize) -> Arc<[crate::meshes::Batch]> {
        self.store
            .meshes
            .mesh(mesh)
            .map_or_else(|| [].into(), |m| m.batches.clone())
    }

    fn draw_of(
        &mut self,
        placed: &Placed,
        material: &vestibule_render::Material,
        opacity: f32,
        flags: u32,
        light: &MeshLight,
        owner: Owner,
    ) -> u32 {
        let mut draw = DrawUniform::zeroed();
        draw.rows = placed.rows();
        draw.material = [
            light.own.unwrap_or(material.luminosity),
            material.diffuse,
            material
                .alpha_test
                .map_or(0.0, |limit| (f32::from(limit) - 0.25) / 255.0),
            opacity,
        ];
        let fog = if material.fogged && light.kind != LightKind::Own {
            FOGGED
        } else {
            0
        };
        draw.how = [light.kind as u32, flags | fog, light.count, 0];
        draw.picks = light.picks;
        draw.id = [
            owner.cell,
            owner.code << 28 | owner.item.unwrap_or(0) & 0x0FFF_FFFF,
            u32::from(owner.item.is_none()),
            0,
        ];
        self.items.draws.push(&draw)
    }

    fn item(
        &mut self,
        key: Key,
        mesh: usize,
        batch: &crate::meshes::Batch,
        draw: u32,
        lights: u32,
    ) -> MeshItem {
        let store = &mut self.store;
        let source = &batch.material.texture;
        let texture = store.textures.get(store.device, store.queue, source, store.stamp);
        MeshItem {
            key,
            mesh,
            first: batch.first,
            count: batch.count,
            draw,
            lights,
            texture,
            wrap: batch.wrap,
        }
    }

    fn push(&mut self, item: MeshItem) {
        self.stats.draws += 1;
        self.stats.triangles += item.count / 3;
        self.items.list.push(Item::Mesh(item));
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

    /// Draws a placed mesh. `opacity` below 1 fades all of it. `cut`: the light's entry has planes.
    fn mesh(
        &mut self,
        mesh: &Arc<Mesh>,
        placed: &Placed,
        owner: Owner,
        light: &MeshLight,
        opacity: f32,
        cut: bool,
    ) {
        let middle = placed.point(mesh.sphere.center);
        if !self.on_screen(middle, f64::from(mesh.sphere.radius) * placed.reach() + 0.01) {
            return;
        }
        let Some(key) = self.store.meshes.get(self.store.device, mesh, self.store.stamp) else {
            return;
        };
        let lit = matches!(light.kind, LightKind::Shell | LightKind::Indoor);
        let pixel_lit = lit && self.settings.light == LightDetail::PerPixel && !self.ids;
        let cull = u8::from(placed.mirrors());
        let cut = cut || self.behind_exits;
        for batch in self.batches(key).iter() {
            let material = &batch.material;
            if material.list == DrawList::Now && opacity >= 1.0 {
                let pipeline = Key {
                    cull,
                    cut,
                    ids: self.ids,
                    ..Key::opaque(Kind::Mesh { pixel_lit })
                };
                let draw = self.draw_of(placed, &material.clone(), 1.0, 0, light, owner);
                let item = self.item(pipeline, key, batch, draw, light.lights);
                self.push(item);
                continue;
            }
            let faded = opacity < 1.0;
            let cut_out = material.list == DrawList::CutOut && !faded;
            if self.ids && !cut_out {
                continue;
            }
            let blend = if faded && material.list == DrawList::Now {
                Blend::ALPHA
            } else {
                material.blend
            };
            let pipeline = Key {
                blend: blend_key(if self.ids { Blend::OPAQUE } else { blend }),
                write: material.writes_depth() && !faded,
                cull,
                cut,
                ids: self.ids,
                ..Key::opaque(Kind::Mesh { pixel_lit: false })
            };
            let flags = if material.list == DrawList::Now { 0 } else { ALPHA };
            let draw = self.draw_of(placed, material, material.opacity * opacity, flags, light, owner);
            let item = self.item(pipeline, key, batch, draw, light.lights);
            self.items.deferred.push(Deferred {
                cut_out,
                distance: middle.length(),
                item,
            });
        }
    }

    /// Draws what was put aside: cut-outs in order, then what is blended far to near (`rendering.md` 14.7).
    fn flush(&mut self) {
        let mut list = core::mem::take(&mut self.items.deferred);
        list.sort_by(|a, b| match (a.cut_out, b.cut_out) {
            (true, true) => core::cmp::Ordering::Equal,
            (true, false) => core::cmp::Ordering::Less,
            (false, true) => core::cmp::Ordering::Greater,
            (false, false) => b.distance.total_cmp(&a.distance),
        });
        for d in &list {
            self.push(d.item);
        }
        list.clear();
        self.items.deferred = list;
    }

    // What commands name.

    fn building(&mut self, block: BlockId, index: u32, model: u32) {
        let scene = self.scene;
        let found = scene.world.loaded_block(block);
        let Some(building) = found.and_then(|b| b.buildings.get(index as usize)) else {
            self.missing();
            return;
        };
        let part = building.shape.parts.first();
        let shell = part.and_then(|p| p.model.as_deref());
        let Some((mesh, part)) = shell
            .and_then(|s| scene.assets.model(scene.world, model, Some(s)))
            .zip(part)
        else {
            self.missing();
            return;
        };
        let frame = building.part_frames.first().copied().unwrap_or(building.frame);
        let placed = self.eye.place(block, &frame, part.scale);
        let owner = Owner {
            cell: building.cell.0,
            code: 2,
            item: None,
        };
        self.mesh(
            &mesh,
            &placed,
            owner,
            &MeshLight::plain(LightKind::Sun),
            1.0,
            false,
        );
    }

    /// The lamps of a cell, camera axes.
    fn seen_lamps(&self, cell: &EnvCell) -> Vec<Lamp> {
        let placed = self.eye.place_block(cell.id.block());
        let lamps = self.scene.assets.lamps(self.scene.world, cell);
        lamps
            .iter()
            .map(|l| Lamp {
                position: placed.point(l.position).as_vec3(),
                ..*l
            })
            .collect()
    }

    /// The entry with a cell's lamps and the planes of a region.
    fn lights(&mut self, cell: CellId, lamps: &[Lamp], planes: &[Vec4]) -> u32 {
        if planes.is_empty()
            && let Some(&found) = self.items.shared_lights.get(&cell)
        {
            return found;
        }
        let entry = LightUniform::new(lamps, self.viewer_lamp.as_ref(), planes);
        let at = self.items.lights.push(&entry);
        if planes.is_empty() {
            self.items.shared_lights.insert(cell, at);
        }
        at
    }

    fn room(&mut self, id: CellId, planes: &[Vec4]) {
        let scene = self.scene;
        let Some(cell) = scene.world.env_cell(id) else {
            self.missing();
            return;
        };
        let Some(mesh) = scene.assets.cell_shell(scene.world, cell) else {
            self.missing();
            return;
        };
        let placed = self.eye.place(id.block(), &cell.frame, Vec3::ONE);
        let lamps = self.seen_lamps(cell);
        let light = MeshLight {
            lights: self.lights(id, &lamps, planes),
            ..MeshLight::plain(LightKind::Shell)
        };
        let owner = Owner {
            cell: id.0,
            code: 3,
            item: None,
        };
        self.mesh(&mesh, &placed, owner, &light, 1.0, !planes.is_empty());
    }

    fn object(&mut self, id: ObjectRef, cell: CellId, planes: &[Vec4]) {
        match id {
            ObjectRef::Static(id) => self.static_object(id, cell, planes),
            ObjectRef::Body(id) => self.body(id, cell, planes),
        }
    }

    /// The model to draw of a part at its distance, and its frame, turned to the viewer if the level says so; `None`
    /// when nothing is drawn of it (`rendering.md` 17.1).
    fn level(&self, block: BlockId, model: u32, frame: &Frame, scale: f32) -> Option<(u32, Frame)> {
        let eye = self.eye.eye_in(block).as_vec3();
        let gap = frame.origin - eye;
        let distance = libm::sqrtf(gap.dot(gap)) / scale;
        let (scene, quality) = (self.scene, self.settings.detail);
        let level = scene.assets.model_level(scene.world, model, distance, quality);
        Some((level.model?, turned(frame, eye, level.mode)))
    }

    fn static_object(&mut self, id: StaticRef, cell: CellId, planes: &[Vec4]) {
        let scene = self.scene;
        let Some(object) = scene.world.static_object(id) else {
            self.missing();
            return;
        };
        let owner = Owner {
            cell: object.cell.0,
            code: 4,
            item: Some(id.index),
        };
        for (part, frame) in object.shape.parts.iter().zip(&object.part_frames) {
            let block = object.cell.block();
            let Some((model, frame)) = self.level(block, part.model_id, frame, part.scale.z) else {
                continue;
            };
            let Some(mesh) = scene.assets.model(scene.world, model, None) else {
                self.missing();
                continue;
            };
            let placed = self.eye.place(block, &frame, part.scale);
            self.lit_object(&mesh, &placed, owner, cell, 1.0, planes);
        }
    }

    fn body(&mut self, id: BodyId, cell: CellId, planes: &[Vec4]) {
        let scene = self.scene;
        let Some(body) = scene.population.and_then(|p| p.body(id)) else {
            self.missing();
            return;
        };
        let opacity = if scene.player == Some(id) {
            scene.player_opacity
        } else {
            1.0
        };
        if !(opacity > 0.0) {
            return;
        }
        let position = body.position();
        let block = position.cell.block();
        let owner = Owner {
            cell: body.cell().unwrap_or(position.cell).0,
            code: 4,
            item: Some(0x0800_0000),
        };
        let mut drawn = false;
        for (part, frame) in body.shape().parts.iter().zip(body.part_frames()) {
            drawn = true;
            let scale = part.scale * body.scale();
            let Some((model, frame)) = self.level(block, part.model_id, frame, scale.z) else {
                continue;
            };
            let Some(mesh) = scene.assets.model(scene.world, model, None) else {
                self.missing();
                continue;
            };
            let placed = self.eye.place(block, &frame, scale);
            self.lit_object(&mesh, &placed, owner, cell, opacity, planes);
        }
        if drawn {
            return;
        }
        let shape = body.shape();
        let tops = shape.spheres.iter().map(|s| s.center.z + s.radius);
        let tallest = tops.fold(shape.height, |a, b| if b > a { b } else { a });
        let height = if tallest > 0.1 { tallest } else { FIGURE_HEIGHT };
        let scale = Vec3::splat(height / FIGURE_HEIGHT * body.scale());
        let placed = self.eye.place(block, &position.frame, scale);
        self.lit_object(&figure(), &placed, owner, cell, opacity, planes);
    }

    fn lit_object(
        &mut self,
        mesh: &Arc<Mesh>,
        placed: &Placed,
        owner: Owner,
        listed_in: CellId,
        opacity: f32,
        planes: &[Vec4],
    ) {
        let cut = !planes.is_empty();
        if self.light == LightSet::Sun && !cut {
            self.mesh(
                mesh,
                placed,
                owner,
                &MeshLight::plain(LightKind::Sun),
                opacity,
                cut,
            );
            return;
        }
        let cell = self.scene.world.env_cell(listed_in);
        let lamps = cell.map(|c| self.seen_lamps(c)).unwrap_or_default();
        let middle = placed.point(mesh.sphere.center).as_vec3();
        let square = |k: usize| {
            let gap = lamps[k].position - middle;
            gap.dot(gap)
        };
        let mut near: Vec<usize> = (0..lamps.len())
            .filter(|&k| {
                let reach = lamps[k].falloff * OBJECT_RANGE + mesh.sphere.radius;
                square(k) < reach * reach
            })
            .collect();
        near.sort_by(|&a, &b| square(a).total_cmp(&square(b)));
        near.truncate(MAX_OBJECT_LAMPS);
        let mut light = MeshLight::plain(if self.light == LightSet::Sun {
            LightKind::Sun
        } else {
            LightKind::Indoor
        });
        light.count = near.len() as u32;
        for (slot, k) in light.picks.iter_mut().zip(near) {
            *slot = k as u32;
        }
        light.lights = self.lights(listed_in, &lamps, planes);
        self.mesh(mesh, placed, owner, &light, opacity, cut);
    }
}
