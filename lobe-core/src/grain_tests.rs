//! Microfacets with a grain against the printed formula, in f64.

use crate::oracle::Random;
use crate::vec3x8::Vec3x8;
use crate::{
    BrdfLobe, BrushedAt, Cone, Facets, Grain, Microfacets, Outline, PackedLobe, Receiver, cap_integral,
    outline_integral,
};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use fearless_simd::{Level, dispatch};
use glam::{DVec3, Vec3};

/// `D·W` about the normal z for a direction of the grain, and `s`.
struct Printed {
    view: DVec3,
    along: DVec3,
    alphas: [f64; 2],
}

impl Printed {
    fn both(&self, l: DVec3) -> [f64; 2] {
        if l.z <= 0.0 {
            return [0.0; 2];
        }
        let ([t, b], beside) = (self.alphas, DVec3::Z.cross(self.along));
        let h = (self.view + l).normalize();
        let spread = (h.dot(self.along) / t).powi(2) + (h.dot(beside) / b).powi(2) + h.z * h.z;
        let smith = |v: DVec3| ((v.dot(self.along) * t).powi(2) + (v.dot(beside) * b).powi(2) + v.z * v.z).sqrt();
        let w = 0.5 * l.z / (l.z * smith(self.view) + self.view.z * smith(l));
        let s = (1.0 - self.view.dot(h)).max(0.0).powi(5);
        [w * (1.0 - s), w * s].map(|w| w / (PI * t * b * spread * spread))
    }

    /// Over what of a cone is above the horizon.
    fn over_cap(&self, axis: DVec3, half_angle: f64) -> [f64; 2] {
        let (rings, turns) = (300, 600);
        let (x, y) = axis.any_orthonormal_pair();
        let mut sum = [0.0; 2];
        for i in 0..rings {
            let (s, c) = (half_angle * (f64::from(i) + 0.5) / f64::from(rings)).sin_cos();
            for j in 0..turns {
                let (sin, cos) = (TAU * (f64::from(j) + 0.5) / f64::from(turns)).sin_cos();
                let f = self.both(axis * c + (x * cos + y * sin) * s);
                sum = [sum[0] + f[0] * s, sum[1] + f[1] * s];
            }
        }
        sum.map(|sum| sum * half_angle / f64::from(rings) * TAU / f64::from(turns))
    }
}

fn polar(angle: f64, turn: f64) -> DVec3 {
    DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos())
}

/// A view, a grain and their printed formula.
fn case(random: &mut Random, tilts: [f64; 2], alphas: [f64; 2]) -> (Receiver, [Microfacets; 2], Printed) {
    let view = polar(random.between(tilts[0], tilts[1]), random.between(0.0, TAU)).as_vec3().normalize();
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
    let strength = ((alphas[0] - alphas[1]) / (1.0 - alphas[1])).sqrt();
    let tangent = polar(1.2, random.between(0.0, TAU)).as_vec3();
    let grain = Grain::new(Vec3::Z, view, tangent, strength as f32);
    // As it is kept, in eleven bits.
    let alphas = [f64::from(grain.alpha(alphas[1] as f32)), alphas[1]];
    let along = grain.direction(Vec3::Z, view).as_dvec3().normalize();
    let facets = Microfacets::new(view, alphas[1] as f32, [Vec3::ONE; 2]).map(|facets| facets.with_grain(Some(grain)));
    (at, facets, Printed { view: view.as_dvec3().normalize(), along, alphas })
}

#[test]
fn values_are_the_printed_formula() {
    let mut random = Random::new(3);
    for _ in 0..2000 {
        let fine = random.log_uniform(1e-2, 1.0);
        let rough = random.between(fine, 1.0);
        let (at, facets, printed) = case(&mut random, [0.0, 1.5], [rough, fine]);
        let l = polar(random.between(0.0, 1.5), random.between(0.0, TAU)).as_vec3().normalize();
        let want = printed.both(l.as_dvec3().normalize());
        let got = facets.map(|facets| f64::from(BrdfLobe::from(facets).eval_at(at.normal, l).x));
        for (got, want) in got.into_iter().zip(want) {
            assert!((got - want).abs() < 2e-4 * want + 1e-6, "{printed:?} {l}: {got} {want}", printed = printed.alphas);
        }
        let Some(grain) = facets[0].grain else { panic!("a grain") };
        let brushed = BrushedAt::new(&facets[0], grain, at.normal);
        let eight: [[f32; 8]; 2] = dispatch!(Level::new(), simd => {
            brushed.both_of_eight(simd, Vec3x8::splat(simd, l)).map(Into::into)
        });
        assert_eq!(eight.map(|lanes| lanes[5].to_bits()), brushed.both(l).map(f32::to_bits));
    }
}

