use crate::axis::product_axis;
use crate::meridian::ln_meridian;
use crate::profile::Profile;
use core::f64::consts::{PI, TAU};

/// The lobe that stands for a product of two lobes of scale 1 (Eq. 17).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProductFit {
    /// Partial scaling factor `p_r`.
    pub scale: f64,
    /// Exponent `e_r`.
    pub exponent: f64,
    /// Angle of the axis from `a1` toward `a2`.
    pub angle: f64,
}

impl ProductFit {
    /// `∫ c_r dv = p_r·2π/(e_r+1)`.
    #[must_use]
    pub fn integral(&self) -> f64 {
        self.scale * TAU / (self.exponent + 1.0)
    }
}

/// Fits one lobe to the product of two (Eqs. 19 and 20): axis at the product's maximum, then scale and exponent that
/// minimise the squared distance over the sphere.
///
/// Eq. 20 by variable projection: for a given exponent the best scale is linear, `p = ⟨c1c2, C_e⟩/⟨C_e, C_e⟩`, and what
/// remains is to maximise `⟨c1c2, C_e⟩²/⟨C_e, C_e⟩` over `e ≥ 0`, by Newton's method in `ln(2e+1)` inside a bracket.
/// The inner product is `B(e1+e2+e)` times a sum along the great circle of the three axes.
///
/// Exponents in [0, 1e7], `alpha` in [0, π]. A few microseconds. Where the product is nowhere positive: scale 0.
#[must_use]
pub fn fit_product(e1: f64, e2: f64, alpha: f64) -> ProductFit {
    fit_product_from(e1, e2, alpha, None)
}

/// [`fit_product`], by Newton's method from the exponent of a neighbour, which saves steps.
pub(crate) fn fit_product_from(e1: f64, e2: f64, alpha: f64, neighbour: Option<f64>) -> ProductFit {
    let angle = product_axis(e1, e2, alpha);
    if PI - alpha < 1e-9 {
        return ProductFit { scale: 0.0, exponent: e1 + e2, angle };
    }
    let profile = Profile::new(e1, e2, alpha);
    let exponent = best_exponent(&profile, neighbour);
    let scale = (profile.times_lobe(exponent).0 + (2.0 * exponent + 1.0).ln() - TAU.ln()).exp();
    ProductFit { scale, exponent, angle }
}

