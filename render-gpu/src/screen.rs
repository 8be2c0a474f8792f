//! Pictures as screens show them, without leaving the device.

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
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl GpuDisplay {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`GpuError`] where the device refuses it.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        gpu.scoped("the kernel of a display", || {
            let (device, label) = (gpu.device(), Some("display_pixels"));
            let text = wgpu::ShaderSource::Wgsl(join(&[&DISPLAY]).into());
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source: text });
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &ENTRIES });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label,
                bind_group_layouts: &[Some(&layout)],
                ..Default::default()
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label,
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: label,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            Self { gpu: gpu.clone(), layout, pipeline }
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
            let (device, label) = (self.gpu.device(), Some("display_pixels"));
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
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label,
                layout: &self.layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&source) },
                    wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&shown) },
                ],
            });
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes: None });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(width.div_ceil(TILE), height.div_ceil(TILE), 1);
            drop(pass);
            self.gpu.queue().submit([encoder.finish()]);
            texture
        })
    }
}

const ENTRIES: [wgpu::BindGroupLayoutEntry; 3] = {
    const fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
        wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
    }
    let view_dimension = wgpu::TextureViewDimension::D2;
    [
        entry(
            0,
            wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
        ),
        entry(
            1,
            wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension,
                multisampled: false,
            },
        ),
        entry(
            2,
            wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format: wgpu::TextureFormat::Rgba8Unorm,
                view_dimension,
            },
        ),
    ]
};
