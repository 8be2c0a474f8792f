//! Cost and error of the integrals: `cargo bench -p cosine-lobes-lobe-core --features oracle`.

use core::hint::black_box;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use lobe_core::lanes::{WIDTH, set_row};
use lobe_core::oracle::{self, CapLobe, Random};
use lobe_core::{
    Cone, Lobe, PackedLobe, Receiver, Sphere, Tile, TileLight, TileLobes, VisibilitySum, cap_integral, cap_integrals,
    product_of_angle, products_of_angle, visible_fraction,
};

/// Pairs at a time.
const PAIRS: usize = 4096;
/// Receivers of a tile.
const TILE: usize = 64;

/// `P(e₁, e₂, α)` by range of both exponents, α up to 2.5 widths.
fn products(c: &mut Criterion) {
    let mut group = c.benchmark_group("product");
    group.throughput(Throughput::Elements(PAIRS as u64));
    for (name, low, high) in
        [("exponents 8-1e5", 8.0, 1e5), ("exponents 1-1e5", 1.0, 1e5), ("exponents 0-8", 0.01, 8.0)]
    {
        let mut random = Random::new(1);
        let mut exponents = || (0..PAIRS).map(|_| random.log_uniform(low, high) as f32).collect::<Vec<_>>();
        let (e1, e2) = (exponents(), exponents());
        let angles: Vec<f64> = (0..PAIRS)
            .map(|k| random.uniform() * (2.5 * (1.0 / f64::from(e1[k]) + 1.0 / f64::from(e2[k])).sqrt()).min(3.0))
            .collect();
        let y: Vec<f32> = angles.iter().map(|a| (2.0 * (0.5 * a).sin().powi(2)) as f32).collect();
        let mut out = vec![0.0; PAIRS];
        products_of_angle(&e1, &e2, &y, &mut out);
        let errors = (0..PAIRS).step_by(4).filter_map(|k| {
            let angle = 2.0 * (0.5 * f64::from(y[k])).sqrt().asin();
            let want = oracle::product(f64::from(e1[k]), f64::from(e2[k]), angle);
            let coaxial = core::f64::consts::TAU / f64::from(e1[k] + e2[k] + 1.0);
            (want > 1e-4 * coaxial).then(|| (f64::from(out[k]) / want - 1.0).abs())
        });
        print_errors(&format!("product, {name}, relative"), errors.collect());
        group.bench_function(BenchmarkId::new("slices", name), |b| {
            b.iter(|| products_of_angle(black_box(&e1), &e2, &y, black_box(&mut out)));
        });
        group.bench_function(BenchmarkId::new("one by one", name), |b| {
            b.iter(|| {
                for (k, out) in out.iter_mut().enumerate() {
                    *out = product_of_angle(black_box(e1[k]), e2[k], y[k]);
                }
            });
        });
    }
}

