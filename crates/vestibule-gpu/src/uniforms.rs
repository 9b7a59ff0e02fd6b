//! What shaders read besides textures, laid out as they declare it (`shaders/common.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use vestibule_render::{Daylight, Fog, Lamp, LightLevels, MAX_SHELL_LAMPS};
use vestibule_view::Camera;

use crate::place::EyeFrame;

/// Distance of entries in the buffers of draws; the alignment that every adapter allows.
pub(crate) const ALIGNMENT: u64 = 256;
/// Planes of one region at most.
pub(crate) const MAX_PLANES: usize = 32;

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
            flags: [u32::from(soft), u32::from(reference), 0, 0],
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
pub(crate) const FOGGED: u32 = 1;
/// The alpha of the texture counts.
pub(crate) const ALPHA: u32 = 2;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct DrawUniform {
    pub(crate) rows: [[f32; 4]; 3],
    /// Luminosity, diffuse, least alpha, opacity.
    pub(crate) material: [f32; 4],
    /// Kind of light, flags, lamps, unused.
    pub(crate) how: [u32; 4],
    pub(crate) picks: [u32; 8],
    /// Cell, code and item, 1 when the polygon is the item.
    pub(crate) id: [u32; 4],
    unused: [u32; 32],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct LightUniform {
    counts: [u32; 4],
    viewer: [[f32; 4]; 2],
    lamps: [[f32; 4]; 2 * MAX_SHELL_LAMPS],
    planes: [[f32; 4]; MAX_PLANES],
    unused: [[f32; 4]; 13],
}

const _: () = assert!(size_of::<DrawUniform>() as u64 == ALIGNMENT);
const _: () = assert!(size_of::<LightUniform>() == 2048);

fn lamp(l: &Lamp) -> [[f32; 4]; 2] {
    [vec4(l.position, l.falloff), vec4(l.color, l.intensity)]
}

impl LightUniform {
    /// Lamps, the viewer's lamp and the planes of a region, camera axes. What is too much is left out.
    pub(crate) fn new(lamps: &[Lamp], viewer: Option<&Lamp>, planes: &[Vec4]) -> Self {
        let mut out = LightUniform::zeroed();
        for (slot, l) in out.lamps.chunks_exact_mut(2).zip(lamps) {
            slot.copy_from_slice(&lamp(l));
        }
        for (slot, p) in out.planes.iter_mut().zip(planes) {
            *slot = p.to_array();
        }
        if let Some(l) = viewer {
            out.viewer = lamp(l);
        }
        out.counts = [
            lamps.len().min(MAX_SHELL_LAMPS) as u32,
            u32::from(viewer.is_some()),
            planes.len().min(MAX_PLANES) as u32,
            0,
        ];
        out
    }
}

/// A buffer that is filled anew in every frame and grows when it must.
#[derive(Debug)]
pub(crate) struct Stream {
    label: &'static str,
    usage: wgpu::BufferUsages,
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) bytes: Vec<u8>,
}

impl Stream {
    pub(crate) fn new(device: &wgpu::Device, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Stream {
            label,
            usage,
            buffer: buffer(device, label, usage, 1 << 16),
            bytes: Vec::new(),
        }
    }

    /// Adds a value; returns where it begins.
    pub(crate) fn push<T: Pod>(&mut self, value: &T) -> u32 {
        let at = self.bytes.len() as u32;
        self.bytes.extend_from_slice(bytemuck::bytes_of(value));
        at
    }

    /// Sends what was added. Returns whether the buffer is another one now.
    pub(crate) fn upload(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> bool {
        let needed = self.bytes.len() as u64;
        let grow = needed > self.buffer.size();
        if grow {
            self.buffer = buffer(device, self.label, self.usage, needed.next_power_of_two());
        }
        if needed > 0 {
            queue.write_buffer(&self.buffer, 0, &self.bytes);
        }
        grow
    }
}

fn buffer(device: &wgpu::Device, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}
