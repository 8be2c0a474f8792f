//! The lobes of [`MetallicRoughness`] against its printed formulas, by quadrature in f64 over directions.

use crate::{Brdf, Material, MaterialError, MetallicRoughness};
use core::f32::consts::FRAC_PI_2;
use core::f64::consts::PI;
use glam::{DVec3, Vec3};
use lobe_core::{BrdfLobe, Receiver};
use shading::BrdfLobes;

const ROUGHNESSES: [f32; 8] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.85, 1.0];

/// The view at an angle to the normal z, toward −x.
pub(crate) fn receiver(degrees: f64) -> Receiver {
    let (s, c) = degrees.to_radians().sin_cos();
    let view = DVec3::new(-s, 0.0, c).as_vec3();
    Receiver::on_surface(Vec3::ZERO, Vec3::Z, view)
}

/// `f̃` as glTF 2.0 prints it (appendix B.3), times the cosine.
pub(crate) fn printed(base: f64, metallic: f64, roughness: f64, view: DVec3, l: DVec3) -> f64 {
    let (nl, nv) = (l.z, view.z);
    if nl <= 0.0 {
        return 0.0;
    }
    let h = (view + l).normalize();
    let a2 = roughness.powi(4);
    let d = a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2));
    let v = 0.5 / (nl * (a2 + (1.0 - a2) * nv * nv).sqrt() + nv * (a2 + (1.0 - a2) * nl * nl).sqrt());
    let schlick = (1.0 - view.dot(h)).max(0.0).powi(5);
    let fresnel = |f0: f64| f0 + (1.0 - f0) * schlick;
    let dielectric = base / PI * (1.0 - fresnel(0.04)) + fresnel(0.04) * d * v;
    nl * (dielectric * (1.0 - metallic) + metallic * fresnel(base) * d * v)
}

/// `∫ f dv` over the upper hemisphere, in polar coordinates about the mirrored view, dense there.
fn integrate(view: DVec3, mut f: impl FnMut(DVec3) -> DVec3) -> DVec3 {
    let n = 280;
    let (mirror, across) = (DVec3::new(-view.x, -view.y, view.z), DVec3::Y);
    let beside = across.cross(mirror);
    let mut sum = DVec3::ZERO;
    for i in 0..n {
        let t = (f64::from(i) + 0.5) / f64::from(n);
        let (angle, stretch) = (PI * t.powi(4), 4.0 * PI * t.powi(3));
        let (s, c) = angle.sin_cos();
        for j in 0..n {
            // Half a turn: both sides of the plane of incidence are the same.
            let (sp, cp) = (PI * (f64::from(j) + 0.5) / f64::from(n)).sin_cos();
            let l = mirror * c + (beside * cp + across * sp) * s;
            if l.z > 0.0 {
                sum += f(l) * (stretch * s);
            }
        }
    }
    sum * (2.0 * PI / f64::from(n * n))
}

/// Peak in the plane of incidence, where it is, and the widths at half of it, along and across that plane.
fn highlight(f: impl Fn(DVec3) -> f64, scale: f64, mirror: f64) -> [f64; 3] {
    let at = |tilt: f64, side: f64| {
        let (s, c) = tilt.sin_cos();
        f(DVec3::new(s * side.cos(), side.sin(), c * side.cos()))
    };
    let places = |n: i32| (-n..=n).map(move |i| mirror + 4.0 * scale * f64::from(i) / f64::from(n));
    let (peak, top) = places(400).map(|t| (at(t, 0.0), t)).fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    let step = 0.002 * scale;
    let reach = |along: bool, sign: f64| {
        let half = |i: &i32| {
            let x = sign * step * f64::from(*i);
            (if along { at(top + x, 0.0) } else { at(top, x) }) < 0.5 * peak
        };
        step * f64::from((0..10_000).find(half).unwrap_or(10_000))
    };
    [peak, reach(true, 1.0) + reach(true, -1.0), 2.0 * reach(false, 1.0)]
}

