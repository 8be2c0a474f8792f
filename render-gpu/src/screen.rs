//! Pictures as screens show them, without leaving the device.

use crate::pipeline::{Pipeline, buffer, entry, written};
use crate::wgsl::DISPLAY;
use crate::{Gpu, GpuError, GpuPicture, TILE};
use lobe_core::wgsl::join;
use pictures::{Display, ToneMap};
use wgpu::util::DeviceExt;

/// Numbers of tone maps in display.wgsl; any other is [`ToneMap::Soft`].
pub(crate) const LINEAR: u32 = 1;
pub(crate) const NEUTRAL: u32 = 2;
pub(crate) const AGX: u32 = 3;

/// Turns pictures on a device into textures for a screen: the bytes of [`Display::bytes`] with eight bits a channel, dither included, in
/// [`Rgba8Unorm`](wgpu::TextureFormat::Rgba8Unorm) with alpha 1. The values are encoded as sRGB.
///
/// # Accuracy
/// A channel differs from the CPU's by at most one level, where rounding in f32 decides which of two levels dither takes.
///
/// # Cost
/// One pass over the pixels. No byte of the picture goes to the CPU.
#[derive(Debug)]
pub struct GpuDisplay {
    gpu: Gpu,
    pipeline: Pipeline,
}

impl GpuDisplay {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`GpuError`] where the device refuses it.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        gpu.scoped("the kernel of a display", || {
            let pipeline = Pipeline::new(gpu.device(), "display_pixels", join(&[&DISPLAY]), &ENTRIES);
            Self { gpu: gpu.clone(), pipeline }
        })
    }

    /// The device.
    #[must_use]
    pub const fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// A new texture that shows a picture of the same device. Submits to the queue and does not wait: what is submitted later sees it
    /// whole. [`Display::depth`] is not used.
    ///
    /// # Errors
    /// [`GpuError`]; [`GpuError::Refused`] for a picture of another device.
    pub fn show(&self, picture: &GpuPicture, display: &Display) -> Result<wgpu::Texture, GpuError> {
        let [width, height] = picture.size();
        let tone = match display.tone {
            ToneMap::Linear => LINEAR,
            ToneMap::Neutral => NEUTRAL,
            ToneMap::Agx => AGX,
            _ => 0,
        };
        let look = [display.exposure.exp2().to_bits(), tone, 0, 0];
        self.gpu.scoped("the commands of a display", || {
            let (device, label) = (self.gpu.device(), Some(self.pipeline.label()));
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label,
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::STORAGE_BINDING
                    | wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            let uniform = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label,
                contents: bytemuck::cast_slice(&look),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let [source, shown] = [picture.texture(), &texture].map(|texture| texture.create_view(&Default::default()));
            let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
            let entries = [
                entry(0, uniform.as_entire_binding()),
                entry(1, wgpu::BindingResource::TextureView(&source)),
                entry(2, wgpu::BindingResource::TextureView(&shown)),
            ];
            let group = self.pipeline.group(device, &entries);
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
            self.pipeline.record(&mut encoder, (&group, &[]), [width, height].map(|side| side.div_ceil(TILE)));
            self.gpu.queue().submit([encoder.finish()]);
            texture
        })
    }
}

const ENTRIES: [wgpu::BindGroupLayoutEntry; 3] = [
    entry(0, buffer(wgpu::BufferBindingType::Uniform)),
    entry(
        1,
        wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
    ),
    entry(2, written(wgpu::TextureFormat::Rgba8Unorm)),
];
