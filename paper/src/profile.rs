use crate::axis::Split;
use crate::meridian::ln_meridian;
use std::sync::OnceLock;

/// Nodes whose value is below `e^-DROP` of the peak may be left out.
const DROP: f64 = 36.0;

/// A product of two lobes along the great circle of their axes, sampled by a fixed double-exponential rule on both sides
/// of its maximum.
///
/// Integrals over the sphere of the product times any lobe about the maximum are one sum over these nodes, because the
/// direction across the plane separates (`ln_meridian`). Relative error 1e-8 (tested).
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    /// Quadrature weight times the product relative to its maximum, and `ln cos` of the angle from the maximum.
    nodes: Vec<(f64, f64)>,
    /// `ln` of the product's maximum.
    ln_peak: f64,
    /// `e1 + e2`.
    exponents: f64,
    /// `e1/cos² t + e2/cos²(α−t)`: curvature of −ln of the product at its maximum, in the plane of the axes.
    curvature: f64,
}

impl Profile {
    pub(crate) fn new(e1: f64, e2: f64, alpha: f64) -> Self {
        let split = Split::of(e1, e2, alpha);
        let exponents = [e1, e2];
        let mut profile =
            Self { nodes: Vec::with_capacity(2 * rule().len()), ln_peak: 0.0, exponents: e1 + e2, curvature: 0.0 };
        for (k, e) in exponents.into_iter().enumerate().filter(|&(_, e)| e > 0.0) {
            profile.ln_peak += e * ln_cos(split.to_axis[k], split.to_edge[k]);
            profile.curvature += e / split.to_edge[k].sin().powi(2);
        }
        profile.side(exponents, &split);
        let mirrored =
            Split { to_axis: [split.to_axis[1], split.to_axis[0]], to_edge: [split.to_edge[1], split.to_edge[0]] };
        profile.side([e2, e1], &mirrored);
        profile
    }

    /// Adds the nodes from the maximum to the end of the first lobe.
    fn side(&mut self, exponents: [f64; 2], split: &Split) {
        let whole = split.to_edge[0];
        let slope = [0, 1].map(|k| split.to_axis[k].sin() / split.to_edge[k].sin());
        // `ln` of the product at s relative to its maximum, and cos s − 1.
        let ln_relative = |s: f64, left: f64| {
            let (half_sin, half_cos) = (0.5 * s).sin_cos();
            let (sin, haversine) = (2.0 * half_sin * half_cos, -2.0 * half_sin * half_sin);
            let term = |k: usize, change: f64, distance: f64| {
                if exponents[k] == 0.0 {
                    return 0.0;
                }
                // The second form where the first has cancelled: close to the lobe's end.
                let near = change > -0.5 && split.to_edge[k] > 0.0;
                exponents[k] * if near { change.ln_1p() } else { (distance.sin() / split.to_edge[k].sin()).ln() }
            };
            let both =
                term(0, haversine - slope[0] * sin, left) + term(1, haversine + slope[1] * sin, split.to_edge[1] + s);
            (both, haversine)
        };
        let mut window = whole;
        while window > 0.0 && ln_relative(0.8 * window, whole - 0.8 * window).0 < -DROP {
            window *= 0.8;
        }
        for &(from, to, weight) in rule() {
            let (s, left) = (window * from, whole - window + window * to);
            let (relative, haversine) = ln_relative(s, left);
            if relative > -DROP {
                let ln = if s < 1.0 { haversine.ln_1p() } else { ln_cos(s, core::f64::consts::FRAC_PI_2 - s) };
                self.nodes.push((window * weight * relative.exp(), ln));
            }
        }
    }

    pub(crate) fn exponents(&self) -> f64 {
        self.exponents
    }

    pub(crate) fn curvature(&self) -> f64 {
        self.curvature
    }

    /// `ln ∫ c1·c2·max(a_r·v, 0)^e dv` over the sphere, then mean and variance of `ln max(a_r·v, 0)` *within the
    /// plane* under that integrand: the two derivatives of the in-plane part with respect to `e`.
    pub(crate) fn times_lobe(&self, e: f64) -> (f64, f64, f64) {
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        for &(weight, ln) in &self.nodes {
            let value = weight * (e * ln).exp();
            sum += value;
            first += value * ln;
            second += value * ln * ln;
        }
        let mean = first / sum;
        (self.ln_peak + sum.ln() + ln_meridian(self.exponents + e).0, mean, (second / sum - mean * mean).max(0.0))
    }

    /// `∫ c1·c2 dv` over the sphere.
    pub(crate) fn integral(&self) -> f64 {
        self.times_lobe(0.0).0.exp()
    }
}

/// `ln cos x`, given also `rest = π/2 − x` where `x` is close to a right angle.
fn ln_cos(x: f64, rest: f64) -> f64 {
    if x < 1.0 { (-2.0 * (0.5 * x).sin().powi(2)).ln_1p() } else { rest.max(f64::MIN_POSITIVE).sin().ln() }
}

/// Distances to both ends and weights of the double-exponential rule on [0, 1], step 1/10.
fn rule() -> &'static [(f64, f64, f64)] {
    static RULE: OnceLock<Vec<(f64, f64, f64)>> = OnceLock::new();
    RULE.get_or_init(|| {
        let node = |i: i32| {
            let t = f64::from(i) * 0.1;
            let q = core::f64::consts::PI * t.sinh();
            let (from, to) = (1.0 / (1.0 + (-q).exp()), 1.0 / (1.0 + q.exp()));
            (from, to, 0.1 * core::f64::consts::PI * t.cosh() * from * to)
        };
        (-31..=31).map(node).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::oracle::{self, Random};

    #[test]
    fn integral_agrees_with_the_oracle() {
        let mut random = Random::new(31);
        for i in 0..3000 {
            let (e1, e2) = (random.exponent(1e5), random.exponent(1e5));
            let alpha = if i % 10 == 0 { 0.0 } else { random.between(0.0, 3.13) };
            let (ln, exact) = (Profile::new(e1, e2, alpha).times_lobe(0.0).0, oracle::ln_product(e1, e2, alpha));
            assert!((ln - exact).abs() < 1e-8 + 1e-12 * exact.abs(), "{e1} {e2} {alpha}: {ln} {exact}");
        }
    }
}
