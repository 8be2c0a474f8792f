use crate::layout::GpuReceiver;
use crate::pipeline::{Pipeline, READ, buffer, entry, written};
use crate::wgsl::TEXTURE_WRITER;
use crate::{Gpu, GpuError, TILE};
use core::num::NonZeroU64;
use lobe_core::wgsl::join;
use wgpu::util::DeviceExt;

/// Writes radiance to a caller's texture: linear RGB, and alpha 0 where a pixel has no point ([`NO_MATERIAL`](crate::NO_MATERIAL)),
/// else 1.
///
/// A `width`×`height` picture has one point a pixel, tile by tile of 8 × 8 pixels, from left to right, top to bottom, and in the
/// same order within a tile ([`place`](Self::place)). Tiles that reach over the edge have all their 64 points
/// ([`points`](Self::points)). The points of [`GpuGBuffer`](crate::GpuGBuffer) are in this order; neighbours in the list are
/// neighbours in space, which makes culling effective.
///
/// ```no_run
/// # fn of(gpu: &render_gpu::Gpu, shader: &mut render_gpu::GpuShader, frame: &scene::Frame<'_>, points: &wgpu::Buffer,
/// # radiance: &wgpu::Buffer, texture: &wgpu::Texture) -> Result<(), render_gpu::GpuError> {
/// use render_gpu::GpuTextureWriter;
/// let writer = GpuTextureWriter::new(gpu, texture.format())?;
/// shader.submit(frame, points, GpuTextureWriter::points(texture.width(), texture.height()), radiance)?;
/// writer.submit(gpu, points, radiance, texture)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct GpuTextureWriter {
    format: wgpu::TextureFormat,
    pipeline: Pipeline,
}

impl GpuTextureWriter {
    /// Compiles the kernel for textures of a format: `Rgba16Float` or `Rgba32Float`.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for other formats.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Result<Self, GpuError> {
        let name = match format {
            wgpu::TextureFormat::Rgba16Float => "rgba16float",
            wgpu::TextureFormat::Rgba32Float => "rgba32float",
            other => {
                let message =
                    format!("write radiance to a texture of format {other:?}; use Rgba16Float or Rgba32Float");
                return Err(GpuError::Unsupported(message));
            }
        };
        let binding = format!("@group(0) @binding(10) var target_texture: texture_storage_2d<{name}, write>;");
        let text = binding + &join(&[&TEXTURE_WRITER]);
        let entries = [
            entry(0, buffer(wgpu::BufferBindingType::Uniform)),
            entry(1, READ),
            entry(3, READ),
            entry(10, written(format)),
        ];
        gpu.scoped("the kernel of a texture writer", || {
            let pipeline = Pipeline::new(gpu.device(), "write_points", text, &entries);
            Self { format, pipeline }
        })
    }

    /// Number of points of a picture.
    #[must_use]
    pub const fn points(width: u32, height: u32) -> u32 {
        width.div_ceil(TILE) * height.div_ceil(TILE) * TILE * TILE
    }

    /// The place of a pixel's point among them.
    #[must_use]
    pub const fn place(width: u32, x: u32, y: u32) -> u32 {
        (y / TILE * width.div_ceil(TILE) + x / TILE) * (TILE * TILE) + y % TILE * TILE + x % TILE
    }

    /// Writes every pixel of a texture (two-dimensional, with the usage `STORAGE_BINDING`) from the points and radiances in the
    /// layout of [`GpuShader::submit`](crate::GpuShader::submit). Submits to the queue and does not wait.
    ///
    /// # Errors
    /// [`GpuError`]; [`GpuError::Refused`] for buffers that are too small, and textures of another format or usage.
    pub fn submit(
        &self,
        gpu: &Gpu,
        points: &wgpu::Buffer,
        radiance: &wgpu::Buffer,
        texture: &wgpu::Texture,
    ) -> Result<(), GpuError> {
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.record(gpu, points, radiance, texture, &mut encoder)?;
        gpu.scoped("the commands of a texture writer", || {
            gpu.queue().submit([encoder.finish()]);
        })
    }

    /// As [`submit`](Self::submit), but writes the commands into the caller's encoder, which the caller submits.
    ///
    /// # Errors
    /// As [`submit`](Self::submit).
    pub fn record(
        &self,
        gpu: &Gpu,
        points: &wgpu::Buffer,
        radiance: &wgpu::Buffer,
        texture: &wgpu::Texture,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), GpuError> {
        const POINT: u64 = size_of::<GpuReceiver>() as u64;
        if texture.format() != self.format {
            let (reason, what) = (format!("it is made for {:?}", self.format), "a texture");
            return Err(GpuError::Refused { what, reason });
        }
        let [columns, rows] = [texture.width().div_ceil(TILE), texture.height().div_ceil(TILE)];
        let in_row = u64::from(columns * TILE * TILE);
        // As many rows of tiles as fit a binding.
        let most = gpu.device().limits().max_storage_buffer_binding_size / (POINT * in_row);
        let band = rows.min(most.max(1) as u32);
        gpu.scoped("the commands of a texture writer", || {
            let device = gpu.device();
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            let mut first = 0;
            while first < rows {
                let count = band.min(rows - first);
                let part = |buffer, size: u64| {
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer,
                        offset: u64::from(first) * in_row * size,
                        size: NonZeroU64::new(u64::from(count) * in_row * size),
                    })
                };
                let uniform = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                    label: Some("band"),
                    contents: bytemuck::bytes_of(&[first, 0, 0, 0]),
                    usage: wgpu::BufferUsages::UNIFORM,
                });
                let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
                let entries = [
                    entry(0, uniform.as_entire_binding()),
                    entry(1, part(points, POINT)),
                    entry(3, part(radiance, 16)),
                    entry(10, wgpu::BindingResource::TextureView(&view)),
                ];
                let group = self.pipeline.group(device, &entries);
                self.pipeline.record(encoder, (&group, &[]), [columns, count]);
                first += count;
            }
        })
    }
}
