//! The integral of the product of two lobes.

use crate::special::cosine_power_arc;
use crate::{Lobe, Receiver};
use glam::Vec3;

/// Below this exponent the saddle-point form of [`product_integral`] is replaced by quadrature.
const LOW_EXPONENT: f32 = 8.0;

/// `P(e₁, e₂, α) = ∫ max(a₁·v, 0)^e₁ max(a₂·v, 0)^e₂ dv`, the integral over the sphere of the product of two lobes of
/// scale 1.
///
/// `P = B(e₁+e₂)·J`, where the integral across the plane of the two axes is exact,
/// `B(n) = √π Γ(n/2+1)/Γ(n/2+3/2)`, and `J = ∫ cos^e₁ψ cos^e₂(ψ−α) dψ` in the plane is taken at its peak: with `t` the
/// angle of the peak from `a₁` (the axis of Eq. 19 in closed form),
/// `J ≈ cos^e₁t cos^e₂(α−t) A(n) exp(5h₃²/24n³ − (h₄−2n)/8n²)`, `n = e₁/cos²t + e₂/cos²(α−t)`,
/// `A(n) = √π Γ((n+1)/2)/Γ(n/2+1)`, h₃ and h₄ the third and fourth derivatives of the integrand's logarithm. Where an
/// exponent is below 8 that expansion is no longer good (the integrand is cut off at the horizon of the broad lobe)
/// and `J` is a 24-node quadrature clustered at both ends.
///
/// # Domain
/// Exponents in [0, 1e6] (up to 1e18 they work as well), unit axes; the angle comes from `|a₁−a₂|`, which keeps its
/// digits where `a₁·a₂` has none left.
///
/// # Accuracy
/// Relative error ≤ 0.1 % wherever `P` exceeds 1e-4 of the coaxial `2π/(e₁+e₂+1)`, against quadrature in f64; absolute
/// error below 1e-6 of the coaxial value elsewhere.
///
/// # Cost
/// About 60 flops, two `log1p`, one `exp` and one Γ ratio each for the plane and across it; the low form eight times
/// that.
///
/// ```
/// use glam::Vec3;
/// let p = lobe_core::product_integral(3.0, 5.0, Vec3::Z, Vec3::Z);
/// assert!((p - core::f32::consts::TAU / 9.0).abs() < 1e-5);
/// ```
#[must_use]
pub fn product_integral(e1: f32, e2: f32, a1: Vec3, a2: Vec3) -> f32 {
    product_of_angle(e1, e2, 0.5 * (a1 - a2).length_squared())
}

/// [`product_integral`] by `1 − cos α` instead of the axes.
#[must_use]
pub fn product_of_angle(e1: f32, e2: f32, one_minus_cos: f32) -> f32 {
    let peak = Peak::new(e1, e2, one_minus_cos);
    let across = cosine_power_arc(e1 + e2 + 1.0);
    let in_plane = if e1.min(e2) < LOW_EXPONENT { peak.arc_by_quadrature(e1, e2) } else { peak.arc(e1, e2) };
    across * in_plane
}

/// Lobes from this exponent on are deltas beside any other: a millionth of a radian wide.
pub(crate) const DELTA: f32 = 1e12;

/// Where the product of two lobes peaks in the plane of their axes (Eq. 19), as tangents of the angles from either axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    pub(crate) cos: f32,
    pub(crate) sin: f32,
    /// tan of the angle from `a₁` toward `a₂`, then from `a₂` toward `a₁`.
    pub(crate) tan: [f32; 2],
}

impl Peak {
    pub(crate) fn new(e1: f32, e2: f32, one_minus_cos: f32) -> Self {
        let y = one_minus_cos.clamp(0.0, 2.0);
        let cos = 1.0 - y;
        let sin_sq = y * (2.0 - y);
        let sin = sin_sq.sqrt();
        // By the exponents' shares of their sum: nothing overflows.
        let inverse = (e1 + e2).max(f32::MIN_POSITIVE).recip();
        let (k1, k2) = (e1 * inverse, e2 * inverse);
        let root = (cos * cos + 4.0 * k1 * k2 * sin_sq).sqrt();
        // tan t = 2 e₂ sin α/(linear + root); for α > 90° by the conjugate, which does not cancel. Beyond the limit the
        // product is below 1e-32 of the coaxial one for any exponent that uses the tangent.
        let tan = |of: f32, other: f32| {
            let (above, below) =
                if cos >= 0.0 { (2.0 * other * sin, cos + root) } else { (root - cos, 2.0 * of * sin) };
            (above / below.max(f32::MIN_POSITIVE)).min(1e4)
        };
        Self { cos, sin, tan: [tan(k1, k2), tan(k2, k1)] }
    }

    /// `J` by the saddle point.
    fn arc(&self, e1: f32, e2: f32) -> f32 {
        let [q1, q2] = self.tan.map(|t| t * t);
        let log_peak = -0.5 * (e1 * q1.ln_1p() + e2 * q2.ln_1p());
        let (s1, s2) = (1.0 + q1, 1.0 + q2);
        let n = e1 * s1 + e2 * s2;
        let h3 = 2.0 * (e1 * s1 * self.tan[0] - e2 * s2 * self.tan[1]);
        let h4 = 2.0 * (e1 * s1 * (s1 + 2.0 * q1) + e2 * s2 * (s2 + 2.0 * q2));
        let skew = h3 / n;
        let correction = (5.0 / 24.0 * skew * skew - 0.125 * (h4 / n - 2.0)) / n;
        // The correction is a series in 1/n that only makes sense while it is small.
        (log_peak + correction.clamp(-1.0, 1.0)).exp() * cosine_power_arc(n)
    }