#[test]
fn grains_are_kept_in_packed_lobes() {
    let mut random = Random::new(5);
    for _ in 0..2000 {
        let (_, [base, edge], _) = case(&mut random, [0.0, 1.5], [0.7, 0.2]);
        let packed = [base, edge].map(PackedLobe::from);
        assert!(packed[0].is_followed_by(&packed[1]) && !packed[1].is_followed_by(&packed[0]));
        assert!(packed.iter().all(PackedLobe::is_microfacets) && !packed[0].is_edge() && packed[1].is_edge());
        assert_eq!(packed.map(BrdfLobe::from), [base, edge].map(BrdfLobe::from));
    }
}

/// Mean and worst error of lights about the mirror's direction, or through the horizon, in parts of a mirrored light.
fn errors(alphas: [f64; 2], half_angle: f64, crosses: bool) -> [f64; 2] {
    let (mut random, mut sum, mut worst, mut count) = (Random::new(7), 0.0, 0.0_f64, 0);
    while count < 12 {
        let (at, facets, printed) = case(&mut random, [0.0, 1.3], alphas);
        // Where a half vector of the distribution reflects to.
        let beside = DVec3::Z.cross(printed.along);
        let [x, y] = printed.alphas.map(|alpha| alpha * random.between(-1.5, 1.5));
        let h = (DVec3::Z + printed.along * x + beside * y).normalize();
        let mut axis = 2.0 * printed.view.dot(h) * h - printed.view;
        if crosses {
            axis = polar(FRAC_PI_2 + half_angle * random.between(-0.9, 0.7), axis.y.atan2(axis.x));
        }
        let mirror = DVec3::new(-printed.view.x, -printed.view.y, printed.view.z);
        if (axis.z < half_angle.sin()) != crosses {
            continue;
        }
        let cone =
            Cone { axis: axis.as_vec3().normalize(), one_minus_cos: (1.0 - half_angle.cos()) as f32, distance: 1.0 };
        let got = facets.map(|facets| f64::from(cap_integral(&at, facets, &cone)));
        let (want, most) = (printed.over_cap(axis, half_angle), printed.over_cap(mirror, half_angle));
        let size = (most[0] + most[1]).max(want[0] + want[1]);
        let error = ((got[0] - want[0]).abs() + (got[1] - want[1]).abs()) / size;
        sum += error / 12.0;
        worst = worst.max(error);
        count += 1;
    }
    [sum, worst]
}

#[test]
fn integrals_are_those_of_quadrature() {
    for alphas in [[0.3, 0.1], [0.5, 0.1], [1.0, 0.1], [0.2, 0.04], [1.0, 0.5]] {
        for (degrees, crosses, limits) in [
            (2.0, false, [1e-5, 1e-4]),
            (8.0, false, [1e-4, 1e-3]),
            (25.0, false, [1e-3, 6e-3]),
            (20.0, true, [1e-3, 4e-3]),
        ] {
            let got = errors(alphas, f64::to_radians(degrees), crosses);
            println!(
                "α {alphas:?}, {degrees}°, through the horizon {crosses}: mean {:.1e}, worst {:.1e}",
                got[0], got[1]
            );
            assert!(got[0] < limits[0] && got[1] < limits[1], "{alphas:?} {degrees} {crosses}: {got:?}");
        }
    }
}

#[test]
fn albedos_are_those_of_quadrature() {
    let (mut random, mut worst) = (Random::new(11), 0.0_f64);
    for alphas in [[0.3, 0.1], [0.6, 0.15], [1.0, 0.2], [1.0, 0.6]] {
        for _ in 0..6 {
            let (at, facets, printed) = case(&mut random, [0.0, 1.4], alphas);
            let everywhere = Cone { axis: Vec3::Z, one_minus_cos: 2.0, distance: 1.0 };
            let got = facets.map(|facets| f64::from(cap_integral(&at, facets, &everywhere)));
            let want = printed.over_cap(DVec3::Z, FRAC_PI_2);
            let error = ((got[0] - want[0]).abs() + (got[1] - want[1]).abs()) / (want[0] + want[1]);
            worst = worst.max(error);
            assert!(error < 0.02, "{alphas:?}: {got:?} for {want:?}");
        }
    }
    println!("albedo: worst {worst:.1e}");
}

