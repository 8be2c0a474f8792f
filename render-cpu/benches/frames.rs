//! Frames of a floor under a blob of spheres, visible points given: how time grows with points, spheres, lights, the size of
//! a light, the exponent and the depth, and what each strategy costs. `cargo bench -p cosine-lobes-render-cpu`.

use brdf::{Lambert, Material, ModifiedPhong};
use core::time::Duration;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Vec2, Vec3};
use lighting::{Light, SphereLight};
use lobe_core::{Receiver, Sphere};
use ray_tracing::World;
use reference::RayShader;
use render_cpu::CpuShader;
use scene::{
    BlockerSet, Camera, Encoding, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, ShadingPoints, Texture, Wrap,
};
use shading::{Accuracy, Unshadowed};
use std::fmt::Display;
use visibility_mask::MaskVisibility;
use visibility_rays::RayBlockers;
use visibility_spheres::SphereBlockers;

/// The number that a curve varies.
#[derive(Clone)]
struct Case {
    side: usize,
    spheres: usize,
    lights: usize,
    radius: f32,
    exponent: f32,
    depth: u32,
}

const USUAL: Case = Case { side: 64, spheres: 64, lights: 1, radius: 0.5, exponent: 1.0, depth: 5 };

/// A square of the floor, in tiles of 8 × 8 as a G-buffer lists them.
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

/// A sphere of spheres, of the same coverage for every count.
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

impl Case {
    fn lights(&self) -> Vec<Light> {
        let one = |i: usize| {
            let (s, c) = (i as f32 * 2.4).sin_cos();
            let center = Vec3::new(1.2 * c, 4.6, 1.2 * s);
            SphereLight::new(Sphere { center, radius: self.radius }, Vec3::splat(20.0)).into()
        };
        (0..self.lights).map(one).collect()
    }

    fn material(&self) -> Material {
        match self.exponent {
            1.0 => Lambert { albedo: Vec3::splat(0.7) }.into(),
            exponent => ModifiedPhong { kd: Vec3::splat(0.2), ks: Vec3::splat(0.3), exponent }.into(),
        }
    }

