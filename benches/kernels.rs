//! What one call of each kernel costs. `cargo bench -p cosine-lobes`.

use cosine_lobes::brdf::{Lambert, Material, ModifiedPhong};
use cosine_lobes::lighting::{MaskVisibility, SphereLight};
use cosine_lobes::lobe_core::{
    Cone, Coverage, Lobe, OWN_NONE, Receiver, Sphere, Unshadowed, VisibilityLobes, VisibilityQuery, VisibilitySum,
    cap_integral, product_integral, visible_fraction,
};
use cosine_lobes::render_cpu::CpuShader;
use cosine_lobes::scene::{Frame, Shade, ShadingPoints};
use cosine_lobes::visibility_spheres::SphereBlockers;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use std::hint::black_box;

fn receiver(position: Vec3) -> Receiver {
    Receiver { position, normal: Vec3::Y, face: Vec3::Y, view: Vec3::new(0.0, 0.8, 0.6), object: OWN_NONE }
}

/// `P(e₁, e₂, α)`: the saddle-point form, and the low one.
fn product(c: &mut Criterion) {
    let mut group = c.benchmark_group("product_integral");
    let axis = Vec3::new(0.1, 0.0, 1.0).normalize();
    for exponents in [(20.0, 300.0), (1000.0, 1e5), (1.5, 300.0)] {
        group.throughput(Throughput::Elements(1));
        group.bench_function(BenchmarkId::from_parameter(format!("{exponents:?}")), |b| {
            b.iter(|| product_integral(black_box(exponents.0), exponents.1, Vec3::Z, black_box(axis)));
        });
    }
}

/// One reflectance lobe over a whole light, by exponent: closed, chords, slab.
fn unshadowed(c: &mut Criterion) {
    let mut group = c.benchmark_group("cap_integral");
    let at = receiver(Vec3::ZERO);
    let cone = Cone { axis: Vec3::new(0.3, 0.9, 0.0).normalize(), one_minus_cos: 0.0097, distance: 5.0 };
    for exponent in [1.0, 20.0, 200.0, 2000.0] {
        let axis = if exponent == 1.0 { at.normal } else { Vec3::new(0.25, 0.9, 0.1).normalize() };
        let lobe = Lobe::new(axis, exponent, Vec3::ONE);
        group.bench_function(BenchmarkId::from_parameter(exponent), |b| {
            b.iter(|| cap_integral(black_box(&at), &lobe, &cone));
        });
    }
}

/// A penumbra point: mask, lobes and integration, by exponent.
fn penumbra_point(c: &mut Criterion) {
    let mut group = c.benchmark_group("penumbra_point");
    let at = receiver(Vec3::ZERO);
    let light = SphereLight::new(Sphere { center: Vec3::new(0.0, 10.0, 0.0), radius: 1.4 }, Vec3::ONE);
    let blockers: Vec<Sphere> =
        (0..8).map(|i| Sphere { center: Vec3::new(0.12 * i as f32, 5.0, 0.3), radius: 0.2 }).collect();
    for depth in [4, 5, 6] {
        let strategy = MaskVisibility::new(SphereBlockers::new(&blockers, &[0; 8], &[]), depth);
        let mut scratch = strategy.scratch();
        let mut sum = VisibilitySum::with_capacity(strategy.max_lobes());
        let cone = Cone::of_sphere(at.position, light.ball);
        let query = VisibilityQuery { at: &at, cone: &cone, tolerance: 0.003 };
        for exponent in [1.0, 20.0, 2000.0] {
            let lobe = Lobe::new(Vec3::Y, exponent, Vec3::ONE);
            let unshadowed = cap_integral(&at, &lobe, &cone);
            group.bench_function(BenchmarkId::new(format!("depth {depth}"), exponent), |b| {
                b.iter(|| {
                    assert_eq!(strategy.coverage(black_box(&query), &mut scratch), Coverage::Partial);
                    strategy.visibility_lobes(&query, &lobe, unshadowed, &mut scratch, &mut sum).expect("room");
                    visible_fraction(&at, &lobe, unshadowed, &sum)
                });
            });
        }
    }
}

/// A frame of a floor under a cluster of balls, points given.
fn frame(c: &mut Criterion) {
    let side = 128;
    let mut points = ShadingPoints::default();
    for tile in 0..side / 8 * (side / 8) {
        for pixel in 0..64 {
            let (x, z) = (tile % (side / 8) * 8 + pixel % 8, tile / (side / 8) * 8 + pixel / 8);
            let at = |i: usize| 4.0 * (i as f32 + 0.5) / side as f32 - 2.0;
            points.receivers.push(receiver(Vec3::new(at(x), 0.0, at(z))));
            points.materials.push(0);
        }
    }
    let spheres: Vec<Sphere> = (0..64)
        .map(|i| {
            let (a, h) = (i as f32 * 2.4, i as f32 / 64.0);
            Sphere { center: Vec3::new(0.5 * h * a.cos(), 0.5 + 0.8 * h, 0.5 * h * a.sin()), radius: 0.12 }
        })
        .collect();
    let lights = [SphereLight::new(Sphere { center: Vec3::new(1.0, 4.5, 0.5), radius: 0.5 }, Vec3::splat(20.0))];
    let materials: [(&str, Material); 2] = [
        ("diffuse", Lambert { albedo: Vec3::splat(0.7) }.into()),
        ("glossy", ModifiedPhong { kd: Vec3::splat(0.2), ks: Vec3::splat(0.3), exponent: 100.0 }.into()),
    ];
    let mut group = c.benchmark_group("frame");
    group.sample_size(10).throughput(Throughput::Elements(points.receivers.len() as u64));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    for (name, material) in materials {
        let materials = [material];
        let frame = Frame { materials: &materials, lights: &lights, tolerance: 0.003, depth: 5, threshold: 0.0 };
        group.bench_function(BenchmarkId::new("none", name), |b| {
            let mut shader = CpuShader::new(Unshadowed);
            b.iter(|| shader.shade(&points, &frame, &mut out).expect("room"));
        });
        let blockers = SphereBlockers::new(&spheres, &vec![0; spheres.len()], &[]);
        group.bench_function(BenchmarkId::new("64 spheres", name), |b| {
            let mut shader = CpuShader::new(MaskVisibility::new(blockers.clone(), 5));
            b.iter(|| shader.shade(&points, &frame, &mut out).expect("room"));
        });
    }
    group.finish();
}

criterion_group!(benches, product, unshadowed, penumbra_point, frame);
criterion_main!(benches);
