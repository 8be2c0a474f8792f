//! Lobes over discs of light, above the horizon and through it, against the oracle.

use super::receiver;
use crate::oracle::{self, CapLobe, Random};
use crate::*;
use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};

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
    let lobe = Lobe { has_cosine: cosine, ..Lobe::new(axis, e as f32, Vec3::ONE) };
    let got = f64::from(cap_integral(&at, lobe, &cone)) * TAU / (e + 1.0);
    let truth =
        CapLobe { axis: axis.as_dvec3().normalize(), exponent: e, cosine, normal: at.normal.as_dvec3().normalize() };
    let want = oracle::cap(&truth, light.as_dvec3().normalize(), theta);
    let on_axis = TAU * -((e + 1.0) * (-f64::from(one_minus_cos)).ln_1p()).exp_m1() / (e + 1.0);
    (got, want, on_axis)
}

/// Mean, 99th percentile and largest error.
fn cap_errors(exponents: (f64, f64), cosine: bool, through: bool) -> [f64; 3] {
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
    let [p99, max] = [errors[errors.len() * 99 / 100], errors[errors.len() - 1]];
    println!(
        "e {exponents:?} cosine {cosine} horizon {through}: mean {:.4} % p99 {:.3} % max {:.3} %",
        100.0 * mean,
        100.0 * p99,
        100.0 * max
    );
    [mean, p99, max]
}

#[test]
fn lobe_over_light_above_the_horizon() {
    for cosine in [false, true] {
        for exponents in [(0.01, 1.0), (1.0, 5.0), (5.0, 50.0), (50.0, 399.0), (400.0, 1e5), (1e5, 1e6)] {
            let [mean, _, max] = cap_errors(exponents, cosine, false);
            assert!(mean < 3e-5 && max < if exponents.1 <= 1.0 { 1e-4 } else { 1.5e-3 });
        }
    }
}

