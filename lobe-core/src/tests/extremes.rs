//! Integrals, fractions and values stay in range for extreme exponents, widths and angles.

use super::EXTREME;
use crate::oracle::Random;
use crate::product::normalized_product;
use crate::*;
use glam::Vec3;

/// Directions that are exactly, or nearly, along, against and across each other.
fn awkward(random: &mut Random, from: Vec3) -> Vec3 {
    let from = from.as_dvec3();
    let axis = match random.bits() % 8 {
        0 => return from.as_vec3(),
        1 => return -from.as_vec3(),
        2 => random.axis_near(from),
        3 => -random.axis_near(from),
        4 => from.any_orthonormal_vector(),
        5 => random.axis_near(from.any_orthonormal_vector()),
        _ => random.axis(),
    };
    axis.as_vec3().normalize()
}

#[test]
fn integrals_are_finite_for_everything() {
    let mut random = Random::new(21);
    for case in 0..60_000 {
        let normal = random.axis().as_vec3().normalize();
        let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
        let mut pick = || EXTREME[(random.bits() % 12) as usize];
        let (e1, e2) = (pick(), pick());
        let (a, b) = (awkward(&mut random, normal), awkward(&mut random, normal));
        let b = if case % 3 == 0 { awkward(&mut random, a) } else { b };
        let f = Lobe { has_cosine: random.bits() % 2 == 1, ..Lobe::with_flux(a, e1, Vec3::ONE) };
        let c = Lobe::with_flux(b, e2, Vec3::ONE);
        let one_minus_cos = [0.0, f32::MIN_POSITIVE, 1e-14, 1e-7, 1e-3, 0.5, 1.0 - 6e-8, 1.0, 2.0][case % 9];
        let cone = Cone { axis: b, one_minus_cos, distance: [0.0, 1.0, f32::INFINITY][case % 3] };
        let cap = cap_integral(&at, f, &cone);
        assert!((0.0..1.02).contains(&cap), "cap {cap} {f:?} {cone:?} {normal}");
        let product = normalized_product(&at, &f, &c);
        assert!(product >= 0.0 && product.is_finite(), "product {product} {f:?} {c:?}");
        let p = product_integral(e1.min(1e18), e2.min(1e18), a, b);
        assert!((0.0..=2.0 * core::f32::consts::TAU).contains(&p), "P {p} {e1} {e2} {a} {b}");
        assert!(sphere_light_irradiance(normal.dot(b), cone.sin_sq()) >= 0.0);
    }
}

#[test]
fn fractions_stay_between_zero_and_one() {
    let mut random = Random::new(22);
    let mut sum = VisibilitySum::default();
    for case in 0..30_000 {
        let normal = random.axis().as_vec3().normalize();
        let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
        let pick = |random: &mut Random| EXTREME[(random.bits() % 12) as usize];
        let e = pick(&mut random);
        let axis = awkward(&mut random, normal);
        let f = Lobe { has_cosine: case % 2 == 1, ..Lobe::with_flux(axis, e, Vec3::ONE) };
        let mut lit = sum.lobes.writer();
        let mut whole = sum.whole.writer();
        for k in 0..case % 4 {
            let axis = awkward(&mut random, f.axis);
            let lobe = Lobe::with_flux(axis, pick(&mut random), Vec3::splat(random.log_uniform(1e-30, 1.0) as f32));
            lit.push(lobe);
            if k < case % 5 {
                whole.push(lobe);
            }
        }
        sum.base = [0.0, 0.5, 1.0][case % 3];
        let unshadowed = [0.0, f32::MIN_POSITIVE, 1e-3, 1.0][case / 4 % 4];
        let share = visible_fraction(&at, &f, unshadowed, &sum);
        assert!((0.0..=1.0).contains(&share), "{share} {f:?} {sum:?} {unshadowed}");
    }
}

#[test]
fn a_lobe_has_a_value_beside_an_infinite_exponent() {
    let aside = Vec3::new(0.6, 0.0, 0.8);
    for e in [1e30_f32, 3e38, f32::MAX, f32::INFINITY] {
        for flux in [0.5_f32, 1e3, 1e30] {
            let lobe = Lobe::with_flux(Vec3::Z, e, Vec3::splat(flux));
            for v in [aside, -Vec3::Z, Vec3::X] {
                assert_eq!(lobe.eval(v), Vec3::ZERO, "{e} {flux}");
            }
            assert!(lobe.eval(Vec3::Z).x > 1e20);
        }
    }
}
