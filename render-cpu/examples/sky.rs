//! The price and the error of a whole sky: one buffer a receiver beside a mask for each patch.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example sky [-- SCENE…] [SIDE]` prints a table in Markdown: scenes × resolutions of the
//! buffer, pictures of SIDE² points (256). Times are of one thread's processor, the least of three; errors those of every 16th point against
//! 36 864 exact rays, in % of the unshadowed radiance, over points that see from 1 to 99 % of it. Meshes that are not there are left out.

#[path = "../tests/sky/oracle.rs"]
mod oracle;

use brdf::{Material, MetallicRoughness, ModifiedPhong};
use core::f32::consts::PI;
use glam::{UVec2, Vec3};
use lighting::{Environment, EnvironmentMap, Light};
use lobe_core::Sphere;
use oracle::errors;
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SkyShader, SurfaceHits, World};
use scene::{Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, ShadingPoints};
use scene_files::load_objects;
use shading::Accuracy;
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use visibility_mask::MaskVisibility;
use visibility_mask::sky::{SkyResolution, SkyTable};
use visibility_silhouettes::SilhouetteBlockers;

/// One point in so many is compared with rays.
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

/// A mesh of the assets beside this repository, 1.2 high on the floor.
fn file(name: &str) -> Result<Mesh, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets/meshes").join(name);
    let mut objects = load_objects(path, None)?.0;
    let scene::Shape::Mesh(mut mesh) = objects.swap_remove(0).shape else { return Err("no mesh".into()) };
    let bounds = mesh.bounds();
    let scale = 1.2 / (bounds.max.y - bounds.min.y);
    let base = Vec3::new(bounds.center().x, bounds.min.y, bounds.center().z);
    mesh.positions.iter_mut().for_each(|p| *p = (*p - base) * scale);
    mesh.smooth_normals();
    Ok(mesh)
}

fn scene(mesh: Mesh, material: &Material, side: u32) -> Scene {
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 6.0, Vec3::NEG_Z * 6.0);
    Scene {
        camera: Camera {
            eye: Vec3::new(0.8, 1.9, 3.3),
            target: Vec3::new(0.0, 0.5, 0.0),
            up: Vec3::Y,
            projection: Projection::perspective(0.66),
        },
        width: side,
        height: side,
        materials: vec![material.clone()],
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::mesh("mesh", mesh, 0, Proxy::Count(8))],
        ..Scene::default()
    }
}

fn soft(v: Vec3) -> Vec3 {
    let glow = v.dot(Vec3::new(0.6, 0.7, 0.4).normalize()).max(0.0).powi(24);
    let dome = if v.y > 0.0 { 0.25 + 0.75 * v.y.sqrt() } else { 0.2 + 0.05 * v.y };
    Vec3::new(0.7, 0.85, 1.1) * dome + Vec3::new(6.0, 5.4, 4.5) * glow
}

/// A hard window of 16° by 22° in four panes.
fn window(v: Vec3) -> Vec3 {
    let (turn, height) = (v.x.atan2(-v.z).to_degrees(), v.y.asin().to_degrees());
    let place = [(turn - 30.0) / 16.0, (height - 40.0) / 22.0];
    let is_pane = place.iter().all(|x| (0.0..1.0).contains(x) && (x - 0.5).abs() > 0.03);
    Vec3::splat(if is_pane { 20.0 } else { 0.15 })
}

fn environment(radiance: impl Fn(Vec3) -> Vec3) -> Environment {
    let size = UVec2::new(512, 256);
    let texel = |k: u32| {
        let turn = (((k % size.x) as f32 + 0.5) / size.x as f32 - 0.5) * 2.0 * PI;
        let down = ((k / size.x) as f32 + 0.5) / size.y as f32 * PI;
        radiance(Vec3::new(turn.sin() * down.sin(), down.cos(), -turn.cos() * down.sin()))
    };
    let map = EnvironmentMap::new(size, (0..size.x * size.y).map(texel).collect()).expect("a picture of this size");
    Environment::new(map, 2, Sphere { center: Vec3::ZERO, radius: 10.0 })
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