/// `eval` and the lobes of microfacets are the printed formula.
#[test]
fn metals_are_ggx() {
    for roughness in [0.05, 0.2, 0.5, 0.8, 1.0_f32] {
        let metal = MetallicRoughness::new(Vec3::splat(0.7), 1.0, roughness).unwrap();
        for degrees in [0.0, 30.0, 60.0, 85.0] {
            let at = receiver(degrees);
            let view = at.view.as_dvec3().normalize();
            let scale = f64::from(roughness * roughness);
            let mut lobes = Vec::new();
            metal.brdf_lobes(&at, &mut lobes);
            for k in 0..200 {
                let (aside, turn) = (scale * 0.02 * f64::from(k), f64::from(k));
                let mirror = DVec3::new(-view.x, -view.y, view.z);
                let l = (mirror + DVec3::new(turn.cos(), turn.sin(), 0.5 * turn.sin()) * aside).normalize();
                let want = printed(0.7, 1.0, f64::from(roughness), view, l.as_vec3().as_dvec3());
                let l = l.as_vec3();
                let (got, sum) = (f64::from(metal.eval(&at, l).x), f64::from(BrdfLobe::sum_at(&lobes, at.normal, l).x));
                // A rounding of a direction, beside the width of the highlight.
                let allowed = want * (1e-5 + 3e-6 / scale) + 1e-12;
                assert!((got - want).abs() < allowed, "{roughness} {degrees}: {got} {want} for {l}");
                assert!((sum - got).abs() <= 1e-5 * got, "{roughness} {degrees}: {sum} {got}");
            }
        }
    }
}

#[test]
fn metals_reflect_as_much_as_ggx_with_its_highlight() {
    // By angle: what is allowed in L2, peak, width at half of it along and across the plane of incidence; relative. Round
    // lobes do not follow long highlights beyond 60°: they are lower there, and wider across. The quadratures agree to 3e-3
    // at the kinks of the horizon.
    let allowed = [
        (0.0, [0.05, 0.06, 0.06, 0.06]),
        (30.0, [0.08, 0.06, 0.08, 0.14]),
        (45.0, [0.12, 0.10, 0.13, 0.15]),
        (60.0, [0.16, 0.14, 0.18, 0.19]),
        (75.0, [0.42, 0.45, 0.20, 0.90]),
        (80.0, [0.60, 0.62, 0.20, 1.80]),
    ];
    for roughness in ROUGHNESSES {
        let metal = MetallicRoughness::new(Vec3::ONE, 1.0, roughness).unwrap();
        for (degrees, limits) in allowed {
            let at = receiver(degrees);
            let view = at.view.as_dvec3().normalize();
            let lobes: Vec<_> = metal.cosines(&at).collect();
            let sum = |l: DVec3| lobes.iter().map(|f| f64::from(f.eval(l.as_vec3()).x)).sum::<f64>();
            let true_value = |l: DVec3| printed(1.0, 1.0, f64::from(roughness), view, l);
            let both = integrate(view, |l| {
                let (a, b) = (sum(l), true_value(l));
                DVec3::new(a, b, b * b)
            });
            let apart = integrate(view, |l| DVec3::X * (sum(l) - true_value(l)).powi(2)).x;
            let scale = f64::from(roughness * roughness);
            let (a, b) =
                (highlight(sum, scale, degrees.to_radians()), highlight(true_value, scale, degrees.to_radians()));
            let errors = [(apart / both.z).sqrt(), a[0] / b[0] - 1.0, a[1] / b[1] - 1.0, a[2] / b[2] - 1.0];
            println!(
                "roughness {roughness} at {degrees}°: {} lobes, albedo {:.4} ({:+.2} %), L2 {:.3}, peak {:+.3}, widths {:+.3} {:+.3}",
                lobes.len(),
                both.y,
                100.0 * (both.x / both.y - 1.0),
                errors[0],
                errors[1],
                errors[2],
                errors[3],
            );
            assert!((both.x / both.y - 1.0).abs() < 0.005 && both.x < 1.001, "{roughness} {degrees}: {both}");
            for (error, limit) in errors.iter().zip(limits) {
                assert!(error.abs() < limit, "{roughness} {degrees}: {errors:?}");
            }
        }
    }
}

