use core::f64::consts::PI;

/// Angle from `a1`, toward `a2`, of the axis of the product of two lobes: where `c1·c2` is largest (Eq. 19).
///
/// The paper searches it with Nelder–Mead; setting the derivative of `e1 ln cos t + e2 ln cos(α−t)` to zero gives
/// `tan t = 2 e2 sin α / ((e1+e2) cos α + √((e1−e2)² cos² α + 4 e1 e2))`.
///
/// `alpha` in [0, π], exponents ≥ 0 and finite. The result lies in [0, α]. Two constants have no maximum: half of
/// `alpha` then, where the paper's search starts. A constant and a lobe whose axis lies outside the constant's
/// hemisphere: the rim of that hemisphere.
#[must_use]
pub fn product_axis(e1: f64, e2: f64, alpha: f64) -> f64 {
    Split::of(e1, e2, alpha).to_axis[0]
}

/// How the maximum of a product divides the angle between the axes. Every angle is computed by itself, so that small
/// ones keep their digits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Split {
    /// From the maximum to each axis; they add up to α.
    pub(crate) to_axis: [f64; 2],
    /// From the maximum to the end of each lobe, π/2 from its axis; they add up to π − α.
    pub(crate) to_edge: [f64; 2],
}

impl Split {
    pub(crate) fn of(e1: f64, e2: f64, alpha: f64) -> Self {
        if e1 + e2 == 0.0 {
            return Self { to_axis: [0.5 * alpha; 2], to_edge: [0.5 * (PI - alpha); 2] };
        }
        let (sin, cos) = alpha.sin_cos();
        let root = (((e1 - e2) * cos).powi(2) + 4.0 * e1 * e2).sqrt();
        let sum = (e1 + e2) * cos.abs() + root;
        // Beyond a right angle the denominator cancels: rationalised there.
        let (one, two) = if cos >= 0.0 {
            ((2.0 * e2 * sin, sum), (2.0 * e1 * sin, sum))
        } else {
            ((sum, 2.0 * e1 * sin), (sum, 2.0 * e2 * sin))
        };
        Self { to_axis: [one.0.atan2(one.1), two.0.atan2(two.1)], to_edge: [one.1.atan2(one.0), two.1.atan2(two.0)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use lobe_core::oracle::Random;

    /// Golden-section search of the maximum of a unimodal function.
    fn search(mut lo: f64, mut hi: f64, f: impl Fn(f64) -> f64) -> f64 {
        let ratio = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..80 {
            let (a, b) = (hi - ratio * (hi - lo), lo + ratio * (hi - lo));
            if f(a) < f(b) { lo = a } else { hi = b }
        }
        0.5 * (lo + hi)
    }

    #[test]
    fn agrees_with_a_search() {
        let mut random = Random::new(21);
        for _ in 0..500 {
            let (e1, e2) = (random.log_uniform(1e-2, 1e5), random.log_uniform(1e-2, 1e5));
            let alpha = random.between(1e-3, 3.1);
            let f = |t: f64| e1 * t.cos().max(0.0).ln() + e2 * (alpha - t).cos().max(0.0).ln();
            let found = search((alpha - 0.5 * PI).max(0.0), alpha.min(0.5 * PI), f);
            // The search cannot resolve better than the square root of the rounding of ln.
            let split = Split::of(e1, e2, alpha);
            assert!((split.to_axis[0] - found).abs() < 1e-6, "{e1} {e2} {alpha}: {} {found}", split.to_axis[0]);
            assert!((split.to_axis[0] + split.to_axis[1] - alpha).abs() < 1e-14);
            assert!((split.to_axis[0] + split.to_edge[0] - 0.5 * PI).abs() < 1e-14);
            // The other closed form: t = ½(α + asin(k sin α)).
            let k = (e2 - e1) / (e1 + e2);
            assert!((split.to_axis[0] - 0.5 * (alpha + (k * alpha.sin()).asin())).abs() < 1e-12);
        }
    }

    #[test]
    fn no_direction_of_the_sphere_is_better() {
        let mut random = Random::new(22);
        for _ in 0..200 {
            let (e1, e2, alpha) = (random.exponent(100.0), random.exponent(100.0), random.between(0.0, 3.1));
            let a2 = DVec3::new(alpha.sin(), 0.0, alpha.cos());
            let value = |v: DVec3| v.z.max(0.0).powf(e1) * a2.dot(v).max(0.0).powf(e2);
            let t = product_axis(e1, e2, alpha);
            let best = value(DVec3::new(t.sin(), 0.0, t.cos()));
            for _ in 0..50 {
                // One part in 1e12: a rim of a hemisphere (e = 0) is hit or missed by rounding.
                assert!(value(random.axis()) <= best * (1.0 + 1e-12) || e1 == 0.0 || e2 == 0.0);
            }
        }
    }

    #[test]
    fn limits() {
        assert_eq!(product_axis(0.0, 0.0, 1.0), 0.5);
        assert_eq!(product_axis(3.0, 0.0, 1.0), 0.0);
        assert!((product_axis(0.0, 3.0, 1.0) - 1.0).abs() < 1e-15);
        assert!((product_axis(0.0, 3.0, 2.0) - 0.5 * PI).abs() < 1e-15);
        assert!((product_axis(7.0, 7.0, 3.0) - 1.5).abs() < 1e-15);
    }
}
