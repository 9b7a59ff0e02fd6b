//! The window with a graphics adapter.

use std::sync::Arc;

use egui::TexturesDelta;
use egui::epaint::ClippedPrimitive;
use vestibule_gpu::wgpu;
use vestibule_gpu::{AdapterChoice, Filtering, Gpu, GpuError, Picture, Renderer, RendererOptions, Target};
use vestibule_render::{Image, RenderSettings};
use winit::window::Window;

use crate::explorer::Explorer;
use crate::panels::FrameTimes;

pub(crate) struct GpuScreen {
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    configured: bool,
    renderer: Renderer,
    target: Option<Target>,
    blit: Blit,
    panels: egui_wgpu::Renderer,
}

impl GpuScreen {
    /// `display` is for adapters that need one before there is a window.
    pub(crate) fn new(
        window: Arc<Window>,
        display: Box<dyn wgpu::wgt::WgpuHasDisplayHandle>,
        choice: AdapterChoice,
    ) -> Result<Self, GpuError> {
        let descriptor = wgpu::InstanceDescriptor::new_with_display_handle_from_env(display);
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance
            .create_surface(window)
            .map_err(|e| GpuError::NoAdapter(e.to_string()))?;
        let gpu = Gpu::for_surface(&instance, &surface, choice)?;
        let can = surface.get_capabilities(&gpu.adapter);
        // Colours are gamma-encoded all the way (`rendering.md` 9.7).
        let plain = [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8Unorm];
        let format = plain.into_iter().find(|f| can.formats.contains(f));
        let unusable = || GpuError::Device {
            adapter: gpu.name().to_owned(),
            reason: "it cannot draw into this window".to_owned(),
        };
        let format = format.or(can.formats.first().copied()).ok_or_else(unusable)?;
        let mut config = surface
            .get_default_config(&gpu.adapter, 1, 1)
            .ok_or_else(unusable)?;
        config.format = format;
        config.present_mode = wgpu::PresentMode::AutoVsync;
        let options = RendererOptions {
            filtering: Filtering::Smooth,
            samples: if gpu.is_software() { 1 } else { 4 },
        };
        Ok(GpuScreen {
            renderer: Renderer::new(&gpu, options),
            blit: Blit::new(&gpu.device, format),
            panels: egui_wgpu::Renderer::new(&gpu.device, format, egui_wgpu::RendererOptions::default()),
            target: None,
            configured: false,
            gpu,
            surface,
            config,
        })
    }

    pub(crate) fn name(&self) -> &str {
        self.gpu.name()
    }

    /// Size of the picture for a window of this size.
    pub(crate) fn picture_size(&self, width: u32, height: u32) -> (u32, u32) {
        let longest = self.gpu.longest_side();
        (width.clamp(1, longest), height.clamp(1, longest))
    }

    pub(crate) fn longest_side(&self) -> u32 {
        self.gpu.longest_side()
    }

    pub(crate) fn image(&self) -> Option<Image> {
        self.target.as_ref()?.image(&self.gpu).ok()
    }

    /// Destroys the device, as a driver does that gives up.
    pub(crate) fn destroy(&self) {
        self.gpu.device.destroy();
    }

    fn free(&mut self, delta: &TexturesDelta) {
        for id in &delta.free {
            self.panels.free_texture(id);
        }
    }

    pub(crate) fn draw(
        &mut self,
        (width, height): (u32, u32),
        explorer: Option<&Explorer>,
        list: &[ClippedPrimitive],
        delta: &TexturesDelta,
        points: f32,
        times: &mut FrameTimes,
    ) -> Result<(), GpuError> {
        // A device that is gone says so only when it is asked, and takes commands until then.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        self.gpu.check()?;
        for (id, changes) in &delta.set {
            for change in changes {
                self.panels
                    .update_texture(&self.gpu.device, &self.gpu.queue, *id, change);
            }
        }
        let (width, height) = self.picture_size(width, height);
        if !self.configured || (self.config.width, self.config.height) != (width, height) {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(&self.gpu.device, &self.config);
            self.configured = true;
        }
        if let Some(explorer) = explorer
            && let Some(camera) = explorer.camera()
        {
            let size = camera.viewport();
            let size = (size.x as u32, size.y as u32);
            if self
                .target
                .as_ref()
                .is_none_or(|t| (t.width(), t.height()) != size)
            {
                self.target = Some(self.renderer.target(&self.gpu, size.0, size.1)?);
            }
            let picture = Picture {
                camera: &camera,
                commands: explorer.commands(),
                frame: explorer.regions_frame(),
                sealed: explorer.is_sealed(),
            };
            if let Some(target) = &self.target {
                let begin = std::time::Instant::now();
                let settings = RenderSettings::default();
                let stats = self
                    .renderer
                    .draw(&self.gpu, target, &explorer.scene(), &picture, &settings)?;
                times.submit = begin.elapsed().as_secs_f32();
                (times.draws, times.triangles) = (stats.draws, stats.triangles);
            }
        }
        let frame = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame) | wgpu::CurrentSurfaceTexture::Suboptimal(frame) => {
                frame
            }
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Occluded => {
                self.free(delta);
                return Ok(());
            }
            // Another size or another screen: set up anew with the next frame.
            _ => {
                self.configured = false;
                self.free(delta);
                return Ok(());
            }
        };
        let view = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("window"),
            });
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: [width, height],
            pixels_per_point: points,
        };
        let extra =
            self.panels
                .update_buffers(&self.gpu.device, &self.gpu.queue, &mut encoder, list, &screen);
        let source = self
            .target
            .as_ref()
            .map(|t| self.blit.group(&self.gpu.device, t.color()));
        {
            let mut pass = encoder
                .begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("window"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &view,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations {
                            load: wgpu::LoadOp::Clear(wgpu::Color {
                                r: 0.07,
                                g: 0.07,
                                b: 0.09,
                                a: 1.0,
                            }),
                            store: wgpu::StoreOp::Store,
                        },
                    })],
                    depth_stencil_attachment: None,
                    timestamp_writes: None,
                    occlusion_query_set: None,
                    multiview_mask: None,
                })
                .forget_lifetime();
            if let Some(source) = source.as_ref().filter(|_| explorer.is_some()) {
                pass.set_pipeline(&self.blit.pipeline);
                pass.set_bind_group(0, source, &[]);
                pass.draw(0..3, 0..1);
            }
            self.panels.render(&mut pass, list, &screen);
        }
        self.gpu
            .queue
            .submit(extra.into_iter().chain(core::iter::once(encoder.finish())));
        self.gpu.queue.present(frame);
        self.free(delta);
        self.gpu.check()
    }
}

/// Copies the picture to the window.
struct Blit {
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
}

impl Blit {
    fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("blit"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                    count: None,
                },
                wgpu::BindGroupLayoutEntry {
                    binding: 1,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                    count: None,
                },
            ],
        });
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("blit"),
            source: wgpu::ShaderSource::Wgsl(include_str!("blit.wgsl").into()),
        });
        let linear = [("LINEAR", if format.is_srgb() { 1.0 } else { 0.0 })];
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("blit"),
            layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("blit"),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            })),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("color"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &linear,
                    ..Default::default()
                },
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Blit {
            pipeline,
            layout,
            sampler,
        }
    }

    fn group(&self, device: &wgpu::Device, picture: &wgpu::TextureView) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blit"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(picture),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&self.sampler),
                },
            ],
        })
    }
}
