//! The ground on the GPU: terrain textures in one array, and the land cells of a block in one buffer
//! (`rendering.md` 11.6).

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use vestibule_render::{
    Assets, CellPaint, Cover, LandMesh, Level, NumberMap, TerrainPaint, Texture, TypeTexture,
};
use vestibule_world::constants::SQUARE_LENGTH;
use vestibule_world::terrain::vertex_index;
use vestibule_world::{BlockId, CellId, World};

use crate::arena::Arena;
use crate::textures::{KEPT_FRAMES, Sampling, extent, fitting, sampler, sampler_entry, texture_entry, write};
use crate::uniforms::WINDOW;

/// Terrain textures, and blend maps, that fit into the six bits of a layer.
const MAX_LAYERS: usize = 63;

/// A corner as `shaders/terrain.wgsl` reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    cell: u32,
    layers: [u32; 4],
    roads: [u32; 2],
    /// Of the list of landblocks.
    land: u32,
}

pub(crate) const CORNER_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32, 4 => Uint32x4, 5 => Uint32x2, 6 => Uint32
    ],
};

/// Corners of one land cell.
const PER_CELL: u32 = 6;
/// Corners of a landblock.
const PER_LAND: u32 = 64 * PER_CELL;
/// Landblocks whose place fits into what shaders see of a list.
const MAX_LANDS: usize = (WINDOW / 16) as usize;

/// The ground of one block at one stride.
#[derive(Debug)]
struct GpuLand {
    source: Arc<LandMesh>,
    /// Its place in the list of landblocks and among the corners.
    slot: u32,
    /// One bit a land cell: it shows its base texture and nothing else.
    plain: u64,
    used: u64,
}

/// The ground of the world that is drawn.
#[derive(Debug)]
pub(crate) struct Ground {
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) corners: Arena,
    /// Where each landblock lies for the eye of the frame, by slot.
    pub(crate) places: Vec<[f32; 4]>,
    paint: Option<Paint>,
    lands: NumberMap<u32, GpuLand>,
    sampling: Sampling,
}

#[derive(Debug)]
struct Paint {
    source: Arc<TerrainPaint>,
    group: wgpu::BindGroup,
    types: HashMap<usize, u32>,
    maps: HashMap<usize, u32>,
}

impl Ground {
    pub(crate) fn new(device: &wgpu::Device, sampling: Sampling) -> Self {
        let array = wgpu::TextureViewDimension::D2Array;
        Ground {
            layout: device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("ground"),
                entries: &[
                    texture_entry(0, array, true),
                    sampler_entry(1),
                    texture_entry(2, array, true),
                    sampler_entry(3),
                ],
            }),
            corners: Arena::new(
                device,
                "ground corners",
                wgpu::BufferUsages::VERTEX,
                size_of::<Corner>() * PER_LAND as usize,
                16,
            ),
            places: Vec::new(),
            paint: None,
            lands: NumberMap::default(),
            sampling,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.lands.len()
    }

    pub(crate) fn group(&self) -> Option<&wgpu::BindGroup> {
        self.paint.as_ref().map(|p| &p.group)
    }

    pub(crate) fn sweep(&mut self, frame: u64) {
        let corners = &mut self.corners;
        self.lands.retain(|_, l| {
            let keep = frame.saturating_sub(l.used) < KEPT_FRAMES;
            if !keep {
                corners.give_back(u64::from(l.slot), 1);
            }
            keep
        });
    }

    /// The slot of a block's ground, every `stride`-th vertex of it, 0 is full detail, and a bit for each land cell that
    /// shows its base texture only. It is uploaded if it is not there yet. `place` tells where the block lies.
    pub(crate) fn get(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        (world, assets): (&World, &Assets),
        (block, stride): (BlockId, u8),
        frame: u64,
        place: impl FnOnce() -> Vec3,
    ) -> Option<(u32, u64)> {
        let land = assets.land(world, block)?;
        let terrain = assets.terrain(world);
        if !self
            .paint
            .as_ref()
            .is_some_and(|p| Arc::ptr_eq(&p.source, &terrain))
        {
            self.drop_all();
            self.paint = Some(Paint::upload(device, queue, &self.layout, terrain, self.sampling));
        }
        let key = u32::from(block.0) << 8 | u32::from(stride);
        let known = self.lands.get(&key);
        if !known.is_some_and(|l| Arc::ptr_eq(&l.source, &land)) {
            self.upload((device, queue), world, (block, stride), land, frame)?;
        }
        let found = self.lands.get_mut(&key)?;
        if found.used < frame {
            found.used = frame;
            let slot = found.slot as usize;
            if self.places.len() <= slot {
                self.places.resize(slot + 1, [0.0; 4]);
            }
            self.places[slot] = place().extend(0.0).to_array();
        }
        Some((found.slot, found.plain))
    }

    fn drop_all(&mut self) {
        for land in self.lands.values() {
            self.corners.give_back(u64::from(land.slot), 1);
        }
        self.lands.clear();
    }

    fn upload(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        world: &World,
        (block, stride): (BlockId, u8),
        land: Arc<LandMesh>,
        frame: u64,
    ) -> Option<()> {
        let key = u32::from(block.0) << 8 | u32::from(stride);
        if let Some(old) = self.lands.remove(&key) {
            self.corners.give_back(u64::from(old.slot), 1);
        }
        if self.lands.len() >= MAX_LANDS {
            // The one that was not drawn for the longest time makes room.
            let oldest = self.lands.iter().min_by_key(|(key, l)| (l.used, **key));
            let (&oldest, _) = oldest.filter(|(_, l)| l.used < frame)?;
            let old = self.lands.remove(&oldest)?;
            self.corners.give_back(u64::from(old.slot), 1);
        }
        let slot = self.corners.take(device, queue, 1)? as u32;
        let paint = self.paint.as_ref();
        let Some(list) = paint.and_then(|paint| corners(world, block, &land, stride, slot, paint)) else {
            self.corners.give_back(u64::from(slot), 1);
            return None;
        };
        self.corners
            .write(queue, u64::from(slot), bytemuck::cast_slice(&list));
        let is_plain = |(k, p): (usize, &CellPaint)| {
            let plain = p.overlays.is_empty() && p.roads.is_empty();
            u64::from(plain) << (k & 63)
        };
        let plain = land.paint.iter().enumerate().map(is_plain).fold(0, |a, b| a | b);
        let made = GpuLand {
            source: land,
            slot,
            plain,
            used: 0,
        };
        self.lands.insert(key, made);
        Some(())
    }
}

