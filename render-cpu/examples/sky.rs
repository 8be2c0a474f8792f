//! The price and the error of a whole sky: one buffer a receiver beside a mask for each patch.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example sky [-- SCENE…] [SIDE]` prints a table in Markdown: scenes × resolutions of the
//! buffer, pictures of SIDE² points (256). Times are of one thread's processor, the least of three; errors those of every 16th point against
//! 36 864 exact rays, in % of the unshadowed radiance, over points that see from 1 to 99 % of it. Meshes that are not there are left out.

#[path = "../tests/sky/oracle.rs"]
mod oracle;
#[path = "sky/scenes.rs"]
mod scenes;

use brdf::{Material, MetallicRoughness, ModifiedPhong};
use glam::Vec3;
use lighting::{Environment, Light};
use oracle::errors;
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SkyShader, SurfaceHits, World};
use scene::{Frame, Scene, Shade, ShadingPoints};
use scenes::{environment, file, scene, soft, window};
use shading::Accuracy;
use std::error::Error;
use std::time::Instant;
use visibility_mask::MaskVisibility;
use visibility_mask::sky::{SkyResolution, SkyTable};
use visibility_silhouettes::SilhouetteBlockers;

/// One point of this number is compared with rays.
const SPARSE: usize = 16;
/// Rows and samples, and the tolerance for simplified forms.
const RESOLUTIONS: [(usize, usize, f32); 6] =
    [(32, 64, 0.01), (64, 64, 0.005), (96, 64, 0.005), (128, 64, 0.003), (128, 128, 0.003), (256, 128, 0.002)];

fn main() -> Result<(), Box<dyn Error>> {
    let (sizes, wanted): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.parse::<u32>().is_ok());
    let side = sizes.first().map_or(Ok(256), |side| side.parse())?;
    // One thread, so that its own processor time is that of all.
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    println!(
        "| scene | by | µs a point | mean % | p99 % | largest % | bias % | table ms |\n|---|---|---|---|---|---|---|---|"
    );
    let lambert = Material::lambert(Vec3::splat(0.7));
    let metal: Material = MetallicRoughness::new(Vec3::splat(0.9), 1.0, 0.4)?.into();
    let phong: Material = ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.5), exponent: 40.0 }.into();
    for (name, mesh, material, sky) in [
        ("bunny", "bunny.obj", &lambert, soft as fn(Vec3) -> Vec3),
        ("window", "bunny.obj", &lambert, window),
        ("metal", "bunny.obj", &metal, soft),
        ("phong", "bunny.obj", &phong, soft),
        ("armadillo", "armadillo.obj", &lambert, soft),
    ] {
        if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
            continue;
        }
        match file(mesh) {
            Ok(mesh) => alone.install(|| measure(name, &scene(mesh, material, side), &environment(sky))),
            Err(reason) => eprintln!("{name} is left out: {reason}"),
        }
    }
    Ok(())
}

/// Nanoseconds that this thread has run; of the clock where the system does not say.
fn nanoseconds(start: Instant) -> u64 {
    let own = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let own = own.and_then(|text| text.split_whitespace().next()?.parse().ok());
    own.unwrap_or_else(|| start.elapsed().as_nanos() as u64)
}

fn measure(name: &str, scene: &Scene, environment: &Environment) {
    let world = World::new(scene);
    let mut silhouettes = SceneSilhouettes::new(scene, |o| o > 0);
    silhouettes.refit(scene);
    let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
    let sparse = |values: &[Vec3]| values.iter().copied().step_by(SPARSE).collect::<Vec<_>>();
    let few = ShadingPoints {
        receivers: points.receivers.iter().copied().step_by(SPARSE).collect(),
        materials: points.materials.iter().copied().step_by(SPARSE).collect(),
        ..ShadingPoints::default()
    };
    let lights: Vec<Light> = environment.lights().to_vec();
    let start = Instant::now();
    let row = |by: &str, table: f64, shade: &mut dyn FnMut(&mut [Vec3])| {
        let mut out = vec![Vec3::ZERO; points.receivers.len()];
        let mut least = u64::MAX;
        for _ in 0..if by == "patches" { 1 } else { 3 } {
            let before = nanoseconds(start);
            shade(&mut out);
            least = least.min(nanoseconds(start) - before);
        }
        let error = errors(scene, environment, &few, &sparse(&out));
        let each = least as f64 * 1e-3 / points.receivers.len() as f64;
        let oracle::Error { mean, p99, largest, bias, .. } = error;
        println!("| {name} | {by} | {each:.2} | {mean:.3} | {p99:.2} | {largest:.2} | {bias:+.3} | {table:.0} |");
    };
    let blockers = |tolerance: f32| {
        let hits = SurfaceHits::new(&world, |o| o > 0);
        SilhouetteBlockers::new(silhouettes.meshes(), hits).with_tolerance(tolerance).under_sky()
    };
    let accuracy = Accuracy::default();
    let patches = blockers(accuracy.tolerance);
    row("patches", 0.0, &mut |out| {
        let frame: Frame<'_> = Frame::new(&scene.materials, &lights, accuracy);
        CpuShader::new(MaskVisibility::new(&patches)).shade(&points, &frame, out).expect("shaded");
    });
    for (rows, samples, tolerance) in RESOLUTIONS {
        let before = nanoseconds(start);
        let map = environment.sky();
        let table = SkyTable::new(SkyResolution::new(rows, samples), map.size().x, |v| map.radiance(v));
        let made = (nanoseconds(start) - before) as f64 * 1e-6;
        let blockers = blockers(tolerance);
        let replaced = environment.patches_among(&lights).expect("its own lights");
        let frame: Frame<'_> = Frame::new(&scene.materials, &lights, Accuracy::new(tolerance));
        let sky = SkyShader::new([&table], replaced, &blockers);
        let mut shader = CpuShader::new(MaskVisibility::new(&blockers)).with_sky(sky);
        row(&format!("{rows} × {samples}"), made, &mut |out| {
            shader.shade(&points, &frame, out).expect("shaded");
        });
    }
}
