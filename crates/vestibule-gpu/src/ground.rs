//! The ground on the GPU: terrain textures in one array, and the land cells of a block in one buffer
//! (`rendering.md` 11.6).

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use vestibule_render::{Assets, CellPaint, Cover, LandMesh, Level, TerrainPaint, Texture, TypeTexture};
use vestibule_world::constants::SQUARE_LENGTH;
use vestibule_world::terrain::vertex_index;
use vestibule_world::{BlockId, CellId, World};

use crate::meshes::filled;
use crate::textures::{KEPT_FRAMES, Sampling, extent, fitting, sampler, sampler_entry, texture_entry, write};

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
}

pub(crate) const CORNER_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32, 4 => Uint32x4, 5 => Uint32x2
    ],
};

/// Corners of one land cell.
pub(crate) const PER_CELL: u32 = 6;

/// The ground of one block at one stride.
#[derive(Debug)]
pub(crate) struct GpuLand {
    source: Arc<LandMesh>,
    pub(crate) vertices: wgpu::Buffer,
    /// One bit a land cell: it shows its base texture and nothing else.
    pub(crate) plain: u64,
    used: u64,
}

/// The ground of the world that is drawn.
#[derive(Debug)]
pub(crate) struct Ground {
    pub(crate) layout: wgpu::BindGroupLayout,
    paint: Option<Paint>,
    lands: HashMap<(BlockId, u8), GpuLand>,
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
            paint: None,
            lands: HashMap::new(),
            sampling,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.lands.len()
    }

    pub(crate) fn group(&self) -> Option<&wgpu::BindGroup> {
        self.paint.as_ref().map(|p| &p.group)
    }

    pub(crate) fn land(&self, key: (BlockId, u8)) -> Option<&GpuLand> {
        self.lands.get(&key)
    }

    pub(crate) fn sweep(&mut self, frame: u64) {
        self.lands
            .retain(|_, l| frame.saturating_sub(l.used) < KEPT_FRAMES);
    }

    /// Sees to it that the ground of a block is there, every `stride`-th vertex of it; 0 is full detail.
    pub(crate) fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        (world, assets): (&World, &Assets),
        (block, stride): (BlockId, u8),
        frame: u64,
    ) -> bool {
        let Some(land) = assets.land(world, block) else {
            return false;
        };
        let terrain = assets.terrain(world);
        if !self
            .paint
            .as_ref()
            .is_some_and(|p| Arc::ptr_eq(&p.source, &terrain))
        {
            self.lands.clear();
            self.paint = Some(Paint::upload(device, queue, &self.layout, terrain, self.sampling));
        }
        if let Some(found) = self.lands.get_mut(&(block, stride))
            && Arc::ptr_eq(&found.source, &land)
        {
            found.used = frame;
            return true;
        }
        let Some(paint) = &self.paint else { return false };
        let Some(corners) = corners(world, block, &land, stride, paint) else {
            return false;
        };
        let is_plain = |(k, p): (usize, &CellPaint)| {
            let plain = p.overlays.is_empty() && p.roads.is_empty();
            u64::from(plain) << (k & 63)
        };
        let plain = land.paint.iter().enumerate().map(is_plain).fold(0, |a, b| a | b);
        let made = GpuLand {
            plain,
            source: land,
            vertices: filled(device, wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&corners)),
            used: frame,
        };
        self.lands.insert((block, stride), made);
        true
    }
}

/// Two triangles for each of the 64 land cells, in the order of their ids.
fn corners(world: &World, block: BlockId, land: &LandMesh, stride: u8, paint: &Paint) -> Option<Vec<Corner>> {
    let ground = world.loaded_block(block)?.land.as_ref()?;
    let mut out = Vec::with_capacity(64 * PER_CELL as usize);
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
    (out.len() == 64 * PER_CELL as usize).then_some(out)
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
