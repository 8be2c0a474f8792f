//! The mathematics of lobe-core in WGSL against the same functions in Rust.

use crate::call::{call, trial};
use libtest_mimic::Trial;
use lobe_core::oracle::{self, Random};
use lobe_core::wgsl::{self, Piece};
use lobe_core::{Cone, Grain, Lobe, Microfacets, PackedLobe, Receiver, Sphere, cap_integral, orthonormal_basis};
use lobe_core::{is_lambert, power, special, sphere_light_irradiance};
use render_gpu::Gpu;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("special_functions", gpu, special_functions),
        trial("cones_and_bases", gpu, cones_and_bases),
        trial("cap_integrals", gpu, cap_integrals),
        trial("microfacet_integrals", gpu, microfacet_integrals),
        trial("brushed_integrals", gpu, brushed_integrals),
        trial("lambert_integrals", gpu, lambert_integrals),
    ]
}

const COUNT: usize = 1 << 14;

/// Mean and largest of some differences.
fn spread(differences: &[f64]) -> (f64, f64) {
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    (mean, differences.iter().copied().fold(0.0, f64::max))
}

/// Largest difference of a function of two numbers, relative to `scale` of Rust's value.
fn difference(
    gpu: &Gpu,
    (name, body): (&str, &str),
    rows: &[[f32; 2]],
    rust: impl Fn(f32, f32) -> f32,
    scale: impl Fn(f64) -> f64,
) -> f64 {
    let got = call(gpu, &wgsl::join(&[&wgsl::SPECIAL]), body, rows.as_flattened(), 2, 1);
    let differences: Vec<f64> = (rows.iter().zip(got))
        .map(|(row, got)| {
            let want = f64::from(rust(row[0], row[1]));
            let difference = (f64::from(got) - want).abs() / scale(want);
            assert!(got.is_finite() && difference.is_finite(), "{name} of {row:?}: {got}, not {want}");
            difference
        })
        .collect();
    let (mean, worst) = spread(&differences);
    println!("{name}: mean {mean:.1e}, worst {worst:.1e}");
    worst
}