/// A rectangle about the mirror's direction, by a grid of its points.
#[test]
fn rectangles_are_those_of_quadrature() {
    let (mut random, mut sum, mut worst) = (Random::new(13), 0.0, 0.0_f64);
    for k in 0..40 {
        let alphas = [[0.3, 0.1], [1.0, 0.2], [0.5, 0.08], [1.0, 0.6]][k % 4];
        let (at, facets, printed) = case(&mut random, [0.0, 1.2], alphas);
        let mirror = DVec3::new(-printed.view.x, -printed.view.y, printed.view.z);
        let [aside, tilt] = [0.2 * random.uniform(), 0.8 * random.uniform()];
        let center = random.axis_at(mirror, aside) * 2.0;
        let face = random.axis_at(center.normalize(), tilt);
        let (u, v) = face.any_orthonormal_pair();
        let (u, v) = (u * random.between(0.1, 1.0), v * random.between(0.1, 1.0));
        let corners = [-u - v, u - v, u + v, v - u].map(|d| (center + d).as_vec3());
        let Some(light) = Outline::new(&corners, face.as_vec3().normalize()) else { continue };
        let n = 300;
        let mut want = [0.0; 2];
        for i in 0..n * n {
            let [x, y] = [i % n, i / n].map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
            let p = center + u * x + v * y;
            let (r, l) = (p.length(), p.normalize());
            let area = 4.0 * u.length() * v.length() / f64::from(n * n) * face.dot(l) / (r * r);
            let f = printed.both(l);
            want = [want[0] + f[0] * area, want[1] + f[1] * area];
        }
        let got = facets.map(|facets| f64::from(outline_integral(&at, facets, &light)));
        let error = ((got[0] - want[0]).abs() + (got[1] - want[1]).abs()) / (want[0] + want[1]);
        sum += error / 40.0;
        worst = worst.max(error);
    }
    println!("rectangles: mean {sum:.1e}, worst {worst:.1e}");
    assert!(sum < 5e-3 && worst < 0.05, "{sum} {worst}");
}

/// Discs in the highlight, beside it and cut by the horizon, by rings of their points, relative to own values.
#[test]
fn discs_are_those_of_quadrature() {
    let kinds = [[0.38, 0.04], [0.82, 0.04], [0.04, 0.04]].map(|alphas| [(alphas, false), (alphas, true)]);
    for (alphas, is_cut) in kinds.into_iter().flatten() {
        let (mut random, mut sum, mut worst, mut count) = (Random::new(17), 0.0, 0.0_f64, 0);
        while count < 24 {
            let (at, facets, printed) = case(&mut random, [0.2, 1.3], alphas);
            let mirror = DVec3::new(-printed.view.x, -printed.view.y, printed.view.z);
            let aside = random.between(0.0, 0.8);
            let center = random.axis_at(mirror, aside) * random.between(0.6, 1.5);
            let tilt = random.between(0.0, 0.8);
            let face = random.axis_at(center.normalize(), tilt);
            let (u, v) = face.any_orthonormal_pair();
            let radius = 0.3;
            if (center.z < radius * (1.0 - face.z * face.z).sqrt()) != is_cut {
                continue;
            }
            let Some(light) = Outline::disc(center.as_vec3(), radius as f32, face.as_vec3().normalize()) else {
                continue;
            };
            let (rings, around) = (200, 600);
            let mut want = [0.0; 2];
            for i in 0..rings {
                let r = radius * (f64::from(i) + 0.5) / f64::from(rings);
                let area = r * radius / f64::from(rings) * TAU / f64::from(around);
                for k in 0..around {
                    let (sin, cos) = (TAU * f64::from(k) / f64::from(around)).sin_cos();
                    let p = center + (u * cos + v * sin) * r;
                    if p.z > 0.0 {
                        let (distance, l) = (p.length(), p.normalize());
                        let f = printed.both(l);
                        let angle = area * face.dot(l) / (distance * distance);
                        want = [want[0] + f[0] * angle, want[1] + f[1] * angle];
                    }
                }
            }
            if want[0] < 1e-4 {
                continue;
            }
            let got = facets.map(|facets| f64::from(outline_integral(&at, facets, &light)));
            let error = (got[0] + got[1]) / (want[0] + want[1]) - 1.0;
            (sum, worst, count) = (sum + error.abs(), worst.max(error.abs()), count + 1);
        }
        println!("discs, α {alphas:?}, cut {is_cut}: mean {:.1e}, worst {worst:.1e}", sum / f64::from(count));
        let limits = if is_cut { [3e-3, 0.03] } else { [3e-4, 3e-3] };
        assert!(sum < limits[0] * f64::from(count) && worst < limits[1], "{alphas:?} {is_cut}: {sum} {worst}");
    }
}

/// Finite and not negative, whatever the input.
#[test]
fn integrals_are_total() {
    let mut random = Random::new(9);
    for _ in 0..50_000 {
        let [normal, view, light, tangent] = [(); 4].map(|()| random.axis().as_vec3().normalize());
        let light = if random.uniform() < 0.1 { 2.0 * normal.dot(view) * normal - view } else { light };
        let grain = Grain::new(normal, view, tangent, random.uniform() as f32);
        let alpha = random.log_uniform(1e-4, 1.0) as f32;
        let at = Receiver::on_surface(Vec3::ZERO, normal, view);
        let one_minus_cos = random.log_uniform(1e-12, 2.0) as f32;
        for facets in Microfacets::new(view, alpha, [Vec3::ONE; 2]) {
            let cone = Cone { axis: light, one_minus_cos, distance: 1.0 };
            let value = cap_integral(&at, facets.with_grain(Some(grain)), &cone);
            assert!(
                value.is_finite() && (0.0..1.3).contains(&value),
                "{value}: {at:?} {facets:?} {light} {one_minus_cos}"
            );
        }
    }
}