    /// `J` by quadrature over the peak's surroundings, for low exponents.
    fn arc_by_quadrature(&self, e1: f32, e2: f32) -> f32 {
        let mut sum = 0.0;
        self.quadrature(e1, e2, |_, weight| sum += weight);
        sum
    }

    /// Calls `f(ψ, weight)` for each node of a rule for `∫ … cos^e₁ψ cos^e₂(ψ−α) dψ`.
    pub(crate) fn quadrature(&self, e1: f32, e2: f32, mut f: impl FnMut(f32, f32)) {
        let half_pi = core::f32::consts::FRAC_PI_2;
        let alpha = self.sin.atan2(self.cos);
        let peak = self.tan[0].atan().clamp(alpha - half_pi, half_pi);
        // The logarithm's curvature is at least e₁+e₂ everywhere: 7 widths away it has fallen by 24.
        let window = 7.0 / (e1 + e2).max(1e-6).sqrt();
        let low = (alpha - half_pi).max(peak - window);
        let high = half_pi.min(peak + window);
        let length = high - low;
        if length <= 0.0 {
            return;
        }
        for (&x, &w) in NODES.iter().zip(&WEIGHTS) {
            for x in [0.5 - 0.5 * x, 0.5 + 0.5 * x] {
                // Clustered at both ends, where a power below 1 has an infinite slope.
                let psi = low + length * (x * x * (3.0 - 2.0 * x));
                let jacobian = 3.0 * x * (1.0 - x) * length * w;
                let log =
                    log_cosine_power(psi, half_pi - psi, e1) + log_cosine_power(psi - alpha, psi + half_pi - alpha, e2);
                f(psi, jacobian * log.exp());
            }
        }
    }
}

/// `e·ln cos ψ`, near 0 and near the end of the support (`complement` = π/2 − |ψ| there) without cancellation.
fn log_cosine_power(psi: f32, complement: f32, e: f32) -> f32 {
    if e == 0.0 {
        return 0.0;
    }
    let log = if psi.abs() < 0.8 {
        let sin = psi.sin();
        0.5 * (-sin * sin).ln_1p()
    } else {
        complement.max(1e-30).sin().ln()
    };
    e * log
}

/// Positive nodes of the 24-point Gauss–Legendre rule on [−1, 1], and their weights.
const NODES: [f32; 12] = [
    0.064_056_89,
    0.191_118_87,
    0.315_042_67,
    0.433_793_5,
    0.545_421_5,
    0.648_093_65,
    0.740_124_2,
    0.820_001_97,
    0.886_415_5,
    0.938_274_55,
    0.974_728_6,
    0.995_187_2,
];
const WEIGHTS: [f32; 12] = [
    0.127_938_2,
    0.125_837_46,
    0.121_670_47,
    0.115_505_67,
    0.107_444_27,
    0.097_618_65,
    0.086_190_16,
    0.073_346_48,
    0.059_298_584,
    0.044_277_44,
    0.028_531_39,
    0.012_341_23,
];

/// `∫ f·c dv` for two lobes with their fluxes, per channel; `f`'s receiver cosine is taken at the product's mean
/// direction.
///
/// An infinite exponent is a delta function. A Lambert lobe (exponent 1 about the normal) with a lobe that stands for
/// directions above the horizon is exact: `n·∫v c(v) dv`.
#[must_use]
pub fn lobe_product(at: &Receiver, f: &Lobe, c: &Lobe) -> Vec3 {
    f.flux * c.flux * normalized_product(at, f, c)
}

/// The same for fluxes of 1.
#[must_use]
pub(crate) fn normalized_product(at: &Receiver, f: &Lobe, c: &Lobe) -> f32 {
    let inverse_tau = 1.0 / core::f32::consts::TAU;
    if is_lambert(at, f) {
        // Mean vector of a lobe: (e+1)/(e+2) along its axis.
        let mean = 1.0 - 1.0 / (c.exponent + 2.0);
        return 2.0 * inverse_tau * mean * at.normal.dot(c.axis).max(0.0);
    }
    let delta = |finite: &Lobe, direction: Vec3| {
        let exponent = finite.exponent.min(DELTA);
        (exponent + 1.0) * inverse_tau * crate::power(finite.axis, direction, exponent)
    };
    let (value, mean) = if c.exponent >= DELTA {
        (delta(f, c.axis), c.axis)
    } else if f.exponent >= DELTA {
        (delta(c, f.axis), f.axis)
    } else {
        let p = product_integral(f.exponent, c.exponent, f.axis, c.axis);
        let value = p * (f.exponent + 1.0) * inverse_tau * ((c.exponent + 1.0) * inverse_tau);
        (value, if f.cosine > 0.0 { product_mean(f, c) } else { Vec3::ZERO })
    };
    if f.cosine > 0.0 { value * at.normal.dot(mean).max(0.0) } else { value }
}

/// Mean vector of the normalised product, up to terms of second order in its width: along the peak (Eq. 19).
fn product_mean(f: &Lobe, c: &Lobe) -> Vec3 {
    let (e1, e2) = (f.exponent, c.exponent);
    let peak = Peak::new(e1, e2, 0.5 * (f.axis - c.axis).length_squared());
    // sin(α−t) : sin t are the weights of the two axes in the unit vector at angle t.
    let [s1, s2] = peak.tan.map(|t| t / (1.0 + t * t).sqrt());
    let axis = (f.axis * s2 + c.axis * s1).try_normalize().unwrap_or(c.axis);
    axis * (1.0 - 1.0 / (e1 + e2 + 2.0))
}

/// Whether `f` is the Lambert lobe at this receiver: exponent 1, axis the normal itself.
#[must_use]
pub fn is_lambert(at: &Receiver, f: &Lobe) -> bool {
    f.exponent == 1.0 && f.cosine == 0.0 && f.axis == at.normal
}
