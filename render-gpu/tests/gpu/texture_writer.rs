//! Radiance in a caller's texture.

use crate::call::{texture_bytes, trial};
use libtest_mimic::Trial;
use render_gpu::{Gpu, GpuError, GpuReceiver, GpuTextureWriter, NO_MATERIAL};
use wgpu::TextureFormat::{Rgba8Unorm, Rgba32Float};
use wgpu::util::DeviceExt;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("texture_writer_has_each_point_at_its_pixel", gpu, each_point_at_its_pixel),
        trial("texture_writer_refuses_other_textures", gpu, other_textures),
    ]
}

fn texture(gpu: &Gpu, format: wgpu::TextureFormat, width: u32, height: u32) -> wgpu::Texture {
    gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn filled(gpu: &Gpu, contents: &[u8]) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE;
    gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

/// The red of pixel (x, y), and whether the pixel has a point.
fn pixel(x: u32, y: u32) -> (f32, bool) {
    (1000.0 * y as f32 + x as f32, !(x + y).is_multiple_of(3))
}

fn each_point_at_its_pixel(gpu: &Gpu) {
    // Copies need rows of 256 bytes, here 16 pixels; neither side is a multiple of a tile.
    for (width, height) in [(16, 8), (48, 27), (16, 1)] {
        let count = GpuTextureWriter::points(width, height) as usize;
        let mut points = vec![GpuReceiver { material: NO_MATERIAL, ..GpuReceiver::default() }; count];
        let mut radiance = vec![[-1.0_f32; 4]; count];
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let place = GpuTextureWriter::place(width, x, y) as usize;
            assert_eq!(radiance[place], [-1.0; 4], "taken");
            let (red, there) = pixel(x, y);
            radiance[place] = [red, 0.25, 1e6, 0.0];
            points[place].material = if there { 0 } else { NO_MATERIAL };
        }
        let texture = texture(gpu, Rgba32Float, width, height);
        let writer = GpuTextureWriter::new(gpu, Rgba32Float).expect("it fits");
        let (points, radiance) =
            (filled(gpu, bytemuck::cast_slice(&points)), filled(gpu, bytemuck::cast_slice(&radiance)));
        writer.submit(gpu, &points, &radiance, &texture).expect("it fits");
        let bytes = texture_bytes(gpu, &texture, 16);
        let texels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        for (i, texel) in texels.iter().enumerate() {
            let (red, there) = pixel(i as u32 % width, i as u32 / width);
            assert_eq!(*texel, [red, 0.25, 1e6, f32::from(u8::from(there))], "{width}×{height} {i}");
        }
    }
}

fn other_textures(gpu: &Gpu) {
    let error = GpuTextureWriter::new(gpu, Rgba8Unorm).expect_err("refused");
    assert!(matches!(&error, GpuError::Unsupported(_)) && error.to_string().contains("Rgba16Float"), "{error}");
    let writer = GpuTextureWriter::new(gpu, Rgba32Float).expect("it fits");
    let buffer = filled(gpu, &[0; 4096]);
    let other = texture(gpu, wgpu::TextureFormat::Rgba16Float, 8, 8);
    let error = writer.submit(gpu, &buffer, &buffer, &other).expect_err("refused");
    assert!(matches!(&error, GpuError::Refused { .. }), "{error}");
    // 4096 bytes are 64 points, 16 × 8 pixels are 128.
    let error = writer.submit(gpu, &buffer, &buffer, &texture(gpu, Rgba32Float, 16, 8)).expect_err("refused");
    assert!(matches!(&error, GpuError::Refused { .. }), "{error}");
    writer.submit(gpu, &buffer, &buffer, &texture(gpu, Rgba32Float, 8, 8)).expect("it fits");
}