/// Adds the corners of the land cells whose bits are set.
pub(crate) fn list_cells(slot: u32, cells: u64, out: &mut Vec<u32>) {
    let mut rest = cells;
    while rest != 0 {
        let from = rest.trailing_zeros();
        let count = (rest >> from).trailing_ones();
        let first = slot * PER_LAND + from * PER_CELL;
        out.extend(first..first + count * PER_CELL);
        rest &= u64::MAX.checked_shl(from + count).unwrap_or(0);
    }
}

/// Two triangles for each of the 64 land cells, in the order of their ids.
fn corners(
    world: &World,
    block: BlockId,
    land: &LandMesh,
    stride: u8,
    slot: u32,
    paint: &Paint,
) -> Option<Vec<Corner>> {
    let ground = world.loaded_block(block)?.land.as_ref()?;
    let mut out = Vec::with_capacity(PER_LAND as usize);
    for k in 0..64usize {
        let (i, j) = (k / 8, k % 8);
        let (layers, roads) = land.paint.get(k).map_or(([0; 4], [0; 2]), |p| paint.cell(p));
        let cell = CellId::new(block, k as u16 + 1).0;
        let mut push = |place: Vec3, normal: Vec3| {
            out.push(Corner {
                position: place.to_array(),
                normal: normal.to_array(),
                uv: [
                    place.x / SQUARE_LENGTH - i as f32,
                    1.0 - (place.y / SQUARE_LENGTH - j as f32),
                ],
                cell,
                layers,
                roads,
                land: slot,
            });
        };
        if stride == 0 {
            for polygon in &ground.cells.get(k)?.polygons {
                for v in polygon.vertices {
                    let at = |v: f32| (libm::roundf(v / SQUARE_LENGTH) as usize).min(8);
                    push(v, *land.normals.get(vertex_index(at(v.x), at(v.y)))?);
                }
            }
            continue;
        }
        let step = usize::from(stride.clamp(1, 8));
        let corner = |x: usize, y: usize| coarse(ground, land, step, x, y);
        let (sw, se, ne, nw) = (
            corner(i, j),
            corner(i + 1, j),
            corner(i + 1, j + 1),
            corner(i, j + 1),
        );
        for (place, normal) in [sw, se, ne, sw, ne, nw] {
            push(place, normal);
        }
        // Ids name the coarse cell's first land cell, as the reference's do.
        let named = CellId::new(block, (1 + 8 * (i / step * step) + j / step * step) as u16).0;
        let from = out.len() - PER_CELL as usize;
        out[from..].iter_mut().for_each(|c| c.cell = named);
    }
    (out.len() == PER_LAND as usize).then_some(out)
}

/// A vertex of the grid on the coarse triangles, with the normal that light is interpolated by.
fn coarse(ground: &vestibule_world::Land, land: &LandMesh, step: usize, x: usize, y: usize) -> (Vec3, Vec3) {
    let (i, j) = ((x / step * step).min(8 - step), (y / step * step).min(8 - step));
    let (u, v) = ((x - i) as f32 / step as f32, (y - j) as f32 / step as f32);
    let at = |i: usize, j: usize| {
        let slot = vertex_index(i, j);
        let place = Vec3::new(
            i as f32 * SQUARE_LENGTH,
            j as f32 * SQUARE_LENGTH,
            ground.heights[slot],
        );
        (place, land.normals[slot])
    };
    let (sw, ne) = (at(i, j), at(i + step, j + step));
    let ((a, an), (b, bn), (c, cn), s, t) = if u >= v {
        (sw, at(i + step, j), ne, u, v)
    } else {
        (sw, at(i, j + step), ne, v, u)
    };
    (a + (b - a) * s + (c - b) * t, an + (bn - an) * s + (cn - bn) * t)
}

