use crate::special::{exp, ln_1p};

/// Below this exponent the saddle point may not be good enough.
const LOW_EXPONENT: f32 = 8.0;
/// From here on the quadrature's angles have too few digits for the narrower lobe.
const NARROWEST: f32 = 2e7;

/// The integral in the plane of two axes by its saddle point.
pub(super) struct Saddle {
    /// Curvature of the logarithm, `e₁/cos²t + e₂/cos²(α−t)`.
    pub(super) n: f32,
    /// `J` without its factor `A(n)`.
    pub(super) value: f32,
    /// Whether that is right to 0.01 % of the coaxial value where an exponent is below 8, to 0.1 % of itself elsewhere.
    pub(super) trusted: bool,
}

/// Where the product of two lobes peaks in the plane of their axes (Eq. 19), as tangents of the angles from either axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    pub(crate) cos: f32,
    pub(crate) sin: f32,
    /// tan of the angle from `a₁` toward `a₂`, then from `a₂` toward `a₁`.
    pub(crate) tan: [f32; 2],
}

impl Peak {
    #[inline(always)]
    pub(crate) fn new(e1: f32, e2: f32, one_minus_cos: f32) -> Self {
        let larger = |x: f32, than: f32| if x > than { x } else { than };
        let smaller = |x: f32, than: f32| if x < than { x } else { than };
        let y = smaller(larger(one_minus_cos, 0.0), 2.0);
        let cos = 1.0 - y;
        let sin_sq = y * (2.0 - y);
        let sin = sin_sq.sqrt();
        // By the exponents over their sum: nothing overflows. A sum of zero would leave 0/0 beyond 90°.
        let inverse = 1.0 / larger(e1 + e2, f32::MIN_POSITIVE);
        let (k1, k2) = (larger(e1 * inverse, 1e-15), larger(e2 * inverse, 1e-15));
        let root = (cos * cos + 4.0 * k1 * k2 * sin_sq).sqrt();
        // tan t = 2 e₂ sin α/(cos α + root); for α > 90° by the conjugate, which does not cancel. Beyond the limit the
        // product is below 1e-32 of the coaxial one for any exponent that uses the tangent.
        let (above, below) = if cos >= 0.0 { (2.0 * sin, cos + root) } else { (root - cos, 2.0 * k1 * k2 * sin) };
        let ratio = above / larger(below, f32::MIN_POSITIVE);
        Self { cos, sin, tan: [smaller(ratio * k2, 1e4), smaller(ratio * k1, 1e4)] }
    }

    /// The integral in the plane at its peak.
    #[inline(always)]
    pub(super) fn saddle(&self, e1: f32, e2: f32) -> Saddle {
        let [q1, q2] = self.tan.map(|t| t * t);
        let log_peak = -0.5 * (e1 * ln_1p(q1) + e2 * ln_1p(q2));
        let (s1, s2) = (1.0 + q1, 1.0 + q2);
        let n = e1 * s1 + e2 * s2;
        let h3 = 2.0 * (e1 * s1 * self.tan[0] - e2 * s2 * self.tan[1]);
        let h4 = 2.0 * (e1 * s1 * (s1 + 2.0 * q1) + e2 * s2 * (s2 + 2.0 * q2));
        let inverse = 1.0 / if n > f32::MIN_POSITIVE { n } else { f32::MIN_POSITIVE };
        let skew = h3 * inverse;
        let (third, fourth) = (5.0 / 24.0 * skew * skew * inverse, 0.125 * (h4 * inverse - 2.0) * inverse);
        let correction = third - fourth;
        // The correction is a series in 1/n that only makes sense while it is small.
        let low = if correction > -1.0 { correction } else { -1.0 };
        let correction = if low < 1.0 { low } else { 1.0 };
        // Trusted: no low exponent, or its horizon is far from the peak (7 widths) and the series short.
        let q = if q1 > q2 { q1 } else { q2 };
        let short = third + fourth.abs() < 2e-3 && 49.0 * q < n && e1 + e2 > 30.0;
        let trusted = short || (e1 >= LOW_EXPONENT && e2 >= LOW_EXPONENT) || e1 + e2 >= NARROWEST;
        Saddle { n, value: exp(log_peak + correction), trusted }
    }
}
