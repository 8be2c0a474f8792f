//! Clear coats against the formula that KHR_materials_clearcoat prints, in f64.

use crate::ggx_tests::{printed, receiver};
use crate::{Brdf, Material, MetallicRoughness, Model};
use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{BrdfLobe, Cone, Receiver, cap_integral};
use shading::BrdfLobes;

fn metal(base: f32, metallic: f32, roughness: f32) -> MetallicRoughness {
    MetallicRoughness::new(Vec3::splat(base), metallic, roughness).unwrap()
}

fn coated(below: MetallicRoughness, weight: f32, roughness: f32) -> MetallicRoughness {
    below.with_clearcoat(weight, roughness).unwrap()
}

/// `c·F(n·ω_o)`.
fn part(weight: f64, cos: f64) -> f64 {
    weight * (0.04 + 0.96 * (1.0 - cos.abs()).powi(5))
}

/// `eval` and the sum of lobes are the printed mix of a metal and a coat.
#[test]
fn coats_are_the_printed_formula() {
    for (weight, base, roughness) in [(1.0, 0.6, 0.1), (0.7, 0.3, 0.4), (0.2, 0.8, 0.9), (1.0, 0.5, 1.0)] {
        let material = coated(metal(0.7, 1.0, base), weight, roughness);
        for degrees in [0.0, 30.0, 60.0, 80.0] {
            let at = receiver(degrees);
            let view = at.view.as_dvec3().normalize();
            let mut lobes = Vec::new();
            material.brdf_lobes(&at, &mut lobes);
            assert_eq!((lobes.len(), material.lobe_count()), (4, 5));
            let scale = f64::from(roughness * roughness).min(f64::from(base * base));
            for k in 0..200 {
                let (aside, turn) = (0.3 * f64::from(k) / 200.0, f64::from(k));
                let l = DVec3::new(-view.x + aside * turn.cos(), aside * turn.sin(), view.z + 0.5 * aside);
                let l = l.normalize().as_vec3();
                let of = |roughness: f32, f0| printed(f0, 1.0, f64::from(roughness), view, l.as_dvec3());
                let part = part(f64::from(weight), view.z);
                let want = (1.0 - part) * of(base, f64::from(0.7_f32)) + part * of(roughness, 1.0);
                let allowed = want * (1e-5 + 3e-6 / scale) + 1e-12;
                for got in [material.eval(&at, l).x, BrdfLobe::sum_at(&lobes, at.normal, l).x] {
                    assert!((f64::from(got) - want).abs() < allowed, "{roughness} {degrees}: {got} {want} for {l}");
                }
            }
        }
    }
}

/// No coat where the weight is 0; numbers out of range are refused; another base keeps the coat.
#[test]
fn weights_are_checked() {
    let plain = metal(0.5, 0.0, 0.3);
    assert_eq!(coated(plain.clone(), 0.0, 0.5), plain);
    let paint = coated(plain.clone(), 0.5, 0.25);
    assert_eq!(paint.clearcoat(), Some((0.5, 0.25)));
    assert_ne!(paint, plain);
    let gold = paint.clone().with_base(Vec3::ONE, 1.0, 0.2).unwrap();
    assert_eq!(gold.clearcoat(), Some((0.5, 0.25)));
    for (weight, roughness) in [(1.1, 0.0), (-0.1, 0.0), (f32::NAN, 0.0), (1.0, 1.5), (1.0, f32::NAN)] {
        let message = plain.clone().with_clearcoat(weight, roughness).unwrap_err().to_string();
        assert!(message.contains("clearcoat") && message.contains("[0, 1]"), "{message}");
    }
    assert!(plain.with_clearcoat_normal(Vec3::Z).is_none() && paint.with_clearcoat_normal(Vec3::Z).is_some());
}

/// Emission is below the coat.
#[test]
fn coats_darken_emission() {
    let paint = coated(metal(0.5, 0.0, 0.3), 0.5, 0.25);
    for degrees in [0.0, 45.0, 85.0] {
        let at = receiver(degrees);
        let want = 1.0 - part(0.5, at.view.as_dvec3().normalize().z);
        assert!((f64::from(paint.lets_out(&at)) - want).abs() < 1e-6);
        assert_eq!(metal(0.5, 0.0, 0.3).lets_out(&at), 1.0);
    }
}

/// The reflection of a coat over a black base by cosine lobes, beside `c·F` times GGX's own albedo.
#[test]
fn cosine_lobes_carry_the_energy() {
    for roughness in [0.1, 0.3, 0.7] {
        let material = coated(metal(0.0, 1.0, 0.5), 1.0, roughness);
        for degrees in [0.0, 40.0, 70.0] {
            let at = receiver(degrees);
            let mut lobes = Vec::new();
            material.cosine_lobes(&at, &mut lobes);
            assert!(lobes.len() <= material.cosine_lobe_count());
            let everywhere = Cone { axis: at.normal, one_minus_cos: 1.0, distance: 1.0 };
            let sum = |lobes: &[BrdfLobe]| -> f64 {
                lobes.iter().map(|lobe| f64::from(lobe.flux().x * cap_integral(&at, *lobe, &everywhere))).sum()
            };
            let (got, mut exact) = (sum(&lobes), Vec::new());
            material.brdf_lobes(&at, &mut exact);
            assert!((got / sum(&exact) - 1.0).abs() < 0.02, "{roughness} {degrees}: {got} for {}", sum(&exact));
        }
    }
}

