//! Textures on the GPU, uploaded once and dropped when nothing draws them any more.

use std::sync::Arc;

use vestibule_render::{Level, NumberMap, Texture};

/// Where a texture is: an array, and a layer of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Slot {
    pub(crate) array: u16,
    pub(crate) layer: u16,
}

#[derive(Debug)]
struct Held {
    // Keeps the address that is its key from being used again.
    #[allow(dead_code, reason = "held, not read")]
    source: Arc<Texture>,
    slot: Slot,
    /// Batches of meshes that are painted with it.
    users: u32,
    bytes: u64,
}

/// Textures of one size.
#[derive(Debug)]
struct Array {
    /// Width, height, mip levels.
    size: (u32, u32, u32),
    texture: wgpu::Texture,
    group: wgpu::BindGroup,
    /// Layers that are in use.
    taken: Vec<bool>,
}

/// Textures by the address of their source, in arrays of equal ones so that few draws need another binding.
#[derive(Debug)]
pub(crate) struct Textures {
    all: NumberMap<usize, Held>,
    arrays: Vec<Array>,
    pub(crate) layout: wgpu::BindGroupLayout,
    samplers: [wgpu::Sampler; 2],
    longest: u32,
    deepest: u32,
    pub(crate) bytes: u64,
}

/// Meshes and ground that were not drawn in this many frames are dropped.
pub(crate) const KEPT_FRAMES: u64 = 900;
/// Layers of an array that is made; one alone would be no array in WebGL2.
const FIRST_LAYERS: u32 = 4;

impl Textures {
    pub(crate) fn new(device: &wgpu::Device, sampling: Sampling) -> Self {
        let limits = device.limits();
        Textures {
            all: NumberMap::default(),
            arrays: Vec::new(),
            layout: layout(device),
            samplers: [
                sampler(device, wgpu::AddressMode::ClampToEdge, sampling),
                sampler(device, wgpu::AddressMode::Repeat, sampling),
            ],
            longest: limits.max_texture_dimension_2d,
            deepest: limits.max_texture_array_layers.min(256),
            bytes: 0,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// Where a texture is, which is uploaded if it is not there yet. It stays until it was released as often as this
    /// was called.
    pub(crate) fn get(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, source: &Arc<Texture>) -> Slot {
        let key = Arc::as_ptr(source) as usize;
        if let Some(found) = self.all.get_mut(&key) {
            found.users += 1;
            return found.slot;
        }
        let levels = fitting(source.levels(), self.longest);
        let slot = self.room(device, queue, &levels[0], levels.len() as u32);
        if let Some(array) = self.arrays.get(usize::from(slot.array)) {
            for (k, level) in levels.iter().enumerate() {
                write(queue, &array.texture, k as u32, u32::from(slot.layer), level);
            }
        }
        let bytes = levels.iter().map(|l| l.pixels.len() as u64 * 4).sum();
        self.bytes += bytes;
        let made = Held {
            source: source.clone(),
            slot,
            users: 1,
            bytes,
        };
        self.all.insert(key, made);
        slot
    }

    /// Undoes one [`Textures::get`].
    pub(crate) fn release(&mut self, source: &Arc<Texture>) {
        let key = Arc::as_ptr(source) as usize;
        let Some(found) = self.all.get_mut(&key) else {
            return;
        };
        found.users -= 1;
        if found.users > 0 {
            return;
        }
        self.bytes -= found.bytes;
        let slot = found.slot;
        self.all.remove(&key);
        if let Some(array) = self.arrays.get_mut(usize::from(slot.array)) {
            array.taken[usize::from(slot.layer)] = false;
        }
    }

    pub(crate) fn group(&self, array: u16) -> Option<&wgpu::BindGroup> {
        self.arrays.get(usize::from(array)).map(|a| &a.group)
    }

    /// A layer for a texture of this size.
    fn room(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, level: &Level, mips: u32) -> Slot {
        let size = (level.width, level.height, mips);
        let deepest = self.deepest as usize;
        let free = |a: &Array| a.taken.iter().position(|t| !t);
        let mut found = None;
        for (k, array) in self.arrays.iter().enumerate().filter(|(_, a)| a.size == size) {
            if let Some(layer) = free(array) {
                found = Some((k, layer));
                break;
            }
            if array.taken.len() < deepest {
                found = Some((k, array.taken.len()));
            }
        }
        let (k, layer) = found.unwrap_or((self.arrays.len(), 0));
        if k == self.arrays.len() {
            let texture = array_texture(device, size, FIRST_LAYERS);
            let made = Array {
                size,
                group: self.bind(device, &texture),
                texture,
                taken: vec![false; FIRST_LAYERS as usize],
            };
            self.arrays.push(made);
        } else if layer == self.arrays[k].taken.len() {
            let layers = (2 * layer).min(deepest);
            let texture = array_texture(device, size, layers as u32);
            copy(
                device,
                queue,
                &self.arrays[k].texture,
                &texture,
                size,
                layer as u32,
            );
            let group = self.bind(device, &texture);
            let array = &mut self.arrays[k];
            (array.texture, array.group) = (texture, group);
            array.taken.resize(layers, false);
        }
        self.arrays[k].taken[layer] = true;
        Slot {
            array: k as u16,
            layer: layer as u16,
        }
    }

    fn bind(&self, device: &wgpu::Device, texture: &wgpu::Texture) -> wgpu::BindGroup {
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("pictures"),
            layout: &self.layout,
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&view)),
                entry(1, wgpu::BindingResource::Sampler(&self.samplers[0])),
                entry(2, wgpu::BindingResource::Sampler(&self.samplers[1])),
            ],
        })
    }
}

fn array_texture(
    device: &wgpu::Device,
    (width, height, mips): (u32, u32, u32),
    layers: u32,
) -> wgpu::Texture {
    use wgpu::TextureUsages as Usage;
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("pictures"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: layers,
        },
        mip_level_count: mips,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: Usage::TEXTURE_BINDING | Usage::COPY_DST | Usage::COPY_SRC,
        view_formats: &[],
    })
}

/// Copies the first layers of an array into a larger one.
fn copy(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    from: &wgpu::Texture,
    to: &wgpu::Texture,
    (width, height, mips): (u32, u32, u32),
    layers: u32,
) {
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    for mip_level in 0..mips {
        let part = |texture| wgpu::TexelCopyTextureInfo {
            texture,
            mip_level,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        };
        let size = wgpu::Extent3d {
            width: (width >> mip_level).max(1),
            height: (height >> mip_level).max(1),
            depth_or_array_layers: layers,
        };
        encoder.copy_texture_to_texture(part(from), part(to), size);
    }
    queue.submit([encoder.finish()]);
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
            texture_entry(0, wgpu::TextureViewDimension::D2Array, true),
            sampler_entry(1),
            sampler_entry(2),
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
