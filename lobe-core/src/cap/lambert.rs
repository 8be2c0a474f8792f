use crate::special::atan2;
use core::f32::consts::PI;

/// Irradiance of a sphere light of radiance 1 on a Lambert receiver, at every position of the horizon.
///
/// `E = π s² cos β` above the horizon (`s = sin σ`, σ the light's half-angle, β the angle between normal and centre);
/// through it `E = s²(cos β acos y − x q) + atan(q/x)` with `x = √(1/s²−1)`, `y = −x cot β`, `q = sin β √(1−y²)`;
/// 0 below. Exact; `sin_sq` = s² in [0, 1].
#[inline]
#[must_use]
pub fn sphere_light_irradiance(cos_beta: f32, sin_sq: f32) -> f32 {
    let sin_sq = sin_sq.clamp(0.0, 1.0);
    let s = sin_sq.sqrt();
    if cos_beta >= s {
        PI * sin_sq * cos_beta
    } else if cos_beta <= -s || sin_sq <= 0.0 {
        0.0
    } else {
        through_horizon(cos_beta, sin_sq)
    }
}

/// The middle case: `|cos β| < s`.
#[inline(always)]
pub(super) fn through_horizon(cos_beta: f32, sin_sq: f32) -> f32 {
    let positive = |x: f32| if x > 0.0 { x } else { 0.0 };
    let sin_beta = positive((1.0 - cos_beta) * (1.0 + cos_beta)).sqrt();
    let x = ((1.0 - sin_sq) / if sin_sq > f32::MIN_POSITIVE { sin_sq } else { f32::MIN_POSITIVE }).sqrt();
    // y·sin β and q by products, so that nothing is lost as y → ±1.
    let y_sin = -x * cos_beta;
    let q = positive((sin_beta - y_sin) * (sin_beta + y_sin)).sqrt();
    positive(sin_sq * (cos_beta * atan2(q, y_sin) - x * q) + atan2(q, x))
}
