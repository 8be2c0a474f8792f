//! How far the exact strategies, `silhouettes` and `rays`, are from Monte Carlo, and what they cost: a picket fence and, given
//! mesh files as arguments, those, each over a floor under a light of half-angle 6°.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example rays -- bunny.obj`
//!
//! V is the visible fraction of a diffuse receiver's irradiance, in %; receivers with V between 1 and 99 count.

use brdf::Material;
use core::sync::atomic::AtomicBool;
use glam::Vec3;
use lighting::SphereLight;
use lobe_core::Sphere;
use ray_tracing::{GBuffer, World};
use reference::{Geometry, Reference, ReferenceJob};
use render_cpu::{CpuShader, SceneSilhouettes, SurfaceHits};
use scene::{BlockerSet, Camera, Frame, Mesh, Object, Projection, Proxy, Scene, ShadeStats};
use shading::{Accuracy, Visibility};
use visibility_mask::MaskVisibility;
use visibility_rays::RayBlockers;
use visibility_silhouettes::SilhouetteBlockers;

/// Samples of the reference at each receiver.
const SAMPLES: u32 = 16384;
/// Receivers of each kind that are compared.
const COUNT: usize = 600;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run("fence", &fence());
    for file in std::env::args().skip(1) {
        let mut scene = scene_files::load(&file)?;
        scene.materials.fill(Material::lambert(Vec3::splat(0.5)));
        run(&file, &scene);
    }
    Ok(())
}

/// Thin pickets and two rails on a floor.
fn fence() -> Scene {
    let mut mesh = Mesh::default();
    for i in 0..33 {
        let x = (i as f32 - 16.0) * 0.06;
        mesh.append(&Mesh::cuboid(Vec3::new(x, 0.4, 0.0), Vec3::new(0.025, 0.8, 0.015)));
    }
    for y in [0.2, 0.62] {
        mesh.append(&Mesh::cuboid(Vec3::new(0.0, y, 0.015), Vec3::new(2.0, 0.04, 0.015)));
    }
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 6.0, Vec3::NEG_Z * 6.0);
    let toward = Vec3::new(-0.5, 0.9, 0.55).normalize();
    let radius = 4.0 * 6.0_f32.to_radians().sin();
    Scene {
        camera: Camera {
            eye: Vec3::new(1.0, 1.4, 2.6),
            target: Vec3::new(0.1, 0.2, -0.2),
            up: Vec3::Y,
            projection: Projection::perspective(0.6),
        },
        width: 320,
        height: 240,
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::mesh("fence", mesh, 0, Proxy::Count(64))],
        lights: vec![SphereLight::new(Sphere { center: 4.0 * toward, radius }, Vec3::splat(90.0)).into()],
        ..Scene::default()
    }
}

/// Every `len/count`-th of the chosen points, as a G-buffer of its own.
fn some(all: &GBuffer, chosen: &[usize], count: usize) -> GBuffer {
    let mut g = GBuffer { width: 1, height: 1, samples: 1, ..GBuffer::default() };
    for &i in chosen.iter().step_by(chosen.len().div_ceil(count).max(1)) {
        g.points.receivers.push(all.points.receivers[i]);
        g.points.materials.push(all.points.materials[i]);
        g.pixels.push(0);
        g.depths.push(all.depths[i]);
    }
    g
}

/// The figures of errors.
fn row(signed: &[f64]) -> String {
    let n = signed.len().max(1) as f64;
    let mut errors: Vec<f64> = signed.iter().map(|e| e.abs()).collect();
    errors.sort_by(f64::total_cmp);
    format!(
        "mean {:.3} p99 {:.2} max {:.2} bias {:+.3}",
        errors.iter().sum::<f64>() / n,
        errors.get(errors.len() * 99 / 100).unwrap_or(&0.0),
        errors.last().unwrap_or(&0.0),
        signed.iter().sum::<f64>() / n,
    )
}