/// A tile of receivers under one light of half-angle 6°, one lobe each, by the form that serves.
fn caps(c: &mut Criterion) {
    let mut group = c.benchmark_group("cap");
    group.throughput(Throughput::Elements(TILE as u64));
    for (name, exponent, beta, off) in [
        ("Lambert", 1.0, 0.5, 0.0),
        ("Lambert through the horizon", 1.0, 1.55, 0.0),
        ("6 chords, exponent 50", 50.0, 0.5, 0.1),
        ("10 chords, exponent 300", 300.0, 0.5, 0.05),
        ("out of the lobe's sight", 300.0, 0.5, 0.9),
        ("slab, exponent 2000", 2000.0, 0.5, 0.05),
        ("through the horizon, exponent 50", 50.0, 1.55, 0.1),
        ("exponent 0.5", 0.5, 0.5, 0.1),
    ] {
        let mut random = Random::new(2);
        let (mut at, mut own) = (Vec::new(), Vec::new());
        for _ in 0..TILE {
            let normal = random.axis();
            let light = random.axis_at(normal, beta);
            let axis = if exponent == 1.0 { normal } else { random.axis_at(light, off) };
            at.push(Receiver { position: -light.as_vec3(), ..receiver(normal.as_vec3()) });
            own.push(Lobe::with_flux(axis.as_vec3(), exponent, Vec3::ONE));
        }
        let (mut tile, mut light, mut lobes) = (Tile::default(), TileLight::default(), TileLobes::default());
        tile.set(&at);
        light.sphere(&tile, Sphere { center: Vec3::ZERO, radius: 6.0_f32.to_radians().sin() }, Vec3::ONE);
        lobes.reset(&tile, 1);
        for (k, lobe) in own.iter().enumerate() {
            set_row(lobes.block_mut(0, k / WIDTH), k % WIDTH, &bytemuck::cast(PackedLobe::from(*lobe)));
        }
        let cones: Vec<Cone> = (0..TILE).map(|k| light.cone(k)).collect();
        let mut out = Vec::new();
        cap_integrals(&light, &lobes, &mut out);
        let errors = (0..TILE).map(|k| {
            let (lobe, cone) = (own[k], &cones[k]);
            let truth = CapLobe {
                axis: lobe.axis.as_dvec3().normalize(),
                exponent: f64::from(exponent),
                cosine: false,
                normal: at[k].normal.as_dvec3().normalize(),
            };
            let half_angle = 2.0 * (0.5 * f64::from(cone.one_minus_cos)).sqrt().asin();
            let n = f64::from(exponent) + 1.0;
            let want = oracle::cap(&truth, cone.axis.as_dvec3().normalize(), half_angle) * n / core::f64::consts::TAU;
            let on_axis = -(n * (-f64::from(cone.one_minus_cos)).ln_1p()).exp_m1();
            (f64::from(out[k]) - want).abs() / on_axis
        });
        print_errors(&format!("cap, {name}, of the on-axis value"), errors.collect());
        group.bench_function(BenchmarkId::new("tile", name), |b| {
            b.iter(|| cap_integrals(black_box(&light), &lobes, black_box(&mut out)));
        });
        group.bench_function(BenchmarkId::new("one by one", name), |b| {
            b.iter(|| {
                for (k, out) in out.iter_mut().enumerate() {
                    *out = cap_integral(black_box(&at[k]), own[k], &cones[k]);
                }
            });
        });
    }
}

/// The share that 32 visibility lobes, with as many of the whole light, let through of one reflectance lobe.
fn fractions(c: &mut Criterion) {
    let mut group = c.benchmark_group("fraction");
    group.throughput(Throughput::Elements(64));
    let at = receiver(Vec3::Z);
    let mut random = Random::new(3);
    let mut sum = VisibilitySum::default();
    let (mut lit, mut whole) = (sum.lobes.writer(), sum.whole.writer());
    for _ in 0..32 {
        let lobe = Lobe::with_flux(random.axis_near(glam::DVec3::Z).as_vec3(), 2e4, Vec3::ONE);
        lit.push(Lobe { flux: lobe.flux * random.uniform() as f32, ..lobe });
        whole.push(lobe);
    }
    let axis = Vec3::new(0.1, 0.0, 1.0).normalize();
    for (name, f) in [
        ("Lambert", Lobe::new(Vec3::Z, 1.0, Vec3::ONE)),
        ("exponent 50", Lobe::new(axis, 50.0, Vec3::ONE)),
        ("exponent 50 and cosine", Lobe::new(axis, 50.0, Vec3::ONE).times_cosine()),
        ("exponent 3", Lobe::new(axis, 3.0, Vec3::ONE)),
    ] {
        group.bench_function(name, |b| b.iter(|| visible_fraction(black_box(&at), &f, 0.1, &sum)));
    }
}

fn receiver(normal: Vec3) -> Receiver {
    Receiver::on_surface(Vec3::ZERO, normal, normal)
}

fn print_errors(what: &str, mut errors: Vec<f64>) {
    errors.sort_by(f64::total_cmp);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    println!("error of {what}: mean {mean:.1e}, largest {:.1e}", errors[errors.len() - 1]);
}

criterion_group!(
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(core::time::Duration::from_millis(500))
        .warm_up_time(core::time::Duration::from_millis(200));
    targets = products, caps, fractions
);
criterion_main!(benches);