impl Paint {
    fn upload(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        source: Arc<TerrainPaint>,
        sampling: Sampling,
    ) -> Self {
        let longest = device.limits().max_texture_dimension_2d;
        let pictures: Vec<&Arc<Texture>> = source.types().iter().map(|t| &t.texture).collect();
        let map_list: Vec<&Arc<Texture>> = source.maps().collect();
        let (view, types) = array(device, queue, &pictures, longest, false);
        let (map_view, maps) = array(device, queue, &map_list, longest, true);
        let samplers = [
            sampler(device, wgpu::AddressMode::Repeat, sampling),
            sampler(device, wgpu::AddressMode::ClampToEdge, Sampling::Reference),
        ];
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ground"),
            layout,
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&view)),
                entry(1, wgpu::BindingResource::Sampler(&samplers[0])),
                entry(2, wgpu::BindingResource::TextureView(&map_view)),
                entry(3, wgpu::BindingResource::Sampler(&samplers[1])),
            ],
        });
        Paint {
            source,
            group,
            types,
            maps,
        }
    }

    /// Base and overlays, and roads, as the shader reads them.
    fn cell(&self, paint: &CellPaint) -> ([u32; 4], [u32; 2]) {
        let mut layers = [self.layer(&paint.base, Some(&Cover::Whole)), 0, 0, 0];
        for (slot, layer) in layers[1..].iter_mut().zip(&paint.overlays) {
            *slot = self.layer(&layer.texture, Some(&layer.cover));
        }
        let mut roads = [self.layer(&paint.road, None); 2];
        for (slot, cover) in roads.iter_mut().zip(&paint.roads) {
            *slot = self.layer(&paint.road, Some(cover));
        }
        (layers, roads)
    }

    fn layer(&self, texture: &TypeTexture, cover: Option<&Cover>) -> u32 {
        let picture = self.types.get(&(Arc::as_ptr(&texture.texture) as usize)).copied();
        let tiling = (texture.tiling as u32).clamp(1, 127);
        let cover = match cover {
            None => 0,
            Some(Cover::Map(map, turns)) => match self.maps.get(&(Arc::as_ptr(map) as usize)) {
                Some(index) => 1 << 13 | index << 15 | (turns & 3) << 21,
                None => 0,
            },
            Some(Cover::Corners(mask)) => 2 << 13 | (mask & 15) << 15,
            Some(Cover::Whole) => 3 << 13,
        };
        picture.unwrap_or(0) | tiling << 6 | cover
    }
}

/// Pictures in one array, all of the size of the largest, and their layers by the address of their source. `map`: the
/// alpha of the largest level counts, and nothing else.
fn array(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    sources: &[&Arc<Texture>],
    longest: u32,
    map: bool,
) -> (wgpu::TextureView, HashMap<usize, u32>) {
    let mut layers: HashMap<usize, u32> = HashMap::new();
    let mut list: Vec<&Arc<Texture>> = Vec::new();
    for &source in sources {
        let key = Arc::as_ptr(source) as usize;
        if !layers.contains_key(&key) && list.len() < MAX_LAYERS {
            layers.insert(key, list.len() as u32);
            list.push(source);
        }
    }
    let side = |t: &Arc<Texture>| {
        let l = &fitting(t.levels(), longest)[0];
        if l.width > l.height { l.width } else { l.height }
    };
    let size = list.iter().map(|t| side(t)).max().unwrap_or(1).max(1);
    let mips = if map { 1 } else { size.ilog2() + 1 };
    let blank = Level {
        width: size,
        height: size,
        pixels: Vec::new(),
    };
    // A view of one layer would be no array in WebGL2.
    let count = (list.len() as u32).max(2);
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("ground"),
        size: extent(&blank, count),
        mip_level_count: mips,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (layer, source) in list.iter().enumerate() {
        let levels = fitting(source.levels(), longest);
        let own = &levels[0];
        let scaled;
        let levels = if (own.width, own.height) == (size, size) {
            levels
        } else {
            scaled = stretched(source, size, map);
            scaled.levels()
        };
        for (k, level) in levels.iter().take(mips as usize).enumerate() {
            if map {
                // The weight in every channel.
                let weights = level.pixels.iter().map(|p| [p[3]; 4]).collect();
                let level = Level {
                    pixels: weights,
                    ..level.clone()
                };
                write(queue, &texture, k as u32, layer as u32, &level);
            } else {
                write(queue, &texture, k as u32, layer as u32, level);
            }
        }
    }
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    (view, layers)
}

/// A picture stretched to a square.
fn stretched(source: &Texture, size: u32, map: bool) -> Texture {
    let pixels = (0..size * size)
        .map(|i| {
            let at = |v: u32| (v as f32 + 0.5) / size as f32;
            let c = source.sample(at(i % size), at(i / size), 0.0, !map);
            c.map(|v| (v + 0.5) as u8)
        })
        .collect();
    Texture::new(size, size, pixels, false)
}
