//! The renderer: uploads what a frame needs, once, and draws it.

use vestibule_render::{IdImage, Image, LightDetail, RenderSettings, Scene};
use vestibule_view::FrameView;

use crate::collect::{Collector, FrameStats, Item, Items, Store};
use crate::device::Gpu;
use crate::error::GpuError;
use crate::ground::Ground;
use crate::meshes::Meshes;
use crate::picture::Picture;
use crate::pipelines::{Key, Kind, Pipelines};
use crate::target::{Content, Target};
use crate::textures::{Sampling, Textures};
use crate::uniforms::FrameUniform;

/// How textures are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filtering {
    /// Mip levels are blended, and on adapters that do not draw in software slanted surfaces stay sharp: for looking at.
    #[default]
    Smooth,
    /// The mip level that the CPU renderer picks: for comparing with it.
    Reference,
}

/// What is chosen once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RendererOptions {
    /// How textures are sampled.
    pub filtering: Filtering,
    /// Samples a pixel, 1 or 4; targets must have as many. 0 counts as 1.
    pub samples: u32,
}

/// Draws frames. One value serves one world at a time; what was uploaded of another is dropped when it is no longer
/// drawn.
#[derive(Debug)]
pub struct Renderer {
    options: RendererOptions,
    pipelines: Pipelines,
    meshes: Meshes,
    textures: Textures,
    ground: Ground,
    items: Items,
    frames: [wgpu::Buffer; 2],
    no_limit: wgpu::TextureView,
    draw_group: Option<wgpu::BindGroup>,
    stamp: u64,
}

/// What is on the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uploaded {
    /// Meshes of models and rooms.
    pub meshes: usize,
    /// Textures.
    pub textures: usize,
    /// Bytes of textures.
    pub texture_bytes: u64,
    /// Landblocks' ground, once per stride.
    pub lands: usize,
}

impl Renderer {
    /// A renderer that has uploaded nothing yet.
    pub fn new(gpu: &Gpu, options: RendererOptions) -> Self {
        let device = &gpu.device;
        let options = RendererOptions {
            samples: if options.samples >= 4 { 4 } else { 1 },
            ..options
        };
        let sampling = match options.filtering {
            Filtering::Reference => Sampling::Reference,
            Filtering::Smooth if gpu.is_software() => Sampling::Trilinear,
            Filtering::Smooth => Sampling::Anisotropic,
        };
        let textures = Textures::new(device, sampling);
        let ground = Ground::new(device, sampling);
        let pipelines = Pipelines::new(device, &textures.layout, &ground.layout, options.samples);
        let frame = || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame"),
                size: size_of::<FrameUniform>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let no_limit = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("no limit"),
            size: wgpu::Extent3d::default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Renderer {
            options,
            pipelines,
            meshes: Meshes::default(),
            textures,
            ground,
            items: Items::new(device),
            frames: [frame(), frame()],
            no_limit: no_limit.create_view(&wgpu::TextureViewDescriptor::default()),
            draw_group: None,
            stamp: 0,
        }
    }

    /// What was chosen.
    pub fn options(&self) -> RendererOptions {
        self.options
    }

    /// A target whose samples are this renderer's.
    ///
    /// # Errors
    /// As [`Target::new`].
    pub fn target(&self, gpu: &Gpu, width: u32, height: u32) -> Result<Target, GpuError> {
        Target::new(gpu, width, height, self.options.samples)
    }

    /// What is on the GPU now.
    pub fn uploaded(&self) -> Uploaded {
        Uploaded {
            meshes: self.meshes.len(),
            textures: self.textures.len(),
            texture_bytes: self.textures.bytes,
            lands: self.ground.len(),
        }
    }

