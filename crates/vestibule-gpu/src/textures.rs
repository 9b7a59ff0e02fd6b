//! Textures on the GPU, uploaded once and dropped when nothing draws them any more.

use std::collections::HashMap;
use std::sync::Arc;

use vestibule_render::{Level, Texture};

/// A texture with its two ways of addressing.
#[derive(Debug)]
pub(crate) struct GpuTexture {
    // Keeps the address that is its key from being used again.
    source: Arc<Texture>,
    pub(crate) clamped: wgpu::BindGroup,
    pub(crate) repeated: wgpu::BindGroup,
    used: u64,
    bytes: u64,
}

/// Textures by the address of their source.
#[derive(Debug)]
pub(crate) struct Textures {
    all: HashMap<usize, GpuTexture>,
    pub(crate) layout: wgpu::BindGroupLayout,
    samplers: [wgpu::Sampler; 2],
    longest: u32,
    pub(crate) bytes: u64,
}

/// Textures and meshes that were not drawn in this many frames are dropped.
pub(crate) const KEPT_FRAMES: u64 = 900;

impl Textures {
    pub(crate) fn new(device: &wgpu::Device, sampling: Sampling) -> Self {
        Textures {
            all: HashMap::new(),
            layout: layout(device),
            samplers: [
                sampler(device, wgpu::AddressMode::ClampToEdge, sampling),
                sampler(device, wgpu::AddressMode::Repeat, sampling),
            ],
            longest: device.limits().max_texture_dimension_2d,
            bytes: 0,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// The key of a texture that is uploaded if it is not there yet.
    pub(crate) fn get(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        source: &Arc<Texture>,
        frame: u64,
    ) -> usize {
        let key = Arc::as_ptr(source) as usize;
        if let Some(found) = self.all.get_mut(&key) {
            found.used = frame;
            return key;
        }
        let levels = fitting(source.levels(), self.longest);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: extent(&levels[0], 1),
            mip_level_count: levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (k, level) in levels.iter().enumerate() {
            write(queue, &texture, k as u32, 0, level);
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = |sampler: &wgpu::Sampler| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("picture"),
                layout: &self.layout,
                entries: &[
                    wgpu::BindGroupEntry {
                        binding: 0,
                        resource: wgpu::BindingResource::TextureView(&view),
                    },
                    wgpu::BindGroupEntry {
                        binding: 1,
                        resource: wgpu::BindingResource::Sampler(sampler),
                    },
                ],
            })
        };
        let bytes = levels.iter().map(|l| l.pixels.len() as u64 * 4).sum();
        self.bytes += bytes;
        let made = GpuTexture {
            source: source.clone(),
            clamped: group(&self.samplers[0]),
            repeated: group(&self.samplers[1]),
            used: frame,
            bytes,
        };
        self.all.insert(key, made);
        key
    }

    pub(crate) fn group(&self, key: usize, wrap: bool) -> Option<&wgpu::BindGroup> {
        let found = self.all.get(&key)?;
        Some(if wrap { &found.repeated } else { &found.clamped })
    }

    /// Drops what was not drawn for long, or what nobody else holds any more.
    pub(crate) fn sweep(&mut self, frame: u64) {
        let bytes = &mut self.bytes;
        self.all.retain(|_, t| {
            let keep = Arc::strong_count(&t.source) > 1 && frame.saturating_sub(t.used) < KEPT_FRAMES;
            if !keep {
                *bytes -= t.bytes;
            }
            keep
        });
    }
}

/// The levels whose sides the adapter can hold; at least one.
pub(crate) fn fitting(levels: &[Level], longest: u32) -> &[Level] {
    let fits = |l: &Level| l.width <= longest && l.height <= longest;
    let first = levels.iter().position(fits).unwrap_or(levels.len() - 1);
    &levels[first..]
}

pub(crate) fn extent(level: &Level, layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width: level.width,
        height: level.height,
        depth_or_array_layers: layers,
    }
}

/// Sends one level of one layer.
pub(crate) fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, mip: u32, layer: u32, level: &Level) {
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: mip,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
            aspect: wgpu::TextureAspect::All,
        },
        bytemuck::cast_slice(&level.pixels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * level.width),
            rows_per_image: None,
        },
        extent(level, 1),
    );
}

/// How textures are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sampling {
    /// From the nearest mip level, as the CPU renderer does.
    Reference,
    /// Levels are blended.
    Trilinear,
    /// And slanted surfaces stay sharp: cheap in hardware, very slow in software.
    Anisotropic,
}

/// A sampler with this way of addressing.
pub(crate) fn sampler(
    device: &wgpu::Device,
    address: wgpu::AddressMode,
    sampling: Sampling,
) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("picture"),
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: address,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: match sampling {
            Sampling::Reference => wgpu::MipmapFilterMode::Nearest,
            _ => wgpu::MipmapFilterMode::Linear,
        },
        anisotropy_clamp: if sampling == Sampling::Anisotropic { 16 } else { 1 },
        ..Default::default()
    })
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("picture"),
        entries: &[
            texture_entry(0, wgpu::TextureViewDimension::D2, true),
            sampler_entry(1),
        ],
    })
}

pub(crate) fn texture_entry(
    binding: u32,
    dimension: wgpu::TextureViewDimension,
    filterable: bool,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension: dimension,
            multisampled: false,
        },
        count: None,
    }
}

pub(crate) fn sampler_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}
