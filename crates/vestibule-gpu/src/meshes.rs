//! Meshes on the GPU: faces as triangles, grouped by what they are painted with.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use vestibule_render::{DrawList, Material, Mesh};

use crate::textures::KEPT_FRAMES;

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

/// Triangles of one material.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) material: Arc<Material>,
    pub(crate) wrap: bool,
}

#[derive(Debug)]
pub(crate) struct GpuMesh {
    pub(crate) source: Arc<Mesh>,
    pub(crate) vertices: wgpu::Buffer,
    pub(crate) indices: wgpu::Buffer,
    pub(crate) batches: Arc<[Batch]>,
    pub(crate) triangles: u32,
    used: u64,
}

/// Meshes by the address of their source.
#[derive(Debug, Default)]
pub(crate) struct Meshes {
    all: HashMap<usize, GpuMesh>,
}

impl Meshes {
    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// The key of a mesh that is uploaded if it is not there yet; `None` when it has no triangles.
    pub(crate) fn get(&mut self, device: &wgpu::Device, source: &Arc<Mesh>, frame: u64) -> Option<usize> {
        let key = Arc::as_ptr(source) as usize;
        if let Some(found) = self.all.get_mut(&key) {
            found.used = frame;
            return (found.triangles > 0).then_some(key);
        }
        let made = upload(device, source, frame);
        let drawn = made.triangles > 0;
        self.all.insert(key, made);
        drawn.then_some(key)
    }

    pub(crate) fn mesh(&self, key: usize) -> Option<&GpuMesh> {
        self.all.get(&key)
    }

    pub(crate) fn sweep(&mut self, frame: u64) {
        self.all
            .retain(|_, m| Arc::strong_count(&m.source) > 1 && frame.saturating_sub(m.used) < KEPT_FRAMES);
    }
}

fn upload(device: &wgpu::Device, source: &Arc<Mesh>, frame: u64) -> GpuMesh {
    let mut corners: Vec<Corner> = Vec::with_capacity(source.vertices.len());
    // Faces with their triangles; what is drawn at once may be grouped, what is put aside keeps its order.
    let mut groups: Vec<(Batch, Vec<u32>)> = Vec::new();
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
        let same = |b: &Batch| Arc::ptr_eq(&b.material, material) && b.wrap == face.wrap;
        let slot = if material.list == DrawList::Now {
            groups.iter().position(|(b, _)| same(b))
        } else {
            groups.len().checked_sub(1).filter(|&k| same(&groups[k].0))
        };
        let slot = slot.unwrap_or_else(|| {
            let batch = Batch {
                first: 0,
                count: 0,
                material: material.clone(),
                wrap: face.wrap,
            };
            groups.push((batch, Vec::new()));
            groups.len() - 1
        });
        let count = corners.len() as u32 - first;
        for k in 1..count.saturating_sub(1) {
            groups[slot].1.extend([first, first + k, first + k + 1]);
        }
    }
    let mut indices: Vec<u32> = Vec::new();
    let batches = groups
        .into_iter()
        .map(|(mut batch, list)| {
            (batch.first, batch.count) = (indices.len() as u32, list.len() as u32);
            indices.extend(list);
            batch
        })
        .collect();
    GpuMesh {
        source: source.clone(),
        vertices: filled(device, wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&corners)),
        indices: filled(device, wgpu::BufferUsages::INDEX, bytemuck::cast_slice(&indices)),
        batches,
        triangles: indices.len() as u32 / 3,
        used: frame,
    }
}

/// A buffer with this content.
pub(crate) fn filled(device: &wgpu::Device, usage: wgpu::BufferUsages, bytes: &[u8]) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("mesh"),
        size: (bytes.len() as u64).max(4).next_multiple_of(4),
        usage,
        mapped_at_creation: true,
    });
    if let Ok(mut range) = buffer.get_mapped_range_mut(0..bytes.len() as u64) {
        range.copy_from_slice(bytes);
    }
    buffer.unmap();
    buffer
}