/// Rust's own accuracy (stated in its documentation) is 1e-7 to 2e-6; the same polynomials in another order of operations
/// stay within twice a rounding error for each of their ten terms.
fn special_functions(gpu: &Gpu) {
    let mut random = Random::new(1);
    let relative = |want: f64| want.abs().max(1e-37);
    let absolute = |_| 1.0;
    let mut rows = |from: f64, to: f64, signed: bool| -> Vec<[f32; 2]> {
        let mut rows: Vec<_> = (0..COUNT)
            .map(|_| {
                let [x, y] = [0, 1].map(|_| random.log_uniform(from, to) as f32);
                [if signed && random.bits().is_multiple_of(2) { -x } else { x }, y]
            })
            .collect();
        rows.extend([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        rows
    };
    let near = rows(1e-8, 1.0, true);
    let all = rows(1.0, 100.0, true);
    let far = rows(1.0, 3e38, true);
    let exp = |x: f32, _: f32| special::exp(x);
    assert!(difference(gpu, ("exp of ±1", "y(0, exp_f32(x(0)));"), &near, exp, relative) < 4e-7);
    assert!(difference(gpu, ("exp of ±100", "y(0, exp_f32(x(0)));"), &all, exp, relative) < 1e-6);
    assert!(difference(gpu, ("exp", "y(0, exp_f32(x(0)));"), &far, exp, relative) < 1e-6);
    let log = |y: f32, _: f32| special::ln_1p(y);
    assert!(difference(gpu, ("ln_1p of ±1", "y(0, ln_1p(x(0)));"), &near, log, relative) < 6e-7);
    assert!(difference(gpu, ("ln_1p", "y(0, ln_1p(x(0)));"), &far, log, relative) < 6e-7);
    let erf = rows(1e-20, 1e20, true);
    assert!(difference(gpu, ("erf", "y(0, erf(x(0)));"), &erf, |x, _| special::erf(x), relative) < 1e-6);
    let angle = rows(1e-15, 1e15, true);
    let atan2 = |x: f32, y: f32| special::atan2(y, x);
    assert!(difference(gpu, ("atan2", "y(0, atan2_f32(x(1), x(0)));"), &angle, atan2, absolute) < 1e-6);
    let octant = rows(0.1, 10.0, true);
    assert!(difference(gpu, ("atan2 about 45°", "y(0, atan2_f32(x(1), x(0)));"), &octant, atan2, absolute) < 1e-6);
    let gamma = rows(1e-6, 1e20, false);
    let arc = |x: f32, _: f32| special::cosine_power_arc(x);
    assert!(difference(gpu, ("A(n)", "y(0, cosine_power_arc(x(0)));"), &gamma, arc, relative) < 2e-6);
}

fn receiver(normal: glam::Vec3) -> Receiver {
    Receiver::on_surface(glam::Vec3::ZERO, normal, normal)
}

fn cones_and_bases(gpu: &Gpu) {
    let mut random = Random::new(2);
    let mut rows = Vec::new();
    let mut want = Vec::new();
    for k in 0..COUNT {
        let (x, center) = (random.axis().as_vec3(), random.axis().as_vec3() * random.log_uniform(1e-6, 1e6) as f32);
        let radius = if k % 8 == 0 { 0.0 } else { (x - center).length() * random.log_uniform(1e-7, 2.0) as f32 };
        let a = if k % 64 == 0 { -glam::Vec3::Z } else { random.axis().as_vec3() };
        let v = random.axis_near(a.as_dvec3()).as_vec3();
        let e = if k % 16 == 0 { f32::INFINITY } else { random.exponent(1e7) as f32 };
        rows.extend(x.to_array());
        rows.extend(center.to_array());
        rows.extend([radius, e]);
        rows.extend(a.to_array());
        rows.extend(v.to_array());
        let cone = Cone::of_sphere(x, Sphere { center, radius });
        let (u, w) = orthonormal_basis(a);
        let solid = cone.solid_angle();
        want.push((cone, [cone.sin_sq(), solid, power(a, v, e)], [u, w], e * 0.5 * (a - v).length_squared()));
    }
    let body = "let cone = cone_of_sphere(vec3f(x(0), x(1), x(2)), vec4f(x(3), x(4), x(5), x(6)));
        y(0, cone.axis.x); y(1, cone.axis.y); y(2, cone.axis.z); y(3, cone.one_minus_cos); y(4, cone.distance);
        y(5, cone_sin_sq(cone)); y(6, cone_solid_angle(cone));
        let a = vec3f(x(8), x(9), x(10));
        y(7, power(a, vec3f(x(11), x(12), x(13)), x(7)));
        let u = orthonormal_basis_u(a); let v = orthonormal_basis_v(a);
        y(8, u.x); y(9, u.y); y(10, u.z); y(11, v.x); y(12, v.y); y(13, v.z);";
    let got = call(gpu, &wgsl::join(&[&wgsl::LOBE]), body, &rows, 14, 14);
    let mut worst = [0.0_f64; 3];
    for (got, (cone, [sin_sq, solid, power], [u, v], drop)) in got.chunks(14).zip(&want) {
        let one_minus_cos = cone.one_minus_cos;
        for (got, want) in got[3..7].iter().zip([one_minus_cos, cone.distance, *sin_sq, *solid]) {
            worst[0] = worst[0].max(f64::from((got - want).abs() / want.max(1e-37)));
        }
        for (got, want) in got[..3].iter().zip(cone.axis.to_array()) {
            worst[0] = worst[0].max(f64::from((got - want).abs()));
        }
        // A rounding error of the squared chord counts e times.
        worst[1] = worst[1].max(f64::from((got[7] - power).abs()) / f64::from(power * drop.max(1.0)).max(1e-30));
        for (got, want) in got[8..].iter().zip([u.to_array(), v.to_array()].as_flattened()) {
            worst[2] = worst[2].max(f64::from((got - want).abs()));
        }
        assert!(got.iter().all(|x| x.is_finite()), "{got:?}");
    }
    println!("cones {:.1e}, powers {:.1e}, bases {:.1e}", worst[0], worst[1], worst[2]);
    assert!(worst[0] < 5e-7 && worst[1] < 2e-6 && worst[2] < 5e-7);
}

/// Positions of light and lobe, which decide how the integral is computed.
#[derive(Clone, Copy, Debug)]
struct Kind {
    name: &'static str,
    exponents: (f64, f64),
    /// `1 − cos θ`.
    lights: (f64, f64),
    through: bool,
}

const fn kind(name: &'static str, exponents: (f64, f64), lights: (f64, f64), through: bool) -> Kind {
    Kind { name, exponents, lights, through }
}

/// All positions, and the ends of each.
const KINDS: [Kind; 12] = [
    kind("Lambert above", (1.0, 1.0), (1e-12, 0.9), false),
    kind("Lambert through", (1.0, 1.0), (1e-12, 1.0), true),
    kind("chords, narrow light", (1.0, 1e3), (1e-6, 1e-3), false),
    kind("chords, wide light", (1.0, 400.0), (1e-3, 0.9), false),
    kind("chords, tiny light", (1.0, 1e7), (1e-14, 1e-9), false),
    kind("slab", (400.0, 1e7), (1e-2, 0.9), false),
    kind("through", (1.0, 1e4), (1e-4, 1.0), true),
    kind("through, tiny light", (1.0, 1e4), (1e-14, 1e-6), true),
    kind("through, narrow lobe", (1e4, 1e7), (1e-4, 1.0), true),
    kind("edge", (0.0, 1.0), (1e-10, 1.0), false),
    kind("mirror", (1e9, f64::INFINITY), (1e-6, 0.9), false),
    kind("inside the light", (0.0, 1e6), (2.0, 2.0), true),
];

fn case(random: &mut Random, kind: &Kind) -> (Receiver, Lobe, Cone) {
    let normal = random.axis();
    let between = |random: &mut Random, (from, to): (f64, f64)| {
        if from == to {
            from
        } else if from == 0.0 && random.bits().is_multiple_of(4) {
            0.0
        } else {
            random.log_uniform(from.max(1e-6), to.min(1e12))
        }
    };
    let one_minus_cos = between(random, kind.lights);
    let sin = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
    let cos = if kind.through {
        // One in eight touches the horizon.
        if random.bits().is_multiple_of(8) { sin * (1.0 - 1e-6) } else { random.between(-sin, sin) }
    } else {
        random.between(sin.min(1.0), 1.0)
    };
    let light = random.axis_at(normal, cos.acos());
    let e = if kind.exponents.1 == f64::INFINITY && random.bits().is_multiple_of(2) {
        f64::INFINITY
    } else {
        between(random, kind.exponents)
    };
    let axis = match random.bits() % 4 {
        0 => random.axis_near(light),
        1 => random.axis(),
        _ => {
            let width = (2.0 / (e + 1.0)).sqrt() + (2.0 * one_minus_cos).sqrt();
            let angle = random.between(0.0, (3.0 * width).min(3.1));
            random.axis_at(light, angle)
        }
    };
    let lambert = kind.name.starts_with("Lambert");
    let axis = if lambert { normal } else { axis }.as_vec3();
    let has_cosine = !lambert && !random.bits().is_multiple_of(2);
    let lobe = Lobe { has_cosine, ..Lobe::with_flux(axis, e as f32, glam::Vec3::ONE) };
    let cone = Cone { axis: light.as_vec3(), one_minus_cos: one_minus_cos as f32, distance: 1.0 };
    (receiver(normal.as_vec3()), lobe, cone)
}

const BODY: &str = "var at: Receiver;
    at.normal = vec3f(x(0), x(1), x(2));
    let lobe = Lobe(vec3f(x(3), x(4), x(5)), x(6), vec3f(1.0), x(7));
    y(0, cap_integral(at, lobe, Cone(vec3f(x(8), x(9), x(10)), x(11), 1.0)));";

/// Differences of [`cap_integral`] from Rust's, relative to the value of the same lobe with the light on its axis.
fn differences(gpu: &Gpu, piece: &'static Piece, cases: &[(Receiver, Lobe, Cone)]) -> Vec<f64> {
    let rows: Vec<f32> = (cases.iter())
        .flat_map(|(at, lobe, cone)| {
            let PackedLobe { axis: a, exponent, kind, .. } = (*lobe).into();
            let [n, l] = [at.normal, cone.axis];
            [n.x, n.y, n.z, a.x, a.y, a.z, exponent, kind, l.x, l.y, l.z, cone.one_minus_cos]
        })
        .collect();
    let got = call(gpu, &wgsl::join(&[piece]), BODY, &rows, 12, 1);
    let one = |((at, lobe, cone), got): (&(Receiver, Lobe, Cone), f32)| {
        let want = cap_integral(at, lobe, cone);
        let on_axis = -((f64::from(lobe.exponent) + 1.0) * (-f64::from(cone.one_minus_cos.min(1.0))).ln_1p()).exp_m1();
        let difference = f64::from((got - want).abs()) / on_axis;
        assert!(got.is_finite() && got >= 0.0 && difference.is_finite(), "{got}, not {want}: {lobe:?} {cone:?} {at:?}");
        difference
    };
    cases.iter().zip(got).map(one).collect()
}

/// The same polynomials in the same order: differences come only from the driver's rewriting (a common factor, 1e-7 on lavapipe).
/// The limits leave room for devices whose divisions and roots are off by 2.5 last digits, where the end of a chord is cut off.
fn cap_integrals(gpu: &Gpu) {
    let mut random = Random::new(3);
    for kind in &KINDS {
        let cases: Vec<_> = (0..COUNT / 4).map(|_| case(&mut random, kind)).collect();
        let differences = differences(gpu, &wgsl::CAP_MICROFACETS, &cases);
        let (mean, worst) = spread(&differences);
        println!("{}: mean {mean:.1e}, worst {worst:.1e}", kind.name);
        assert!(mean <= 2e-6 && worst <= 2e-4, "{}", kind.name);
    }
}

/// Microfacets of all roughnesses; lights of all sizes in the mirror direction of the view, beside it, anywhere, and across the
/// horizon.
fn microfacet_integrals(gpu: &Gpu) {
    microfacet_integrals_by(gpu, &wgsl::CAP_MICROFACETS, false);
}

/// The same of microfacets with a grain, strong and weak, and of some without.
fn brushed_integrals(gpu: &Gpu) {
    microfacet_integrals_by(gpu, &wgsl::CAP_BRUSHED, true);
}

fn microfacet_integrals_by(gpu: &Gpu, piece: &'static Piece, is_brushed: bool) {
    let mut random = Random::new(6);
    let mut rows: Vec<f32> = Vec::new();
    let mut wants = Vec::new();
    for case in 0..COUNT / 4 {
        let normal = random.axis();
        let tilt = random.between(0.0, 1.5);
        let view = random.axis_at(normal, tilt);
        // A grain that is hundreds of times as rough along as across leaves the chords' direction to rounding.
        let alpha = random.log_uniform(if is_brushed { 0.01 } else { 1e-3 }, 1.0);
        let half_angle = random.log_uniform(1e-3, 1.3);
        let mirror = 2.0 * normal.dot(view) * normal - view;
        let light = match case % 4 {
            0 => mirror,
            1 => random.axis(),
            _ => random.axis_at(mirror, (half_angle + 4.0 * alpha).min(3.0) * (case % 7) as f64 / 6.0),
        };
        let at = Receiver { view: view.as_vec3(), ..receiver(normal.as_vec3()) };
        let one_minus_cos = (2.0 * (0.5 * half_angle).sin().powi(2)) as f32;
        let cone = Cone { axis: light.as_vec3(), one_minus_cos, distance: 1.0 };
        // Light from everywhere among them.
        let cone = if case % 16 == 5 { Cone { axis: at.normal, one_minus_cos: 1.0, distance: 1.0 } } else { cone };
        let grain = is_brushed.then(|| {
            let tangent = random.axis().as_vec3();
            Grain::new(at.normal, at.view, tangent, random.uniform() as f32)
        });
        for facets in Microfacets::new(at.view, alpha as f32, [glam::Vec3::ONE; 2]) {
            // One of five without a grain among them.
            let facets = facets.with_grain(grain.filter(|_| case % 5 > 0));
            wants.push(cap_integral(&at, facets, &cone));
            let PackedLobe { axis: a, exponent, kind, .. } = facets.into();
            let [n, l] = [at.normal, cone.axis];
            rows.extend([n.x, n.y, n.z, a.x, a.y, a.z, exponent, kind, l.x, l.y, l.z, cone.one_minus_cos]);
        }
    }
    let got = call(gpu, &wgsl::join(&[piece]), BODY, &rows, 12, 1);
    let differences: Vec<f64> = got.iter().zip(&wants).map(|(got, want)| f64::from((got - want).abs())).collect();
    let (mean, worst) = spread(&differences);
    println!("microfacets, brushed {is_brushed}: mean {mean:.1e}, worst {worst:.1e}");
    assert!(mean <= 2e-6 && worst <= 2e-3);
}

fn lambert_integrals(gpu: &Gpu) {
    let mut random = Random::new(4);
    for kind in KINDS.iter().filter(|kind| kind.name.starts_with("Lambert")) {
        let cases: Vec<_> = (0..COUNT / 4).map(|_| case(&mut random, kind)).collect();
        assert!(cases.iter().all(|(at, lobe, _)| is_lambert(at, lobe)));
        let (at, _, cone) = cases[0];
        assert!(sphere_light_irradiance(at.normal.dot(cone.axis), cone.sin_sq()) >= 0.0);
        let (mean, worst) = spread(&differences(gpu, &wgsl::CAP_LAMBERT, &cases));
        println!("{} alone: mean {mean:.1e}, worst {worst:.1e}", kind.name);
        assert!(mean <= 2e-6 && worst <= 2e-4, "{}", kind.name);
    }
    small_lights_at_the_horizon(gpu, &mut random);
}

/// Errors relative to the value itself, against the f64 oracle: lights of all sizes, at all heights at which the horizon cuts them.
fn small_lights_at_the_horizon(gpu: &Gpu, random: &mut Random) {
    let rows: Vec<[f32; 2]> = (0..4 * COUNT)
        .map(|_| {
            let sin_sq = random.log_uniform(1e-14, 1.0) as f32;
            let near = random.log_uniform(1e-5, 1.0);
            let height = [near - 1.0, 1.0 - near, random.between(-1.0, 1.0)][(random.bits() % 3) as usize];
            [(f64::from(sin_sq).sqrt() * height) as f32, sin_sq]
        })
        .collect();
    let text = wgsl::join(&[&wgsl::CAP_LAMBERT]);
    let got = call(gpu, &text, "y(0, through_horizon(x(0), x(1)));", rows.as_flattened(), 2, 1);
    let mut worst = (0.0_f64, [0.0; 2]);
    for ([cos_beta, sin_sq], got) in rows.iter().zip(got) {
        let s = f64::from(*sin_sq).sqrt();
        let want = oracle::sphere_light_irradiance(f64::from(*cos_beta), s.asin());
        let error = (f64::from(got) - want).abs() / want.max(1e-12 * s.powi(3)).max(f64::from(f32::MIN_POSITIVE));
        if error > worst.0 {
            worst = (error, [*cos_beta, *sin_sq]);
        }
    }
    println!("small lights at the horizon: {:.1e} of the value, {:?}", worst.0, worst.1);
    assert!(worst.0 <= 1e-5, "{worst:?}");
}