/// The exponent that maximises `(2e+1)·⟨c1c2, C_e⟩²`.
fn best_exponent(profile: &Profile, neighbour: Option<f64>) -> f64 {
    // Half the derivative of the logarithm, times 2e+1; and the derivative of that with respect to ln(2e+1).
    let residual = |e: f64| {
        let (_, mean, variance) = profile.times_lobe(e);
        let n = profile.exponents() + e;
        let width = 2.0 * e + 1.0;
        let slope = 1.0 / width + ln_meridian(n).1 + mean;
        let w = 0.5 * n + 0.75;
        let curvature = -2.0 / (width * width) + 0.125 / (w * w) + variance;
        (slope * width, (curvature * width + 2.0 * slope) * 0.5 * width)
    };
    let is_constant = || residual(0.0).0 <= 0.0;
    if neighbour.is_none_or(|e| e < 1.0) && is_constant() {
        return 0.0;
    }
    // For narrow lobes the answer is the geometric mean of the curvatures along and across the plane of the axes.
    let narrow = || (profile.exponents() * profile.curvature()).sqrt();
    let mut y = (2.0 * neighbour.unwrap_or_else(narrow)).ln_1p().max(0.5);
    let (mut low, mut high) = (0.0, f64::INFINITY);
    for _ in 0..100 {
        let (value, slope) = residual(0.5 * y.exp_m1());
        if value > 0.0 {
            low = y
        } else {
            high = y
        }
        let newton = y - value / slope;
        // After a small step of Newton's the next would be its square; a bisection's would be its half.
        let (next, enough) = if slope < 0.0 && newton > low && newton < high {
            (newton, 1e-6)
        } else if high.is_finite() {
            (0.5 * (low + high), 1e-9)
        } else {
            (y + 1.0, 0.0)
        };
        let moved = (next - y).abs();
        y = next;
        if moved < enough || y > 60.0 {
            break;
        }
    }
    0.5 * y.exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use lobe_core::oracle::{Random, Zone, brute_force, product};

    #[test]
    fn coaxial_products_are_lobes_already() {
        for (e1, e2) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.25), (1.0, 20.0), (300.0, 4e4), (1e5, 1e5)] {
            let fit = fit_product(e1, e2, 0.0);
            assert!((fit.scale - 1.0).abs() < 1e-7, "{e1} {e2} {fit:?}");
            assert!((fit.exponent - e1 - e2).abs() < 1e-7 * (1.0 + e1 + e2), "{e1} {e2} {fit:?}");
        }
    }

    #[test]
    fn narrow_lobes_follow_the_curvatures() {
        // Two Gaussians: e_r → √(n_in·n_out) with n_in = e1/cos²t + e2/cos²(α−t).
        let (e1, e2, alpha) = (3e4, 8e4, 0.9);
        let fit = fit_product(e1, e2, alpha);
        let n_in = e1 / fit.angle.cos().powi(2) + e2 / (alpha - fit.angle).cos().powi(2);
        assert!((fit.exponent / (n_in * (e1 + e2)).sqrt() - 1.0).abs() < 1e-3);
    }

    /// Squared distance of Eq. 20 by plain quadrature over the sphere.
    fn distance_sq(e1: f64, e2: f64, alpha: f64, scale: f64, exponent: f64, angle: f64) -> f64 {
        let axis = |t: f64| DVec3::new(t.sin(), 0.0, t.cos());
        let (a2, r) = (axis(alpha), axis(angle));
        let f = |v: DVec3| {
            let c = v.z.max(0.0).powf(e1) * a2.dot(v).max(0.0).powf(e2);
            (c - scale * r.dot(v).max(0.0).powf(exponent)).powi(2)
        };
        brute_force(f, &Zone { axis: r, from: -1.0, to: 1.0, rings: 96, points: 96 })
    }

    #[test]
    fn no_neighbour_is_closer() {
        let mut random = Random::new(41);
        for _ in 0..25 {
            let (e1, e2, alpha) =
                (random.log_uniform(1.0, 30.0), random.log_uniform(1.0, 30.0), random.between(0.2, 2.0));
            let ProductFit { scale, exponent, angle } = fit_product(e1, e2, alpha);
            let best = distance_sq(e1, e2, alpha, scale, exponent, angle);
            for (ds, de) in [(1.02, 1.0), (0.98, 1.0), (1.0, 1.02), (1.0, 0.98), (1.02, 1.02), (0.98, 0.98)] {
                let other = distance_sq(e1, e2, alpha, scale * ds, exponent * de, angle);
                assert!(other > best, "{e1} {e2} {alpha}: {best:e} {other:e}");
            }
        }
    }

    #[test]
    fn lobes_of_all_sizes_are_finite() {
        let mut random = Random::new(42);
        for _ in 0..4000 {
            let (e1, e2, alpha) = (random.exponent(1e5), random.exponent(1e5), random.between(0.0, PI));
            let fit = fit_product(e1, e2, alpha);
            assert!(fit.scale.is_finite() && fit.scale >= 0.0, "{e1} {e2} {alpha} {fit:?}");
            assert!(fit.exponent.is_finite() && fit.exponent >= 0.0, "{e1} {e2} {alpha} {fit:?}");
            // Cauchy–Schwarz: ‖c_r‖ ≤ ‖c1c2‖ for a projection.
            let (own, whole) =
                (fit.scale * fit.scale * TAU / (2.0 * fit.exponent + 1.0), product(2.0 * e1, 2.0 * e2, alpha));
            assert!(own <= whole * (1.0 + 1e-6), "{e1} {e2} {alpha} {fit:?}");
        }
        assert_eq!(fit_product(1.0, 1.0, PI).scale, 0.0);
    }
}
