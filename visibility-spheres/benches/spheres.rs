//! The `spheres` strategy, stage by stage: hierarchy, culling of a group, one point. `cargo bench -p cosine-lobes-visibility-spheres`.

use core::time::Duration;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use lobe_core::{Cone, Receiver, Sphere};
use shading::{Accuracy, LightId, Shaft, Visibility, VisibilityQuery};
use std::hint::black_box;
use visibility_mask::{Blockers, MaskVisibility};
use visibility_spheres::SphereBlockers;

const LIGHT: Sphere = Sphere { center: Vec3::new(1.0, 4.6, 0.5), radius: 0.5 };

/// A sphere of spheres over the floor, of the same coverage for every count.
fn blob(count: usize) -> Vec<Sphere> {
    let radius = 0.7 * (count as f32).powf(-1.0 / 3.0);
    let one = |i: usize| {
        let t = (i as f32 + 0.5) / count as f32;
        let (s, c) = (i as f32 * 2.399_963).sin_cos();
        let (y, out) = (1.0 - 2.0 * t, (4.0 * t * (1.0 - t)).sqrt());
        // Shells in turn, so that the inside is filled too.
        let shell = 0.5 * (1.0 + (i % 8) as f32).cbrt() / 2.0;
        Sphere { center: Vec3::new(0.0, 0.8, 0.0) + shell * Vec3::new(out * c, y, out * s), radius }
    };
    (0..count).map(one).collect()
}

fn hierarchy(c: &mut Criterion) {
    let mut group = c.benchmark_group("hierarchy");
    for count in [64, 512, 4096] {
        let spheres = blob(count);
        let objects = vec![0; count];
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("build", count), |b| {
            b.iter(|| SphereBlockers::new(black_box(&spheres), &objects, &[]));
        });
        let mut blockers = SphereBlockers::new(&spheres, &objects, &[]);
        group.bench_function(BenchmarkId::new("refit", count), |b| b.iter(|| blockers.update(black_box(&spheres))));
    }
}

/// A group of points in the shadow, and one of them: its mask at depth 5.
fn point(c: &mut Criterion) {
    let (mut culling, position) = (c.benchmark_group("sphere_stages"), Vec3::new(-0.55, 0.0, -0.1));
    let at = Receiver::on_surface(position, Vec3::Y, Vec3::Y);
    let cone = Cone::of_sphere(position, LIGHT);
    let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.005));
    let shaft = Shaft::new(Sphere { center: position, radius: 0.06 }, LIGHT, LightId(0));
    for count in [64, 512, 4096] {
        let blockers = SphereBlockers::new(&blob(count), &vec![0; count], &[]);
        let mut scratch = blockers.scratch();
        culling.bench_function(BenchmarkId::new("cull a group", count), |b| {
            b.iter(|| blockers.enter(black_box(&shaft), &mut scratch));
        });
        culling.bench_function(BenchmarkId::new("select for a point", count), |b| {
            b.iter(|| blockers.select(black_box(&query), &mut scratch));
        });
        let strategy = MaskVisibility::new(blockers);
        let mut scratch = strategy.scratch();
        strategy.enter(&shaft, &mut scratch);
        culling.bench_function(BenchmarkId::new("mask of a point", count), |b| {
            b.iter(|| strategy.coverage(black_box(&query), &mut scratch));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    targets = hierarchy, point
}
criterion_main!(benches);
