//! Moment lobes: the one lobe that keeps a function's total and its mean vector.

use crate::{Cone, Lobe};
use glam::Vec3;

/// Exponent of the lobe whose mean vector has length `R` times its flux: `e = (2R−1)/(1−R)`, from `1 − R`.
///
/// A lobe of exponent `e` has `R = (e+1)/(e+2)`. 0 for `R ≤ ½` (no lobe is broader), infinite for `R = 1`.
#[must_use]
pub fn exponent_of_spread(one_minus_r: f32) -> f32 {
    (one_minus_r.max(0.0).recip() - 2.0).max(0.0)
}

/// The moment lobe of a uniform cone: exponent `2C/(1−C)`, flux `2π(1−C)`, `C = cos θ`.
///
/// Its total and its mean vector `π sin²θ` are exact, hence Lambert irradiance is, as long as the cone is above the
/// horizon. (The least-squares lobe of Eq. 31 overshoots the flux of a small light by 13.8 %.)
///
/// Half-angles up to 90°; beyond, the exponent stays 0.
///
/// ```
/// use glam::Vec3;
/// let cone = lobe_core::Cone { axis: Vec3::Z, one_minus_cos: 0.01, distance: 1.0 };
/// let lobe = lobe_core::cone_lobe(&cone);
/// assert!((lobe.exponent - 198.0).abs() < 1e-3);
/// ```
#[must_use]
pub fn cone_lobe(cone: &Cone) -> Lobe {
    // 1 − R of a cone is (1−C)/2.
    let exponent = exponent_of_spread(0.5 * cone.one_minus_cos);
    Lobe::with_flux(cone.axis, exponent, Vec3::splat(cone.solid_angle()))
}
