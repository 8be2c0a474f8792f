//! From a mask to radiance: one point in penumbra, by depth and exponent. `cargo bench -p cosine-lobes-visibility-mask`.

use core::time::Duration;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::Vec3;
use lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use shading::{Accuracy, Coverage, LightId, LightVisibility, Visibility, VisibilityQuery};
use std::hint::black_box;
use visibility_mask::{Blockers, Mask, MaskVisibility};

/// Hides the left of the light, with a slanted edge: the cheapest possible blocker.
struct Curtain;

impl Blockers for Curtain {
    type Scratch = ();

    fn scratch(&self) {}

    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }

    fn splat(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        for row in 0..mask.side() {
            mask.block_span(row, f32::NEG_INFINITY, 0.3 * mask.row_y(row));
        }
    }
}

fn penumbra_point(c: &mut Criterion) {
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
    let cone = Cone::of_sphere(at.position, Sphere { center: Vec3::new(0.0, 10.0, 0.0), radius: 1.4 });
    let mut group = c.benchmark_group("penumbra_point");
    for depth in [3, 4, 5, 6] {
        let strategy = MaskVisibility::new(Curtain);
        let mut scratch = strategy.scratch();
        let accuracy = Accuracy::new(0.003).with_depth(depth);
        for exponent in [1.0, 20.0, 200.0, 2000.0] {
            let lobe = Lobe::new(Vec3::Y, exponent, Vec3::ONE);
            let unshadowed = cap_integral(&at, lobe, &cone);
            group.bench_function(BenchmarkId::new(format!("depth {depth}"), exponent), |b| {
                b.iter(|| {
                    let mut visit = LightVisibility::alone(&strategy, LightId(0), accuracy, &mut scratch);
                    visit.visible_fraction(black_box(&at), &cone, &lobe, unshadowed).x
                });
            });
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(600));
    targets = penumbra_point
}
criterion_main!(benches);
