//! Products of lobes, and the moment lobes of products and sums, against the oracle.

use super::{EXTREME, levels, receiver};
use crate::oracle::{self, Random};
use crate::product::normalized_product;
use crate::*;
use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};

/// Axes whose angle survives rounding to f32: one minus cosine as given.
fn product_error(e1: f64, e2: f64, alpha: f64) -> (f64, f64) {
    let got = f64::from(product_of_angle(e1 as f32, e2 as f32, (2.0 * (0.5 * alpha).sin().powi(2)) as f32));
    let want = oracle::product(f64::from(e1 as f32), f64::from(e2 as f32), alpha);
    (got, want)
}

#[test]
fn product_against_quadrature() {
    let mut random = Random::new(1);
    let (mut worst, mut at, mut far) = (0.0, (0.0, 0.0, 0.0), 0.0_f64);
    for i in 0..20_000 {
        let e1 = random.exponent(1e6);
        let e2 = if i % 2 == 0 { random.exponent(1e6) } else { random.between(0.0, 12.0) };
        let width = (1.0 / (e1 + 0.1) + 1.0 / (e2 + 0.1)).sqrt();
        let alpha = if i % 3 == 0 { random.between(0.0, PI) } else { random.between(0.0, PI.min(5.0 * width)) };
        let (got, want) = product_error(e1, e2, alpha);
        assert!(got.is_finite() && got >= 0.0, "P({e1}, {e2}, {alpha}) = {got}");
        let coaxial = TAU / (e1 + e2 + 1.0);
        if want > 1e-4 * coaxial {
            let error = (got / want - 1.0).abs();
            if error > worst {
                (worst, at) = (error, (e1, e2, alpha));
            }
        } else {
            far = far.max((got - want).abs() / coaxial);
        }
    }
    println!("worst relative {worst:.2e} at {at:?}; elsewhere {far:.2e} of coaxial");
    assert!(worst < 1.5e-3 && far < 1e-6);
}

#[test]
fn product_at_the_extremes() {
    for e1 in [0.0, 1e-6, 0.5, 1.0, 5.0, 8.0, 1e5, 1e7] {
        for e2 in [0.0, 1e-6, 0.5, 1.0, 7.999, 1e5, 1e7] {
            for alpha in [0.0, 1e-7, 0.5, 0.5 * PI, 0.5 * PI + 1e-7, 2.0, PI - 1e-6, PI] {
                let (got, want) = product_error(e1, e2, alpha);
                let coaxial = TAU / (e1 + e2 + 1.0);
                // From 1e6 on there is no promise.
                let part = if e1.max(e2) <= 1e6 { 1.5e-3 } else { 5e-3 };
                let bound = if want > 1e-4 * coaxial { part * want } else { 1e-6 * coaxial };
                assert!((got - want).abs() <= bound, "P({e1}, {e2}, {alpha}) = {got}, not {want}");
            }
        }
    }
}

#[test]
fn a_delta_takes_the_lobes_value() {
    let at = receiver(DVec3::Z);
    let f = Lobe::new(Vec3::new(0.6, 0.0, 0.8), 30.0, Vec3::ONE);
    let light = Lobe::with_flux(Vec3::Z, f32::INFINITY, Vec3::ONE);
    let want = f.eval(Vec3::Z);
    for product in [normalized_product(&at, &f, &light), normalized_product(&at, &light, &f)] {
        assert!((f.flux * product - want).length() < 1e-5 * want.length());
    }
}

#[test]
fn narrow_lobes_keep_their_angle() {
    // A lobe of exponent 1e8…1e18 is a delta to one of exponent 100.
    let (a, b) = (Vec3::Z, Vec3::new(0.1_f32.sin(), 0.0, 0.1_f32.cos()));
    let want = crate::power(a, b, 100.0);
    for e in [1e8_f32, 1e10, 1e12, 1e15, 1e18] {
        let got = product_integral(100.0, e, a, b) * (e / core::f32::consts::TAU);
        assert!((got / want - 1.0).abs() < 1e-2, "e {e}: {got} instead of {want}");
    }
}

#[test]
fn products_side_by_side_are_the_single_ones_on_every_machine() {
    let mut random = Random::new(25);
    for count in [0, 1, 15, 16, 17, 4000] {
        let mut exponent =
            |k: usize| if k.is_multiple_of(17) { EXTREME[k / 17 % 12].min(1e18) } else { random.exponent(1e6) as f32 };
        let e1: Vec<f32> = (0..count).map(&mut exponent).collect();
        let e2: Vec<f32> = (0..count).map(|k| exponent(k + 5)).collect();
        let y: Vec<f32> = (0..count).map(|k| [0.0, 1e-7, 0.01, 0.3, 1.0, 1.3, 2.0][k % 7]).collect();
        for level in levels() {
            let mut out = vec![f32::NAN; count];
            crate::product::products_at(level, &e1, &e2, &y, &mut out);
            for (k, value) in out.into_iter().enumerate() {
                let single = product_of_angle(e1[k], e2[k], y[k]);
                assert_eq!(
                    value.to_bits(),
                    single.to_bits(),
                    "{level:?}: {value} {single} {} {} {}",
                    e1[k],
                    e2[k],
                    y[k]
                );
            }
        }
    }
}
