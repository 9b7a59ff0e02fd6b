//! What shaders read besides textures, laid out as they declare it (`shaders/common.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use vestibule_render::{Daylight, EyeFrame, Fog, Lamp, LightLevels, MAX_SHELL_LAMPS, NumberMap};
use vestibule_view::Camera;
use vestibule_world::CellId;

/// Where what is bound in a buffer may begin; the alignment that every adapter allows.
const ALIGNMENT: usize = 256;
/// Bytes that shaders see at once of lists: what every adapter allows.
pub(crate) const WINDOW: u64 = 16384;
/// Vectors of a window.
const WINDOW_VECTORS: usize = 1024;
/// Planes of one region at most.
const MAX_PLANES: usize = 32;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct FrameUniform {
    lens: [f32; 4],
    sun: [f32; 4],
    sun_land: [f32; 4],
    sun_color: [f32; 4],
    terrain_light: [f32; 4],
    outdoor_light: [f32; 4],
    indoor_light: [f32; 4],
    fog: [f32; 4],
    fog_range: [f32; 4],
    right: [f32; 4],
    forward: [f32; 4],
    up: [f32; 4],
    horizon: [f32; 4],
    zenith: [f32; 4],
    sky_sun: [f32; 4],
    flags: [u32; 4],
    viewer: [[f32; 4]; 2],
}

fn vec4(v: Vec3, w: f32) -> [f32; 4] {
    v.extend(w).to_array()
}

impl FrameUniform {
    /// The frame of a camera; `soft` rolls bright light off indoors, `reference` picks mip levels as the CPU renderer
    /// does.
    pub(crate) fn new(
        camera: &Camera,
        day: &Daylight,
        levels: &LightLevels,
        fog: Option<Fog>,
        viewer: Option<Lamp>,
        soft: bool,
        reference: bool,
    ) -> Self {
        let eye = EyeFrame::new(camera);
        let [right, forward, up] = camera.axes().map(|a| vec4(a, 0.0));
        let slopes = camera.slopes();
        let fog_color = fog.map_or([0.0; 4], |f| vec4(f.color, 1.0));
        FrameUniform {
            lens: [slopes.x, slopes.y, camera.near(), 0.0],
            sun: vec4(eye.turn(levels.sun_direction.as_dvec3()).as_vec3(), 0.0),
            sun_land: vec4(levels.sun_direction, 0.0),
            sun_color: vec4(levels.sun, 0.0),
            terrain_light: vec4(levels.terrain, 0.0),
            outdoor_light: vec4(levels.outdoors, 0.0),
            indoor_light: vec4(levels.indoors, 0.0),
            fog: fog_color,
            fog_range: fog.map_or([0.0; 4], |f| [f.start, f.end, 0.0, 0.0]),
            right,
            forward,
            up,
            horizon: vec4(day.horizon, 0.0),
            zenith: vec4(day.zenith, 0.0),
            sky_sun: vec4(day.sun, 0.0),
            flags: [
                u32::from(soft),
                u32::from(reference),
                0,
                u32::from(viewer.is_some()),
            ],
            viewer: viewer.map_or([[0.0; 4]; 2], |l| lamp(&l)),
        }
    }

    /// The same, drawing nothing that lies before an exit.
    pub(crate) fn behind_exits(mut self) -> Self {
        self.flags[2] = 1;
        self
    }
}

/// The kinds of light of `shaders/mesh.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LightKind {
    Sun = 0,
    Shell = 1,
    Indoor = 2,
    Own = 3,
}

/// Its colour is fogged.
pub(crate) const FOGGED: u32 = 1 << 2;
/// The alpha of the texture counts.
pub(crate) const ALPHA: u32 = 1 << 3;
/// The item of its ids is the polygon's.
pub(crate) const BY_POLYGON: u32 = 1 << 4;

/// A mesh being drawn, as `shaders/mesh.wgsl` reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Instance {
    pub(crate) rows: [[f32; 4]; 3],
    /// Luminosity in place of the material's where the light is its own, opacity.
    pub(crate) fade: [f32; 2],
    /// Kind of light and flags, number of lamps, nothing, number of planes: a byte each; first lamp and first plane in the
    /// window, 16 bits each; the lamps of an object, a byte each from the first.
    pub(crate) how: [u32; 4],
    /// Cell, code and item.
    pub(crate) id: [u32; 2],
}

pub(crate) const INSTANCE_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Instance>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![
        4 => Float32x4, 5 => Float32x4, 6 => Float32x4, 7 => Float32x2, 8 => Uint32x4, 9 => Uint32x2
    ],
};

fn lamp(l: &Lamp) -> [[f32; 4]; 2] {
    [vec4(l.position, l.falloff), vec4(l.color, l.intensity)]
}

/// A part of the list of lamps and planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Part {
    /// Of the windows.
    pub(crate) window: u16,
    /// First vector in the window.
    pub(crate) first: u16,
    /// Lamps or planes.
    pub(crate) count: u16,
}

/// The lamps and planes of a frame, in windows that shaders see one at a time.
#[derive(Debug, Default)]
pub(crate) struct Lists {
    vectors: Vec<[f32; 4]>,
    /// First vector of each window.
    windows: Vec<usize>,
    shared: NumberMap<u32, Part>,
}

impl Lists {
    pub(crate) fn clear(&mut self) {
        self.vectors.clear();
        self.windows.clear();
        self.windows.push(0);
        self.shared.clear();
    }

    /// Sees to it that so many vectors fit into the window.
    fn reserve(&mut self, vectors: usize) {
        let first = self.windows.last().copied().unwrap_or(0);
        if self.vectors.len() - first + vectors > WINDOW_VECTORS {
            let step = ALIGNMENT / size_of::<[f32; 4]>();
            self.vectors
                .resize(self.vectors.len().next_multiple_of(step), [0.0; 4]);
            self.windows.push(self.vectors.len());
            self.shared.clear();
        }
    }

