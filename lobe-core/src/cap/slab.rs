use super::pair::Pair;
use crate::special::{erf, exp, ln_1p};
use core::f32::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI};

/// The slab form is used above the horizon from this exponent on, for lights at least as wide as the lobe:
/// `(e+1)(1 − cos θ)/2 ≥ WIDTH`; narrower, the tails of the lobe would be up to 6 % of themselves too bright. It follows the arc of the offset, which off the axis of a broad lobe is wrong by 2 % of
/// the local value (0.2 % of the on-axis one); chords, right there, lose their precision on wide lights instead.
pub(super) const EXPONENT: f32 = 400.0;
pub(super) const WIDTH: f32 = 5.0;

/// The slab form of a lobe of flux 1: a Gaussian over a disc, seen along its offset, is almost a Gaussian over a slab of
/// adjusted half-width R' and width σ: `I = I₀·[erf κ(R'+d) + erf κ(R'−d)]/(2 erf κR')`, κ = 1/(√2 σ).
///
/// The receiver's cosine takes the first moment of the lobe over the light, by differentiation of the integral one
/// exponent higher: `M·a = I_{e+1}`, `M·t = −∂I_{e+1}/∂δ /(e+1)`, t ⟂ a toward the light.
#[inline(always)]
pub(super) fn slab(pair: &Pair) -> f32 {
    let y = pair.one_minus_cos_delta();
    let e = pair.exponent + pair.cosine;
    let theta = arc(pair.one_minus_cos);
    let delta = arc(y);
    let q = (e + 1.0) * theta * theta;
    let root = (e + 0.5).sqrt();
    let radius_sq = q * (1.0 - (0.263_53 + 0.067_66 * q) / (1.0 + 0.159_77 * q + 0.067_66 * q * q));
    let sigma_sq = 1.0 + 0.017_26 * q / (1.0 - 0.084_54 * q + 0.030_46 * q * q);
    // Both squares are positive in the domain: q is at least 6.
    let radius = radius_sq.abs().sqrt() * (1.0 + (-0.127_69 + 0.000_76 * q) / ((1.0 + 0.023_68 * q) * e));
    let sigma = sigma_sq.abs().sqrt() * (1.0 + (0.081_99 - 0.489_43 * q) / ((1.0 + 3.0 * q) * e));
    let kappa = FRAC_1_SQRT_2 / sigma;
    let (r, d) = (kappa * radius, kappa * root * delta);
    let (near, far) = (r - d, r + d);
    // I₀ of scale 1, 2π(1 − C^(e+1))/(e+1), times the scale (e₀+1)/2π of flux 1: without the cosine e = e₀.
    let whole = (1.0 - exp((e + 1.0) * ln_1p(-pair.one_minus_cos))) * ((pair.exponent + 1.0) / (e + 1.0));
    let norm = whole / (2.0 * erf(r));
    let value = erf(far) + erf(near);
    // With the cosine n·M; the slope of the integral is two Gaussians.
    let slope = FRAC_2_SQRT_PI * (exp(-far * far) - exp(-near * near)) * kappa * root;
    let aside = pair.aside();
    let moment = pair.normal.dot(pair.axis) * value - pair.normal.dot(aside) * (slope / (pair.exponent + 1.0));
    let result = norm * if pair.cosine > 0.0 { moment } else { value };
    if result > 0.0 { result } else { 0.0 }
}

/// The arc of a chord `h = 2 sin(x/2)` from `h²/… = 2(1 − cos x)`; relative error 2e-6 up to 74°.
#[inline(always)]
fn arc(one_minus_cos: f32) -> f32 {
    let y = 2.0 * one_minus_cos;
    y.sqrt() * (1.0 + y * (0.041_650_7 + y * (0.004_778_75 + y * (0.000_521_976 + y * 0.000_245_232))))
}

#[cfg(test)]
mod tests {
    use super::arc;

    #[test]
    fn arcs_of_chords() {
        for i in 1..=74 {
            let angle = f64::from(i).to_radians();
            let got = f64::from(arc((2.0 * (0.5 * angle).sin().powi(2)) as f32));
            assert!((got / angle - 1.0).abs() < 3e-6, "{i}°: {got}");
        }
    }
}
