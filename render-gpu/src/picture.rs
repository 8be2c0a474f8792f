//! Pictures that stay on the device.

use crate::memory::Memory;
use crate::{Gpu, GpuError};
use glam::Vec3;
use std::sync::{Arc, OnceLock};
use wgpu::{BufferUsages, TextureUsages};

/// Bytes that a row of a copy from a texture is a multiple of.
const ROW: u64 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as u64;
/// Bytes of a pixel.
const PIXEL: u64 = 16;
/// Bytes that are read back at once, unless a row has more.
const AT_ONCE: u64 = 1 << 26;
/// Textures that are kept for later pictures: those of a picture that is made while another is seen, whole or coarse.
const SPARE: usize = 4;

/// A picture in a texture of its device: linear radiance in RGB as [`Rgba32Float`](wgpu::TextureFormat::Rgba32Float), alpha 1. Nothing of it
/// is on the CPU until [`radiance`](Self::radiance) is called.
#[derive(Debug)]
pub struct GpuPicture {
    gpu: Gpu,
    texture: Arc<wgpu::Texture>,
    read: OnceLock<Result<Vec<Vec3>, GpuError>>,
}

impl GpuPicture {
    /// The device.
    #[must_use]
    pub const fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The texture, for kernels and samplers that do not filter.
    #[must_use]
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    /// Linear radiance, row by row: waits for the picture and reads it back, once. Not for browsers, where nothing may wait.
    ///
    /// # Cost
    /// 16 bytes a pixel over the bus at the first call; nothing later.
    ///
    /// # Errors
    /// [`GpuError`] if the device is lost or has no memory; the same at each call.
    pub fn radiance(&self) -> Result<&[Vec3], GpuError> {
        let read = self.read.get_or_init(|| pollster::block_on(self.read_back()));
        read.as_deref().map_err(Clone::clone)
    }

    /// Whether it was read back.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.read.get().is_some()
    }

    async fn read_back(&self) -> Result<Vec<Vec3>, GpuError> {
        let [width, height] = self.size();
        let bytes_per_row = (PIXEL * u64::from(width)).next_multiple_of(ROW);
        let band = (AT_ONCE / bytes_per_row).clamp(1, u64::from(height)) as u32;
        let mut staging = Memory::new("a copy of the picture", BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for top in (0..height).step_by(band as usize) {
            let rows = band.min(height - top);
            let bytes = bytes_per_row * u64::from(rows);
            let buffer = staging.sized(&self.gpu, bytes)?;
            self.gpu.scoped("a copy of the picture", || {
                let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let origin = wgpu::Origin3d { x: 0, y: top, z: 0 };
                let from = wgpu::TexelCopyTextureInfo { origin, ..self.texture.as_image_copy() };
                let layout = wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(bytes_per_row as u32),
                    rows_per_image: None,
                };
                let size = wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 };
                encoder.copy_texture_to_buffer(from, wgpu::TexelCopyBufferInfo { buffer, layout }, size);
                self.gpu.queue().submit([encoder.finish()]);
            })?;
            let take = |bytes: &[u8]| {
                for row in bytes.chunks_exact(bytes_per_row as usize) {
                    let texels = row.chunks_exact(PIXEL as usize).take(width as usize);
                    pixels.extend(texels.map(|texel| {
                        let [r, g, b, _]: [f32; 4] = bytemuck::pod_read_unaligned(texel);
                        Vec3::new(r, g, b)
                    }));
                }
            };
            self.gpu.read(buffer, bytes, take).await?;
        }
        Ok(pixels)
    }
}

/// Textures for pictures: those of pictures that were dropped are used again.
#[derive(Debug, Default)]
pub(crate) struct Textures {
    known: Vec<Arc<wgpu::Texture>>,
}

impl Textures {
    /// An empty picture of this size: its pixels are those of an older one, or zero.
    pub(crate) fn picture(&mut self, gpu: &Gpu, [width, height]: [u32; 2]) -> Result<GpuPicture, GpuError> {
        let most = gpu.device().limits().max_texture_dimension_2d;
        if width.max(height) > most {
            let (needed, allowed) = (width.max(height).into(), most.into());
            return Err(GpuError::Limits { what: "a side of a picture's texture", needed, allowed });
        }
        let is_free = |texture: &Arc<wgpu::Texture>| Arc::strong_count(texture) == 1;
        let fits = |texture: &Arc<wgpu::Texture>| [texture.width(), texture.height()] == [width, height];
        let texture = match self.known.iter().find(|texture| is_free(texture) && fits(texture)) {
            Some(texture) => Arc::clone(texture),
            None => {
                let texture = Arc::new(create(gpu, [width, height])?);
                if self.known.len() >= SPARE
                    && let Some(place) = self.known.iter().position(is_free)
                {
                    self.known.remove(place);
                }
                if self.known.len() < SPARE {
                    self.known.push(Arc::clone(&texture));
                }
                texture
            }
        };
        Ok(GpuPicture { gpu: gpu.clone(), texture, read: OnceLock::new() })
    }
}

fn create(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<wgpu::Texture, GpuError> {
    gpu.scoped("the texture of a picture", || {
        gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    })
}