    fn part(&self, count: usize) -> Part {
        let first = self.windows.last().copied().unwrap_or(0);
        Part {
            window: self.windows.len().saturating_sub(1) as u16,
            first: (self.vectors.len() - first) as u16,
            count: count as u16,
        }
    }

    /// The lamps of a cell, camera axes, what is too many left out, and planes.
    pub(crate) fn add(&mut self, cell: CellId, lamps: &[Lamp], planes: &[Vec4]) -> (Part, Part) {
        let lamps = &lamps[..lamps.len().min(MAX_SHELL_LAMPS)];
        let planes = &planes[..planes.len().min(MAX_PLANES)];
        if planes.is_empty()
            && let Some(&found) = self.shared.get(&cell.0)
        {
            return (found, Part::default());
        }
        self.reserve(2 * lamps.len() + planes.len());
        let lamp_part = self.part(lamps.len());
        for l in lamps {
            self.vectors.extend(lamp(l));
        }
        let plane_part = self.part(planes.len());
        self.vectors.extend(planes.iter().map(Vec4::to_array));
        self.shared.insert(cell.0, lamp_part);
        (lamp_part, plane_part)
    }
}

/// Everything that changes from frame to frame but indices, in one buffer that is sent at once and grows when it must.
#[derive(Debug)]
pub(crate) struct Stream {
    pub(crate) buffer: wgpu::Buffer,
    bytes: Vec<u8>,
    /// Where the frame's uniforms begin: as they are, and for what is kept behind exits.
    pub(crate) frames: [u32; 2],
    /// Where the places of landblocks begin.
    pub(crate) lands: u32,
    /// Where each window begins.
    pub(crate) windows: Vec<u32>,
    /// Where the corners of punches and seals begin.
    pub(crate) points: u32,
}

/// Where the frame's uniforms begin, and the instances, which come first.
const UNIFORMS: [usize; 2] = [0, size_of::<FrameUniform>().next_multiple_of(ALIGNMENT)];
const INSTANCES: usize = 2 * UNIFORMS[1];

/// What a frame sends.
pub(crate) struct Sent<'s> {
    pub(crate) frame: &'s FrameUniform,
    pub(crate) lists: &'s Lists,
    pub(crate) points: &'s [[f32; 4]],
    pub(crate) lands: &'s [[f32; 4]],
}

impl Stream {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Stream {
            buffer: stream(device, 1 << 18),
            bytes: Vec::new(),
            frames: UNIFORMS.map(|at| at as u32),
            lands: 0,
            windows: Vec::new(),
            points: 0,
        }
    }

    /// Where the instances begin.
    pub(crate) fn instances(&self) -> u64 {
        INSTANCES as u64
    }

    /// Begins a frame, which has no instances yet.
    pub(crate) fn begin(&mut self) {
        self.bytes.clear();
        self.bytes.resize(INSTANCES, 0);
    }

    /// Adds an instance; all of a frame come before it is sent. Returns which it is.
    pub(crate) fn add(&mut self, instance: &Instance) -> u32 {
        let at = (self.bytes.len() - INSTANCES) / size_of::<Instance>();
        self.bytes.extend_from_slice(bytemuck::bytes_of(instance));
        at as u32
    }

    fn align(&mut self) -> u32 {
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        self.bytes.len() as u32
    }

    fn push<T: Pod>(&mut self, values: &[T]) -> u32 {
        let at = self.align();
        self.bytes.extend_from_slice(bytemuck::cast_slice(values));
        at
    }

    /// Sends a frame. Returns whether the buffer is another one now.
    pub(crate) fn send(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, sent: &Sent<'_>) -> bool {
        for (at, frame) in UNIFORMS.into_iter().zip([*sent.frame, sent.frame.behind_exits()]) {
            if let Some(place) = self.bytes.get_mut(at..at + size_of::<FrameUniform>()) {
                place.copy_from_slice(bytemuck::bytes_of(&frame));
            }
        }
        self.points = self.push(sent.points);
        let lists = self.push(&sent.lists.vectors);
        let bytes = size_of::<[f32; 4]>() as u32;
        self.windows.clear();
        self.windows
            .extend(sent.lists.windows.iter().map(|&w| lists + w as u32 * bytes));
        self.lands = self.push(sent.lands);
        // Shaders see whole windows.
        let needed = u64::from(self.align()) + WINDOW;
        let grow = needed > self.buffer.size();
        if grow {
            self.buffer = stream(device, needed.next_power_of_two());
        }
        queue.write_buffer(&self.buffer, 0, &self.bytes);
        grow
    }
}

fn stream(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("frame"),
        size,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// The indices of the ground of a frame.
#[derive(Debug)]
pub(crate) struct IndexStream {
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) indices: Vec<u32>,
    /// What is in the buffer: as long as the same land cells are in view nothing is sent.
    sent: Vec<u32>,
}

impl IndexStream {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        IndexStream {
            buffer: index_stream(device, 1 << 16),
            indices: Vec::new(),
            sent: Vec::new(),
        }
    }

    pub(crate) fn send(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) {
        if self.sent.starts_with(&self.indices) {
            return;
        }
        let bytes: &[u8] = bytemuck::cast_slice(&self.indices);
        if bytes.len() as u64 > self.buffer.size() {
            self.buffer = index_stream(device, (bytes.len() as u64).next_power_of_two());
        }
        queue.write_buffer(&self.buffer, 0, bytes);
        self.sent.clone_from(&self.indices);
    }
}

fn index_stream(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("ground"),
        size,
        usage: wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