    /// Draws a picture into a target and submits it.
    ///
    /// # Errors
    /// When the device was lost, or the camera's screen is not the target's size.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        target: &Target,
        scene: &Scene<'_>,
        picture: &Picture<'_>,
        settings: &RenderSettings,
    ) -> Result<FrameStats, GpuError> {
        gpu.check()?;
        let size = picture.camera.viewport();
        if (size.x, size.y) != (target.width() as f32, target.height() as f32) {
            return Err(GpuError::Camera {
                width: size.x,
                height: size.y,
            });
        }
        self.stamp += 1;
        if self.stamp.is_multiple_of(256) {
            self.textures.sweep(self.stamp);
            self.meshes.sweep(self.stamp);
            self.ground.sweep(self.stamp);
        }
        let ids = target.content == Content::Ids;
        let day = scene.daylight();
        let store = Store {
            device: &gpu.device,
            queue: &gpu.queue,
            meshes: &mut self.meshes,
            textures: &mut self.textures,
            ground: &mut self.ground,
            stamp: self.stamp,
        };
        let mut collector = Collector::new(scene, settings, picture, &mut self.items, store, ids);
        collector.run(picture);
        let levels = collector.levels(&day);
        let stats = collector.stats;
        let frame = FrameUniform::new(
            picture.camera,
            &day,
            &levels,
            day.fog.filter(|_| settings.fog && !picture.sealed),
            settings.light == LightDetail::PerPixel,
            self.options.filtering == Filtering::Reference,
        );
        gpu.queue
            .write_buffer(&self.frames[0], 0, bytemuck::bytes_of(&frame));
        let behind = frame.behind_exits();
        gpu.queue
            .write_buffer(&self.frames[1], 0, bytemuck::bytes_of(&behind));
        self.upload(gpu);
        self.make_pipelines(gpu, ids);
        let clear = if picture.sealed {
            glam::Vec3::ZERO
        } else {
            day.horizon
        };
        let byte = |v: f32| f64::from((v * 255.0) as u8) / 255.0;
        let clear = if ids {
            wgpu::Color::TRANSPARENT
        } else {
            wgpu::Color {
                r: byte(clear.x),
                g: byte(clear.y),
                b: byte(clear.z),
                a: 1.0,
            }
        };
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        self.encode(gpu, &mut encoder, target, clear);
        gpu.queue.submit([encoder.finish()]);
        Ok(stats)
    }

    /// Draws the picture of a frame and reads it back, for those without a window.
    ///
    /// # Errors
    /// When the frame has no camera, its screen is no size for a picture, or the device was lost.
    pub fn image(
        &mut self,
        gpu: &Gpu,
        scene: &Scene<'_>,
        frame: &FrameView,
        settings: &RenderSettings,
    ) -> Result<Image, GpuError> {
        let picture = Picture::of(frame).ok_or(GpuError::Camera {
            width: 0.0,
            height: 0.0,
        })?;
        let size = picture.camera.viewport();
        let target = self.target(gpu, size.x as u32, size.y as u32)?;
        self.draw(gpu, &target, scene, &picture, settings)?;
        target.image(gpu)
    }

    /// Draws the picture of a frame as ids and reads it back (`rendering.md` 10.1).
    ///
    /// # Errors
    /// As [`Renderer::image`].
    pub fn ids(
        &mut self,
        gpu: &Gpu,
        scene: &Scene<'_>,
        frame: &FrameView,
        settings: &RenderSettings,
    ) -> Result<IdImage, GpuError> {
        let picture = Picture::of(frame).ok_or(GpuError::Camera {
            width: 0.0,
            height: 0.0,
        })?;
        let size = picture.camera.viewport();
        let target = Target::for_ids(gpu, size.x as u32, size.y as u32)?;
        self.draw(gpu, &target, scene, &picture, settings)?;
        target.id_image(gpu)
    }

    fn upload(&mut self, gpu: &Gpu) {
        let items = &mut self.items;
        let draws = items.draws.upload(&gpu.device, &gpu.queue);
        let lights = items.lights.upload(&gpu.device, &gpu.queue);
        items.points.upload(&gpu.device, &gpu.queue);
        if draws || lights || self.draw_group.is_none() {
            let binding = |buffer, size: usize| {
                wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(size as u64),
                })
            };
            self.draw_group = Some(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("draw"),
                layout: &self.pipelines.draw_layout,
                entries: &[
                    wgpu::BindGroupEntry {
                        binding: 0,
                        resource: binding(&items.draws.buffer, size_of::<crate::uniforms::DrawUniform>()),
                    },
                    wgpu::BindGroupEntry {
                        binding: 1,
                        resource: binding(&items.lights.buffer, size_of::<crate::uniforms::LightUniform>()),
                    },
                ],
            }));
        }
    }

    fn sky_key(ids: bool) -> Key {
        Key {
            test: false,
            write: false,
            cull: 2,
            ids,
            ..Key::opaque(Kind::Sky)
        }
    }

    fn depth_key(kind: Kind, ids: bool) -> Key {
        Key {
            test: false,
            cull: 2,
            ids,
            ..Key::opaque(kind)
        }
    }

    fn make_pipelines(&mut self, gpu: &Gpu, ids: bool) {
        if self.items.limits.1 > 0 {
            self.pipelines
                .prepare(&gpu.device, Self::depth_key(Kind::Limit, false));
        }
        for item in &self.items.list {
            let key = match item {
                Item::Mesh(m) => m.key,
                Item::Terrain { key, .. } => *key,
                Item::Sky(_) => Self::sky_key(ids),
                Item::Depth { .. } => Self::depth_key(Kind::Depth, ids),
                Item::ClearDepth => continue,
            };
            self.pipelines.prepare(&gpu.device, key);
        }
    }

    fn frame_group(&self, gpu: &Gpu, index: usize, limit: &wgpu::TextureView) -> wgpu::BindGroup {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.pipelines.frame_layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: self.frames[index].as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(limit),
                },
            ],
        })
    }

    fn encode(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, target: &Target, clear: wgpu::Color) {
        let ids = target.content == Content::Ids;
        let plain = self.frame_group(gpu, 0, &self.no_limit);
        let limited = (self.items.limits.1 > 0).then(|| self.frame_group(gpu, 1, &target.limit));
        if self.items.limits.1 > 0 {
            let mut pass = begin(encoder, None, &target.limit, None);
            if let Some(pipeline) = self.pipelines.get(Self::depth_key(Kind::Limit, false)) {
                let (first, count) = self.items.limits;
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &plain, &[]);
                pass.set_vertex_buffer(0, self.items.points.buffer.slice(..));
                pass.draw(first..first + count, 0..1);
            }
        }
        let clears = self.items.list.iter().filter(|i| matches!(i, Item::ClearDepth));
        let mut passes_left = clears.count();
        let mut list = self.items.list.as_slice();
        let mut first_pass = true;
        loop {
            let end = list.iter().position(|i| matches!(i, Item::ClearDepth));
            let (now, later) = list.split_at(end.unwrap_or(list.len()));
            let (view, resolve) = match &target.multisampled {
                Some(samples) => (samples, (passes_left == 0).then_some(target.color())),
                None => (target.color(), None),
            };
            let color = wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: resolve,
                ops: wgpu::Operations {
                    load: if first_pass {
                        wgpu::LoadOp::Clear(clear)
                    } else {
                        wgpu::LoadOp::Load
                    },
                    store: wgpu::StoreOp::Store,
                },
            };
            let mut pass = begin(encoder, Some(color), &target.depth, None);
            let group = if first_pass {
                limited.as_ref().unwrap_or(&plain)
            } else {
                &plain
            };
            self.encode_items(&mut pass, now, group, target, ids);
            drop(pass);
            first_pass = false;
            if later.is_empty() {
                break;
            }
            passes_left -= 1;
            list = &later[1..];
        }
    }

    fn encode_items(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        items: &[Item],
        frame: &wgpu::BindGroup,
        target: &Target,
        ids: bool,
    ) {
        let Some(draw_group) = &self.draw_group else {
            return;
        };
        let whole = [0, target.width(), 0, target.height()];
        pass.set_bind_group(0, frame, &[]);
        // What is set is not set again.
        let mut key: Option<Key> = None;
        let mut mesh: Option<usize> = None;
        let mut texture: Option<(usize, bool)> = None;
        for item in items {
            let wanted = match item {
                Item::Mesh(m) => m.key,
                Item::Terrain { key, .. } => *key,
                Item::Sky(_) => Self::sky_key(ids),
                Item::Depth { .. } => Self::depth_key(Kind::Depth, ids),
                Item::ClearDepth => continue,
            };
            if key != Some(wanted) {
                let Some(pipeline) = self.pipelines.get(wanted) else {
                    continue;
                };
                pass.set_pipeline(pipeline);
                key = Some(wanted);
            }
            match item {
                Item::Mesh(m) => {
                    let (Some(found), Some(group)) =
                        (self.meshes.mesh(m.mesh), self.textures.group(m.texture, m.wrap))
                    else {
                        continue;
                    };
                    if mesh != Some(m.mesh) {
                        pass.set_vertex_buffer(0, found.vertices.slice(..));
                        pass.set_index_buffer(found.indices.slice(..), wgpu::IndexFormat::Uint32);
                        mesh = Some(m.mesh);
                    }
                    pass.set_bind_group(1, draw_group, &[m.draw, m.lights]);
                    if texture != Some((m.texture, m.wrap)) {
                        pass.set_bind_group(2, group, &[]);
                        texture = Some((m.texture, m.wrap));
                    }
                    pass.draw_indexed(m.first..m.first + m.count, 0, 0..1);
                }
                Item::Terrain {
                    land, ranges, draw, ..
                } => {
                    let (Some(found), Some(group)) = (self.ground.land(*land), self.ground.group()) else {
                        continue;
                    };
                    pass.set_vertex_buffer(0, found.vertices.slice(..));
                    pass.set_bind_group(1, draw_group, &[*draw, 0]);
                    pass.set_bind_group(2, group, &[]);
                    (mesh, texture) = (None, None);
                    let (first, end) = (ranges.0 as usize, ranges.1 as usize);
                    for &(from, to) in self.items.ranges.get(first..end).unwrap_or(&[]) {
                        pass.draw(from..to, 0..1);
                    }
                }
                Item::Sky([x0, x1, y0, y1]) => {
                    if x0 < x1 && y0 < y1 {
                        pass.set_scissor_rect(*x0, *y0, x1 - x0, y1 - y0);
                        pass.draw(0..3, 0..1);
                        pass.set_scissor_rect(whole[0], whole[2], whole[1], whole[3]);
                    }
                }
                Item::Depth { first, count } => {
                    pass.set_vertex_buffer(0, self.items.points.buffer.slice(..));
                    mesh = None;
                    pass.draw(*first..first + count, 0..1);
                }
                Item::ClearDepth => {}
            }
        }
    }
}

/// A pass that clears depth to the farthest there is.
fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    color: Option<wgpu::RenderPassColorAttachment<'_>>,
    depth: &wgpu::TextureView,
    label: Option<&str>,
) -> wgpu::RenderPass<'e> {
    let colors = [color];
    let colors = if colors[0].is_some() { &colors[..] } else { &[] };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label,
        color_attachments: colors,
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
