//! Directions drawn in proportion to a lobe sum: the one sampler of all models.

use crate::BrdfSample;
use core::f32::consts::TAU;
use glam::Vec3;
use lobe_core::{Lobe, orthonormal_basis, power};

/// Luminance, by Rec. 709.
pub(crate) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// How often a lobe is chosen: the luminance of its flux.
fn weight(lobe: &Lobe) -> f32 {
    luminance(lobe.flux)
}

/// Chooses a lobe in proportion to its weight, then a direction in proportion to `max(a·v, 0)^e`. A receiver's cosine
/// on the lobe is not sampled; `None` below the horizon or when nothing is reflected.
pub(crate) fn draw(lobes: impl Iterator<Item = Lobe> + Clone, normal: Vec3, u: [f32; 3]) -> Option<BrdfSample> {
    let total: f32 = lobes.clone().map(|l| weight(&l)).sum();
    let mut left = u[0] * total;
    let mut chosen = None;
    for lobe in lobes.clone().filter(|l| weight(l) > 0.0) {
        chosen = Some(lobe);
        left -= weight(&lobe);
        if left < 0.0 {
            break;
        }
    }
    let lobe = chosen?;
    let direction = cosine_power_direction(lobe.axis, lobe.exponent, u[1], u[2]);
    let pdf = density(lobes, normal, direction);
    (pdf > 0.0).then_some(BrdfSample { direction, pdf })
}

/// Density with which [`draw`] yields `v`; 0 below the horizon. Integrates to at most 1: the rest is drawn as `None`.
pub(crate) fn density(lobes: impl Iterator<Item = Lobe>, normal: Vec3, v: Vec3) -> f32 {
    if normal.dot(v) <= 0.0 {
        return 0.0;
    }
    let (mut total, mut sum) = (0.0, 0.0);
    for lobe in lobes {
        let w = weight(&lobe);
        total += w;
        sum += w * ((lobe.exponent + 1.0) / TAU) * power(lobe.axis, v, lobe.exponent);
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

/// Inverts the cumulative distribution of `(e+1)/2π·cos^e`: `cos θ = (1−u)^(1/(e+1))`, through `1 − cos θ` because that
/// is all there is to a narrow lobe.
pub(crate) fn cosine_power_direction(axis: Vec3, exponent: f32, u: f32, azimuth: f32) -> Vec3 {
    let one_minus_cos = -((-u).ln_1p() / (exponent + 1.0)).exp_m1();
    let sin = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
    let (t, b) = orthonormal_basis(axis);
    let (s, c) = (TAU * azimuth).sin_cos();
    (axis * (1.0 - one_minus_cos) + (t * c + b * s) * sin).normalize()
}
