//! What more or fewer spheres of the same object cost, and err.

use crate::measure::{Timing, frames};
use crate::scenes::close_up;
use core::sync::atomic::AtomicBool;
use cosine_lobes::render_cpu::{Estimate, GBuffer, Geometry, Reference, ReferenceJob, World};
use glam::Vec3;

/// A set of so many spheres.
pub(crate) struct Count {
    pub(crate) spheres: usize,
    pub(crate) timing: Timing,
    /// Error against the mesh as a share of the unshadowed radiance, over points in penumbra: mean, and what 99 % stay below.
    pub(crate) mean: f32,
    pub(crate) most: f32,
}

/// Samples of the reference: it errs by some 0.1 %.
const SAMPLES: u32 = 256;

pub(crate) fn measure(repeats: usize) -> Result<Vec<Count>, String> {
    eprintln!("Sets by count");
    let of = |spheres: usize| {
        let (scene, blockers) = close_up(1.0, spheres);
        let world = World::new(&scene);
        let gbuffer = GBuffer::new(&world, 360, 240, 1);
        let job =
            ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 1 };
        let mut reference = Reference::new(job);
        reference.advance(SAMPLES, &AtomicBool::new(false), &|_| {});
        let (timing, radiance) = frames(&scene, &blockers, &gbuffer.points, 0.0, repeats)?;
        let [mean, most] = errors(&radiance, &reference.estimate());
        Ok(Count { spheres, timing, mean, most })
    };
    [64, 128, 256, 484].into_iter().map(of).collect()
}

/// Mean and 99th percentile where the truth is between 1 and 99 % of the unshadowed radiance.
fn errors(test: &[Vec3], truth: &Estimate) -> [f32; 2] {
    let mut errors: Vec<f32> = test
        .iter()
        .zip(truth.radiance.iter().zip(&truth.unshadowed))
        .filter(|(_, (radiance, whole))| (0.01..0.99).contains(&(radiance.y / whole.y)))
        .map(|(test, (radiance, whole))| (test.y - radiance.y).abs() / whole.y)
        .collect();
    errors.sort_by(f32::total_cmp);
    let mean = errors.iter().sum::<f32>() / errors.len().max(1) as f32;
    [mean, errors.get(errors.len() * 99 / 100).copied().unwrap_or(0.0)]
}
