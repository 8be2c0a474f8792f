//! Moment lobes: the one lobe that keeps a function's total and its mean vector.

use crate::product::{Arc, DELTA, Peak};
use crate::special::cosine_power_arc;
use crate::{Cone, Lobe, Lobes, product_integral};
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

/// The moment lobe of the product of two lobes, per-channel fluxes multiplied.
///
/// The first moments of a product are `P` again, `∫(a₁·v)c₁c₂ = P(e₁+1, e₂, α)`: total and mean vector come from the
/// same plane integral as [`product_integral`]. For exponents of at least 8 the mean is the saddle point's (peak, skew
/// and the two curvatures), below it is quadrature.
///
/// An exponent of 1e12 or more, infinity included, gives a delta function; two of them give nothing.
#[must_use]
pub fn product_lobe(a: &Lobe, b: &Lobe) -> Lobe {
    let inverse_tau = 1.0 / core::f32::consts::TAU;
    for (delta, other) in [(a, b), (b, a)] {
        if delta.exponent >= DELTA {
            let value = if other.exponent >= DELTA { Vec3::ZERO } else { other.eval(delta.axis) };
            return Lobe::with_flux(delta.axis, f32::INFINITY, delta.flux * value);
        }
    }
    let (e1, e2) = (a.exponent, b.exponent);
    let y = 0.5 * (a.axis - b.axis).length_squared();
    let peak = Peak::new(e1, e2, y);
    // Angle of the mean from a's axis, and 1 − R.
    let (angle, one_minus_r) = if e1.min(e2) < 8.0 {
        let (mut total, mut along, mut aside) = (0.0, 0.0, 0.0);
        let arc = Arc::new(&peak, e1, e2);
        for (psi, weight) in Arc::NODES.into_iter().map(|node| arc.node(node)) {
            total += weight;
            along += weight * psi.cos();
            aside += weight * psi.sin();
        }
        // One more power of cos λ across the plane: B(n+1)/B(n).
        let across = cosine_power_arc(e1 + e2 + 2.0) / cosine_power_arc(e1 + e2 + 1.0);
        let length = if total > 0.0 { along.hypot(aside) / total } else { 1.0 };
        (aside.atan2(along), 1.0 - (length * across).min(1.0))
    } else {
        let [q1, q2] = peak.tan.map(|t| t * t);
        let n = e1 * (1.0 + q1) + e2 * (1.0 + q2);
        let h3 = 2.0 * (e1 * (1.0 + q1) * peak.tan[0] - e2 * (1.0 + q2) * peak.tan[1]);
        (peak.tan[0].atan() - 0.5 * h3 / (n * n), 0.5 * ((n + 1.5).recip() + (e1 + e2 + 2.5).recip()))
    };
    let aside = (b.axis - a.axis * (1.0 - y)).try_normalize().unwrap_or(Vec3::ZERO);
    let axis = (a.axis * angle.cos() + aside * angle.sin()).try_normalize().unwrap_or(a.axis);
    let integral = product_integral(e1, e2, a.axis, b.axis);
    let flux = a.flux * b.flux * (integral * ((e1 + 1.0) * inverse_tau) * ((e2 + 1.0) * inverse_tau));
    Lobe::with_flux(axis, exponent_of_spread(one_minus_r), flux)
}

/// The moment lobe of a sum of lobes with non-negative fluxes; weights are the channel sums.
///
/// Total and mean vector of the sum are kept: `1−R = Σ wᵢ(1 − Rᵢ âᵢ·â)/Σ wᵢ`, which does not cancel for narrow sums.
/// `None` for an empty or black sum, or one whose mean vector is zero.
#[must_use]
pub fn mixture_lobe(sum: Lobes<'_>) -> Option<Lobe> {
    let weight = |l: &Lobe| l.flux.element_sum();
    let shrink = |l: &Lobe| 1.0 / (l.exponent + 2.0);
    let mut total = Vec3::ZERO;
    let mut mean = Vec3::ZERO;
    for l in sum.iter() {
        total += l.flux;
        mean += l.axis * (weight(&l) * (1.0 - shrink(&l)));
    }
    let axis = mean.try_normalize()?;
    let spread: f32 = sum
        .iter()
        .map(|l| {
            let (s, y) = (shrink(&l), 0.5 * (l.axis - axis).length_squared());
            weight(&l) * (s + y - s * y)
        })
        .sum();
    Some(Lobe::with_flux(axis, exponent_of_spread(spread / total.element_sum()), total))
}