#[test]
fn the_haze_around_a_highlight_is_there() {
    // Seen from above, at so many times α from the mirrored view, where the tail has fallen by 1e-3 … 1e-6 and one lobe
    // fewer would be 0 or three times too much.
    for roughness in [0.1_f32, 0.15, 0.2, 0.3] {
        let metal = MetallicRoughness::new(Vec3::ONE, 1.0, roughness).unwrap();
        let at = receiver(0.0);
        for distance in [6.0, 12.0, 24.0] {
            let angle = distance * f64::from(roughness).powi(2);
            if angle > 1.0 {
                continue;
            }
            let l = DVec3::new(angle.sin(), 0.0, angle.cos());
            let ratio =
                f64::from(metal.eval(&at, l.as_vec3()).x) / printed(1.0, 1.0, f64::from(roughness), DVec3::Z, l);
            println!("roughness {roughness} at {distance} α: {ratio:.3}");
            assert!((0.8..1.25).contains(&ratio), "{roughness} {distance}: {ratio}");
        }
    }
}

#[test]
fn coated_materials_never_reflect_more_than_they_get() {
    for (base, metallic) in [(1.0, 0.0), (0.5, 0.0), (0.0, 0.0), (1.0, 0.5), (0.6, 0.7)] {
        for roughness in [0.0, 0.25, 0.6, 1.0] {
            let material = MetallicRoughness::new(Vec3::splat(base), metallic, roughness).unwrap();
            for degrees in [0.0, 45.0, 80.0, 89.0] {
                let at = receiver(degrees);
                let view = at.view.as_dvec3().normalize();
                let lobes: Vec<_> = material.cosines(&at).collect();
                if roughness == 0.0 {
                    // Too narrow for the quadrature; all of it is above the horizon, but at 89°.
                    let all: f32 = lobes.iter().map(|f| f.flux.x).sum();
                    assert!(all < 1.002 || degrees > 88.0, "{base} {metallic} {degrees}: {all}");
                    continue;
                }
                let sums = integrate(view, |l| {
                    let got = lobes.iter().map(|f| f64::from(f.eval(l.as_vec3()).x)).sum::<f64>();
                    let r = f64::from(roughness);
                    let part = |metallic| printed(f64::from(base), metallic, r, view, l);
                    DVec3::new(got, part(0.0), part(1.0))
                });
                // Where the printed coat gives back more than it gets, the diffuse part below it is less here.
                let m = f64::from(metallic);
                let want = sums.y.min(1.0) * (1.0 - m) + sums.z * m;
                assert!(sums.x < 1.002, "{base} {metallic} {roughness} {degrees}: {sums}");
                assert!((sums.x - want).abs() < 0.004 + 0.01 * want, "{base} {metallic} {roughness} {degrees}: {sums}");
            }
        }
    }
}

/// Other coats reflect by their own index, as cosine lobes and as microfacets, and the base below gets what is left.
#[test]
fn coats_of_other_indices() {
    let plastic = MetallicRoughness::new(Vec3::splat(0.5), 0.0, 0.4).unwrap();
    let at = receiver(30.0);
    // Rows that are there must not stay.
    assert!(plastic.cosines(&at).count() > 1);
    let flux = |m: &MetallicRoughness| -> (f32, f32) {
        let lobes: Vec<_> = m.cosines(&at).collect();
        (lobes[0].flux.x, lobes[1..].iter().map(|lobe| lobe.flux.x).sum())
    };
    let mut last = flux(&plastic);
    for (f0, f90) in [(0.1, 1.0), (0.25, 1.0), (0.6, 1.0)] {
        let coated = plastic.clone().with_coat(Vec3::splat(f0), f90).unwrap();
        let now = flux(&coated);
        assert!(now.0 < last.0 && now.1 > last.1, "{f0}: {now:?} after {last:?}");
        last = now;
    }
    // No coat at all: a diffuse surface.
    let bare = plastic.clone().with_coat(Vec3::ZERO, 0.0).unwrap();
    assert_eq!(flux(&bare), (0.5, 0.0));
    let lobes: Vec<_> = bare.lobes(&at).map(|lobe| lobe.flux().x).collect();
    assert_eq!(lobes, [0.5, 0.0, 0.0]);
    let l = DVec3::new(0.3, 0.2, 0.9).normalize().as_vec3();
    let diffuse = Material::lambert(Vec3::splat(0.5));
    assert!((bare.eval(&at, l) - diffuse.eval(&at, l)).length() < 1e-6);
    for (f0, f90) in [(0.5, 0.4), (-0.1, 1.0), (0.1, 1.1), (f32::NAN, 1.0)] {
        assert!(plastic.clone().with_coat(Vec3::splat(f0), f90).is_err(), "{f0} {f90}");
    }
}

