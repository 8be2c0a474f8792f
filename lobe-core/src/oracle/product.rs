use super::tanh_sinh::integrate;
use core::f64::consts::{PI, TAU};

/// Integrand below `e^-DROP` of its peak is left out.
const DROP: f64 = 50.0;

/// `∫ max(a·v, 0)^e dv = 2π/(e+1)`, steradians.
#[must_use]
pub fn lobe_integral(e: f64) -> f64 {
    TAU / (e + 1.0)
}

/// `P(e1, e2, α) = ∫ max(a1·v, 0)^e1 max(a2·v, 0)^e2 dv` over the sphere, for axes at the angle `alpha`.
///
/// `P = B(e1+e2)·J` separates in longitude and latitude about the axis perpendicular to both lobes:
/// `J = ∫ cos^e1 ψ cos^e2(ψ−α) dψ` over the common half-planes, see [`meridian`] for `B`. Relative error about 1e-11
/// wherever the result is a normal number, for exponents in [0, 1e7] and α in [0, π]; 0 where it underflows.
#[must_use]
pub fn product(e1: f64, e2: f64, alpha: f64) -> f64 {
    ln_product(e1, e2, alpha).exp()
}

/// `ln P(e1, e2, α)`: [`product`] where that would underflow; −∞ for α = π.
#[must_use]
pub fn ln_product(e1: f64, e2: f64, alpha: f64) -> f64 {
    let alpha = alpha.clamp(0.0, PI);
    let peak = Peak::of(e1, e2, alpha);
    meridian(e1 + e2).ln() + peak.ln_value + peak.relative_integral().ln()
}

/// `B(n) = ∫ cos^(n+1) θ dθ` over (−π/2, π/2) `= √π Γ(n/2+1)/Γ(n/2+3/2)`: what integrating a lobe product along the
/// meridians leaves. Relative error 1e-15 for n ≥ 0.
///
/// Recurrence up to `w = n/2 + 3/4 ≥ 16`, then the series of `ln Γ(w+1/4) − ln Γ(w+3/4)`, which has even powers of
/// `1/w` only; its coefficients are Euler numbers (NIST Digital Library of Mathematical Functions, 5.11.8 and 24.4.31).
#[must_use]
pub fn meridian(n: f64) -> f64 {
    let mut n = n;
    let mut factor = PI.sqrt();
    while n < 31.0 {
        factor *= (n + 3.0) / (n + 2.0);
        n += 2.0;
    }
    let w = 0.5 * n + 0.75;
    let x = 1.0 / (w * w);
    let series = x * (-1.0 / 64.0 + x * (5.0 / 2048.0 + x * (-61.0 / 49152.0 + x * (1385.0 / 1048576.0))));
    factor * series.exp() / w.sqrt()
}

/// The maximum of `cos^e1 ψ cos^e2(ψ−α)`, and its neighbourhood in coordinates that lose no digits.
struct Peak {
    exponents: [f64; 2],
    /// Angle from the peak to each axis.
    to_axis: [f64; 2],
    /// Angle from the peak to where each lobe ends.
    to_edge: [f64; 2],
    ln_value: f64,
}

impl Peak {
    fn of(e1: f64, e2: f64, alpha: f64) -> Self {
        let (sin, cos) = ((PI - alpha).sin().min(alpha.sin().abs()), alpha.cos());
        let root = (((e1 - e2) * cos).powi(2) + 4.0 * e1 * e2).sqrt();
        let sum = (e1 + e2) * cos.abs() + root;
        // tan t of Eq. 19 as a pair (sine, cosine) that is proportional to it; never a difference of near equals.
        let direction = |own: f64, other: f64| {
            if cos >= 0.0 { (2.0 * other * sin, sum) } else { (sum, 2.0 * own * sin) }
        };
        let ((s1, c1), (s2, c2)) = (direction(e1, e2), direction(e2, e1));
        let (to_axis, to_edge) = if sum > 0.0 {
            ([s1.atan2(c1), s2.atan2(c2)], [c1.atan2(s1), c2.atan2(s2)])
        } else {
            ([0.5 * alpha; 2], [0.5 * (PI - alpha); 2])
        };
        let ln_cos = |e: f64, x: f64, rest: f64| {
            if e == 0.0 {
                0.0
            } else if x < 1.0 {
                e * (-2.0 * (0.5 * x).sin().powi(2)).ln_1p()
            } else {
                e * rest.sin().ln()
            }
        };
        let ln_value = ln_cos(e1, to_axis[0], to_edge[0]) + ln_cos(e2, to_axis[1], to_edge[1]);
        Self { exponents: [e1, e2], to_axis, to_edge, ln_value }
    }

