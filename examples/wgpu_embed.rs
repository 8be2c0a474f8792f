//! Draws into a texture of a program that has a wgpu device, queue and textures of its own.
//!
//! `cargo run --release --example wgpu_embed [-- PREFIX]` draws the built-in scene, moves a light, draws it again, and writes
//! the texture to PREFIX-0.png and PREFIX-1.png (`embed` unless given). Any adapter will do, also a software
//! one; without an adapter it prints a message and ends with 1.

use cosine_lobes::render_cpu::blockers;
use cosine_lobes::render_gpu::{Gpu, GpuGBuffer, GpuShader, GpuTextureWriter, Occlusion};
use cosine_lobes::scene::{Frame, builtin};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use glam::Vec3;
use std::error::Error;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::time::Instant;

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

fn main() -> ExitCode {
    match pollster::block_on(run()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("wgpu_embed: {error}");
            ExitCode::FAILURE
        }
    }
}

async fn run() -> Result<(), Box<dyn Error>> {
    // The program's own device and queue.
    let (device, queue) = device().await?;
    let size = wgpu::Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });

    // Once: the blockers, the visible points, memory for their radiance.
    let mut scene = builtin();
    let set = blockers(&scene, &mut |_, _| ControlFlow::Continue(()))?;
    let spheres = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
    let spheres = spheres.with_self_shadows(&set.self_shadows);
    let gpu = Gpu::from_device(device.clone(), queue.clone());
    let mut shader = GpuShader::new(&gpu, Occlusion::of(&[&spheres]))?;
    let writer = GpuTextureWriter::new(&gpu, texture.format())?;
    let mut view = GpuGBuffer::new(&gpu, &scene)?;
    let points = view.trace(&scene.camera, WIDTH, HEIGHT, 0..WIDTH, 0..HEIGHT)?;
    let radiance = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("radiance"),
        size: 16 * u64::from(points.count),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });

    // Each frame: a light that has moved is 256 bytes for the GPU, nothing else is uploaded.
    let prefix = std::env::args().nth(1).unwrap_or_else(|| "embed".to_owned());
    println!("{}: {WIDTH}×{HEIGHT}, {} spheres", gpu.name(), spheres.spheres().len());
    for picture in 0..2 {
        let start = Instant::now();
        let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.003));
        shader.submit(&frame, points.buffer, points.count, &radiance)?;
        writer.submit(&gpu, points.buffer, &radiance, &texture)?;
        let texels = read(&device, &queue, &texture)?;
        println!("picture {picture}: {:.0} ms, read back", 1e3 * start.elapsed().as_secs_f64());
        save(&format!("{prefix}-{picture}.png"), &texels, scene.background)?;
        if let Some(light) = scene.lights[0].as_sphere_mut() {
            light.sphere.center += Vec3::new(-3.0, 0.5, 0.0);
        }
    }
    Ok(())
}

async fn device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.map_err(
        |_| "no GPU adapter; install a Vulkan driver (a software one: packages libvulkan1 and mesa-vulkan-drivers)",
    )?;
    // Every device has eight storage buffers a kernel; higher limits of sizes are useful.
    let required_limits = adapter.limits();
    Ok(adapter.request_device(&wgpu::DeviceDescriptor { required_limits, ..Default::default() }).await?)
}

/// Reads the texture.
fn read(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<Vec<[f32; 4]>, Box<dyn Error>> {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read-back"),
        size: 16 * u64::from(WIDTH * HEIGHT),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    // Rows are a multiple of 256 bytes, as copies want them, because the width is one of 16.
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * WIDTH), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    let (sender, mapped) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
    device.poll(wgpu::PollType::wait_indefinitely())?;
    mapped.recv()??;
    let texels = bytemuck::cast_slice(&buffer.slice(..).get_mapped_range()?).to_vec();
    Ok(texels)
}

/// Over the background, as sRGB.
fn save(path: &str, texels: &[[f32; 4]], background: Vec3) -> Result<(), Box<dyn Error>> {
    let over = |[r, g, b, a]: &[f32; 4]| Vec3::new(*r, *g, *b) + background * (1.0 - a);
    let picture = Picture::new(WIDTH as usize, HEIGHT as usize, texels.iter().map(over).collect());
    Ok(write_png(Output::create(path)?, WIDTH as usize, HEIGHT as usize, &srgb_bytes(&picture, 0.0))?)
}
