use glam::Vec3;
use lobe_core::{Cone, Lobe};

/// Values in each table (§5.2).
pub(crate) const VALUES: usize = 1000;

/// The least-squares lobe of a uniformly bright cone of radiance 1: `w_light` and `e_light` of Eq. 30.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightLobe {
    /// Scale `w_light`.
    pub weight: f64,
    /// Exponent `e_light`.
    pub exponent: f64,
}

/// Fits one lobe to a uniform cone (Eq. 31); `one_minus_cos` = 1 − cos θ of the half-angle, clamped to (0, 1].
///
/// With C = cos θ the best scale for an exponent is `w = (2e+1)(1−C^(e+1))/(e+1)`, and e maximises
/// `(2e+1)(1−C^(e+1))²/(e+1)²`. For small lights `w → 1.43` and `(e+1)(1−C) → x` with `eˣ = 1+2x`: the lobe's flux is
/// then 13.8 % more than the light's, which is the price of least squares.
#[must_use]
pub fn fit_light(one_minus_cos: f64) -> LightLobe {
    let q = clamp(one_minus_cos);
    let ln_cos = (-q).ln_1p();
    // Derivative of the logarithm; decreasing through its one zero.
    let exponent = root(q, |e| {
        let m = e + 1.0;
        let tail = if ln_cos.is_finite() { -2.0 * ln_cos / (-m * ln_cos).exp_m1() } else { 0.0 };
        1.0 / (e + 0.5) - 2.0 / m + tail
    });
    let m = exponent + 1.0;
    LightLobe { weight: (2.0 * exponent + 1.0) * -(m * ln_cos).exp_m1() / m, exponent }
}

/// Fits the exponent of a lobe of scale 1 to a cone (Eq. 35): `e_cap` of an occluder that is seen under the half-angle
/// θ, `one_minus_cos` = 1 − cos θ clamped to (0, 1].
#[must_use]
pub fn fit_occluder(one_minus_cos: f64) -> f64 {
    let q = clamp(one_minus_cos);
    let ln_cos = (-q).ln_1p();
    root(q, |e| {
        let m = e + 1.0;
        let left = (m * ln_cos).exp();
        let slope = if left > 0.0 { ln_cos * left } else { 0.0 };
        // Minus the derivative of −2(1−C^m)/m + 1/(2e+1).
        1.0 / (2.0 * (e + 0.5) * (e + 0.5)) - 2.0 * (1.0 - left) / (m * m) - 2.0 * slope / m
    })
}

fn clamp(one_minus_cos: f64) -> f64 {
    one_minus_cos.clamp(1e-12, 1.0)
}

