//! The `shadow-map` strategy: drawing a map, one point. `cargo bench -p cosine-lobes-visibility-shadowmap`.

use core::time::Duration;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::Vec3;
use lobe_core::{Cone, Receiver, Sphere};
use shading::{Accuracy, LightId, Shaft, Visibility, VisibilityQuery};
use std::hint::black_box;
use visibility_mask::MaskVisibility;
use visibility_shadowmap::{MapOptions, ReceiverBounds, ShadowMap, ShadowMapBlockers};

const LIGHT: Sphere = Sphere { center: Vec3::new(1.0, 4.6, 0.5), radius: 0.5 };

/// A sphere of triangles over the floor.
fn sphere() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    const N: u32 = 32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..=N {
        for i in 0..2 * N {
            let angle = |k: u32| core::f32::consts::PI * k as f32 / N as f32;
            let ((s, c), (t, d)) = (angle(j).sin_cos(), angle(i).sin_cos());
            positions.push(Vec3::Y * 0.8 + 0.5 * Vec3::new(s * d, c, s * t));
        }
    }
    for j in 0..N {
        for i in 0..2 * N {
            let at = |i: u32, j: u32| j * 2 * N + i % (2 * N);
            triangles.extend([[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
        }
    }
    (positions, triangles)
}

fn maps(c: &mut Criterion) {
    let (positions, triangles) = sphere();
    let receivers = ReceiverBounds { min: Vec3::new(-2.0, -0.01, -2.0), max: Vec3::new(2.0, 0.01, 2.0) };
    let position = Vec3::new(-0.55, 0.0, -0.1);
    let at = Receiver::on_surface(position, Vec3::Y, Vec3::Y);
    let cone = Cone::of_sphere(position, LIGHT);
    let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.005));
    let mut group = c.benchmark_group("shadow_map");
    group.sample_size(10);
    for resolution in [256, 1024] {
        let options = MapOptions { resolution, receivers: Some(receivers), ..MapOptions::default() };
        let build = || ShadowMap::build(&positions, &triangles, LIGHT, &options).expect("a sound map");
        group.bench_function(BenchmarkId::new("draw", resolution), |b| b.iter(build));
        let strategy = MaskVisibility::new(ShadowMapBlockers::new(vec![build()]));
        let mut scratch = strategy.scratch();
        strategy.enter(&Shaft::new(Sphere { center: position, radius: 0.06 }, LIGHT, LightId(0)), &mut scratch);
        group.bench_function(BenchmarkId::new("mask of a point", resolution), |b| {
            b.iter(|| strategy.coverage(black_box(&query), &mut scratch));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    targets = maps
}
criterion_main!(benches);