    /// `J` divided by the peak's value.
    fn relative_integral(&self) -> f64 {
        self.side(0, 1) + self.side(1, 0)
    }

    /// From the peak toward the edge of lobe `near`, away from the axis of lobe `near`.
    fn side(&self, near: usize, far: usize) -> f64 {
        let whole = self.to_edge[near];
        // ln of the integrand relative to the peak, at distance s; `left` is what remains to the edge.
        let ln_relative = |s: f64, left: f64| {
            let haversine = -2.0 * (0.5 * s).sin().powi(2);
            let term = |k: usize, sign: f64, distance: f64| {
                if self.exponents[k] == 0.0 {
                    return 0.0;
                }
                let change = haversine - sign * self.to_axis[k].sin() / self.to_edge[k].sin() * s.sin();
                let ln = if change > -0.5 && self.to_edge[k] > 0.0 {
                    change.ln_1p()
                } else {
                    (distance.sin() / self.to_edge[k].sin()).ln()
                };
                self.exponents[k] * ln
            };
            term(near, 1.0, left) + term(far, -1.0, self.to_edge[far] + s)
        };
        let mut window = whole;
        while window > 0.0 && ln_relative(0.5 * window, whole - 0.5 * window) < -DROP {
            window *= 0.5;
        }
        let beyond = whole - window;
        integrate(window, |s, right| ln_relative(s, beyond + right).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Random, Zone, brute_force};
    use super::*;
    use core::f64::consts::FRAC_PI_2;
    use glam::DVec3;

    fn close(a: f64, b: f64, relative: f64, what: &str) {
        assert!((a - b).abs() <= relative * b.abs(), "{what}: {a:e} {b:e} {:e}", (a / b - 1.0).abs());
    }

    #[test]
    fn meridian_integral_of_integer_powers() {
        // ∫cos^(n+1): π/2·(odd/even products) and 2·(even/odd products).
        for (n, exact) in [(0.0, 2.0), (1.0, FRAC_PI_2), (2.0, 4.0 / 3.0), (3.0, 3.0 * PI / 8.0), (4.0, 16.0 / 15.0)] {
            close(meridian(n), exact, 2e-15, "B");
        }
        // n·B(n)² → 2π with the next term −3π/n: Wallis.
        close(1e9 * meridian(1e9).powi(2), TAU * (1.0 - 1.5e-9), 1e-14, "B at large n");
    }

    #[test]
    fn coaxial_product_is_one_lobe() {
        for e1 in [0.0, 1e-6, 0.5, 1.0, 3.7, 200.0, 1e5, 1e7] {
            for e2 in [0.0, 1e-6, 0.5, 1.0, 90.0, 1e5, 1e7] {
                close(product(e1, e2, 0.0), lobe_integral(e1 + e2), 2e-12, &format!("{e1} {e2}"));
            }
        }
    }

    #[test]
    fn closed_forms_at_every_angle() {
        for i in 0..=64 {
            let alpha = PI * f64::from(i) / 64.0;
            // Two hemispheres share a lune of 2(π−α).
            close(product(0.0, 0.0, alpha), 2.0 * (PI - alpha), 1e-12, "lune");
            // A clamped cosine over a hemisphere: π(1+cos α)/2.
            let half = FRAC_PI_2 * 2.0 * (0.5 * alpha).cos().powi(2);
            if i < 64 {
                close(product(1.0, 0.0, alpha), half, 1e-12, "cosine over a hemisphere");
                close(product(0.0, 1.0, alpha), half, 1e-12, "hemisphere times cosine");
                // Two clamped cosines: (2/3)(sin α + (π−α) cos α), by parts from J.
                let rest = PI - alpha;
                close(product(1.0, 1.0, alpha), (rest.sin() - rest * rest.cos()) * 2.0 / 3.0, 1e-10, "cos·cos");
            }
        }
        assert_eq!(product(2.0, 3.0, PI), 0.0);
    }

    #[test]
    fn symmetric_and_recurrent() {
        // a1·v splits over a2 and the third direction: P(e1+1,e2,α) with the rotated pair is P of the mean vector, and
        // |M| ≤ P; a plain consequence that no code path shares: P decreases in each exponent and in α.
        let mut random = Random::new(3);
        for _ in 0..300 {
            let (e1, e2) = (random.exponent(1e7), random.exponent(1e7));
            let alpha = random.uniform() * PI;
            let p = ln_product(e1, e2, alpha);
            let mirrored = ln_product(e2, e1, alpha);
            assert!((p - mirrored).abs() <= 1e-12 * p.abs().max(10.0), "{e1} {e2} {alpha}");
            assert!(ln_product(e1 + 1.0, e2, alpha) < p && ln_product(e1, e2, (alpha + 1e-3).min(PI)) <= p);
        }
    }

    #[test]
    fn agrees_with_the_sphere() {
        let mut random = Random::new(5);
        for _ in 0..30 {
            // Whole exponents ≥ 3 keep the integrand smooth enough at the edges for the plain rule.
            let (e1, e2) = ((random.log_uniform(3.0, 60.0)).round(), random.log_uniform(3.0, 60.0).round());
            let alpha = random.uniform() * 2.5;
            let a2 = DVec3::new(alpha.sin(), 0.0, alpha.cos());
            let zone = Zone { axis: DVec3::Z, from: 0.0, to: 1.0, rings: 400, points: 800 };
            let f = |v: DVec3| v.z.powf(e1) * a2.dot(v).max(0.0).powf(e2);
            let (sum, exact) = (brute_force(f, &zone), product(e1, e2, alpha));
            assert!(
                (sum - exact).abs() < 1e-9 * lobe_integral(e1 + e2) + 1e-6 * exact,
                "{e1} {e2} {alpha}: {sum} {exact}"
            );
        }
    }

    #[test]
    fn lambert_factor_is_closed() {
        // J(1,e,α) = cos α·K(e+1) + sin^(e+2) α/(e+1) with K over [α−π/2, π/2]; at α = π/2, K is half of B(e).
        for e in [0.3, 1.0, 7.5, 300.0, 1e5, 1e7] {
            close(product(1.0, e, FRAC_PI_2), meridian(e + 1.0) / (e + 1.0), 2e-11, "quarter turn");
        }
    }

    #[test]
    fn extremes_are_finite() {
        let exponents = [0.0, 1e-6, 0.5, 1.0, 1e5, 1e7];
        let ulp = f64::EPSILON;
        for e1 in exponents {
            for e2 in exponents {
                for alpha in [0.0, 1e-7, FRAC_PI_2 - ulp, FRAC_PI_2, FRAC_PI_2 + ulp, PI - 1e-7, PI] {
                    let p = product(e1, e2, alpha);
                    assert!(p.is_finite() && (0.0..=TAU * (1.0 + 1e-14)).contains(&p), "{e1} {e2} {alpha} {p}");
                    assert!(!ln_product(e1, e2, alpha).is_nan(), "{e1} {e2} {alpha}");
                }
            }
        }
        // A delta-like pair a hair apart: exp(−½·e1e2/(e1+e2)·α²)·2π/(e1+e2).
        close(product(1e7, 1e7, 1e-4), (-0.025f64).exp() * TAU / 2e7, 2e-7, "needles");
    }
}
