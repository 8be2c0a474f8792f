//! The built-in scene shaded by the CPU and by a GPU: the same points, the same frame, the same trait.
//!
//! `cargo run --release --example gpu` prints the time of each and the difference of the pictures, and writes gpu.png.

use cosine_lobes::brdf::Material;
use cosine_lobes::lighting::Light;
use cosine_lobes::render_cpu::{CpuShader, GBuffer, World, blockers};
use cosine_lobes::render_gpu::{Gpu, GpuOptions, GpuShader, Occlusion};
use cosine_lobes::scene::{Frame, Shade, builtin};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use glam::Vec3;
use std::error::Error;
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn Error>> {
    let (width, height, depth) = (960, 540, 5);
    let scene = builtin();
    let g = GBuffer::new(&World::new(&scene), width, height, 1);
    let set = blockers(&scene, &mut |_, _| ControlFlow::Continue(()))?;
    let spheres =
        SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances).with_self_shadows(&set.self_shadows);
    let frame = Frame::new(&g.materials, &scene.lights, Accuracy { tolerance: 0.005, depth });

    let gpu = Gpu::blocking(&GpuOptions::default())?;
    let mut on_gpu = GpuShader::new(&gpu, Occlusion::of(&[&spheres]))?;
    let got = shade(&gpu.name(), &mut on_gpu, &g, &frame)?;
    let want = shade("cpu", &mut CpuShader::new(MaskVisibility::new(&spheres)), &g, &frame)?;

    let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let largest = want.iter().zip(&got).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    println!("largest difference: {:.1e} of the maximum", largest / peak);
    let picture = Picture::new(width as usize, height as usize, g.picture(&got, scene.background));
    Ok(write_png(Output::create("gpu.png")?, width as usize, height as usize, &srgb_bytes(&picture, 0.0))?)
}

/// Radiance of all points. The first time is not counted: kernels are compiled, memory is taken.
fn shade<S>(name: &str, shader: &mut S, g: &GBuffer, frame: &Frame<'_>) -> Result<Vec<Vec3>, Box<dyn Error>>
where
    S: Shade<Material, Light, Error: Error + 'static>,
{
    let mut out = vec![Vec3::ZERO; g.len()];
    shader.shade(&g.points, frame, &mut out)?;
    let stats = shader.shade(&g.points, frame, &mut out)?;
    println!("{name}: {:.2} ms for {} points", 1e3 * stats.seconds, g.len());
    Ok(out)
}