    fn run(&self, group: &mut BenchmarkGroup<'_, WallTime>, value: impl Display) {
        let (points, lights, materials) = (points(self.side), self.lights(), [self.material()]);
        let blockers = SphereBlockers::new(&blob(self.spheres), &vec![0; self.spheres], &[]);
        let mut shader = CpuShader::new(MaskVisibility::new(blockers));
        let frame = Frame::new(&materials, &lights, Accuracy { tolerance: 0.005, depth: self.depth });
        let mut out = vec![Vec3::ZERO; points.receivers.len()];
        group.throughput(Throughput::Elements(out.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(value), |b| {
            b.iter(|| shader.shade(&points, &frame, &mut out).expect("room"));
        });
    }
}

fn curves(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame by points");
    [32, 64, 128].into_iter().for_each(|side| Case { side, ..USUAL }.run(&mut group, side * side));
    drop(group);
    let mut group = c.benchmark_group("frame by spheres");
    [64, 256, 1024, 4096].into_iter().for_each(|spheres| Case { spheres, ..USUAL }.run(&mut group, spheres));
    drop(group);
    let mut group = c.benchmark_group("frame by lights");
    [1, 4, 16].into_iter().for_each(|lights| Case { lights, ..USUAL }.run(&mut group, lights));
    drop(group);
    let mut group = c.benchmark_group("frame by radius of the light");
    [0.05, 0.2, 0.5, 1.0, 2.0].into_iter().for_each(|radius| Case { radius, ..USUAL }.run(&mut group, radius));
    drop(group);
    let mut group = c.benchmark_group("frame by exponent");
    [1.0, 20.0, 200.0, 2000.0].into_iter().for_each(|exponent| Case { exponent, ..USUAL }.run(&mut group, exponent));
    drop(group);
    let mut group = c.benchmark_group("frame by depth");
    [3, 4, 5, 6].into_iter().for_each(|depth| Case { depth, ..USUAL }.run(&mut group, depth));
}

/// The same frame by every strategy, and by shadow rays with so many samples.
fn strategies(c: &mut Criterion) {
    let (points, lights, materials) = (points(USUAL.side), USUAL.lights(), [USUAL.material()]);
    let spheres = blob(USUAL.spheres);
    let camera = Camera {
        eye: Vec3::new(0.0, 4.0, 3.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::perspective(0.6),
    };
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 9.0, Vec3::NEG_Z * 9.0);
    let scene = Scene {
        camera,
        width: 64,
        height: 64,
        materials: materials.to_vec(),
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::spheres("spheres", spheres.clone(), 0)],
        lights: lights.clone(),
        ..Scene::default()
    };
    let world = World::new(&scene);
    let set = BlockerSet {
        objects: vec![1; spheres.len()],
        self_distances: vec![0.0; 2],
        self_shadows: Vec::new(),
        spheres: spheres.clone(),
    };
    let frame = Frame::new(&materials, &lights, Accuracy::new(0.005));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let mut group = c.benchmark_group("frame by strategy");
    group.throughput(Throughput::Elements(out.len() as u64));
    let mut none = CpuShader::new(Unshadowed);
    group.bench_function("none", |b| b.iter(|| none.shade(&points, &frame, &mut out).expect("room")));
    let spheres = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
    let mut spheres = CpuShader::new(MaskVisibility::new(spheres));
    group.bench_function("spheres", |b| b.iter(|| spheres.shade(&points, &frame, &mut out).expect("room")));
    let mut rays = CpuShader::new(MaskVisibility::new(RayBlockers::new(&world)));
    group.bench_function("rays", |b| b.iter(|| rays.shade(&points, &frame, &mut out).expect("room")));
    for samples in [16, 256] {
        let mut sampler = RayShader::spheres(&set, samples);
        group.bench_function(format!("{samples} samples"), |b| {
            b.iter(|| sampler.shade(&points, &frame, &mut out).expect("no error"));
        });
    }
}

/// One lookup each, at places and footprints that change: a texel from near, the pyramid, a footprint eight times as long as wide.
fn textures(c: &mut Criterion) {
    let side = 4096;
    let texels = || (0..side * side).map(|i: u32| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect::<Vec<_>>();
    let texture = Texture::new("noise", [side, side], texels(), Encoding::Srgb);
    let mut group = c.benchmark_group("texture lookup");
    group.throughput(Throughput::Elements(4096));
    let step = 1.0 / side as f32;
    // Neighbours of a picture: half a texel, or two and a half, apart.
    for (name, apart, long) in [("near", 0.5, 0.5), ("far", 2.5, 2.5), ("at a low view", 2.5, 20.0)] {
        let footprint = [Vec2::X * apart * step, Vec2::Y * long * step];
        group.bench_function(name, |b| {
            b.iter(|| {
                let at = |i: u32| Vec2::new((i % 64) as f32 * apart, (i / 64) as f32 * long) * step + 0.3;
                (0..4096).map(|i| texture.sample(at(i), footprint, [Wrap::Repeat; 2], false)[0]).sum::<f32>()
            });
        });
    }
    // Any two are pages apart.
    group.bench_function("anywhere", |b| {
        let mut k = 0u32;
        b.iter(|| {
            let mut at = || {
                k = k.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (k >> 8) as f32 / (1 << 24) as f32
            };
            let place = |_| texture.sample(Vec2::new(at(), at()), [Vec2::ZERO; 2], [Wrap::Repeat; 2], false)[0];
            (0..4096).map(place).sum::<f32>()
        });
    });
    group.finish();
    let mut group = c.benchmark_group("texture of 4096 x 4096");
    group.bench_function("pyramid", |b| {
        b.iter_with_setup(texels, |texels| Texture::new("noise", [side, side], texels, Encoding::Srgb));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800));
    targets = curves, strategies, textures
}
criterion_main!(benches);
