//! Pipelines, made when first needed.

use vestibule_render::{Blend, Factor, NumberMap};

use crate::ground;
use crate::meshes;
use crate::uniforms::{FrameUniform, INSTANCE_LAYOUT, WINDOW};

/// Depth as `rendering.md` 9.3 wants it: reversed, in floating point.
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Colours are stored and blended as they are (`rendering.md` 9.7).
pub(crate) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Two words an id.
pub(crate) const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A mesh, its light computed at each pixel or at its corners.
    Mesh { pixel_lit: bool },
    /// The ground; `plain` shows its base texture only.
    Terrain { plain: bool },
    /// The sky.
    Sky,
    /// A punch or a seal: depth, whatever is there.
    Depth,
    /// A seal in the texture that keeps the landscape behind the exits: the nearest wins.
    Limit,
}

/// Everything a pipeline depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) kind: Kind,
    pub(crate) blend: (u8, u8),
    pub(crate) test: bool,
    pub(crate) write: bool,
    /// Back faces (0), front faces (1) or none (2) are left out.
    pub(crate) cull: u8,
    /// Pixels may be cut away: exits before the landscape, regions of a room.
    pub(crate) cut: bool,
    pub(crate) ids: bool,
    /// Textures repeat.
    pub(crate) wrap: bool,
}

impl Key {
    /// The nearest of the exits that the landscape is kept behind.
    pub(crate) fn limit() -> Self {
        Key {
            test: false,
            cull: 2,
            ..Key::opaque(Kind::Limit)
        }
    }

    /// A number for each key.
    pub(crate) fn code(&self) -> u32 {
        let kind = match self.kind {
            Kind::Mesh { pixel_lit } => u32::from(pixel_lit),
            Kind::Terrain { plain } => 2 + u32::from(plain),
            Kind::Sky => 4,
            Kind::Depth => 5,
            Kind::Limit => 6,
        };
        let bits = [self.test, self.write, self.cut, self.ids, self.wrap];
        let bits = bits.iter().fold(0, |a, &b| a << 1 | u32::from(b));
        let blend = u32::from(self.blend.0) << 2 | u32::from(self.blend.1);
        kind << 12 | blend << 8 | u32::from(self.cull) << 5 | bits
    }

    pub(crate) fn opaque(kind: Kind) -> Self {
        Key {
            kind,
            blend: blend_key(Blend::OPAQUE),
            test: true,
            write: true,
            cull: 0,
            cut: false,
            ids: false,
            wrap: false,
        }
    }
}

pub(crate) fn blend_key(blend: Blend) -> (u8, u8) {
    let code = |f: Factor| match f {
        Factor::Zero => 0,
        Factor::One => 1,
        Factor::SrcAlpha => 2,
        Factor::InvSrcAlpha => 3,
    };
    (code(blend.src), code(blend.dst))
}

fn factor(code: u8) -> wgpu::BlendFactor {
    match code {
        0 => wgpu::BlendFactor::Zero,
        1 => wgpu::BlendFactor::One,
        2 => wgpu::BlendFactor::SrcAlpha,
        _ => wgpu::BlendFactor::OneMinusSrcAlpha,
    }
}

#[derive(Debug)]
pub(crate) struct Pipelines {
    /// The last key that was asked for, with its code.
    last: Option<(Key, u32)>,
    all: NumberMap<u32, wgpu::RenderPipeline>,
    shaders: [wgpu::ShaderModule; 4],
    layouts: [wgpu::PipelineLayout; 3],
    pub(crate) frame_layout: wgpu::BindGroupLayout,
    samples: u32,
}