/// The integral of `eval` over what of a cone is above the horizon, in polar coordinates about its axis.
fn over_cone(material: &Material, at: &Receiver, axis: DVec3, half_angle: f64) -> f64 {
    let (rings, turns) = (160, 320);
    let (t, b) = axis.any_orthonormal_pair();
    let mut sum = 0.0;
    for i in 0..rings {
        let (s, c) = (half_angle * (f64::from(i) + 0.5) / f64::from(rings)).sin_cos();
        for j in 0..turns {
            let (y, x) = (TAU * (f64::from(j) + 0.5) / f64::from(turns)).sin_cos();
            let v = axis * c + (t * x + b * y) * s;
            sum += f64::from(material.eval(at, v.as_vec3().normalize()).x) * s;
        }
    }
    sum * half_angle / f64::from(rings) * TAU / f64::from(turns)
}

/// A coat whose normal is not the base's: its lobes lie about the receiver's normal. The error of what lights give by them, relative to
/// what one gives that the coat mirrors: mean and worst.
fn errors(roughness: f32, tilt: f64) -> [f64; 2] {
    let mut random = Random::new(17);
    let (mut sum, mut worst, count) = (0.0, 0.0_f64, 24);
    for _ in 0..count {
        let (angle, turn) = (random.between(0.0, 1.2), random.between(0.0, TAU));
        let view = DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos());
        let own = DVec3::new(tilt.sin(), 0.0, tilt.cos());
        let mirrored = 2.0 * own.dot(view) * own - view;
        if mirrored.z < 0.3 || own.dot(view) < 0.1 {
            continue;
        }
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view.as_vec3().normalize());
        let material = Material::from(coated(metal(0.0, 1.0, 1.0), 1.0, roughness));
        let material = material.with_clearcoat_normal(own.as_vec3().normalize()).unwrap();
        let mut lobes = Vec::new();
        material.brdf_lobes(&at, &mut lobes);
        let half_angle = random.log_uniform(0.02, 0.3);
        let aside = random.uniform() * (half_angle + 2.0 * f64::from(roughness * roughness));
        let axis = random.axis_at(mirrored, aside);
        if axis.z < half_angle.sin() {
            continue;
        }
        let cone =
            Cone { axis: axis.as_vec3().normalize(), one_minus_cos: (1.0 - half_angle.cos()) as f32, distance: 1.0 };
        let got: f64 = lobes.iter().map(|lobe| f64::from(lobe.flux().x * cap_integral(&at, *lobe, &cone))).sum();
        let [want, most] = [axis, mirrored].map(|axis| over_cone(&material, &at, axis, half_angle));
        let error = (got - want).abs() / most;
        sum += error / f64::from(count);
        worst = worst.max(error);
    }
    [sum, worst]
}

#[test]
fn coats_with_a_normal_of_their_own_are_near_the_formula() {
    for (roughness, tilt, limits) in
        [(0.1, 0.0, [0.001, 0.003]), (0.1, 10.0, [0.01, 0.03]), (0.1, 25.0, [0.04, 0.2]), (0.3, 10.0, [0.06, 0.4])]
    {
        let got = errors(roughness, f64::to_radians(tilt));
        println!("roughness {roughness}, {tilt}° apart: mean {:.4}, worst {:.4}", got[0], got[1]);
        assert!(got[0] < limits[0] && got[1] < limits[1], "{roughness} {tilt}: {got:?}");
    }
}

/// E[f̃/pdf] is what is reflected, with the receiver's normal and with another.
#[test]
fn drawn_directions_carry_the_energy() {
    let paint = Material::from(coated(metal(0.6, 0.3, 0.5), 1.0, 0.3));
    let at = receiver(50.0);
    let other = paint.with_clearcoat_normal(Vec3::new(0.15, 0.1, 1.0).normalize()).unwrap();
    for material in [paint, other] {
        let want = over_cone(&material, &at, DVec3::Z, 0.5 * PI);
        let (mut random, count, mut sum) = (Random::new(2), 60_000, 0.0);
        for _ in 0..count {
            let u = core::array::from_fn(|_| random.between(0.0, 1.0 - 1e-7) as f32);
            if let Some(drawn) = material.sample(&at, u) {
                assert!((material.pdf(&at, drawn.direction) / drawn.pdf - 1.0).abs() < 1e-3);
                sum += f64::from(material.eval(&at, drawn.direction).x / drawn.pdf) / f64::from(count);
            }
        }
        assert!((sum / want - 1.0).abs() < 0.01, "{sum} for {want}");
    }
}
