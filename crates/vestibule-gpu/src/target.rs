//! What a picture is drawn into, and reading it back.

use vestibule_render::{IdImage, Image, PixelId};

use crate::device::Gpu;
use crate::error::GpuError;
use crate::pipelines::{COLOR_FORMAT, DEPTH_FORMAT, ID_FORMAT};

/// Colours or ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    Colors,
    Ids,
}

/// A picture on the GPU with the depth buffers that go with it. The colours are in a texture of their own
/// ([`Target::color`]) that other passes may sample or copy.
#[derive(Debug)]
pub struct Target {
    width: u32,
    height: u32,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// Several samples a pixel, drawn into the picture at the end.
    pub(crate) multisampled: Option<wgpu::TextureView>,
    pub(crate) depth: wgpu::TextureView,
    pub(crate) limit: wgpu::TextureView,
    pub(crate) content: Content,
}

impl Target {
    /// A target of this size; `samples` (1 or 4) a pixel smooth edges.
    ///
    /// # Errors
    /// When a side is 0 or longer than [`Gpu::longest_side`].
    pub fn new(gpu: &Gpu, width: u32, height: u32, samples: u32) -> Result<Self, GpuError> {
        Self::with_content(gpu, width, height, samples, Content::Colors)
    }

    /// A target for ids.
    pub(crate) fn for_ids(gpu: &Gpu, width: u32, height: u32) -> Result<Self, GpuError> {
        Self::with_content(gpu, width, height, 1, Content::Ids)
    }

    fn with_content(
        gpu: &Gpu,
        width: u32,
        height: u32,
        samples: u32,
        content: Content,
    ) -> Result<Self, GpuError> {
        let max = gpu.longest_side();
        if !(1..=max).contains(&width) || !(1..=max).contains(&height) {
            return Err(GpuError::Size { width, height, max });
        }
        use wgpu::TextureUsages as Usage;
        let make = |format, samples, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("target"),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: Usage::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let format = match content {
            Content::Colors => COLOR_FORMAT,
            Content::Ids => ID_FORMAT,
        };
        let texture = make(format, 1, Usage::TEXTURE_BINDING | Usage::COPY_SRC);
        Ok(Target {
            width,
            height,
            view: view(&texture),
            texture,
            multisampled: (samples > 1).then(|| view(&make(format, samples, Usage::empty()))),
            depth: view(&make(DEPTH_FORMAT, samples, Usage::empty())),
            limit: view(&make(DEPTH_FORMAT, 1, Usage::TEXTURE_BINDING)),
            content,
        })
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The colours, `Rgba8Unorm`, gamma-encoded as they are to be shown (`rendering.md` 9.7).
    pub fn color(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Reads the colours back.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn image(&self, gpu: &Gpu) -> Result<Image, GpuError> {
        let bytes = self.read(gpu, 4)?;
        let mut image = Image::new(self.width, self.height, [0; 4])?;
        for (pixel, c) in image.pixels_mut().iter_mut().zip(bytes.chunks_exact(4)) {
            *pixel = [c[0], c[1], c[2], 255];
        }
        Ok(image)
    }

    /// Reads ids back.
    pub(crate) fn id_image(&self, gpu: &Gpu) -> Result<IdImage, GpuError> {
        let bytes = self.read(gpu, 8)?;
        let word = |b: &[u8]| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let ids = bytes
            .chunks_exact(8)
            .map(|b| PixelId(word(b) << 32 | word(&b[4..])))
            .collect();
        IdImage::from_ids(self.width, self.height, ids)
            .ok_or_else(|| GpuError::ReadBack("it came back with another size".to_owned()))
    }

    fn read(&self, gpu: &Gpu, bytes_per_pixel: u32) -> Result<Vec<u8>, GpuError> {
        gpu.check()?;
        let row = self.width * bytes_per_pixel;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: u64::from(padded) * u64::from(self.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: None,
                },
            },
            self.texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let (tell, told) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody waits any more: nothing to tell.
            let _ = tell.send(result);
        });
        gpu.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| GpuError::ReadBack(e.to_string()))?;
        gpu.check()?;
        match told.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(GpuError::ReadBack(e.to_string())),
            Err(e) => return Err(GpuError::ReadBack(e.to_string())),
        }
        let range = buffer
            .get_mapped_range(..)
            .map_err(|e| GpuError::ReadBack(e.to_string()))?;
        let mut out = Vec::with_capacity(row as usize * self.height as usize);
        for line in range.chunks_exact(padded as usize) {
            out.extend_from_slice(&line[..row as usize]);
        }
        Ok(out)
    }
}