impl Pipelines {
    pub(crate) fn new(
        device: &wgpu::Device,
        pictures: &wgpu::BindGroupLayout,
        ground: &wgpu::BindGroupLayout,
        samples: u32,
    ) -> Self {
        let shader = |label, source: &str| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(
                    [include_str!("shaders/common.wgsl"), source].concat().into(),
                ),
            })
        };
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let uniform = |binding, size| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: both,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: true,
                min_binding_size: wgpu::BufferSize::new(size),
            },
            count: None,
        };
        let frame_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[
                uniform(0, size_of::<FrameUniform>() as u64),
                crate::textures::texture_entry(1, wgpu::TextureViewDimension::D2, false),
                uniform(2, WINDOW),
                uniform(3, WINDOW),
            ],
        });
        let layout = |groups: &[&wgpu::BindGroupLayout]| {
            let groups: Vec<Option<&wgpu::BindGroupLayout>> = groups.iter().map(|g| Some(*g)).collect();
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("vestibule"),
                bind_group_layouts: &groups,
                immediate_size: 0,
            })
        };
        let layouts = [
            layout(&[&frame_layout, pictures]),
            layout(&[&frame_layout, ground]),
            layout(&[&frame_layout]),
        ];
        Pipelines {
            last: None,
            all: NumberMap::default(),
            shaders: [
                shader("mesh", include_str!("shaders/mesh.wgsl")),
                shader("terrain", include_str!("shaders/terrain.wgsl")),
                shader("sky", include_str!("shaders/sky.wgsl")),
                shader("depth", include_str!("shaders/depth.wgsl")),
            ],
            layouts,
            frame_layout,
            samples,
        }
    }

    /// The pipeline of a code.
    pub(crate) fn get(&self, code: u32) -> Option<&wgpu::RenderPipeline> {
        self.all.get(&code)
    }

    /// Sees to it that a pipeline is there. Returns its code.
    pub(crate) fn prepare(&mut self, device: &wgpu::Device, key: Key) -> u32 {
        if let Some((last, code)) = self.last
            && last == key
        {
            return code;
        }
        let code = key.code();
        if !self.all.contains_key(&code) {
            let made = self.make(device, key);
            self.all.insert(code, made);
        }
        self.last = Some((key, code));
        code
    }

    fn make(&self, device: &wgpu::Device, key: Key) -> wgpu::RenderPipeline {
        const POINTS: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x4],
        };
        // Every kind has slots of its own, so that all buffers are set once a pass.
        let (shader, layout, buffers): (usize, usize, &[Option<wgpu::VertexBufferLayout<'static>>]) =
            match key.kind {
                Kind::Mesh { .. } => (0, 0, &[Some(meshes::CORNER_LAYOUT), Some(INSTANCE_LAYOUT)]),
                Kind::Terrain { .. } => (1, 1, &[None, None, Some(ground::CORNER_LAYOUT)]),
                Kind::Sky => (2, 2, &[]),
                Kind::Depth | Kind::Limit => (3, 2, &[None, None, None, Some(POINTS)]),
            };
        let flag = |on: bool| if on { 1.0 } else { 0.0 };
        let cut = ("CUT", flag(key.cut));
        let mesh_constants = [
            cut,
            ("PIXEL_LIT", flag(key.kind == Kind::Mesh { pixel_lit: true })),
            ("WRAP", flag(key.wrap)),
        ];
        let terrain_constants = [cut, ("PLAIN", flag(key.kind == Kind::Terrain { plain: true }))];
        let constants: &[(&str, f64)] = match key.kind {
            Kind::Mesh { .. } => &mesh_constants,
            Kind::Terrain { .. } => &terrain_constants,
            _ => &[],
        };
        let options = wgpu::PipelineCompilationOptions {
            constants,
            ..Default::default()
        };
        let no_color = matches!(key.kind, Kind::Depth | Kind::Limit);
        let (src, dst) = key.blend;
        let opaque = key.blend == blend_key(Blend::OPAQUE);
        let blend = wgpu::BlendState {
            color: wgpu::BlendComponent {
                src_factor: factor(src),
                dst_factor: factor(dst),
                operation: wgpu::BlendOperation::Add,
            },
            // The picture itself stays opaque.
            alpha: wgpu::BlendComponent {
                src_factor: wgpu::BlendFactor::Zero,
                dst_factor: wgpu::BlendFactor::One,
                operation: wgpu::BlendOperation::Add,
            },
        };
        let target = wgpu::ColorTargetState {
            format: if key.ids { ID_FORMAT } else { COLOR_FORMAT },
            blend: (!opaque && !key.ids).then_some(blend),
            write_mask: if no_color {
                wgpu::ColorWrites::empty()
            } else {
                wgpu::ColorWrites::ALL
            },
        };
        let targets = [Some(target)];
        let limit = key.kind == Kind::Limit;
        let entry = match (no_color, key.ids) {
            (true, _) => "nothing",
            (_, true) => "ids",
            _ => "color",
        };
        let samples = if limit || key.ids { 1 } else { self.samples };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("vestibule"),
            layout: Some(&self.layouts[layout]),
            vertex: wgpu::VertexState {
                module: &self.shaders[shader],
                entry_point: Some("vertex"),
                compilation_options: options.clone(),
                buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::TriangleList,
                front_face: wgpu::FrontFace::Ccw,
                cull_mode: match key.cull {
                    0 => Some(wgpu::Face::Back),
                    1 => Some(wgpu::Face::Front),
                    _ => None,
                },
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(key.write),
                depth_compare: Some(match (limit, key.test) {
                    (true, _) => wgpu::CompareFunction::Greater,
                    (false, true) => wgpu::CompareFunction::GreaterEqual,
                    (false, false) => wgpu::CompareFunction::Always,
                }),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: samples,
                ..Default::default()
            },
            fragment: (!limit).then_some(wgpu::FragmentState {
                module: &self.shaders[shader],
                entry_point: Some(entry),
                compilation_options: options,
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
