//! Frames of a floor under a blob of spheres on the GPU, with given visible points: by points, spheres, lights and strategy. Times
//! are the GPU's own timestamps, if it has them; else those of the call, transfers included. Without a GPU it measures nothing and
//! prints so. `cargo bench -p cosine-lobes-render-gpu --bench gpu`.

use brdf::Material;
use core::time::Duration;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput};
use glam::Vec3;
use lighting::{Light, SphereLight};
use lobe_core::{Receiver, Sphere};
use render_gpu::{Gpu, GpuOptions, GpuShader, GpuWorld, Occlusion};
use scene::{Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, ShadeStats, ShadingPoints, Shape};
use shading::Accuracy;
use visibility_rays::GpuRays;
use visibility_shadowmap::{MapOptions, ShadowMap, ShadowMapBlockers};
use visibility_silhouettes::{GpuSilhouettes, SilhouetteMesh};
use visibility_spheres::SphereBlockers;

/// A square of the floor, in tiles of 8 × 8 as in a G-buffer.
fn points(side: usize) -> ShadingPoints {
    let mut points = ShadingPoints::default();
    let tiles = side / 8;
    let at = |i: usize| 4.0 * (i as f32 + 0.5) / side as f32 - 2.0;
    for tile in 0..tiles * tiles {
        for pixel in 0..64 {
            let (x, z) = (tile % tiles * 8 + pixel % 8, tile / tiles * 8 + pixel / 8);
            let position = Vec3::new(at(x), 0.0, at(z));
            let view = (Vec3::new(0.0, 4.0, 3.0) - position).normalize();
            points.receivers.push(Receiver::on_surface(position, Vec3::Y, view));
            points.materials.push(0);
        }
    }
    points
}

/// Small spheres that fill a sphere, with the same coverage for every count.
fn blob(count: usize) -> Vec<Sphere> {
    let radius = 0.7 * (count as f32).powf(-1.0 / 3.0);
    let one = |i: usize| {
        let t = (i as f32 + 0.5) / count as f32;
        let (s, c) = (i as f32 * 2.399_963).sin_cos();
        let (y, out) = (1.0 - 2.0 * t, (4.0 * t * (1.0 - t)).sqrt());
        let shell = 0.25 * (1.0 + (i % 8) as f32).cbrt();
        Sphere { center: Vec3::new(0.0, 0.8, 0.0) + shell * Vec3::new(out * c, y, out * s), radius }
    };
    (0..count).map(one).collect()
}

fn lights(count: usize) -> Vec<Light> {
    let one = |i: usize| {
        let (s, c) = (i as f32 * 2.4).sin_cos();
        SphereLight::new(Sphere { center: Vec3::new(1.2 * c, 4.6, 1.2 * s), radius: 0.5 }, Vec3::splat(20.0)).into()
    };
    (0..count).map(one).collect()
}

/// The GPU's time, by its own clock if it has one.
fn spent(stats: &ShadeStats) -> Duration {
    let gpu = stats.stages.lighting + stats.stages.mask;
    Duration::from_secs_f64(if gpu > 0.0 { gpu } else { stats.seconds })
}

fn run(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: BenchmarkId,
    shader: &mut GpuShader,
    points: &ShadingPoints,
    lights: &[Light],
) {
    let materials = [Material::lambert(Vec3::splat(0.7))];
    let frame = Frame::new(&materials, lights, Accuracy::new(0.005));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    group.throughput(Throughput::Elements(out.len() as u64));
    group.bench_function(name, |b| {
        b.iter_custom(|times| {
            let mut one = || spent(&shader.shade(points, &frame, &mut out).expect("shaded"));
            (0..times).map(|_| one()).sum()
        });
    });
}

fn curves(c: &mut Criterion, gpu: &Gpu) {
    // A software device takes a thousand times as long.
    let sides: &[usize] = if gpu.is_software() { &[32, 64] } else { &[256, 512, 1024, 1440] };
    let usual = sides[sides.len() - 1];
    let spheres = |count: usize| SphereBlockers::new(&blob(count), &vec![0; count], &[]);
    let shader = |of: &SphereBlockers| GpuShader::new(gpu, Occlusion::of(&[of])).expect("a shader");
    let mut group = c.benchmark_group("gpu frame by points");
    for side in sides {
        let id = BenchmarkId::from_parameter(side * side);
        run(&mut group, id, &mut shader(&spheres(64)), &points(*side), &lights(1));
    }
    drop(group);
    let points = points(usual);
    let mut group = c.benchmark_group("gpu frame by spheres");
    for count in [64, 256, 1024, 4096] {
        run(&mut group, BenchmarkId::from_parameter(count), &mut shader(&spheres(count)), &points, &lights(1));
    }
    drop(group);
    let mut group = c.benchmark_group("gpu frame by lights");
    for count in [1, 4, 16] {
        run(&mut group, BenchmarkId::from_parameter(count), &mut shader(&spheres(64)), &points, &lights(count));
    }
    drop(group);

    let mut group = c.benchmark_group("gpu frame by strategy");
    let lights = lights(1);
    let cube = Mesh::cuboid(Vec3::Y * 0.8, Vec3::splat(0.9));
    let options = MapOptions { resolution: 1024, ..MapOptions::default() };
    let map = ShadowMap::build(&cube.positions, &cube.triangles, lights[0].sphere().expect("a sphere"), &options)
        .expect("a map");
    let maps = ShadowMapBlockers::new(vec![map]).pack();
    let scene = Scene {
        camera: Camera {
            eye: Vec3::new(0.0, 4.0, 3.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::perspective(0.6),
        },
        width: 64,
        height: 64,
        materials: vec![Material::lambert(Vec3::ONE)],
        objects: vec![Object::mesh("cube", cube, 0, Proxy::None)],
        lights: lights.clone(),
        ..Scene::default()
    };
    let world = GpuWorld::only(gpu, &scene, |_| true).expect("a hierarchy");
    let Shape::Mesh(cube) = &scene.objects[0].shape else { unreachable!("a mesh") };
    let silhouettes = GpuSilhouettes::new(&[SilhouetteMesh::new(0, &cube.positions, &cube.triangles)]);
    let (none, spheres) = (Occlusion::default(), spheres(64));
    let strategies = [
        ("none", none),
        ("64 spheres", Occlusion { blockers: &[&spheres], any_hit: None }),
        ("cube by its map", Occlusion { blockers: &[&maps], any_hit: None }),
        ("cube by rays", Occlusion { blockers: &[&GpuRays], any_hit: Some(&world) }),
        ("cube by silhouettes", Occlusion { blockers: &[&silhouettes], any_hit: Some(&world) }),
    ];
    for (name, occlusion) in strategies {
        let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
        run(&mut group, BenchmarkId::from_parameter(name), &mut shader, &points, &lights);
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .configure_from_args();
    match Gpu::blocking(&GpuOptions::default()) {
        Ok(gpu) => {
            println!("GPU: {}{}", gpu.name(), if gpu.is_software() { " (software: no figure is a GPU's)" } else { "" });
            curves(&mut criterion, &gpu);
            criterion.final_summary();
        }
        Err(error) => println!("skipped, nothing is measured: {error}"),
    }
}