/// The exponent at which a function changes from positive to negative, between 0 and 8/(1 − cos θ), by bisection.
fn root(one_minus_cos: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 8.0 / one_minus_cos);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if f(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

/// The tables of §5.2 and §5.3: lobes of spherical lights and occluders by the cone that they are seen in, 10³ values,
/// linear interpolation.
///
/// Over `1 − cos θ`, which a [`Cone`] carries. Exponents are kept as `(e+1)(1 − cos θ)`, which is finite for a
/// vanishing cone: a table of `e` itself would end at some largest distance. Cones wider than a hemisphere are taken
/// as one.
#[derive(Clone, Debug)]
pub struct CapTable {
    /// `w_light`, `(e_light+1)(1−C)` and `(e_cap+1)(1−C)`.
    rows: Vec<[f32; 3]>,
}

impl CapTable {
    /// Solves Eq. 31 and Eq. 35 at all samples: a few milliseconds.
    #[must_use]
    pub fn build() -> Self {
        let row = |i: usize| {
            let q = clamp(i as f64 / (VALUES - 1) as f64);
            let light = fit_light(q);
            [light.weight, (light.exponent + 1.0) * q, (fit_occluder(q) + 1.0) * q].map(|x| x as f32)
        };
        Self { rows: (0..VALUES).map(row).collect() }
    }

    pub(crate) fn rows(&self) -> &[[f32; 3]] {
        &self.rows
    }

    fn lookup(&self, one_minus_cos: f32) -> [f32; 3] {
        let position = one_minus_cos.clamp(0.0, 1.0) * (VALUES - 1) as f32;
        let i = (position as usize).min(VALUES - 2);
        let t = position - i as f32;
        core::array::from_fn(|k| self.rows[i][k] + t * (self.rows[i + 1][k] - self.rows[i][k]))
    }

    /// The lobe of a light of uniform radiance that is seen in `cone` (Eq. 30): `radiance·w·max(axis·v, 0)^e`.
    ///
    /// A point light (a cone of half-angle 0) has no flux here, as its solid angle is 0.
    #[must_use]
    pub fn light(&self, cone: &Cone, radiance: Vec3) -> Lobe {
        let [weight, spread, _] = self.lookup(cone.one_minus_cos);
        let q = cone.one_minus_cos.clamp(0.0, 1.0);
        // flux = 2π w/(e+1), and (e+1) = spread/(1−C).
        let flux = radiance * (core::f32::consts::TAU * weight * q / spread);
        Lobe::with_flux(cone.axis, exponent(spread, q), flux)
    }

    /// The lobe of scale 1 that stands for an occluder seen in `cone` (Eq. 34).
    #[must_use]
    pub fn occluder(&self, cone: &Cone) -> Lobe {
        let [_, _, spread] = self.lookup(cone.one_minus_cos);
        let q = cone.one_minus_cos.clamp(0.0, 1.0);
        Lobe::with_flux(cone.axis, exponent(spread, q), Vec3::splat(core::f32::consts::TAU * q / spread))
    }
}

/// `e` from `(e+1)(1−C)`; infinite for a cone without extent.
fn exponent(spread: f32, one_minus_cos: f32) -> f32 {
    (spread / one_minus_cos - 1.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// Squared distance between a cone and `w·max(cos, 0)^e`, over 2π, by parts from the two closed integrals.
    fn distance_sq(q: f64, w: f64, e: f64) -> f64 {
        q + 2.0 * w * ((e + 1.0) * (-q).ln_1p()).exp_m1() / (e + 1.0) + w * w / (2.0 * e + 1.0)
    }

    #[test]
    fn no_neighbour_is_closer() {
        for q in [1e-6, 1e-3, 0.1, 0.5, 0.9, 0.999] {
            let (light, cap) = (fit_light(q), fit_occluder(q));
            let (best, best_cap) = (distance_sq(q, light.weight, light.exponent), distance_sq(q, 1.0, cap));
            for f in [0.99, 1.01] {
                assert!(distance_sq(q, light.weight * f, light.exponent) > best, "{q}");
                assert!(distance_sq(q, light.weight, light.exponent * f) > best, "{q}");
                assert!(distance_sq(q, 1.0, cap * f) > best_cap, "{q}");
            }
            // A search over all exponents: no other local minimum is deeper.
            for i in 0..4000 {
                let e = (f64::from(i) * 0.005).exp_m1();
                let m = e + 1.0;
                let w = (2.0 * e + 1.0) * -(m * (-q).ln_1p()).exp_m1() / m;
                assert!(distance_sq(q, w, e) >= best * (1.0 - 1e-12), "{q} {e}");
                assert!(distance_sq(q, 1.0, e) >= best_cap * (1.0 - 1e-12), "{q} {e}");
            }
        }
    }

    #[test]
    fn limits() {
        // e^x = 1+2x: x = 1.25643, w = 2(1−e^(−x)) = 1.43067, flux ratio w/x = 1.13868.
        let small = fit_light(1e-9);
        assert!((small.exponent * 1e-9 - 1.25643).abs() < 1e-5 && (small.weight - 1.43067).abs() < 1e-5, "{small:?}");
        let hemisphere = fit_light(1.0);
        assert!(hemisphere.exponent < 1e-9 && (hemisphere.weight - 1.0).abs() < 1e-9, "{hemisphere:?}");
        assert!(fit_occluder(1.0) < 1e-6);
    }

    #[test]
    fn table_follows_the_fits() {
        let table = CapTable::build();
        for i in 1..=3000 {
            let q = (f64::from(i) / 3000.0).powi(3) as f32;
            let cone = Cone { axis: Vec3::Z, one_minus_cos: q, distance: 1.0 };
            let (light, exact) = (table.light(&cone, Vec3::ONE), fit_light(f64::from(q)));
            let (occluder, e_cap) = (table.occluder(&cone), fit_occluder(f64::from(q)));
            assert!((f64::from(light.exponent) - exact.exponent).abs() < 1e-3 * (1.0 + exact.exponent), "{q}");
            assert!((f64::from(light.scale().x) - exact.weight).abs() < 1e-3, "{q}");
            assert!((f64::from(occluder.exponent) - e_cap).abs() < 1e-3 * (1.0 + e_cap), "{q}");
            assert!((occluder.scale().x - 1.0).abs() < 1e-5, "{q}");
            let overshoot = f64::from(light.flux.x) / (TAU * f64::from(q));
            assert!((0.999..1.14).contains(&overshoot), "{q} {overshoot}");
        }
    }

    #[test]
    fn finite_for_every_cone() {
        let table = CapTable::build();
        for q in [0.0, 1e-30, 1e-7, 1.0, 1.7, 2.0] {
            let cone = Cone { axis: Vec3::X, one_minus_cos: q, distance: 1.0 };
            let (light, occluder) = (table.light(&cone, Vec3::ONE), table.occluder(&cone));
            assert!(light.flux.is_finite() && occluder.flux.is_finite(), "{q}");
            assert!(light.exponent >= 0.0 && occluder.exponent >= 0.0, "{q}");
        }
    }
}
