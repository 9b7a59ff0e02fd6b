//! The renderer: uploads what a frame needs, once, and draws it.

use vestibule_render::{
    IdImage, Image, LightDetail, LightLevels, Picture, RenderSettings, Scene, Walk, WalkMemory,
};
use vestibule_view::FrameView;

use crate::collect::{Collector, Store};
use crate::device::Gpu;
use crate::error::GpuError;
use crate::ground::Ground;
use crate::items::{FrameStats, Item, Items};
use crate::meshes::Meshes;
use crate::pipelines::{Key, Pipelines};
use crate::target::{Content, Target};
use crate::textures::{Sampling, Textures};
use crate::uniforms::{FrameUniform, WINDOW};

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
    walk: WalkMemory,
    no_limit: wgpu::TextureView,
    /// Without and with a limit, and whose limit that is.
    frame_groups: [Option<(wgpu::TextureView, wgpu::BindGroup)>; 2],
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
            meshes: Meshes::new(device),
            textures,
            ground,
            items: Items::new(device),
            walk: WalkMemory::new(),
            no_limit: no_limit.create_view(&wgpu::TextureViewDescriptor::default()),
            frame_groups: [None, None],
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
        self.draw_with(gpu, target, scene, picture, settings, || {})
    }

    /// As [`Renderer::draw`]; `before_submit` is called when everything is ready to be submitted.
    pub(crate) fn draw_with(
        &mut self,
        gpu: &Gpu,
        target: &Target,
        scene: &Scene<'_>,
        picture: &Picture<'_>,
        settings: &RenderSettings,
        before_submit: impl FnOnce(),
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
            self.meshes.sweep(&mut self.textures, self.stamp);
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
            pipelines: &mut self.pipelines,
            stamp: self.stamp,
        };
        let mut walk = Walk::new(scene, settings, picture, &mut self.walk);
        if ids {
            walk = walk.unlit();
        }
        let viewer = walk.viewer_lamp();
        let mut collector = Collector::new(scene, settings, picture.camera, &mut self.items, store, ids);
        let met = walk.run(&mut collector);
        collector.finish();
        collector.prepare_limits();
        let stats = FrameStats {
            missing: met.missing,
            confined: met.confined,
            ..collector.stats
        };
        let frame = FrameUniform::new(
            picture.camera,
            &day,
            &LightLevels::new(&day, picture.sealed, settings.light),
            day.fog.filter(|_| settings.fog && !picture.sealed),
            viewer,
            settings.light == LightDetail::PerPixel,
            self.options.filtering == Filtering::Reference,
        );
        let places = &self.ground.places;
        if self.items.send(&gpu.device, &gpu.queue, &frame, places) {
            self.frame_groups = [None, None];
        }
        self.bind(gpu, target);
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
        self.encode(&mut encoder, target, clear);
        let commands = encoder.finish();
        before_submit();
        gpu.queue.submit([commands]);
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
        let (picture, (width, height)) = whole(frame)?;
        let target = self.target(gpu, width, height)?;
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
        let (picture, (width, height)) = whole(frame)?;
        let target = Target::for_ids(gpu, width, height)?;
        self.draw(gpu, &target, scene, &picture, settings)?;
        target.id_image(gpu)
    }

    /// Sees to it that the frame's bindings are there.
    fn bind(&mut self, gpu: &Gpu, target: &Target) {
        let wanted = [
            Some(&self.no_limit),
            (self.items.limits.1 > 0).then_some(&target.limit),
        ];
        let buffer = |size| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &self.items.stream.buffer,
                offset: 0,
                size: wgpu::BufferSize::new(size),
            })
        };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        for (slot, limit) in self.frame_groups.iter_mut().zip(wanted) {
            let Some(limit) = limit else { continue };
            if slot.as_ref().is_some_and(|(bound, _)| bound == limit) {
                continue;
            }
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("frame"),
                layout: &self.pipelines.frame_layout,
                entries: &[
                    entry(0, buffer(size_of::<FrameUniform>() as u64)),
                    entry(1, wgpu::BindingResource::TextureView(limit)),
                    entry(2, buffer(WINDOW)),
                    entry(3, buffer(WINDOW)),
                ],
            });
            *slot = Some((limit.clone(), group));
        }
    }

    fn encode(&self, encoder: &mut wgpu::CommandEncoder, target: &Target, clear: wgpu::Color) {
        let limited = self.items.limits.1 > 0;
        if limited {
            let mut pass = begin(encoder, None, &target.limit, None);
            if let Some(pipeline) = self.pipelines.get(Key::limit().code()) {
                let (first, count) = self.items.limits;
                pass.set_pipeline(pipeline);
                self.set_frame(&mut pass, false, 0);
                let stream = &self.items.stream;
                pass.set_vertex_buffer(3, stream.buffer.slice(u64::from(stream.points)..));
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
            self.encode_items(&mut pass, now, first_pass && limited, target);
            drop(pass);
            first_pass = false;
            if later.is_empty() {
                break;
            }
            passes_left -= 1;
            list = &later[1..];
        }
    }

    /// Binds the frame and a window of its lists.
    fn set_frame(&self, pass: &mut wgpu::RenderPass<'_>, limited: bool, window: u16) {
        let stream = &self.items.stream;
        let lists = stream.windows.get(usize::from(window)).copied().unwrap_or(0);
        let offsets = [stream.frames[usize::from(limited)], lists, stream.lands];
        if let Some((_, group)) = &self.frame_groups[usize::from(limited)] {
            pass.set_bind_group(0, group, &offsets);
        }
    }

    fn encode_items(&self, pass: &mut wgpu::RenderPass<'_>, items: &[Item], limited: bool, target: &Target) {
        if items.is_empty() {
            return;
        }
        let stream = &self.items.stream;
        pass.set_vertex_buffer(0, self.meshes.corners.buffer.slice(..));
        pass.set_vertex_buffer(1, stream.buffer.slice(stream.instances()..));
        pass.set_vertex_buffer(2, self.ground.corners.buffer.slice(..));
        pass.set_vertex_buffer(3, stream.buffer.slice(u64::from(stream.points)..));
        let mut state = State::default();
        let mut bound = 0;
        self.set_frame(pass, limited, 0);
        for item in items {
            match *item {
                Item::Mesh {
                    pipeline,
                    array,
                    window,
                    indices: (first, count),
                    instances: (from, to),
                } => {
                    if !self.pipeline(pass, &mut state, pipeline) {
                        continue;
                    }
                    if let Some(window) = window.filter(|&w| w != bound) {
                        self.set_frame(pass, limited, window);
                        bound = window;
                    }
                    if state.group != Some(Group::Pictures(array)) {
                        let Some(group) = self.textures.group(array) else {
                            continue;
                        };
                        pass.set_bind_group(1, group, &[]);
                        state.group = Some(Group::Pictures(array));
                    }
                    if state.indices != Some(Indices::Meshes) {
                        let indices = self.meshes.indices.buffer.slice(..);
                        pass.set_index_buffer(indices, wgpu::IndexFormat::Uint32);
                        state.indices = Some(Indices::Meshes);
                    }
                    pass.draw_indexed(first..first + count, 0, from..to);
                }
                Item::Ground {
                    pipeline,
                    indices: (first, count),
                } => {
                    let Some(group) = self.ground.group() else {
                        continue;
                    };
                    if !self.pipeline(pass, &mut state, pipeline) {
                        continue;
                    }
                    if state.group != Some(Group::Ground) {
                        pass.set_bind_group(1, group, &[]);
                        state.group = Some(Group::Ground);
                    }
                    if state.indices != Some(Indices::Ground) {
                        let indices = self.items.ground_indices.buffer.slice(..);
                        pass.set_index_buffer(indices, wgpu::IndexFormat::Uint32);
                        state.indices = Some(Indices::Ground);
                    }
                    pass.draw_indexed(first..first + count, 0, 0..1);
                }
                Item::Sky {
                    pipeline,
                    bounds: [x0, x1, y0, y1],
                } => {
                    if x0 < x1 && y0 < y1 && self.pipeline(pass, &mut state, pipeline) {
                        pass.set_scissor_rect(x0, y0, x1 - x0, y1 - y0);
                        pass.draw(0..3, 0..1);
                        pass.set_scissor_rect(0, 0, target.width(), target.height());
                    }
                }
                Item::Depth {
                    pipeline,
                    points: (first, count),
                } => {
                    if self.pipeline(pass, &mut state, pipeline) {
                        pass.draw(first..first + count, 0..1);
                    }
                }
                Item::ClearDepth => {}
            }
        }
    }

    /// Sets a pipeline that is not set; returns whether it is now.
    fn pipeline(&self, pass: &mut wgpu::RenderPass<'_>, state: &mut State, code: u32) -> bool {
        if state.pipeline == Some(code) {
            return true;
        }
        let Some(pipeline) = self.pipelines.get(code) else {
            return false;
        };
        pass.set_pipeline(pipeline);
        state.pipeline = Some(code);
        true
    }
}

/// The picture of a frame and its size in pixels.
fn whole(frame: &FrameView) -> Result<(Picture<'_>, (u32, u32)), GpuError> {
    let picture = Picture::of(frame).ok_or(GpuError::Camera {
        width: 0.0,
        height: 0.0,
    })?;
    let size = picture.camera.viewport();
    Ok((picture, (size.x as u32, size.y as u32)))
}

/// What is set in a pass, which is not set again.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    pipeline: Option<u32>,
    group: Option<Group>,
    indices: Option<Indices>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    Pictures(u16),
    Ground,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Indices {
    Meshes,
    Ground,
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
