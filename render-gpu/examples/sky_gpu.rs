//! The price and the error of a whole sky on a GPU: one buffer a point beside a mask for each patch, and beside the CPU's buffer.
//!
//! `cargo run --release -p cosine-lobes-render-gpu --example sky_gpu [-- SCENE…] [SIDE]` prints a table in Markdown, pictures of SIDE² points (96). Times are of all
//! of the process's processors, which on a software driver are the GPU, without the compilation of kernels; errors those of every 4th point
//! against 36 864 exact rays, in % of the unshadowed radiance, over points that see from 1 to 99 % of it; differences from the CPU are parts of the
//! largest value. A mesh that is not there is left out.

#[path = "../../render-cpu/tests/sky/oracle.rs"]
mod oracle;
#[path = "../../render-cpu/examples/sky/scenes.rs"]
mod scenes;

use brdf::{Material, MetallicRoughness, ModifiedPhong};
use glam::Vec3;
use lighting::{Environment, Light};
use oracle::errors;
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SkyShader, SurfaceHits, World};
use render_gpu::{Gpu, GpuOptions, GpuShader, GpuSky, GpuWorld, Occlusion};
use scene::{Frame, Scene, Shade, ShadingPoints};
use scenes::{environment, file, scene, soft, window};
use shading::Accuracy;
use shading::gpu::GpuBlockers;
use std::error::Error;
use visibility_mask::MaskVisibility;
use visibility_mask::sky::{SkyResolution, SkyTable};
use visibility_silhouettes::{GpuSilhouettes, SilhouetteBlockers};

/// One point of this number is compared with rays.
const SPARSE: usize = 4;
/// Processor time in `/proc/self/stat`, in seconds.
const TICK: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let (sizes, wanted): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.parse::<u32>().is_ok());
    let side = sizes.first().map_or(Ok(96), |side| side.parse())?;
    let gpu = Gpu::blocking(&GpuOptions::default())?;
    println!("{}\n", gpu.name());
    println!("| scene | by | µs a point | mean % | p99 % | largest % | bias % | to CPU: rms | mean | largest |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let lambert = Material::lambert(Vec3::splat(0.7));
    let metal: Material = MetallicRoughness::new(Vec3::splat(0.9), 1.0, 0.4)?.into();
    let phong: Material = ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.5), exponent: 40.0 }.into();
    for (name, material, sky) in [
        ("bunny", &lambert, soft as fn(Vec3) -> Vec3),
        ("window", &lambert, window),
        ("metal", &metal, soft),
        ("phong", &phong, soft),
        ("ambient", &lambert, |_| Vec3::ONE),
    ] {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            match file("bunny.obj") {
                Ok(mesh) => measure(&gpu, name, &scene(mesh, material, side), &environment(sky))?,
                Err(reason) => eprintln!("{name} is left out: {reason}"),
            }
        }
    }
    Ok(())
}

/// Shades all points.
type Shading<'a> = dyn FnMut(&mut [Vec3]) -> Result<(), Box<dyn Error>> + 'a;

/// Seconds that all processors have spent on this process, where the system says.
fn seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = text.rsplit(')').next()?.split_whitespace().skip(11);
    let mut next = || fields.next()?.parse::<f64>().ok();
    Some((next()? + next()?) * TICK)
}

fn measure(gpu: &Gpu, name: &str, scene: &Scene, environment: &Environment) -> Result<(), Box<dyn Error>> {
    let world = World::new(scene);
    let blocks = |object: u32| object > 0;
    let silhouettes = SceneSilhouettes::new(scene, blocks);
    let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
    let sparse = |values: &[Vec3]| values.iter().copied().step_by(SPARSE).collect::<Vec<_>>();
    let few = ShadingPoints {
        receivers: points.receivers.iter().copied().step_by(SPARSE).collect(),
        materials: points.materials.iter().copied().step_by(SPARSE).collect(),
        ..ShadingPoints::default()
    };
    let lights: Vec<Light> = environment.lights().to_vec();
    let replaced = environment.patches_among(&lights).ok_or("the patches are lights")?;
    let accuracy = Accuracy::default();
    let frame: Frame<'_> = Frame::new(&scene.materials, &lights, accuracy);
    let map = environment.sky();
    let table = SkyTable::new(SkyResolution::of_tolerance(accuracy.tolerance), map.size().x, |v| map.radiance(v));
    let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, blocks));
    let mut want = vec![Vec3::ZERO; points.receivers.len()];
    let mut row = |by: &str, shade: &mut Shading<'_>| {
        let mut out = vec![Vec3::ZERO; points.receivers.len()];
        // Compiles.
        shade(&mut out)?;
        let before = seconds();
        shade(&mut out)?;
        let each = seconds().zip(before).map_or(f64::NAN, |(after, before)| after - before);
        let each = each * 1e6 / points.receivers.len() as f64;
        let oracle::Error { mean, p99, largest, bias, .. } = errors(scene, environment, &few, &sparse(&out));
        if by == "CPU" {
            want.clone_from(&out);
        }
        let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
        let apart: Vec<f64> =
            want.iter().zip(&out).map(|(a, b)| f64::from((*a - *b).abs().max_element() / peak)).collect();
        let count = apart.len() as f64;
        let rms = (apart.iter().map(|d| d * d).sum::<f64>() / count).sqrt();
        let [sum, most] = [apart.iter().sum::<f64>() / count, apart.iter().copied().fold(0.0, f64::max)];
        println!(
            "| {name} | {by} | {each:.1} | {mean:.3} | {p99:.2} | {largest:.2} | {bias:+.3} | {rms:.1e} | {sum:.1e} | {most:.1e} |"
        );
        Ok::<(), Box<dyn Error>>(())
    };
    row("CPU", &mut |out| {
        let sky = SkyShader::new([&table], replaced.clone(), &blockers);
        CpuShader::new(MaskVisibility::new(&blockers)).with_sky(sky).shade(&points, &frame, out)?;
        Ok(())
    })?;
    let rays = GpuWorld::only(gpu, scene, blocks)?;
    let own = GpuSilhouettes::new(silhouettes.meshes());
    let own: &[&dyn GpuBlockers] = &[&own];
    let mut shader = GpuShader::new(gpu, Occlusion { blockers: own, any_hit: Some(&rays) })?;
    let packed = GpuSky::new(&table);
    for (by, sky) in [("at once", Some((&packed, replaced.clone()))), ("patches", None)] {
        shader.set_sky(sky);
        row(by, &mut |out| {
            shader.shade(&points, &frame, out)?;
            Ok(())
        })?;
    }
    Ok(())
}
