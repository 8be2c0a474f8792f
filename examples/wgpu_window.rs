//! Pictures of a session on a wgpu device of the program's own, as a window has one: how long an edit takes until its picture is a texture
//! that a window can draw, and how many bytes are copied, with pictures that come to the CPU and with pictures that stay on the device.
//!
//! `cargo run --release --example wgpu_window [-- COLUMNS [SCENE]]` moves the first light, then the camera, in pictures of 640 columns unless
//! given. Any adapter will do, also a software one; without an adapter it prints a message and ends with 1.

use cosine_lobes::Display;
use cosine_lobes::glam::{Mat4, Vec3};
use cosine_lobes::render_gpu::{Gpu, GpuDisplay};
use cosine_lobes::renderer::{Backend, PixelSamples, Renderer, Settings, Window};
use cosine_lobes::scene::{self, Animation};
use cosine_lobes::session::{Edit, Picture, Session};
use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

/// Edits of each kind.
const EDITS: usize = 12;

fn main() -> ExitCode {
    match pollster::block_on(run()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("wgpu_window: {error}");
            ExitCode::FAILURE
        }
    }
}

async fn run() -> Result<(), Box<dyn Error>> {
    // The program's own device and queue, with all that kernels may need.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.map_err(
        |_| "no GPU adapter; install a Vulkan driver (a software one: packages libvulkan1 and mesa-vulkan-drivers)",
    )?;
    let (required_features, required_limits) = Gpu::requirements(&adapter);
    let descriptor = wgpu::DeviceDescriptor { required_features, required_limits, ..Default::default() };
    let (device, queue) = adapter.request_device(&descriptor).await?;
    let gpu = Gpu::from_device(device, queue);
    let columns = std::env::args().nth(1).map_or(Ok(640), |columns| columns.parse())?;
    let (mut scene, animation) = match std::env::args().nth(2) {
        Some(path) => {
            let (scene, animation, _) = scene::load_animated(path)?;
            (scene, animation)
        }
        None => (scene::builtin(), Animation::default()),
    };
    (scene.width, scene.height) = (columns, columns * 9 / 16);
    println!("{}, {} x {}", gpu.name(), scene.width, scene.height);
    let settings = Settings { samples: PixelSamples::Edges(8), ..Settings::default() };
    let renderer = Renderer::with_backend(scene, animation, settings, Backend::on(&gpu)?)?;
    let session = Session::new(renderer);
    let screen = Screen { display: GpuDisplay::new(&gpu)?, gpu };
    for stays in [false, true] {
        session.set_on_gpu(stays);
        let (first, eye) = (session.finished().scene.lights[0].clone(), session.finished().scene.camera.eye);
        for (name, of_camera) in [("light", false), ("camera", true)] {
            let (mut times, mut besides) = (Vec::new(), Vec::new());
            for step in 0..EDITS {
                let by = 0.01 * step as f32 * Vec3::X;
                let watch = Instant::now();
                session.edit(match of_camera {
                    true => Edit::Camera(scene::Camera { eye: eye + by, ..session.picture().scene.camera }),
                    false => Edit::Light(first.handle, first.light.moved(Mat4::from_translation(by)).into()),
                });
                let picture = session.finished();
                screen.show(&picture)?;
                let time = 1e3 * watch.elapsed().as_secs_f64();
                let stages = picture.stats.shading.first().map(|shading| shading.stages).unwrap_or_default();
                times.push(time);
                besides.push(time - 1e3 * (stages.lighting + stages.mask));
            }
            for list in [&mut times, &mut besides] {
                list.sort_by(f64::total_cmp);
            }
            let how = if session.picture().is_on_gpu() { "stays" } else { "comes to the CPU" };
            let [time, beside] = [&times, &besides].map(|times| times[EDITS / 2]);
            println!("{name} moves, picture {how}: median {time:.1} ms, {beside:.1} ms of it besides kernels");
            let picture = session.picture();
            let (points, pixels) = (picture.stats.points as f64, picture.size[0] as f64 * picture.size[1] as f64);
            // A point has 64 bytes and its radiance 16; a pixel on a screen has 4. A picture that stays has 4 more for each, with new points.
            let megabytes = match (picture.is_on_gpu(), of_camera) {
                (false, _) => 80.0 * points + 4.0 * pixels,
                (true, true) => 68.0 * points + 4.0 * pixels,
                (true, false) => 0.0,
            };
            println!("  {points} points in {pixels} pixels: {:.2} MB are copied", 1e-6 * megabytes);
        }
    }
    Ok(())
}

struct Screen {
    display: GpuDisplay,
    gpu: Gpu,
}

impl Screen {
    /// A texture for a window; waits until it is there.
    fn show(&self, picture: &Picture) -> Result<wgpu::Texture, Box<dyn Error>> {
        let texture = match &picture.on_gpu {
            Some(picture) => self.display.show(picture, &Display::default())?,
            None => self.upload(picture),
        };
        self.gpu.device().poll(wgpu::PollType::wait_indefinitely())?;
        Ok(texture)
    }

    fn upload(&self, picture: &Picture) -> wgpu::Texture {
        let [width, height] = picture.size;
        let bytes = Display::default().bytes(&picture.radiance, &Window::whole(width, height));
        let texels: Vec<u8> = bytes.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
        let size = wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 };
        let texture = self.gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width as u32), rows_per_image: None };
        self.gpu.queue().write_texture(texture.as_image_copy(), &texels, layout, size);
        self.gpu.queue().submit([]);
        texture
    }
}
