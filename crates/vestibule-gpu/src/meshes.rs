//! Meshes on the GPU: faces as triangles, grouped by what they are painted with, all in one pair of buffers.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use vestibule_render::{Blend, DrawList, Material, Mesh, MeshFace, NumberMap, Texture};

use crate::arena::Arena;
use crate::textures::{KEPT_FRAMES, Slot, Textures};
use crate::uniforms::{ALPHA, FOGGED};

/// A corner as `shaders/mesh.wgsl` reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    polygon: u32,
    /// Flags of its material and, from bit 16, the layer of its texture.
    surface: u32,
    /// Luminosity, diffuse, least alpha.
    paint: [f32; 3],
}

pub(crate) const CORNER_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint32, 10 => Uint32, 11 => Float32x3
    ],
};

/// Triangles that are drawn at once: of materials that differ in nothing but what corners hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Batch {
    /// In the buffer of indices.
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) way: Way,
}

/// How a batch is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Way {
    /// The array of its textures.
    pub(crate) array: u16,
    pub(crate) wrap: bool,
    pub(crate) writes_depth: bool,
    pub(crate) list: DrawList,
    pub(crate) blend: Blend,
    pub(crate) opacity: f32,
}

/// Faces of one material.
struct Group<'m> {
    material: &'m Arc<Material>,
    wrap: bool,
    faces: Vec<&'m MeshFace>,
}

impl Group<'_> {
    fn way(&self, array: u16) -> Way {
        let material = self.material;
        Way {
            array,
            wrap: self.wrap,
            writes_depth: material.writes_depth(),
            list: material.list,
            blend: material.blend,
            opacity: material.opacity,
        }
    }

    /// What its corners hold of the material.
    fn paint(&self, slot: Slot) -> (u32, [f32; 3]) {
        let material = self.material;
        let flag = |on: bool, bit: u32| if on { bit } else { 0 };
        let flags = flag(material.fogged, FOGGED) | flag(material.list != DrawList::Now, ALPHA);
        let least = material.alpha_test;
        let least = least.map_or(0.0, |limit| (f32::from(limit) - 0.25) / 255.0);
        let paint = [material.luminosity, material.diffuse, least];
        (flags | u32::from(slot.layer) << 16, paint)
    }
}

#[derive(Debug)]
pub(crate) struct GpuMesh {
    pub(crate) source: Arc<Mesh>,
    batches: Box<[Batch]>,
    /// Those it holds, some more than once.
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
        let mut made = GpuMesh {
            source: source.clone(),
            batches: Box::default(),
            textures: Box::default(),
            corners: (0, 0),
            indices: (0, 0),
            used: frame,
        };
        let mut groups: Vec<(Group<'_>, Slot)> = Vec::new();
        for group in grouped(source) {
            let slot = textures.get(device, queue, &group.material.texture);
            groups.push((group, slot));
        }
        if groups.is_empty() {
            return made;
        }
        made.textures = groups.iter().map(|(g, _)| g.material.texture.clone()).collect();
        // What is drawn at once may be in any order: alike next to alike.
        groups.sort_by_key(|(g, slot)| match g.material.list {
            DrawList::Now => (false, g.wrap, slot.array),
            _ => (true, false, 0),
        });
        let (mut corners, mut indices) = (Vec::with_capacity(source.vertices.len()), Vec::new());
        let mut batches: Vec<Batch> = Vec::new();
        for (group, slot) in &groups {
            let (way, first) = (group.way(slot.array), indices.len() as u32);
            add_triangles(source, group, *slot, &mut corners, &mut indices);
            let count = indices.len() as u32 - first;
            match batches.last_mut() {
                Some(last) if last.way == way => last.count += count,
                _ => batches.push(Batch { first, count, way }),
            }
        }
        let Some(at) = self.corners.take(device, queue, corners.len() as u64) else {
            return made;
        };
        made.corners = (at, corners.len() as u64);
        self.corners.write(queue, at, bytemuck::cast_slice(&corners));
        indices.iter_mut().for_each(|i| *i += at as u32);
        let Some(at) = self.indices.take(device, queue, indices.len() as u64) else {
            return made;
        };
        made.indices = (at, indices.len() as u64);
        self.indices.write(queue, at, bytemuck::cast_slice(&indices));
        batches.iter_mut().for_each(|b| b.first += at as u32);
        made.batches = batches.into();
        made
    }
}

/// Faces by what they are painted with; what is drawn at once may be grouped, what is put aside keeps its order.
fn grouped(source: &Mesh) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for face in source.faces.iter().filter(|f| source.corners(f).len() >= 3) {
        let Some(material) = source.materials.get(face.material as usize) else {
            continue;
        };
        let same = |g: &Group<'_>| Arc::ptr_eq(g.material, material) && g.wrap == face.wrap;
        let slot = if material.list == DrawList::Now {
            groups.iter().position(same)
        } else {
            groups.len().checked_sub(1).filter(|&k| same(&groups[k]))
        };
        match slot.and_then(|k| groups.get_mut(k)) {
            Some(group) => group.faces.push(face),
            None => groups.push(Group {
                material,
                wrap: face.wrap,
                faces: vec![face],
            }),
        }
    }
    groups
}

/// Adds the corners of a group's faces, and its triangles.
fn add_triangles(
    source: &Mesh,
    group: &Group<'_>,
    slot: Slot,
    corners: &mut Vec<Corner>,
    indices: &mut Vec<u32>,
) {
    let (surface, paint) = group.paint(slot);
    for face in &group.faces {
        let first = corners.len() as u32;
        corners.extend(source.corners(face).iter().map(|v| Corner {
            position: v.position.to_array(),
            normal: v.normal.to_array(),
            uv: v.uv.to_array(),
            polygon: u32::from(face.polygon),
            surface,
            paint,
        }));
        let count = corners.len() as u32 - first;
        for k in 1..count.saturating_sub(1) {
            indices.extend([first, first + k, first + k + 1]);
        }
    }
}
