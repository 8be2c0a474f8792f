//! Radiance under an environment by many rays, in the order of a grid.

use glam::{DVec3, Vec3};
use lighting::Environment;
use lobe_core::{BrdfLobe, Receiver};
use rayon::prelude::*;
use render_cpu::World;
use scene::{Scene, ShadingPoints};
use shading::BrdfLobes;

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

/// Cones about the mirrored view that narrow lobes are summed in, by finer and finer grids; half their angles.
const CONES: [f64; 4] = [0.6, 0.25, 0.1, 0.04];
/// From this exponent on they are needed.
const NARROW: f32 = 45.0;

/// The sum over channels of what a receiver reflects, with and without blockers.
fn radiance(world: &World<'_>, environment: &Environment, at: &Receiver, lobes: &[BrdfLobe]) -> [f64; 2] {
    let origin = world.leave(at.position, at.face);
    let normal = at.normal.as_dvec3();
    let mirrored = 2.0 * normal.dot(at.view.as_dvec3()) * normal - at.view.as_dvec3();
    // 1 within half of a cone about the mirrored view, 0 outside of it, and smooth.
    let inside = |cone: usize, v: DVec3| {
        let part = CONES.get(cone).map_or(2.0, |angle| v.angle_between(mirrored) / angle);
        let t = (2.0 * part - 1.0).clamp(0.0, 1.0);
        1.0 - t * t * t * (10.0 - t * (15.0 - 6.0 * t))
    };
    let mut sums = [0.0; 2];
    let mut add = |direction: DVec3, weight: f64| {
        let direction = direction.as_vec3();
        let value = BrdfLobe::sum_at(lobes, at.normal, direction) * environment.map().radiance(direction);
        let value = f64::from(value.element_sum()) * weight;
        if value == 0.0 {
            return;
        }
        sums[1] += value;
        let is_below = at.object > 0 && at.face.dot(direction) <= 0.0;
        if !is_below && !world.occluded_by(origin, direction, f32::INFINITY, |o| o > 0) {
            sums[0] += value;
        }
    };
    let narrow = |lobe: &BrdfLobe| match lobe {
        BrdfLobe::Cosine(lobe) => lobe.exponent > NARROW,
        BrdfLobe::Microfacets(facets) => 0.25 * facets.exponent > NARROW,
    };
    let cones = if lobes.iter().any(narrow) { &CONES[..] } else { &[] };
    let side = if cones.is_empty() { RAYS } else { RAYS / 2 };
    for (turn, part) in grid(side) {
        // Heights are even in the square of the cosine, for a Lambert surface: cos θ sin θ dθ dφ = ½ d(cos²θ) dφ.
        let v = around(normal, part.sqrt(), turn);
        let size = core::f64::consts::PI / part.sqrt() / f64::from(side * side);
        add(v, size * if cones.is_empty() { 1.0 } else { 1.0 - inside(0, v) });
    }
    for (cone, angle) in cones.iter().enumerate() {
        let size = core::f64::consts::TAU * (1.0 - angle.cos()) / f64::from(side * side);
        for (turn, part) in grid(side) {
            let v = around(mirrored, 1.0 - part * (1.0 - angle.cos()), turn);
            if v.dot(normal) > 0.0 {
                let outer: f64 = (0..=cone).map(|cone| inside(cone, v)).product();
                add(v, size * outer * (1.0 - inside(cone + 1, v)));
            }
        }
    }
    sums
}

/// Parts of a turn and of a range, so many of each; rows are shifted against each other.
fn grid(side: u32) -> impl Iterator<Item = (f64, f64)> {
    (0..side * side).map(move |k| {
        let row = k / side;
        let turn = (f64::from(k % side) + (f64::from(row) * 0.618_033_988_75).fract()) / f64::from(side);
        (turn, (f64::from(row) + 0.5) / f64::from(side))
    })
}

/// The direction at a height above an axis, and at a part of a turn about it.
fn around(axis: DVec3, height: f64, turn: f64) -> DVec3 {
    let (u, v) = axis.any_orthonormal_pair();
    let (sin, cos) = (turn * core::f64::consts::TAU).sin_cos();
    axis * height + (u * cos + v * sin) * (1.0 - height * height).sqrt()
}
