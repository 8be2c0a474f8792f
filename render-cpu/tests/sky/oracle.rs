//! Radiance under an environment by many rays, in the order of a grid.

use glam::{DVec3, Vec3};
use lighting::Environment;
use lobe_core::{BrdfLobe, BrdfLobes, Receiver};
use rayon::prelude::*;
use render_cpu::World;
use scene::{Scene, ShadingPoints};

/// Rays along each side of a grid over a hemisphere.
const RAYS: u32 = 192;

/// Errors in % of the unshadowed radiance: over points that see from 1 to 99 % of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Error {
    pub(crate) mean: f64,
    pub(crate) p99: f64,
    pub(crate) largest: f64,
    #[cfg_attr(test, expect(dead_code, reason = "printed"))]
    pub(crate) bias: f64,
}

/// Of shaded points.
pub(crate) fn errors(scene: &Scene, environment: &Environment, points: &ShadingPoints, got: &[Vec3]) -> Error {
    let world = World::new(scene);
    let all: Vec<[f64; 2]> = points
        .receivers
        .par_iter()
        .zip(&points.materials)
        .zip(got)
        .map(|((at, material), got)| {
            let mut lobes = Vec::new();
            scene.materials[*material as usize].brdf_lobes(at, &mut lobes);
            let [seen, whole] = radiance(&world, environment, at, &lobes);
            [(got.as_dvec3().element_sum() - seen) / whole, seen / whole]
        })
        .collect();
    let penumbra: Vec<f64> = all.iter().filter(|p| p[1] > 0.01 && p[1] < 0.99).map(|p| p[0] * 100.0).collect();
    assert!(!penumbra.is_empty());
    let mut sizes: Vec<f64> = penumbra.iter().map(|e| e.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let n = sizes.len() as f64;
    Error {
        mean: sizes.iter().sum::<f64>() / n,
        p99: sizes[sizes.len() * 99 / 100],
        largest: all.iter().map(|p| p[0].abs() * 100.0).fold(0.0, f64::max),
        bias: penumbra.iter().sum::<f64>() / n,
    }
}

/// The sum over channels of what a receiver reflects, with and without blockers.
fn radiance(world: &World<'_>, environment: &Environment, at: &Receiver, lobes: &[BrdfLobe]) -> [f64; 2] {
    let origin = world.leave(at.position, at.face);
    let (u, v) = at.normal.as_dvec3().any_orthonormal_pair();
    let mut sums = [0.0; 2];
    for k in 0..RAYS * RAYS {
        // Heights are even in the square of the cosine, for a Lambert surface; rows are shifted against each other.
        let row = k / RAYS;
        let turn = (f64::from(k % RAYS) + (f64::from(row) * 0.618_033_988_75).fract()) / f64::from(RAYS);
        let square = (f64::from(row) + 0.5) / f64::from(RAYS);
        let (sin, cos) = (turn * core::f64::consts::TAU).sin_cos();
        let across: DVec3 = (u * cos + v * sin) * (1.0 - square).sqrt();
        let height = square.sqrt();
        let direction = (across + at.normal.as_dvec3() * height).as_vec3();
        let value = BrdfLobe::sum_at(lobes, at.normal, direction) * environment.map().radiance(direction);
        // cos θ sin θ dθ dφ = ½ d(cos²θ) dφ.
        let value = f64::from(value.element_sum()) / height * core::f64::consts::PI / f64::from(RAYS * RAYS);
        sums[1] += value;
        let is_below = at.object > 0 && at.face.dot(direction) <= 0.0;
        if !is_below && !world.occluded_by(origin, direction, f32::INFINITY, |o| o > 0) {
            sums[0] += value;
        }
    }
    sums
}
