//! Writes open-cpu.png, and open-gpu.png where there is a GPU.

use cosine_lobes::glam::Vec3;
use cosine_lobes::render_gpu::{Gpu, GpuOptions};
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use open::scene::Own;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let own = Own::new(640, 400);
    let points = own.points();
    let save = |name: &str, radiance: &[Vec3]| -> Result<(), Box<dyn Error>> {
        let picture = Picture::new(640, 400, points.resolve(radiance, Vec3::ZERO));
        write_png(Output::create(name)?, 640, 400, &srgb_bytes(&picture, 0.0))?;
        println!("{name}");
        Ok(())
    };
    save("open-cpu.png", &own.on_cpu(&points)?)?;
    match Gpu::blocking(&GpuOptions::default()) {
        Ok(gpu) => save("open-gpu.png", &own.on_gpu(&gpu, &points)?),
        Err(error) => {
            println!("no picture by a GPU: {error}");
            Ok(())
        }
    }
}
