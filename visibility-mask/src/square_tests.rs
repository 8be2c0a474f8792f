//! Windows against the lobe's weight outside of them, in f64.

use crate::UnitSquare;
use crate::accuracy::zoom_sigmas;
use glam::{DVec3, Vec2, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe};

/// The lobe's weight outside the window, relative to its weight over the emitting disc; and the latter relative to its weight over
/// all directions.
fn outside(window: &UnitSquare, lobe: &Lobe, normal: Vec3) -> Option<(f64, f64)> {
    const SIDE: i32 = 400;
    let [right, up, toward] = [window.right, window.up, window.axis].map(Vec3::as_dvec3);
    let (normal, axis, disc) = (normal.as_dvec3(), lobe.axis.as_dvec3(), f64::from(window.disc));
    let (mut out, mut all) = (0.0, 0.0);
    for k in 0..SIDE * SIDE {
        let at = |k: i32| disc * (f64::from(2 * k + 1) / f64::from(SIDE) - 1.0);
        let (x, y) = (at(k % SIDE), at(k / SIDE));
        let p: DVec3 = right * x + up * y + toward;
        let above = normal.dot(p);
        if x * x + y * y > disc * disc || above <= 0.0 {
            continue;
        }
        let length = p.length();
        let cosine = if lobe.has_cosine { above / length } else { 1.0 };
        let w = (axis.dot(p) / length).max(0.0).powf(f64::from(lobe.exponent)) * cosine / length.powi(3);
        all += w;
        if (Vec2::new(x as f32, y as f32) - window.center).abs().cmpgt(window.half).any() {
            out += w;
        }
    }
    let part = all * (2.0 * disc / f64::from(SIDE)).powi(2) * (f64::from(lobe.exponent) + 1.0) / core::f64::consts::TAU;
    (all > 0.0).then(|| (out / all, part))
}

/// Lobes around the rim and around the horizon, of large and small lights, from a tenth of the light's width to its full width.
#[test]
fn windows_hold_all_but_a_part_of_the_tolerance() {
    let mut random = Random::new(21);
    for tolerance in [0.01_f32, 0.003, 0.001] {
        let (mut mean, mut worst, mut n) = (0.0, (0.0, String::new()), 0.0);
        for case in 0..600 {
            let theta = [0.003, 0.15, 0.43, 0.8][case % 4];
            let sigma = theta * random.log_uniform(0.1, 1.0);
            let axis = random.axis();
            let tilt = match case % 3 {
                0 => random.between(0.0, 0.7),
                _ => core::f64::consts::FRAC_PI_2 + random.between(-theta, 0.8 * theta),
            };
            let normal = random.axis_at(axis, tilt).as_vec3().normalize();
            let off = random.between((theta - 4.0 * sigma).max(0.0), theta + 2.5 * sigma);
            let lobe =
                Lobe::new(random.axis_at(axis, off).as_vec3().normalize(), (1.0 / (sigma * sigma)) as f32, Vec3::ONE);
            let lobe = if case % 2 == 0 { lobe } else { lobe.times_cosine() };
            let one_minus_cos = (2.0 * (0.5 * theta).sin().powi(2)) as f32;
            let cone = Cone { axis: axis.as_vec3().normalize(), one_minus_cos, distance: f32::INFINITY };
            let square = UnitSquare::facing(&cone, random.axis().as_vec3());
            let window = square.above(normal).zoomed(&lobe, normal, zoom_sigmas(tolerance));
            let Some((out, part)) = outside(&window, &lobe, normal) else { continue };
            let out = out * (100.0 * part).min(1.0);
            mean += out;
            n += 1.0;
            if out > worst.0 {
                worst = (
                    out,
                    format!(
                        "case {case} θ {theta} σ {:.2} θ, off {:.2} σ, tilt {tilt:.2}",
                        sigma / theta,
                        (off - theta) / sigma
                    ),
                );
            }
        }
        mean /= n;
        println!(
            "τ {tolerance}: {:.2} τ outside on average, {:.2} τ at most, {}",
            mean / f64::from(tolerance),
            worst.0 / f64::from(tolerance),
            worst.1
        );
        assert!(mean < 0.3 * f64::from(tolerance) && worst.0 < 3.0 * f64::from(tolerance));
    }
}