fn run(name: &str, scene: &Scene) {
    let world = World::new(scene);
    let all = GBuffer::new(&world, 320, 240, 1);
    println!("{name}: {} triangles, {} points", world.triangle_count(), all.len());
    let frame = |depth| Frame::new(&scene.materials, &scene.lights, Accuracy { tolerance: 0.003, depth });
    let shade = |g: &GBuffer, depth: u32, start: usize, bisections: u32| {
        let shader = CpuShader::new(MaskVisibility::new(RayBlockers::with_detail(&world, start, bisections)));
        let (shares, stats) = shares(&shader, g, &frame(depth));
        (shares, stats, shader.visibility().blockers().rays())
    };
    let silhouettes = SceneSilhouettes::new(scene, |_| true);
    let outlines = |g: &GBuffer, depth: u32| {
        let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |_| true));
        shares(&CpuShader::new(MaskVisibility::new(blockers)), g, &frame(depth))
    };
    let (coarse, stats, rays) = shade(&all, 5, 8, 2);
    println!(
        "  lit {}, dark {}, part {}; {} rays, {:.0} ms",
        stats.counts.lit_points,
        stats.counts.dark_points,
        stats.counts.penumbra_points,
        rays,
        1e3 * stats.seconds
    );
    let in_penumbra = |i: &usize| coarse[*i] > 0.005 && coarse[*i] < 0.995;
    for (part, on_floor) in [("floor", true), ("object", false)] {
        let chosen: Vec<usize> =
            (0..all.len()).filter(in_penumbra).filter(|i| (all.points.receivers[*i].object == 0) == on_floor).collect();
        let g = some(&all, &chosen, COUNT);
        let job = ReferenceJob {
            world: &world,
            gbuffer: &g,
            blockers: &BlockerSet::default(),
            geometry: Geometry::Mesh,
            seed: 1,
        };
        let mut reference = Reference::new(job);
        reference.advance(SAMPLES, &AtomicBool::new(false), &|_| {});
        let truth = reference.estimate();
        let share = |i: usize| f64::from(truth.radiance[i].x / truth.unshadowed[i].x);
        let counted: Vec<usize> = (0..g.len()).filter(|&i| (0.01..=0.99).contains(&share(i))).collect();
        let n = counted.len().max(1) as f64;
        let noise = counted.iter().map(|&i| f64::from(truth.std_error[i].x / truth.unshadowed[i].x)).sum::<f64>() / n;
        println!("  {part}: {} penumbra receivers, reference ± {:.3} %", counted.len(), 100.0 * noise);
        let errors = |ours: &[f64]| row(&counted.iter().map(|&i| 100.0 * (ours[i] - share(i))).collect::<Vec<_>>());
        for (depth, start, bisections) in CONFIGURATIONS {
            let (ours, stats, rays) = shade(&g, depth, start, bisections);
            println!(
                "    rays, {}² cells, start {start}², {bisections} bisections: {}, {:.0} rays a point, {:.0} µs",
                1 << depth,
                errors(&ours),
                rays as f64 / g.len() as f64,
                1e6 * stats.stages.mask / g.len() as f64,
            );
        }
        for depth in [4, 5, 6] {
            let (ours, stats) = outlines(&g, depth);
            let time = 1e6 * stats.stages.mask / g.len() as f64;
            println!("    silhouettes, {}² cells: {}, {time:.1} µs", 1 << depth, errors(&ours));
        }
    }
}

/// The visible fraction at each point, and the figures of the run.
fn shares<V: Visibility>(shader: &CpuShader<V>, g: &GBuffer, frame: &Frame<'_>) -> (Vec<f64>, ShadeStats) {
    let mut out = vec![Vec3::ZERO; g.len()];
    let (stats, layers) = shader.shade_layers(&g.points, frame, &mut out);
    let share = |(a, b): (&Vec3, &Vec3)| if b.x > 0.0 { f64::from(a.x / b.x) } else { 0.0 };
    (out.iter().zip(&layers.unshadowed).map(share).collect(), stats)
}

/// Depth, blocks a side, bisections.
const CONFIGURATIONS: [(u32, usize, u32); 12] = [
    (4, 8, 0),
    (4, 8, 2),
    (4, 8, 3),
    (5, 4, 2),
    (5, 8, 0),
    (5, 8, 1),
    (5, 8, 2),
    (5, 8, 3),
    (5, 16, 2),
    (6, 8, 0),
    (6, 8, 2),
    (6, 16, 2),
];
