//! The closed forms against the f64 oracle.

use crate::lanes::{WIDTH, set_row};
use crate::oracle::{self, CapLobe, Random};
use crate::*;
use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};

pub(crate) fn receiver(normal: DVec3) -> Receiver {
    Receiver {
        position: Vec3::ZERO,
        normal: normal.as_vec3(),
        face: normal.as_vec3(),
        view: normal.as_vec3(),
        object: OWN_NONE,
    }
}

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
    assert!(worst < 2e-3 && far < 1e-6);
}

#[test]
fn product_at_the_extremes() {
    for e1 in [0.0, 1e-6, 0.5, 1.0, 5.0, 8.0, 1e5, 1e7] {
        for e2 in [0.0, 1e-6, 0.5, 1.0, 7.999, 1e5, 1e7] {
            for alpha in [0.0, 1e-7, 0.5, 0.5 * PI, 0.5 * PI + 1e-7, 2.0, PI - 1e-6, PI] {
                let (got, want) = product_error(e1, e2, alpha);
                let coaxial = TAU / (e1 + e2 + 1.0);
                let bound = if want > 1e-4 * coaxial { 5e-3 * want } else { 1e-6 * coaxial };
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
    assert!((lobe_product(&at, &f, &light) - want).length() < 1e-5 * want.length());
    assert!((lobe_product(&at, &light, &f) - want).length() < 1e-5 * want.length());
}

/// A lobe and a light at random, the light wholly above the horizon or not.
fn cap_case(random: &mut Random, exponents: (f64, f64), cosine: bool, through: bool) -> (f64, f64, f64) {
    let e = f64::from(random.log_uniform(exponents.0, exponents.1) as f32);
    let theta = random.log_uniform(0.05, 40.0).to_radians();
    let normal = random.axis();
    let beta = if through {
        random.between(0.5 * PI - theta, 0.5 * PI + theta)
    } else {
        random.between(0.0, 0.5 * PI - theta)
    };
    let light = random.axis_at(normal, beta).as_vec3().normalize();
    let delta = random.between(0.0, (theta + 4.0 / e.sqrt()).min(PI));
    let axis = random.axis_at(light.as_dvec3(), delta).as_vec3().normalize();
    let one_minus_cos = (2.0 * (0.5 * theta).sin().powi(2)) as f32;
    let theta = 2.0 * (0.5 * f64::from(one_minus_cos)).sqrt().asin();
    let at = receiver(normal);
    let cone = Cone { axis: light, one_minus_cos, distance: 1.0 };
    let lobe = Lobe { factor: if cosine { 1.0 } else { 0.0 }, ..Lobe::new(axis, e as f32, Vec3::ONE) };
    let got = f64::from(cap_integral(&at, &lobe, &cone)) * TAU / (e + 1.0);
    let truth =
        CapLobe { axis: axis.as_dvec3().normalize(), exponent: e, cosine, normal: at.normal.as_dvec3().normalize() };
    let want = oracle::cap(&truth, light.as_dvec3().normalize(), theta);
    let on_axis = TAU * -((e + 1.0) * (-f64::from(one_minus_cos)).ln_1p()).exp_m1() / (e + 1.0);
    (got, want, on_axis)
}

fn cap_errors(exponents: (f64, f64), cosine: bool, through: bool) -> (f64, f64) {
    let mut random = Random::new(7);
    let mut errors: Vec<f64> = (0..1000)
        .map(|_| {
            let (got, want, on_axis) = cap_case(&mut random, exponents, cosine, through);
            assert!(got.is_finite());
            (got - want).abs() / on_axis
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    println!(
        "e {exponents:?} cosine {cosine} horizon {through}: mean {:.4} % p99 {:.3} % max {:.3} %",
        100.0 * mean,
        100.0 * errors[errors.len() * 99 / 100],
        100.0 * errors[errors.len() - 1]
    );
    (mean, errors[errors.len() - 1])
}

#[test]
fn lobe_over_light_above_the_horizon() {
    for cosine in [false, true] {
        for exponents in [(0.01, 1.0), (1.0, 5.0), (5.0, 50.0), (50.0, 399.0), (400.0, 1e5), (1e5, 1e6)] {
            let (mean, max) = cap_errors(exponents, cosine, false);
            let bound = if exponents.1 <= 1.0 {
                6e-3
            } else if cosine {
                3e-3
            } else {
                1.7e-3
            };
            assert!(mean < 5e-4 && max < bound);
        }
    }
}

#[test]
fn lobe_over_light_through_the_horizon() {
    for cosine in [false, true] {
        for exponents in [(0.01, 1.0), (1.0, 5.0), (5.0, 49.9), (50.0, 500.0), (500.0, 1e5)] {
            let (mean, max) = cap_errors(exponents, cosine, true);
            assert!(mean < 2e-4 && max < 3e-3);
        }
    }
}

/// 99th-percentile and largest error, of the on-axis value, over lights of `1 − cos θ` in a range. Rounding of n·l by 2e-7,
/// which moves the horizon across a small light, is left out, and that of a·l where the lobe's own edge is as sharp.
fn survey(exponents: (f64, f64), lights: (f64, f64), cosine: bool, through: bool, count: usize) -> (f64, f64) {
    let mut random = Random::new(31);
    let mut worst = (0.0_f64, String::new());
    let mut errors: Vec<f64> = (0..count)
        .map(|_| {
            let e = random.log_uniform(exponents.0, exponents.1) as f32;
            let wide = random.log_uniform(lights.0, lights.1);
            let one_minus_cos = if wide > 0.5 && random.bits().is_multiple_of(2) { 1.0 } else { wide.min(1.0) } as f32;
            let theta = 2.0 * (0.5 * f64::from(one_minus_cos)).sqrt().asin();
            let normal = random.axis().as_vec3().normalize();
            let sin = theta.sin();
            let height = if through { random.between(-1.0, 1.0) * sin } else { random.between(sin, 1.0) };
            let light = random.axis_at(normal.as_dvec3(), height.acos()).as_vec3().normalize();
            let delta = match random.bits() % 3 {
                0 => random.between(0.0, PI),
                1 => (0.5 * PI + random.between(-1.5, 1.5) * theta).clamp(0.0, PI),
                _ => random.between(0.0, (theta + 4.0 / f64::from(e).sqrt()).min(PI)),
            };
            let axis = random.axis_at(light.as_dvec3(), delta).as_vec3().normalize();
            let at = receiver(normal.as_dvec3());
            let cone = Cone { axis: light, one_minus_cos, distance: 1.0 };
            let lobe = Lobe { factor: if cosine { 1.0 } else { 0.0 }, ..Lobe::with_flux(axis, e, Vec3::ONE) };
            let truth = CapLobe {
                axis: axis.as_dvec3().normalize(),
                exponent: f64::from(e),
                cosine,
                normal: normal.as_dvec3().normalize(),
            };
            let n = f64::from(e) + 1.0;
            let want = oracle::cap(&truth, light.as_dvec3().normalize(), theta) * n / TAU;
            let on_axis = -(n * (-f64::from(one_minus_cos)).ln_1p()).exp_m1();
            let got = f64::from(cap_integral(&at, &lobe, &cone));
            let rounding = if through || e < 1.0 { 2e-7 / sin } else { 0.0 };
            let error = ((got - want).abs() / on_axis - rounding).max(0.0);
            if error > worst.0 {
                worst = (error, format!("e {e:e} 1−cos θ {one_minus_cos:e} δ {delta:.4} n·l {height:.4}: {got:.4e} for {want:.4e} of {on_axis:.4e}"));
            }
            error
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    let p99 = errors[errors.len() * 99 / 100];
    println!(
        "e {exponents:?} 1−cos θ {lights:?} cosine {cosine} horizon {through}: p99 {p99:.1e} max {:.1e} at {}",
        worst.0, worst.1
    );
    (p99, worst.0)
}

#[test]
fn lobes_over_lights_of_all_sizes() {
    let exponents = [(1e-3, 1.0), (1.0, 5.0), (5.0, 50.0), (50.0, 400.0), (400.0, 1e5)];
    let lights = [(1e-12, 1e-6), (1e-6, 1e-2), (1e-2, 0.5), (0.5, 0.93), (0.93, 1.0)];
    for through in [false, true] {
        for exponents in exponents {
            for lights in lights {
                for cosine in [false, true] {
                    let (p99, max) = survey(exponents, lights, cosine, through, 250);
                    let (p99_limit, limit) = if exponents.1 <= 1.0 {
                        (6e-3, 6e-3)
                    } else if through {
                        (1.5e-3, 3e-3)
                    } else {
                        (1.5e-3, 1.5e-3)
                    };
                    assert!(
                        p99 <= p99_limit && max <= limit,
                        "e {exponents:?} 1−cos θ {lights:?} {through}: {p99} {max}"
                    );
                }
            }
        }
    }
}

#[test]
fn seams_between_slab_and_chords() {
    let mut random = Random::new(3);
    let at = receiver(DVec3::Z);
    let (mut by_exponent, mut by_width) = (0.0_f32, 0.0_f32);
    for _ in 0..2000 {
        let e = random.log_uniform(400.0, 1e5) as f32;
        let width = random.log_uniform(3.0, 90.0) as f32;
        let value = |e: f32, one_minus_cos: f32, axis: Vec3| {
            cap_integral(&at, &Lobe::new(axis, e, Vec3::ONE), &Cone { axis: Vec3::Z, one_minus_cos, distance: 1.0 })
        };
        let offset = |c: f32| f64::from((2.0 * c).sqrt()) + 4.0 / f64::from(e).sqrt();
        // Across the exponent 400 at any width, and across the width at any exponent.
        let c = width / 401.0;
        let axis = random.axis_at(DVec3::Z, random.clone().between(0.0, offset(c))).as_vec3().normalize();
        by_exponent =
            by_exponent.max((value(399.99, c, axis) - value(400.01, c, axis)).abs() / value(400.0, c, Vec3::Z));
        let c = 3.0 / (e + 1.0);
        let axis = random.axis_at(DVec3::Z, random.clone().between(0.0, offset(c))).as_vec3().normalize();
        by_width = by_width.max((value(e, c * 0.9999, axis) - value(e, c * 1.0001, axis)).abs() / value(e, c, Vec3::Z));
    }
    println!("seams: {by_exponent:.2e} across the exponent, {by_width:.2e} across the width");
    assert!(by_exponent < 2e-3 && by_width < 2e-3);
}

/// Sphere lights at a receiver's horizon, `(cos β, sin²σ)`: all sizes, and heights that come as near to the ends as digits let
/// them.
pub(crate) fn at_the_horizon(random: &mut Random) -> (f32, f32) {
    let sin_sq = match random.bits() % 8 {
        0 => 1.0 - random.log_uniform(1e-7, 0.5),
        1 => 1.0,
        2..4 => random.log_uniform(1e-2, 1.0),
        _ => random.log_uniform(1e-18, 1.0),
    } as f32;
    let s = f64::from(sin_sq).sqrt();
    let height = match random.bits() % 4 {
        0 => random.log_uniform(1e-6, 1.0) - 1.0,
        1 => 1.0 - random.log_uniform(1e-6, 1.0),
        2 => random.log_uniform(1e-7, 1.0) * if random.bits().is_multiple_of(2) { 1.0 } else { -1.0 },
        _ => random.between(-1.0, 1.0),
    };
    ((s * height) as f32, sin_sq)
}

/// Error relative to the value itself, and that value over `s³`.
pub(crate) fn irradiance_error(got: f32, (cos_beta, sin_sq): (f32, f32)) -> (f64, f64) {
    let s = f64::from(sin_sq).sqrt();
    let want = oracle::sphere_light_irradiance(f64::from(cos_beta), s.asin());
    let least = (1e-14 * s.powi(3)).max(f64::from(f32::MIN_POSITIVE));
    ((f64::from(got) - want).abs() / want.max(least), want / s.powi(3))
}

#[test]
fn lambert_is_exact_at_every_horizon_crossing() {
    let mut random = Random::new(5);
    let mut worst = (0.0_f64, String::new());
    for _ in 0..400_000 {
        let light = at_the_horizon(&mut random);
        let (error, value) = irradiance_error(sphere_light_irradiance(light.0, light.1), light);
        if error > worst.0 {
            worst = (error, format!("cos β {:e} sin² {:e}: {value:.3e} s³", light.0, light.1));
        }
    }
    println!("sphere lights through the horizon: {:.1e} at {}", worst.0, worst.1);
    assert!(worst.0 <= 1e-5, "{worst:?}");
}

/// The integrator's tile takes the same formula in columns.
#[test]
fn small_lights_at_the_horizon_of_a_tile() {
    let mut random = Random::new(6);
    let (mut at, mut centers) = (Vec::new(), Vec::new());
    for _ in 0..1024 {
        // A horizontal receiver, the light's centre at a height that f32 keeps: n·l is that height over the distance.
        let radius = random.log_uniform(1e-8, 0.5) as f32;
        let height = random.between(-0.99, 0.99) as f32 * radius;
        at.push(Receiver { position: Vec3::new(-1.0, 0.0, -height), ..receiver(DVec3::Z) });
        centers.push((radius, height));
    }
    let (mut tile, mut light, mut lobes, mut out) =
        (Tile::default(), TileLight::default(), TileLobes::default(), Vec::new());
    for (at, (radius, _)) in at.iter().zip(&centers) {
        tile.set(core::slice::from_ref(at));
        light.ball(&tile, Sphere { center: Vec3::ZERO, radius: *radius }, Vec3::ONE);
        lobes.reset(&tile, 1);
        set_row(lobes.block_mut(0, 0), 0, &bytemuck::cast(Lobe::new(Vec3::Z, 1.0, Vec3::ONE)));
        cap_integrals(&light, &lobes, &mut out);
        let cone = light.cone(0);
        let seen = (at.normal.dot(cone.axis), cone.sin_sq());
        let (error, value) = irradiance_error(out[0] * core::f32::consts::PI, seen);
        assert!(error <= 1e-5, "radius {radius}: {error:.1e} of {value} s³");
    }
}

#[test]
fn inside_a_light_everything_is_bright() {
    let at = receiver(DVec3::Z);
    let cone = Cone { axis: Vec3::X, one_minus_cos: 2.0, distance: 0.1 };
    let lambert = cap_integral(&at, &Lobe::new(Vec3::Z, 1.0, Vec3::ONE), &cone);
    assert!((lambert - 1.0).abs() < 1e-5, "{lambert}");
    let phong = cap_integral(&at, &Lobe::new(Vec3::Z, 20.0, Vec3::ONE), &cone);
    assert!((phong - 1.0).abs() < 1e-3, "{phong}");
}

#[test]
fn a_light_grows_continuously_from_a_point() {
    let at = receiver(DVec3::Z);
    for e in [0.0_f32, 1.0, 3.0, 50.0, 1e5, 1e7] {
        let axis = Vec3::new(0.0, 0.6, 0.8);
        let light = Vec3::new(0.0, 0.6_f32.sin() * 0.0 + 0.6, 0.8);
        let mut last = 0.0;
        for k in 0..40 {
            let one_minus_cos = 1e-12 * 2.0_f32.powi(k);
            let value =
                cap_integral(&at, &Lobe::new(axis, e, Vec3::ONE), &Cone { axis: light, one_minus_cos, distance: 1.0 });
            assert!(value.is_finite() && value >= last * 0.999, "e {e} k {k}: {value} after {last}");
            last = value;
        }
    }
}

#[test]
fn moment_lobe_of_a_product_keeps_its_mean() {
    let mut random = Random::new(11);
    let mut worst = (0.0_f64, 0.0_f64);
    for _ in 0..300 {
        let (e1, e2) = (random.log_uniform(0.5, 300.0), random.log_uniform(0.5, 300.0));
        let a = random.axis().as_vec3().normalize();
        let width = (1.0 / e1 + 1.0 / e2).sqrt();
        let b = random.axis_at(a.as_dvec3(), random.clone().between(0.0, (2.5 * width).min(2.0))).as_vec3().normalize();
        let lobe = product_lobe(&Lobe::new(a, e1 as f32, Vec3::ONE), &Lobe::new(b, e2 as f32, Vec3::ONE));
        // ∫ (a·v) c₁c₂ = P(e₁+1, e₂, α), and the other way round.
        let alpha = f64::from(a.as_dvec3().angle_between(b.as_dvec3()) as f32);
        let p = oracle::product(e1, e2, alpha);
        let mean = f64::from(1.0 - 1.0 / (lobe.exponent + 2.0));
        for (axis, want) in [(a, oracle::product(e1 + 1.0, e2, alpha)), (b, oracle::product(e1, e2 + 1.0, alpha))] {
            let got = mean * axis.as_dvec3().dot(lobe.axis.as_dvec3());
            worst.0 = worst.0.max((got - want / p).abs());
        }
        worst.1 = worst.1.max((f64::from(lobe.flux.x) / p - 1.0).abs());
    }
    println!("product lobe: mean vector {:.2e}, total {:.2e}", worst.0, worst.1);
    assert!(worst.0 < 6e-3 && worst.1 < 2e-3);
}

#[test]
fn mixtures_keep_total_and_mean() {
    let mut buffer = LobeBuffer::with_capacity(3);
    let mut out = buffer.writer();
    let parts = [(Vec3::Z, 1e6, 1.0), (Vec3::new(0.001, 0.0, 1.0).normalize(), 1e6, 2.0)];
    for (axis, e, flux) in parts {
        out.push(Lobe::with_flux(axis, e, Vec3::splat(flux))).unwrap();
    }
    let lobe = mixture_lobe(buffer.lobes()).unwrap();
    assert!((lobe.flux.x - 3.0).abs() < 1e-6);
    // 1−R = 1e-6 (the parts) + variance/2 of the axes: 2/9·1e-6/2.
    let spread = f64::from(1.0 / (lobe.exponent + 2.0));
    assert!((spread / (1e-6 + 1e-6 / 9.0) - 1.0).abs() < 1e-3, "{spread}");
    assert!(mixture_lobe(LobeBuffer::default().lobes()).is_none());
}

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

const EXTREME: [f32; 12] = [0.0, 1e-30, 1e-6, 0.5, 0.999_999, 1.0, 7.999, 400.0, 1e5, 1e7, 1e20, f32::INFINITY];

#[test]
fn integrals_are_finite_for_everything() {
    let mut random = Random::new(21);
    for case in 0..60_000 {
        let normal = random.axis().as_vec3().normalize();
        let at = Receiver { position: Vec3::ZERO, normal, face: normal, view: normal, object: OWN_NONE };
        let mut pick = || EXTREME[(random.bits() % 12) as usize];
        let (e1, e2) = (pick(), pick());
        let (a, b) = (awkward(&mut random, normal), awkward(&mut random, normal));
        let b = if case % 3 == 0 { awkward(&mut random, a) } else { b };
        let f = Lobe { factor: (random.bits() % 2) as f32, ..Lobe::with_flux(a, e1, Vec3::ONE) };
        let c = Lobe::with_flux(b, e2, Vec3::ONE);
        let one_minus_cos = [0.0, f32::MIN_POSITIVE, 1e-14, 1e-7, 1e-3, 0.5, 1.0 - 6e-8, 1.0, 2.0][case % 9];
        let cone = Cone { axis: b, one_minus_cos, distance: [0.0, 1.0, f32::INFINITY][case % 3] };
        let cap = cap_integral(&at, &f, &cone);
        assert!((0.0..1.02).contains(&cap), "cap {cap} {f:?} {cone:?} {normal}");
        let product = lobe_product(&at, &f, &c).x;
        assert!(product >= 0.0 && product.is_finite(), "product {product} {f:?} {c:?}");
        let lobe = product_lobe(&Lobe { factor: 0.0, ..f }, &c);
        assert!(!lobe.axis.is_nan() && (lobe.axis.length() - 1.0).abs() < 1e-4, "{lobe:?} {f:?} {c:?}");
        assert!(lobe.exponent >= 0.0 && !lobe.flux.is_nan(), "{lobe:?} {f:?} {c:?}");
        let p = product_integral(e1.min(1e18), e2.min(1e18), a, b);
        assert!((0.0..=2.0 * core::f32::consts::TAU).contains(&p), "P {p} {e1} {e2} {a} {b}");
        assert!(sphere_light_irradiance(normal.dot(b), cone.sin_sq()) >= 0.0);
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
fn cones_of_all_balls() {
    let x = Vec3::new(1.0, -2.0, 0.5);
    for d in [0.0_f32, 1e-38, 1e-30, 1e-12, 1e-3, 1.0, 1e6, 1e15, 1e19, 3e25, 2e38] {
        for ratio in [0.0_f32, 1e-30, 1e-6, 0.5, 1.0 - 6e-8, 1.0, 1.0 + 1e-6, 2.0, 1e6] {
            for x in [Vec3::ZERO, x] {
                let center = x + Vec3::new(0.6, 0.0, 0.8) * d;
                let cone = Cone::of_sphere(x, Sphere { center, radius: d * ratio });
                assert!((cone.axis.length() - 1.0).abs() < 1e-5, "{d} {ratio}: {cone:?}");
                if d > 0.0 && (x == Vec3::ZERO || d > 1e6) {
                    assert!(cone.axis.distance(Vec3::new(0.6, 0.0, 0.8)) < 1e-5, "{d} {ratio}: {cone:?}");
                    assert!((cone.distance / d - 1.0).abs() < 1e-5, "{d} {ratio}: {cone:?}");
                }
                assert!((0.0..=2.0).contains(&cone.one_minus_cos) && cone.distance >= 0.0, "{d} {ratio}: {cone:?}");
                assert!(cone.sin_sq() >= 0.0 && cone.solid_angle() >= 0.0);
                if ratio == 0.0 {
                    assert_eq!(cone.one_minus_cos, 0.0, "a point at {d} has no width");
                }
                let lobe = cone_lobe(&cone);
                assert!(lobe.exponent >= 0.0 && !lobe.flux.is_nan(), "{lobe:?}");
            }
        }
    }
    // sin θ = r/d also where 1 − cos θ is far below an ulp of 1.
    let cone = Cone::of_sphere(Vec3::ZERO, Sphere { center: Vec3::Z, radius: 1e-6 });
    assert!((f64::from(cone.one_minus_cos) / 5e-13 - 1.0).abs() < 1e-6);
}

#[test]
fn fractions_stay_between_zero_and_one() {
    let mut random = Random::new(22);
    let mut sum = VisibilitySum::with_capacity(4);
    for case in 0..30_000 {
        let normal = random.axis().as_vec3().normalize();
        let at = Receiver { position: Vec3::ZERO, normal, face: normal, view: normal, object: OWN_NONE };
        let pick = |random: &mut Random| EXTREME[(random.bits() % 12) as usize];
        let e = pick(&mut random);
        let axis = awkward(&mut random, normal);
        let f = Lobe { factor: (case % 2) as f32, ..Lobe::with_flux(axis, e, Vec3::ONE) };
        let mut lit = sum.lobes.writer();
        let mut whole = sum.whole.writer();
        for k in 0..case % 4 {
            let axis = awkward(&mut random, f.axis);
            let lobe = Lobe::with_flux(axis, pick(&mut random), Vec3::splat(random.log_uniform(1e-30, 1.0) as f32));
            lit.push(lobe).unwrap();
            if k < case % 5 {
                whole.push(lobe).unwrap();
            }
        }
        sum.base = [0.0, 0.5, 1.0][case % 3];
        let unshadowed = [0.0, f32::MIN_POSITIVE, 1e-3, 1.0][case / 4 % 4];
        let share = visible_fraction(&at, &f, unshadowed, &sum);
        assert!((0.0..=1.0).contains(&share), "{share} {f:?} {sum:?} {unshadowed}");
    }
}

#[test]
fn touching_the_horizon_is_seamless() {
    // The rim of a light goes through the horizon: the forms for "above" and "through" meet there.
    let mut random = Random::new(23);
    let (mut worst, mut at_worst) = (0.0_f64, String::new());
    for _ in 0..4000 {
        let e = random.log_uniform(1.5, 1e5) as f32;
        let theta = random.log_uniform(0.3, 40.0).to_radians();
        let light = random.axis();
        let near = light.any_orthonormal_vector();
        let normal = |step: f64| {
            let beta = core::f64::consts::FRAC_PI_2 - theta - step;
            (light * beta.cos() + near * beta.sin()).as_vec3().normalize()
        };
        let off = random.uniform() * (theta + 1.5 / f64::from(e).sqrt());
        let axis = random.axis_at(light, off).as_vec3().normalize();
        let cone = Cone {
            axis: light.as_vec3().normalize(),
            one_minus_cos: (2.0 * (0.5 * theta).sin().powi(2)) as f32,
            distance: 1.0,
        };
        let lobe = Lobe { factor: (random.bits() % 2) as f32, ..Lobe::new(axis, e, Vec3::ONE) };
        let lobe = Lobe { flux: Vec3::ONE, ..lobe };
        let value = |step: f64| f64::from(cap_integral(&receiver(normal(step).as_dvec3()), &lobe, &cone));
        let on_axis = f64::from(cap_integral(&receiver(light), &Lobe { axis: cone.axis, factor: 0.0, ..lobe }, &cone));
        let jump = (value(2e-5) - value(-2e-5)).abs() / on_axis;
        if jump > worst {
            (worst, at_worst) =
                (jump, format!("e {e} θ {}° off {}° cosine {}", theta.to_degrees(), off.to_degrees(), lobe.factor));
        }
    }
    println!("at the horizon: {worst:.2e} of the on-axis value, {at_worst}");
    assert!(worst < 3e-3);
}

/// All that this machine can run, from the plainest on.
pub(crate) fn levels() -> Vec<fearless_simd::Level> {
    use fearless_simd::{Level, Simd};
    let best = Level::new();
    let mut all = vec![Level::baseline(), best];
    #[cfg(target_arch = "x86_64")]
    {
        all.extend(best.as_sse4_2().map(Simd::level));
        all.extend(best.as_avx2().map(Simd::level));
    }
    all
}

#[test]
fn many_at_once_are_the_single_ones_on_every_machine() {
    let mut random = Random::new(24);
    let (mut at, mut cones, mut rows) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for k in 0..3000_u32 {
        let normal = random.axis();
        let theta = random.log_uniform(0.05, 40.0).to_radians();
        let beta = random.between(0.0, 0.5 * PI + theta);
        let light = random.axis_at(normal, beta);
        let one_minus_cos = if k % 97 == 0 { 2.0 } else { (2.0 * (0.5 * theta).sin().powi(2)) as f32 };
        at.push(receiver(normal));
        cones.push(Cone { axis: light.as_vec3().normalize(), one_minus_cos, distance: 1.0 });
        rows[0].push(Lobe::new(normal.as_vec3(), 1.0, Vec3::ONE));
        // Some blocks of one kind, most of all.
        let gloss = if k / 16 % 5 == 0 { 30.0 * f64::from(1 + k / 16 % 3 * 20) } else { random.exponent(1e6) };
        let e = if k % 31 == 0 { EXTREME[(k / 31 % 12) as usize] } else { gloss as f32 };
        let off = random.uniform() * (theta + 4.0 / f64::from(e + 0.1).sqrt());
        let axis = random.axis_at(light, off.min(PI)).as_vec3().normalize();
        let flux = if k % 11 == 0 { Vec3::ZERO } else { Vec3::ONE };
        rows[1].push(Lobe { factor: (k % 2) as f32, ..Lobe::with_flux(axis, e, flux) });
    }
    let (mut tile, mut lobes, mut out) = (Tile::default(), TileLobes::default(), Vec::new());
    tile.set(&at);
    lobes.reset(&tile, 2);
    for (place, rows) in rows.iter().enumerate() {
        for (block, rows) in rows.chunks(WIDTH).enumerate() {
            rows.iter().enumerate().for_each(|(j, l)| set_row(lobes.block_mut(place, block), j, &bytemuck::cast(*l)));
        }
    }
    let mut light = TileLight::default();
    light.one_by_one(&tile, cones.iter().map(|cone| LightTerm::of_cone(*cone, Vec3::ONE)));
    for level in levels() {
        crate::cap::integrals_at(level, &light, &lobes, &mut out);
        for (i, (at, cone)) in at.iter().zip(&cones).enumerate() {
            for (k, lobe) in lobes.of(i) {
                let single = cap_integral(at, &lobe, cone);
                assert_eq!(out[k].to_bits(), single.to_bits(), "{level:?}: {} {single} {lobe:?}", out[k]);
            }
            let empty = rows[1][i].flux == Vec3::ZERO;
            assert!(lobes.of(i).count() == if empty { 1 } else { 2 } && (!empty || out[3008 + i] == 0.0));
        }
    }
}

/// With their edges beside them, alone, apart, and beside edges of other microfacets.
#[test]
fn pairs_of_microfacets_are_the_single_ones_on_every_machine() {
    let mut random = Random::new(25);
    let (mut at, mut cones, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..1000_u32 {
        let normal = random.axis();
        let theta = random.log_uniform(0.5, 30.0).to_radians();
        let beta = random.between(0.0, 0.5 * PI + 0.5 * theta);
        let axis = random.axis_at(normal, beta).as_vec3().normalize();
        at.push(receiver(normal));
        cones.push(Cone { axis, one_minus_cos: (1.0 - theta.cos()) as f32, distance: 1.0 });
        let tilt = random.between(0.0, 1.5);
        let view = random.axis_at(normal, tilt).as_vec3().normalize();
        let alpha = random.log_uniform(0.01, 1.0) as f32;
        let [base, edge] = Lobe::microfacets(view, alpha, [Vec3::ONE; 2]);
        let [_, other] = Lobe::microfacets(view, 0.5 * alpha, [Vec3::ONE; 2]);
        let none = Lobe::default();
        let black = Lobe { flux: Vec3::ZERO, ..edge };
        let orders =
            [[none, base, edge], [base, edge, none], [base, none, edge], [edge, base, none], [base, base, edge]];
        let rest = [[base, black, other], [base, other, edge], [none, none, base], [edge, none, none]];
        rows.push(if k % 3 == 0 { rest[(k / 3 % 4) as usize] } else { orders[(k / 3 % 5) as usize] });
    }
    let (mut tile, mut lobes, mut out) = (Tile::default(), TileLobes::default(), Vec::new());
    tile.set(&at);
    lobes.reset(&tile, 3);
    for (i, row) in rows.iter().enumerate() {
        for (place, lobe) in row.iter().enumerate() {
            set_row(lobes.block_mut(place, i / WIDTH), i % WIDTH, &bytemuck::cast(*lobe));
        }
    }
    let mut light = TileLight::default();
    light.one_by_one(&tile, cones.iter().map(|cone| LightTerm::of_cone(*cone, Vec3::ONE)));
    for level in levels() {
        out.fill(f32::NAN);
        crate::cap::integrals_at(level, &light, &lobes, &mut out);
        for (i, (at, cone)) in at.iter().zip(&cones).enumerate() {
            for (k, lobe) in lobes.of(i) {
                let single = cap_integral(at, &lobe, cone);
                assert_eq!(out[k].to_bits(), single.to_bits(), "{level:?} {i}: {} {single} {lobe:?}", out[k]);
            }
        }
    }
}

#[test]
fn cones_and_balls_of_tiles_are_the_single_ones() {
    let mut random = Random::new(26);
    for count in [0, 1, 16, 63, 64, 200] {
        let mut point = || random.axis().as_vec3() * random.log_uniform(1e-3, 1e3) as f32;
        let at: Vec<Receiver> = (0..count).map(|_| Receiver { position: point(), ..receiver(DVec3::Z) }).collect();
        let mut tile = Tile::default();
        tile.set(&at);
        let ball = tile.ball();
        assert!(at.iter().all(|at| at.position.distance(ball.center) <= ball.radius));
        let mut balls = vec![Sphere { center: point(), radius: 0.5 }, Sphere { center: point(), radius: 0.0 }];
        balls.extend(at.first().map(|at| Sphere { center: at.position, radius: 0.3 }));
        balls.extend(at.first().map(|at| Sphere { center: at.position, radius: 0.0 }));
        for ball in balls {
            let mut light = TileLight::default();
            light.ball(&tile, ball, Vec3::ONE);
            for (i, at) in at.iter().enumerate() {
                assert_eq!(light.cone(i), Cone::of_sphere(at.position, ball));
            }
        }
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

#[test]
fn small_lights_on_the_horizon_keep_their_pieces() {
    // Axes 1e-4 apart tell the direction of the pieces' cuts only if it is made orthogonal.
    let mut random = Random::new(27);
    let (mut mean, mut worst) = (0.0, 0.0_f64);
    for _ in 0..1000 {
        let e = f64::from(random.log_uniform(400.0, 1e5) as f32);
        let theta = random.log_uniform(0.05, 0.3).to_radians();
        let normal = random.axis().as_vec3().normalize();
        let tilt = random.between(-theta, theta);
        let light = random.axis_at(normal.as_dvec3(), 0.5 * PI + tilt).as_vec3().normalize();
        let off = random.between(0.0, 2.0 * theta);
        let axis = random.axis_at(light.as_dvec3(), off).as_vec3().normalize();
        let one_minus_cos = (2.0 * (0.5 * theta).sin().powi(2)) as f32;
        let cone = Cone { axis: light, one_minus_cos, distance: 1.0 };
        let got = cap_integral(&receiver(normal.as_dvec3()), &Lobe::new(axis, e as f32, Vec3::ONE), &cone);
        let truth = CapLobe {
            axis: axis.as_dvec3().normalize(),
            exponent: e,
            cosine: false,
            normal: normal.as_dvec3().normalize(),
        };
        let want = oracle::cap(&truth, light.as_dvec3().normalize(), theta) * (e + 1.0) / TAU;
        let on_axis = -((e + 1.0) * (-f64::from(one_minus_cos)).ln_1p()).exp_m1();
        let error = (f64::from(got) - want).abs() / on_axis;
        mean += error / 1000.0;
        worst = worst.max(error);
    }
    println!("small lights on the horizon: mean {mean:.1e}, largest {worst:.1e}");
    assert!(mean < 1e-3 && worst < 2e-2);
}

/// From the near ball to the whole one, continuous, always inside the whole one and around the near one.
#[test]
fn the_own_ball_grows_with_the_distance() {
    use crate::{SelfShadow, Sphere};
    let whole = Sphere { center: Vec3::X, radius: 2.0 };
    let own = SelfShadow { offset: Vec3::new(0.0, 0.5, 0.25), radius: 0.25, distance: 0.1 };
    let near = own.near(whole.radius);
    assert_eq!(near, Sphere { center: Vec3::new(0.0, 1.0, 0.5), radius: 0.5 });
    let at = |d: f32| SelfShadow::seen(whole, near, Vec3::new(1.0, 0.0, d));
    assert_eq!([0.0, 1.0, 2.0].map(at), [Sphere { center: whole.center + near.center, ..near }; 3]);
    assert_eq!(at(4.0), Sphere { center: Vec3::new(1.0, 0.5, 0.25), radius: 1.25 });
    assert_eq!(at(f32::INFINITY), whole);
    let inside = |a: Sphere, b: Sphere| a.center.distance(b.center) + a.radius <= b.radius * 1.000_001;
    let balls: Vec<Sphere> = (0..1000).map(|k| at(0.01 * k as f32)).collect();
    assert!(balls.iter().all(|ball| inside(at(0.0), *ball) && inside(*ball, whole)));
    assert!(balls.windows(2).all(|b| (0.0..0.01).contains(&(b[1].radius - b[0].radius)) && inside(b[0], b[1])));
    for (radius, share, d) in [(0.0, 0.0, 0.0), (f32::MAX, 0.0, 0.0), (1e-45, 0.0, 1e-45), (f32::MAX, 1.0, f32::MAX)] {
        let whole = Sphere { center: Vec3::ZERO, radius };
        let near = SelfShadow { radius: share, ..SelfShadow::whole(0.0) }.near(radius);
        let ball = SelfShadow::seen(whole, near, Vec3::X * d);
        assert!((0.0..=radius).contains(&ball.radius) && ball.center.is_finite(), "{radius} {share} {d}: {ball:?}");
    }
}

/// What is out of range is put right, and turns keep it so.
#[test]
fn own_balls_stay_inside() {
    use crate::SelfShadow;
    let given = |x: f32, radius, distance| SelfShadow { offset: Vec3::X * x, radius, distance }.sound();
    assert_eq!(given(0.3, 0.5, 1.0), SelfShadow { offset: Vec3::X * 0.3, radius: 0.5, distance: 1.0 });
    assert_eq!(given(3.0, 0.5, -1.0), SelfShadow { offset: Vec3::X * 0.5, radius: 0.5, distance: 0.0 });
    assert_eq!(given(f32::NAN, f32::NAN, f32::NAN), SelfShadow::whole(0.0));
    assert_eq!(given(1.0, 7.0, 2.0), SelfShadow::whole(2.0));
    let own = given(0.5, 0.5, 1.0);
    let quarter = glam::Mat3::from_rotation_z(core::f32::consts::FRAC_PI_2);
    assert!(own.turned(quarter * 7.0).offset.distance(Vec3::Y * 0.5) < 1e-6);
    for flat in [glam::Mat3::ZERO, glam::Mat3::NAN, glam::Mat3::IDENTITY * 1e38, glam::Mat3::IDENTITY * 1e-42] {
        let turned = own.turned(flat);
        assert!(turned.offset.length() <= 0.500_001 && turned.radius == 0.5, "{turned:?}");
    }
}
#[test]
fn the_tail_of_a_lobe_is_right_too() {
    // A light of 4° that the lobe looks past, down to a thousandth of the on-axis value, a hundredth beyond
    // (e+1)(1 − cos θ) = 10, where the slab form takes over.
    let mut random = Random::new(32);
    let mut worst = [0.0_f64; 2];
    for _ in 0..4000 {
        let e = random.log_uniform(50.0, 2e4) as f32;
        let theta = 4.0_f64.to_radians();
        let one_minus_cos = (2.0 * (0.5 * theta).sin().powi(2)) as f32;
        let theta = 2.0 * (0.5 * f64::from(one_minus_cos)).sqrt().asin();
        let light = random.axis_at(DVec3::Z, 0.5).as_vec3().normalize();
        let delta = random.between(0.0, theta + 5.0 / f64::from(e).sqrt());
        let axis = random.axis_at(light.as_dvec3(), delta).as_vec3().normalize();
        let lobe = Lobe { factor: (random.bits() % 2) as f32, ..Lobe::with_flux(axis, e, Vec3::ONE) };
        let n = f64::from(e) + 1.0;
        let truth = CapLobe {
            axis: axis.as_dvec3().normalize(),
            exponent: f64::from(e),
            cosine: lobe.factor > 0.0,
            normal: DVec3::Z,
        };
        let want = oracle::cap(&truth, light.as_dvec3().normalize(), theta) * n / TAU;
        let on_axis = -(n * (-f64::from(one_minus_cos)).ln_1p()).exp_m1();
        let got =
            f64::from(cap_integral(&receiver(DVec3::Z), &lobe, &Cone { axis: light, one_minus_cos, distance: 1.0 }));
        let slab = usize::from(n * f64::from(one_minus_cos) > 10.0);
        if want > [1e-3, 1e-2][slab] * on_axis {
            worst[slab] = worst[slab].max((got / want - 1.0).abs());
        }
    }
    println!("tails: chords {:.1e}, slab {:.1e} of the value itself", worst[0], worst[1]);
    assert!(worst[0] < 1e-3 && worst[1] < 3e-2, "{worst:?}");
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

/// Points of a light's own surface see a hemisphere of it, whatever their rounding: none of it is above their horizon.
#[test]
fn surfaces_of_lights_see_nothing_of_them() {
    let mut random = oracle::Random::new(5);
    for _ in 0..10_000 {
        let ball = Sphere { center: random.axis().as_vec3() * 30.0, radius: random.log_uniform(1e-2, 1e2) as f32 };
        let normal = random.axis().as_vec3().normalize();
        let position = ball.center + normal * ball.radius;
        let at = Receiver { position, normal, face: normal, view: normal, object: OWN_NONE };
        let cone = Cone::of_sphere(position, ball);
        assert!((cone.one_minus_cos - 1.0).abs() < 0.05, "{ball:?} {cone:?}");
        let seen = cap_integral(&at, &Lobe::new(normal, 1.0, Vec3::ONE), &cone);
        assert!(seen < 2e-3, "{ball:?}: {seen}");
    }
    let ball = Sphere { center: Vec3::ZERO, radius: 2.0 };
    let of = |x: f32| Cone::of_sphere(Vec3::X * x, ball).one_minus_cos;
    assert_eq!((of(0.0), of(1.99), of(1.9981), of(2.0)), (2.0, 2.0, 1.0, 1.0));
}