#[test]
fn lobe_over_light_through_the_horizon() {
    let exponents = [(0.01, 1.0), (1.0, 5.0), (5.0, 49.9), (50.0, 500.0), (500.0, 1e5)];
    for cosine in [false, true] {
        let mut all = 0.0;
        for exponents in exponents {
            let [mean, p99, max] = cap_errors(exponents, cosine, true);
            assert!(p99 < 1.5e-3 && max < 3e-3);
            all += mean;
        }
        assert!(all < 3e-5 * exponents.len() as f64);
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
            let lobe = Lobe { has_cosine: cosine, ..Lobe::with_flux(axis, e, Vec3::ONE) };
            let truth = CapLobe {
                axis: axis.as_dvec3().normalize(),
                exponent: f64::from(e),
                cosine,
                normal: normal.as_dvec3().normalize(),
            };
            let n = f64::from(e) + 1.0;
            let want = oracle::cap(&truth, light.as_dvec3().normalize(), theta) * n / TAU;
            let on_axis = -(n * (-f64::from(one_minus_cos)).ln_1p()).exp_m1();
            let got = f64::from(cap_integral(&at, lobe, &cone));
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
            cap_integral(&at, Lobe::new(axis, e, Vec3::ONE), &Cone { axis: Vec3::Z, one_minus_cos, distance: 1.0 })
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
    assert!(by_exponent < 1.5e-3 && by_width < 1.5e-3);
}

/// Sphere lights at a receiver's horizon, `(cos β, sin²σ)`: all sizes, and heights that come as near to the ends as digits let
/// them.
fn at_the_horizon(random: &mut Random) -> (f32, f32) {
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
pub(super) fn irradiance_error(got: f32, (cos_beta, sin_sq): (f32, f32)) -> (f64, f64) {
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

#[test]
fn inside_a_light_everything_is_bright() {
    let at = receiver(DVec3::Z);
    let cone = Cone { axis: Vec3::X, one_minus_cos: 2.0, distance: 0.1 };
    let lambert = cap_integral(&at, Lobe::new(Vec3::Z, 1.0, Vec3::ONE), &cone);
    assert!((lambert - 1.0).abs() < 1e-5, "{lambert}");
    let phong = cap_integral(&at, Lobe::new(Vec3::Z, 20.0, Vec3::ONE), &cone);
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
                cap_integral(&at, Lobe::new(axis, e, Vec3::ONE), &Cone { axis: light, one_minus_cos, distance: 1.0 });
            assert!(value.is_finite() && value >= last * 0.999, "e {e} k {k}: {value} after {last}");
            last = value;
        }
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
        let lobe = Lobe { has_cosine: random.bits() % 2 == 1, ..Lobe::new(axis, e, Vec3::ONE) };
        let lobe = Lobe { flux: Vec3::ONE, ..lobe };
        let value = |step: f64| f64::from(cap_integral(&receiver(normal(step).as_dvec3()), lobe, &cone));
        let on_axis =
            f64::from(cap_integral(&receiver(light), Lobe { axis: cone.axis, has_cosine: false, ..lobe }, &cone));
        let jump = (value(2e-5) - value(-2e-5)).abs() / on_axis;
        if jump > worst {
            (worst, at_worst) =
                (jump, format!("e {e} θ {}° off {}° cosine {}", theta.to_degrees(), off.to_degrees(), lobe.has_cosine));
        }
    }
    println!("at the horizon: {worst:.2e} of the on-axis value, {at_worst}");
    assert!(worst < 3e-3);
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
        let got = cap_integral(&receiver(normal.as_dvec3()), Lobe::new(axis, e as f32, Vec3::ONE), &cone);
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
    assert!(mean < 1e-4 && worst < 3e-3);
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
        let lobe = Lobe { has_cosine: random.bits() % 2 == 1, ..Lobe::with_flux(axis, e, Vec3::ONE) };
        let n = f64::from(e) + 1.0;
        let truth = CapLobe {
            axis: axis.as_dvec3().normalize(),
            exponent: f64::from(e),
            cosine: lobe.has_cosine,
            normal: DVec3::Z,
        };
        let want = oracle::cap(&truth, light.as_dvec3().normalize(), theta) * n / TAU;
        let on_axis = -(n * (-f64::from(one_minus_cos)).ln_1p()).exp_m1();
        let got =
            f64::from(cap_integral(&receiver(DVec3::Z), lobe, &Cone { axis: light, one_minus_cos, distance: 1.0 }));
        let slab = usize::from(n * f64::from(one_minus_cos) > 10.0);
        if want > [1e-3, 1e-2][slab] * on_axis {
            worst[slab] = worst[slab].max((got / want - 1.0).abs());
        }
    }
    println!("tails: chords {:.1e}, slab {:.1e} of the value itself", worst[0], worst[1]);
    assert!(worst[0] < 1e-3 && worst[1] < 3e-2, "{worst:?}");
}

/// Points of a light's own surface see a hemisphere of it, whatever their rounding: none of it is above their horizon.
#[test]
fn surfaces_of_lights_see_nothing_of_them() {
    let mut random = oracle::Random::new(5);
    for _ in 0..10_000 {
        let sphere = Sphere { center: random.axis().as_vec3() * 30.0, radius: random.log_uniform(1e-2, 1e2) as f32 };
        let normal = random.axis().as_vec3().normalize();
        let position = sphere.center + normal * sphere.radius;
        let at = Receiver::on_surface(position, normal, normal);
        let cone = Cone::of_sphere(position, sphere);
        assert!((cone.one_minus_cos - 1.0).abs() < 0.05, "{sphere:?} {cone:?}");
        let seen = cap_integral(&at, Lobe::new(normal, 1.0, Vec3::ONE), &cone);
        assert!(seen < 2e-3, "{sphere:?}: {seen}");
    }
    let sphere = Sphere { center: Vec3::ZERO, radius: 2.0 };
    let of = |x: f32| Cone::of_sphere(Vec3::X * x, sphere).one_minus_cos;
    assert_eq!((of(0.0), of(1.99), of(1.9981), of(2.0)), (2.0, 2.0, 1.0, 1.0));
}
