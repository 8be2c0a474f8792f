//! Writes open-cpu.png, and open-gpu.png where there is a GPU.

use cosine_lobes::renderer::{Device, RenderError};
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    for (name, device) in [("open-cpu.png", Device::Cpu), ("open-gpu.png", Device::Gpu)] {
        let mut renderer = match open::scene::renderer(640, 400, device) {
            Err(RenderError::Gpu(error)) => {
                println!("no picture by a GPU: {error}");
                continue;
            }
            renderer => renderer?,
        };
        let picture = Picture::new(640, 400, renderer.render()?.radiance);
        write_png(Output::create(name)?, 640, 400, &srgb_bytes(&picture, 0.0))?;
        println!("{name}");
    }
    Ok(())
}