#[test]
fn turning_the_view_changes_the_highlight_continuously() {
    for roughness in [0.15_f32, 0.4, 0.7, 1.0] {
        let metal = MetallicRoughness::new(Vec3::ONE, 1.0, roughness).unwrap();
        for degrees in [10.0, 26.0, 40.0, 57.0, 70.0_f64] {
            // A direction on the highlight's flank, fixed; its steepest slope is peak/width, the width about α/2.
            let (s, c) = (degrees.to_radians() + 0.5 * f64::from(roughness * roughness)).sin_cos();
            let l = DVec3::new(s, 0.0, c).as_vec3();
            let value = |d: f64| f64::from(metal.eval(&receiver(d), l).x);
            let peak = f64::from(metal.eval(&receiver(degrees), receiver(-degrees).view).x);
            let step = 0.002_f64;
            for i in 0..2000 {
                let d = degrees - 2.0 + step * f64::from(i);
                let change = (value(d + step) - value(d)).abs();
                let most = 4.0 * peak * step.to_radians() / f64::from(roughness * roughness);
                assert!(change < most + 1e-4 * peak, "{roughness} {d}: {change} of {peak}, expected {most}");
            }
        }
    }
}

#[test]
fn every_view_gives_finite_lobes_within_capacity() {
    let n = Vec3::new(0.3, -0.5, 0.8).normalize();
    let (t, b) = lobe_core::orthonormal_basis(n);
    for roughness in [0.0, 1e-3, 0.03, 0.5, 1.0] {
        for metallic in [0.0, 0.5, 1.0] {
            let material = MetallicRoughness::new(Vec3::new(1.0, 0.5, 0.0), metallic, roughness).unwrap();
            for angle in [0.0_f32, 1e-8, 1e-4, 0.3, 1.2, 1.56, FRAC_PI_2, 1.6, 2.5, PI as f32] {
                let view = n * angle.cos() + (t * 0.6 + b * 0.8) * angle.sin();
                let at = Receiver::on_surface(Vec3::ZERO, n, view);
                let lobes: Vec<_> = material.cosines(&at).collect();
                assert!(!lobes.is_empty());
                for lobe in lobes {
                    let ok = lobe.flux.is_finite() && lobe.flux.min_element() >= 0.0 && lobe.exponent >= 0.0;
                    assert!(ok && (lobe.axis.length() - 1.0).abs() < 1e-5 && lobe.exponent <= 1e7, "{lobe:?}");
                }
                for v in [n, view, -view, t, (n + t).normalize()] {
                    assert!(material.eval(&at, v).is_finite() && material.pdf(&at, v).is_finite());
                }
            }
        }
    }
}

#[test]
fn samples_follow_the_lobes() {
    // E[f̃/pdf] is the reflected fraction: here against the quadrature. The weight f̃/pdf is at most 1.
    let gold = Material::from(MetallicRoughness::new(Vec3::new(0.9, 0.7, 0.3), 0.8, 0.4).unwrap());
    for degrees in [0.0, 50.0, 75.0] {
        let at = receiver(degrees);
        let want = integrate(at.view.as_dvec3().normalize(), |l| gold.eval(&at, l.as_vec3()).as_dvec3());
        let n = 40_000_u32;
        let mut sum = DVec3::ZERO;
        for i in 0..n {
            // The R₃ sequence of M. Roberts.
            let u = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_97]
                .map(|g: f64| ((0.5 + g * f64::from(i)).fract() as f32).min(1.0 - f32::EPSILON));
            if let Some(drawn) = gold.sample(&at, u) {
                sum += (gold.eval(&at, drawn.direction) / drawn.pdf).as_dvec3();
            }
        }
        // Low-discrepancy points err by about 1/n^(2/3) at a horizon; ten times that.
        assert!((sum / f64::from(n) - want).abs().max_element() < 0.008, "{degrees}: {} {want}", sum / f64::from(n));
    }
}

#[test]
fn fractions_are_checked() {
    for (base, metallic, roughness, name) in [
        (Vec3::new(0.5, 1.1, 0.0), 0.0, 0.5, "base"),
        (Vec3::ONE, f32::NAN, 0.5, "metallic"),
        (Vec3::ONE, 0.0, -0.1, "roughness"),
    ] {
        let error = MetallicRoughness::new(base, metallic, roughness).unwrap_err();
        assert!(matches!(error, MaterialError::Fraction { name: found, .. } if found == name), "{error}");
    }
}
