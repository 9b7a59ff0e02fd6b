//! Meshes on the GPU: faces as triangles, grouped by what they are painted with, all in one pair of buffers.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use vestibule_render::{Blend, DrawList, Material, Mesh, NumberMap, Texture};

use crate::arena::Arena;
use crate::textures::{KEPT_FRAMES, Slot, Textures};

/// A corner as `shaders/mesh.wgsl` reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    polygon: u32,
}

pub(crate) const CORNER_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32],
};

/// Triangles of one material, with all of it that a draw needs: nothing else has to be looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Batch {
    /// In the buffer of indices.
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) texture: Slot,
    pub(crate) wrap: bool,
    pub(crate) fogged: bool,
    pub(crate) writes_depth: bool,
    pub(crate) list: DrawList,
    pub(crate) blend: Blend,
    pub(crate) opacity: f32,
    /// Luminosity, diffuse, least alpha.
    pub(crate) paint: [f32; 3],
}

impl Batch {
    fn new(material: &Material, texture: Slot, wrap: bool, (first, count): (u32, u32)) -> Self {
        let least = material.alpha_test;
        Batch {
            first,
            count,
            texture,
            wrap,
            fogged: material.fogged,
            writes_depth: material.writes_depth(),
            list: material.list,
            blend: material.blend,
            opacity: material.opacity,
            paint: [
                material.luminosity,
                material.diffuse,
                least.map_or(0.0, |limit| (f32::from(limit) - 0.25) / 255.0),
            ],
        }
    }
}

#[derive(Debug)]
pub(crate) struct GpuMesh {
    pub(crate) source: Arc<Mesh>,
    batches: Box<[Batch]>,
    /// One a batch.
    textures: Box<[Arc<Texture>]>,
    /// Corners and indices (first, count) in the arenas.
    corners: (u64, u64),
    indices: (u64, u64),
    used: u64,
}

/// Meshes by the address of their source.
#[derive(Debug)]
pub(crate) struct Meshes {
    all: NumberMap<usize, GpuMesh>,
    pub(crate) corners: Arena,
    pub(crate) indices: Arena,
}

impl Meshes {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Meshes {
            all: NumberMap::default(),
            corners: Arena::new(
                device,
                "corners",
                wgpu::BufferUsages::VERTEX,
                size_of::<Corner>(),
                1 << 16,
            ),
            indices: Arena::new(
                device,
                "indices",
                wgpu::BufferUsages::INDEX,
                size_of::<u32>(),
                1 << 17,
            ),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// The batches of a mesh that is uploaded if it is not there yet; none when it has no triangles or no room.
    pub(crate) fn get(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        textures: &mut Textures,
        source: &Arc<Mesh>,
        frame: u64,
    ) -> &[Batch] {
        let key = Arc::as_ptr(source) as usize;
        if !self.all.contains_key(&key) {
            let made = self.upload(device, queue, textures, source, frame);
            self.all.insert(key, made);
        }
        match self.all.get_mut(&key) {
            Some(found) => {
                found.used = frame;
                &found.batches
            }
            None => &[],
        }
    }

    /// Drops what was not drawn for long, or what nobody else holds any more.
    pub(crate) fn sweep(&mut self, textures: &mut Textures, frame: u64) {
        let (corners, indices) = (&mut self.corners, &mut self.indices);
        self.all.retain(|_, m| {
            let keep = Arc::strong_count(&m.source) > 1 && frame.saturating_sub(m.used) < KEPT_FRAMES;
            if !keep {
                corners.give_back(m.corners.0, m.corners.1);
                indices.give_back(m.indices.0, m.indices.1);
                for texture in &m.textures {
                    textures.release(texture);
                }
            }
            keep
        });
    }

    fn upload(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        textures: &mut Textures,
        source: &Arc<Mesh>,
        frame: u64,
    ) -> GpuMesh {
        let (corners, groups) = grouped(source);
        let count = groups.iter().map(|(.., list)| list.len() as u64).sum();
        let mut made = GpuMesh {
            source: source.clone(),
            batches: Box::default(),
            textures: Box::default(),
            corners: (0, 0),
            indices: (0, 0),
            used: frame,
        };
        if count == 0 {
            return made;
        }
        let Some(at) = self.corners.take(device, queue, corners.len() as u64) else {
            return made;
        };
        made.corners = (at, corners.len() as u64);
        self.corners.write(queue, at, bytemuck::cast_slice(&corners));
        let lists = groups.iter().flat_map(|(.., list)| list);
        let all: Vec<u32> = lists.map(|i| i + at as u32).collect();
        let Some(at) = self.indices.take(device, queue, count) else {
            return made;
        };
        made.indices = (at, count);
        self.indices.write(queue, at, bytemuck::cast_slice(&all));
        let mut first = at as u32;
        let batch = |(material, wrap, list): &(Arc<Material>, bool, Vec<u32>)| {
            let range = (first, list.len() as u32);
            first += range.1;
            Batch::new(
                material,
                textures.get(device, queue, &material.texture),
                *wrap,
                range,
            )
        };
        made.batches = groups.iter().map(batch).collect();
        made.textures = groups.iter().map(|(m, ..)| m.texture.clone()).collect();
        made
    }
}

/// Corners, and triangles by what they are painted with; what is drawn at once may be grouped, what is put aside keeps
/// its order.
fn grouped(source: &Mesh) -> (Vec<Corner>, Vec<(Arc<Material>, bool, Vec<u32>)>) {
    let mut corners: Vec<Corner> = Vec::with_capacity(source.vertices.len());
    let mut groups: Vec<(Arc<Material>, bool, Vec<u32>)> = Vec::new();
    for face in &source.faces {
        let Some(material) = source.materials.get(face.material as usize) else {
            continue;
        };
        let first = corners.len() as u32;
        corners.extend(source.corners(face).iter().map(|v| Corner {
            position: v.position.to_array(),
            normal: v.normal.to_array(),
            uv: v.uv.to_array(),
            polygon: u32::from(face.polygon),
        }));
        let same = |g: &(Arc<Material>, bool, Vec<u32>)| Arc::ptr_eq(&g.0, material) && g.1 == face.wrap;
        let slot = if material.list == DrawList::Now {
            groups.iter().position(same)
        } else {
            groups.len().checked_sub(1).filter(|&k| same(&groups[k]))
        };
        let slot = slot.unwrap_or_else(|| {
            groups.push((material.clone(), face.wrap, Vec::new()));
            groups.len() - 1
        });
        let count = corners.len() as u32 - first;
        for k in 1..count.saturating_sub(1) {
            groups[slot].2.extend([first, first + k, first + k + 1]);
        }
    }
    groups.retain(|(.., list)| !list.is_empty());
    (corners, groups)
}
