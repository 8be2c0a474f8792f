//! Tests that every model must pass, against f64 formulas and quadratures that share no code with it.

use crate::{
    Brdf, HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, Model,
    ModifiedPhong, Neumann, Phong,
};
use core::f64::consts::PI;
use glam::{DMat3, DVec3, Mat3, Vec3};
use lobe_core::{BrdfLobe, Lobe, Receiver, Tile, TileLobes, orthonormal_basis};
use shading::BrdfLobes;

const EXTREME_EXPONENTS: [f32; 7] = [0.0, 1e-6, 0.5, 1.0, 200.0, 1e5, 1e7];

/// Uniform numbers in [0, 1).
struct Random(lobe_core::Random);

impl Random {
    const fn new(seed: u64) -> Self {
        Self(lobe_core::Random::new(seed))
    }

    fn next(&mut self) -> f64 {
        self.0.uniform()
    }

    /// Below 1 in f32 as well.
    fn triple(&mut self) -> [f32; 3] {
        core::array::from_fn(|_| ((self.next() * 16_777_216.0).floor() / 16_777_216.0) as f32)
    }

    fn direction(&mut self) -> Vec3 {
        let (z, phi) = (2.0 * self.next() - 1.0, 2.0 * PI * self.next());
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), z).normalize().as_vec3().normalize()
    }
}

fn receiver(normal: Vec3, view: Vec3) -> Receiver {
    Receiver::on_surface(Vec3::new(1.0, 2.0, 3.0), normal.normalize(), view.normalize())
}

/// Views from straight above to grazing and to just below the horizon, over an oblique normal.
fn receivers() -> Vec<Receiver> {
    let normal = Vec3::new(0.3, -0.5, 0.8).normalize();
    let (t, b) = orthonormal_basis(normal);
    [0.0_f32, 1e-4, 0.5, 1.2, 1.5, core::f32::consts::FRAC_PI_2 - 1e-5, 1.58]
        .iter()
        .map(|&angle| receiver(normal, normal * angle.cos() + (0.6 * t + 0.8 * b) * angle.sin()))
        .collect()
}

/// The printed formulas in f64.
fn oracle(material: &Material, at: &Receiver, v: DVec3) -> DVec3 {
    let (n, o) = (at.normal.as_dvec3().normalize(), at.view.as_dvec3().normalize());
    let cos = n.dot(v);
    if cos <= 0.0 {
        return DVec3::ZERO;
    }
    let lobe = |e: f32| {
        let c = (2.0 * n.dot(o) * n - o).dot(v);
        if c > 0.0 { c.powf(f64::from(e)) } else { 0.0 }
    };
    match material {
        Material::Lambert(m) => m.albedo.as_dvec3() / PI * cos,
        Material::Phong(m) => m.kd.as_dvec3() * cos + m.ks.as_dvec3() * lobe(m.exponent),
        Material::ModifiedPhong(m) => {
            let e = f64::from(m.exponent);
            (m.kd.as_dvec3() / PI + m.ks.as_dvec3() * (e + 2.0) / (2.0 * PI) * lobe(m.exponent)) * cos
        }
        Material::Lafortune(m) => {
            let t = orthonormal_basis(at.normal).0.as_dvec3();
            let t = (t - n * n.dot(t)).normalize(); // orthonormal to f64 precision: exponent 1e7 sees 1e-8
            let frame = DMat3::from_cols(t, n.cross(t), n);
            let (lo, lv) = (frame.transpose() * o, frame.transpose() * v);
            let mut f = m.diffuse.as_dvec3() / PI;
            for l in &m.lobes {
                let q = DMat3::from_cols_array(&l.matrix().to_cols_array().map(f64::from));
                let d = lv.dot(q * lo);
                if d > 0.0 {
                    f += l.scale().as_dvec3() * d.powf(f64::from(l.exponent()));
                }
            }
            f * cos
        }
        _ => unreachable!("measured in a file of its own"),
    }
}

fn lafortune() -> Lafortune {
    let turned = Mat3::from_cols_array(&[-0.9, 0.15, 0.05, 0.15, -0.7, 0.0, 0.05, 0.0, 0.8]);
    let mut lobes = vec![
        LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 0.9), 15.0, Vec3::new(0.2, 0.1, 0.05)), // off-specular
        LafortuneLobe::diagonal(Vec3::new(0.8, 0.8, 0.8), 6.0, Vec3::splat(0.1)),             // retro-reflective
        LafortuneLobe::diagonal(Vec3::new(-1.0, -0.6, 0.9), 8.0, Vec3::splat(0.1)),           // anisotropic
        LafortuneLobe::new(turned, 12.0, Vec3::splat(0.3)),
    ];
    let c = |x: f32| Mat3::from_diagonal(Vec3::new(-x, -x, x));
    // A matrix and an exponent for each channel.
    for (channel, (matrix, exponent)) in [(c(0.9), 5.0), (c(0.95), 10.0), (c(1.0), 20.0)].into_iter().enumerate() {
        lobes.push(LafortuneLobe::new(matrix, exponent, Vec3::AXES[channel] * 0.2));
    }
    Lafortune { diffuse: Vec3::new(0.2, 0.3, 0.4), lobes }
}

fn half_vector() -> HalfVector {
    let lobes = vec![
        HalfVectorLobe::new(0.8, Vec3::new(0.3, 0.1, 0.05), Vec3::splat(0.3)),
        HalfVectorLobe::new(0.55, Vec3::new(0.2, 0.3, 0.4), Vec3::new(0.4, 0.5, 0.2)),
    ];
    HalfVector { diffuse: Vec3::splat(0.1), lobes }
}

fn materials() -> Vec<Material> {
    let mut all: Vec<Material> = vec![Lambert { albedo: Vec3::new(0.8, 0.5, 0.1) }.into(), lafortune().into()];
    let (a, b) = (Vec3::new(0.3, 0.2, 0.1), Vec3::new(0.2, 0.4, 0.6));
    for exponent in EXTREME_EXPONENTS {
        all.push(Phong { kd: a, ks: b, exponent }.into());
        all.push(ModifiedPhong { kd: a, ks: b, exponent }.into());
        all.push(
            Lafortune {
                diffuse: Vec3::ZERO,
                lobes: vec![LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 1.0), exponent, b)],
            }
            .into(),
        );
    }
    all
}

/// Random directions, and some at the distance at which a lobe of the model has fallen to a tenth.
fn probes(at: &Receiver, random: &mut Random) -> Vec<Vec3> {
    let mirror = 2.0 * at.normal.dot(at.view) * at.normal - at.view;
    let mut all: Vec<Vec3> = (0..40).map(|_| random.direction()).collect();
    for spread in [0.0, 1e-4, 1e-3, 0.02, 0.3] {
        all.extend((0..10).map(|_| (mirror + spread * random.direction()).normalize()));
    }
    all
}

#[test]
fn eval_and_lobe_sum_equal_the_printed_formulas() {
    let mut random = Random::new(1);
    for material in materials() {
        material.validate().unwrap();
        for at in receivers() {
            let lobes = lobes(&material, &at);
            for v in probes(&at, &mut random) {
                let want = oracle(&material, &at, v.as_dvec3().normalize());
                let direct = material.eval(&at, v);
                let below = at.normal.dot(v) <= 0.0;
                let sum = if below { Vec3::ZERO } else { BrdfLobe::sum_at(&lobes, at.normal, v) };
                assert!(direct.is_finite() && sum.is_finite(), "{material:?} {at:?} {v}");
                let e = match &material {
                    Material::Phong(m) => m.exponent,
                    Material::ModifiedPhong(m) => m.exponent,
                    Material::Lafortune(m) => m.lobes[0].exponent(),
                    _ => 1.0,
                };
                // A rounding of 1e-7 in the axis shifts the argument of a lobe's steepest point, where its value is
                // about half of the peak, by √e·1e-7; the peak itself has relative error e·(1e-7)² and f32 rounding.
                let peak = match &material {
                    Material::Phong(m) => m.ks.max_element(),
                    Material::ModifiedPhong(m) => m.ks.max_element() * (e + 2.0) / 6.0,
                    _ => 1.0,
                };
                let allowed = f64::from(peak) * (2e-6 + 1.5e-6 * f64::from(e).sqrt()) + 1e-6;
                for got in [direct, sum] {
                    let error = (got.as_dvec3() - want).abs().max_element();
                    assert!(error <= allowed, "{material:?}\n{at:?} v {v}: {got} for {want}, allowed {allowed:e}");
                }
            }
        }
    }
}

fn lobes(material: &impl Brdf, at: &Receiver) -> Vec<BrdfLobe> {
    let mut lobes = Vec::new();
    material.brdf_lobes(at, &mut lobes);
    lobes
}

#[test]
fn lambert_lobe_is_recognisable() {
    let at = receivers()[3];
    for material in [Material::lambert(Vec3::splat(0.3)), lafortune().into(), materials()[3].clone()] {
        let BrdfLobe::Cosine(Lobe { axis, exponent, has_cosine, .. }) = lobes(&material, &at)[0] else { panic!() };
        assert_eq!((axis, exponent, has_cosine), (at.normal, 1.0, false));
    }
}

#[test]
fn black_materials_have_no_lobe_and_draw_nothing() {
    let black: [Material; 4] = [
        Lambert::default().into(),
        Phong { exponent: 5.0, ..Phong::default() }.into(),
        ModifiedPhong { exponent: 5.0, ..ModifiedPhong::default() }.into(),
        Lafortune { diffuse: Vec3::ZERO, lobes: vec![LafortuneLobe::diagonal(Vec3::ONE, 3.0, Vec3::ZERO)] }.into(),
    ];
    for material in black {
        assert_eq!(lobes(&material, &receivers()[1]), []);
        assert!(material.sample(&receivers()[1], [0.5; 3]).is_none());
        assert_eq!(material.pdf(&receivers()[1], receivers()[1].normal), 0.0);
    }
}

#[test]
fn lafortune_without_an_axis_has_no_lobe() {
    // M keeps only the normal's part and the view is exactly at the horizon; and M = 0.
    for c in [Vec3::Z, Vec3::ZERO, Vec3::splat(1e-32)] {
        for exponent in EXTREME_EXPONENTS {
            let model = Lafortune { diffuse: Vec3::ZERO, lobes: vec![LafortuneLobe::diagonal(c, exponent, Vec3::ONE)] };
            model.validate().unwrap();
            let at = receiver(Vec3::Z, Vec3::X);
            assert_eq!(lobes(&model, &at), []);
            assert_eq!(model.eval(&at, Vec3::Z), Vec3::ZERO);
            assert!(model.sample(&at, [0.3; 3]).is_none());
        }
    }
}

#[test]
fn reciprocity() {
    // f_r(v, o) = f_r(o, v) for all but the printed Phong model.
    let mut random = Random::new(2);
    let mut models: Vec<Material> = materials().into_iter().filter(|m| !matches!(m, Material::Phong(_))).collect();
    models.push(half_vector().into());
    models.extend([1.0, 30.0].map(|exponent| Neumann { kd: Vec3::ONE, ks: Vec3::ONE, exponent }.into()));
    for material in models {
        for _ in 0..200 {
            let n = random.direction();
            let mut above = || loop {
                let v = random.direction();
                if n.dot(v) > 0.05 {
                    return v;
                }
            };
            let (a, b) = (above(), above());
            let ab = material.eval(&receiver(n, a), b) / n.dot(b);
            let ba = material.eval(&receiver(n, b), a) / n.dot(a);
            // f32 dot products of relative error 1e-6/0.05 in the cosines divided out, and a lobe's flank.
            let allowed = 1e-4 * ab.max_element().max(ba.max_element()) + 1e-4;
            assert!((ab - ba).abs().max_element() <= allowed, "{material:?} {n} {a} {b}: {ab} {ba}");
        }
    }
}

/// `∫ f(v) dv` over the hemisphere of `n` by the midpoint rule on (√(1 − cos θ), φ), dense around the normal.
fn hemisphere(n: Vec3, mut f: impl FnMut(Vec3) -> DVec3) -> DVec3 {
    let (t, b) = orthonormal_basis(n);
    let (rows, columns) = (200, 320);
    let mut sum = DVec3::ZERO;
    for i in 0..rows {
        let root = (i as f64 + 0.5) / rows as f64;
        let c = 1.0 - root * root;
        let s = (1.0 - c * c).sqrt();
        for j in 0..columns {
            let phi = 2.0 * PI * (j as f64 + 0.5) / columns as f64;
            let v = n.as_dvec3() * c + (t.as_dvec3() * phi.cos() + b.as_dvec3() * phi.sin()) * s;
            sum += f(v.as_vec3()) * (2.0 * root);
        }
    }
    sum * (2.0 * PI / (rows * columns) as f64)
}

#[test]
fn energy_and_white_furnace() {
    // A diffuse surface of albedo 1 in a uniform environment of radiance 1 is indistinguishable from it.
    let white = Lambert { albedo: Vec3::ONE };
    for at in receivers() {
        let e = hemisphere(at.normal, |v| white.eval(&at, v).as_dvec3());
        assert!((e - 1.0).abs().max_element() < 2e-5, "{e}");
    }
    for exponent in [0.0, 1e-6, 0.5, 1.0, 20.0, 200.0] {
        let model = ModifiedPhong { kd: Vec3::splat(0.4), ks: Vec3::splat(0.6), exponent };
        for (i, at) in receivers().iter().enumerate() {
            let e = hemisphere(at.normal, |v| model.eval(at, v).as_dvec3()).x;
            assert!(e < 1.0 + 1e-3, "{exponent} {i}: {e}");
            // At normal incidence nothing is lost below the horizon: exactly kd + ks.
            assert!(i > 0 || (e - 1.0).abs() < 1e-3, "{exponent}: {e}");
        }
        // The printed model: π kd + 2π ks/(e+1), reached at normal incidence.
        let kd = 0.1;
        let ks = 0.5;
        let model = Phong { kd: Vec3::splat(kd), ks: Vec3::splat(ks), exponent };
        let bound = PI * f64::from(kd) + 2.0 * PI * f64::from(ks) / (f64::from(exponent) + 1.0);
        for (i, at) in receivers().iter().enumerate() {
            let e = hemisphere(at.normal, |v| model.eval(at, v).as_dvec3()).x;
            assert!(e <= bound * 1.001 && (i > 0 || e > bound * 0.999), "{exponent} {i}: {e} of {bound}");
        }
    }
}

#[test]
fn densities_integrate_to_what_is_not_refused() {
    let mut random = Random::new(3);
    for material in materials() {
        let e = match &material {
            Material::Phong(m) => m.exponent,
            Material::ModifiedPhong(m) => m.exponent,
            _ => 1.0,
        };
        if e > 300.0 || matches!(&material, Material::Lafortune(m) if m.lobes[0].exponent() > 300.0) {
            continue; // too narrow for the quadrature; the estimate below covers them
        }
        for at in receivers() {
            let mass = hemisphere(at.normal, |v| DVec3::splat(f64::from(material.pdf(&at, v)))).x;
            assert!(mass <= 1.0 + 2e-3, "{material:?} {at:?}: {mass}");
            let n = 20_000;
            let kept = (0..n).filter(|_| material.sample(&at, random.triple()).is_some()).count() as f64 / n as f64;
            // Five standard errors of a proportion (≤ 0.5/√n) and the quadrature's error at the lobe's horizon.
            assert!((kept - mass).abs() < 5.0 * 0.5 / (n as f64).sqrt() + 3e-3, "{material:?} {at:?}: {kept} {mass}");
        }
    }
}

#[test]
fn drawn_directions_follow_the_density() {
    // χ² over 8 × 16 cells of (cos θ, φ) about the normal. With 127 degrees of freedom the statistic exceeds 127 + 5·√254
    // with a probability below 1e-5; the seed is fixed. Expected counts are integrated with 20 × 20 points a cell.
    let (rows, columns, sub, n) = (8, 16, 20, 100_000);
    let phong = ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.5), exponent: 20.0 };
    let metal = |metallic, roughness| MetallicRoughness::new(Vec3::new(0.9, 0.6, 0.3), metallic, roughness).unwrap();
    let varnished = metal(0.0, 0.8).with_clearcoat(1.0, 0.5).unwrap();
    let metals = [metal(1.0, 0.7), metal(0.0, 0.5), metal(0.4, 1.0), varnished].map(Material::from);
    let stretched = Neumann { kd: Vec3::splat(0.2), ks: Vec3::splat(0.7), exponent: 12.0 };
    let others =
        [Material::lambert(Vec3::ONE), phong.into(), lafortune().into(), stretched.into(), half_vector().into()];
    for material in others.into_iter().chain(metals) {
        for at in [receivers()[0], receivers()[2], receivers()[4]] {
            let (t, b) = orthonormal_basis(at.normal);
            let at_cell = |c: f64, phi: f64| {
                let s = (1.0 - c * c).sqrt();
                (at.normal.as_dvec3() * c + (t.as_dvec3() * phi.cos() + b.as_dvec3() * phi.sin()) * s).as_vec3()
            };
            let mut expected = vec![0.0; rows * columns];
            for i in 0..rows * sub {
                for j in 0..columns * sub {
                    let c = (i as f64 + 0.5) / (rows * sub) as f64;
                    let phi = 2.0 * PI * (j as f64 + 0.5) / (columns * sub) as f64;
                    let area = 2.0 * PI / (rows * sub * columns * sub) as f64;
                    expected[i / sub * columns + j / sub] +=
                        f64::from(n) * area * f64::from(material.pdf(&at, at_cell(c, phi)));
                }
            }
            let mut counts = vec![0.0; rows * columns];
            let mut random = Random::new(4);
            for _ in 0..n {
                let Some(sample) = material.sample(&at, random.triple()) else { continue };
                assert!((sample.direction.length() - 1.0).abs() < 1e-6);
                assert!((sample.pdf / material.pdf(&at, sample.direction) - 1.0).abs() < 1e-5);
                let (c, x, y) = (
                    f64::from(at.normal.dot(sample.direction)),
                    f64::from(t.dot(sample.direction)),
                    f64::from(b.dot(sample.direction)),
                );
                let row = ((c * rows as f64) as usize).min(rows - 1);
                let turn = (y.atan2(x) / (2.0 * PI)).rem_euclid(1.0);
                let column = ((turn * columns as f64) as usize).min(columns - 1);
                counts[row * columns + column] += 1.0;
            }
            let (mut chi, mut cells) = (0.0, 0.0);
            for (count, want) in counts.iter().zip(&expected).filter(|(_, w)| **w >= 5.0) {
                chi += (count - want) * (count - want) / want;
                cells += 1.0_f64;
            }
            assert!(chi < cells + 5.0 * (2.0 * cells).sqrt(), "{material:?}: χ² {chi} over {cells} cells");
        }
    }
}

/// A lobe's matrix in the frame of a tangent is the lobe turned with it.
#[test]
fn lobes_turn_with_a_tangent() {
    let matrix = Mat3::from_cols_array(&[-1.0, 0.15, 0.1, 0.15, -0.5, 0.0, 0.1, 0.0, 0.9]);
    let round = LafortuneLobe::diagonal(Vec3::new(-0.9, -0.9, 1.0), 7.0, Vec3::splat(0.2));
    let lobes = vec![LafortuneLobe::new(matrix, 14.0, Vec3::new(0.3, 0.5, 0.2)), round];
    let model = Lafortune { diffuse: Vec3::splat(0.2), lobes };
    let mut random = Random::new(8);
    for _ in 0..200 {
        let normal = random.direction();
        let (t, _) = orthonormal_basis(normal);
        let turn = glam::Quat::from_axis_angle(normal, (random.next() * 2.0 * PI) as f32);
        let tangent = turn * t * 3.0 + normal * 0.7;
        let turned = model.turned(normal, tangent);
        turned.validate().unwrap();
        let (view, v) = (random.direction(), random.direction());
        let [view, v] = [view, v].map(|d| if d.dot(normal) < 0.0 { -d } else { d });
        let got = turned.eval(&receiver(normal, turn * view), turn * v);
        let want = model.eval(&receiver(normal, view), v);
        assert!((got - want).abs().max_element() < 2e-5 * want.max_element().max(0.1), "{got} {want}");
    }
    // Without a tangent, and where none has a say.
    assert_eq!(model.turned(Vec3::Z, Vec3::Z), model);
    assert!(Material::from(Lafortune { lobes: vec![round], ..model.clone() }).turned(Vec3::Z, Vec3::X).is_none());
    assert!(Material::from(model).turned(Vec3::Z, Vec3::X).is_some());
}

#[test]
fn narrow_lobes_are_drawn_with_the_right_mean() {
    // At normal incidence E[f̃/pdf] is the reflected fraction kd + ks.
    for exponent in [200.0, 1e5, 1e7] {
        let model = ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.5), exponent };
        let at = receiver(Vec3::new(0.2, 0.9, -0.4), Vec3::new(0.2, 0.9, -0.4));
        let mut random = Random::new(5);
        let n = 50_000;
        let mean = (0..n)
            .filter_map(|_| model.sample(&at, random.triple()))
            .map(|s| f64::from(model.eval(&at, s.direction).x / s.pdf))
            .sum::<f64>()
            / f64::from(n);
        // f̃/pdf lies in [0, 1.1], so a standard deviation of 0.1 is an upper bound where the lobes don't overlap.
        assert!((mean - 0.8).abs() < 5.0 * 0.1 / f64::from(n).sqrt(), "{exponent}: {mean}");
    }
}

#[test]
fn bad_parameters_are_refused_in_one_line() {
    let lobe = |c: Vec3, exponent: f32| Lafortune {
        diffuse: Vec3::ZERO,
        lobes: vec![LafortuneLobe::diagonal(c, exponent, Vec3::ONE)],
    };
    let skew = Mat3::from_cols_array(&[1.0, 0.2, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let bad: Vec<(Material, &str)> = vec![
        (Material::lambert(Vec3::new(0.1, f32::NAN, 0.1)), "albedo"),
        (Material::lambert(Vec3::new(0.1, -0.1, 0.1)), "albedo"),
        (Material::lambert(Vec3::splat(f32::INFINITY)), "albedo"),
        (Phong { kd: Vec3::ONE, ks: Vec3::ONE, exponent: -1.0 }.into(), "exponent"),
        (Phong { kd: Vec3::ONE, ks: Vec3::ONE, exponent: 1.1e7 }.into(), "exponent"),
        (ModifiedPhong { kd: Vec3::ONE, ks: Vec3::ONE, exponent: f32::NAN }.into(), "exponent"),
        (ModifiedPhong { kd: Vec3::ONE, ks: -Vec3::ONE, exponent: 1.0 }.into(), "ks"),
        (Neumann { ks: Vec3::ONE, exponent: 0.5, ..Neumann::default() }.into(), "[1, 1e7]"),
        (Neumann { ks: Vec3::splat(f32::NAN), exponent: 5.0, ..Neumann::default() }.into(), "ks"),
        (lobe(Vec3::splat(f32::NAN), 2.0).into(), "matrix"),
        (lobe(Vec3::splat(1.1), 1e5).into(), "peak"),
        (Lafortune { diffuse: Vec3::ZERO, lobes: vec![LafortuneLobe::new(skew, 1.0, Vec3::ONE)] }.into(), "symmetric"),
    ];
    for (material, word) in bad {
        let message = material.validate().unwrap_err().to_string();
        assert!(message.contains(word) && !message.contains('\n'), "{message}");
    }
    lobe(Vec3::new(-1.0, -1.0, 1.0), 1e7).validate().unwrap();
}

#[test]
fn lobes_of_tiles_are_the_single_ones_on_every_machine() {
    use crate::material_lobes::{ByCosines, ByModel, lobes_at};
    use lobe_core::lanes::Level;
    let mut random = Random::new(6);
    let glossy = MetallicRoughness::new(Vec3::new(0.9, 0.6, 0.3), 0.5, 0.3).unwrap();
    let mut materials = materials();
    materials.push(glossy.clone().with_clearcoat(0.8, 0.1).unwrap().into());
    materials.push(glossy.clone().with_anisotropy(0.7).unwrap().into());
    let stretched = Neumann { kd: Vec3::ZERO, ks: Vec3::new(0.9, 0.6, 0.3), exponent: 70.0 };
    materials.extend([glossy.into(), stretched.into(), half_vector().into(), Material::lambert(Vec3::ZERO)]);
    let receivers: Vec<Receiver> =
        (0..100).map(|i| receiver(random.direction(), if i % 9 == 0 { Vec3::X } else { random.direction() })).collect();
    let (mut tile, mut tiled) = (Tile::default(), TileLobes::default());
    for receivers in [&receivers[..], &receivers[..16], &receivers[..1], &[]] {
        tile.set(receivers);
        // One material for all, for some, and for each its own.
        for run in [1000, 16, 5, 1] {
            let count = materials.len();
            let of: Vec<u32> = (0..receivers.len()).map(|i| ((i / run * 7 + run) % count) as u32).collect();
            for level in [Level::new(), Level::baseline()] {
                lobes_at::<ByModel>(level, &materials, (&of, receivers), &tile, &mut tiled);
                for (i, at) in receivers.iter().enumerate() {
                    let got: Vec<_> = tiled.of(i).map(|(_, lobe)| lobe).collect();
                    assert_eq!(got, lobes(&materials[of[i] as usize], at), "{level:?} {at:?}");
                }
                lobes_at::<ByCosines>(level, &materials, (&of, receivers), &tile, &mut tiled);
                for (i, at) in receivers.iter().enumerate() {
                    let mut want = Vec::new();
                    materials[of[i] as usize].cosine_lobes(at, &mut want);
                    let got: Vec<_> = tiled.of(i).map(|(_, lobe)| lobe).collect();
                    assert_eq!(got, want, "{level:?} {at:?}");
                }
            }
        }
    }
}

/// Lobes about the view, of a model that is not built in.
#[derive(Debug)]
struct Retro;

impl shading::BrdfLobes for Retro {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<lobe_core::BrdfLobe>) {
        // By place, which no built-in model is.
        let red = Vec3::X * at.position.x.abs();
        out.push(lobe_core::Lobe::new(at.view, 9.0, red + Vec3::Y).times_cosine().into());
    }
}

impl Brdf for Retro {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        let cos = at.normal.dot(v).max(0.0);
        (Vec3::X * at.position.x.abs() + Vec3::Y) * (at.view.dot(v).max(0.0).powi(9) * cos)
    }
}

impl Model for Retro {
    fn name(&self) -> &'static str {
        "retro"
    }

    fn lobe_count(&self) -> usize {
        1
    }
}

/// The tiles of a model of one's own are its receivers beside built-in models.
#[test]
fn custom_models_are_models() {
    let retro: Material = Material::Custom(std::sync::Arc::new(Retro));
    assert_eq!((retro.clone() == retro, retro == Material::Custom(std::sync::Arc::new(Retro))), (true, false));
    assert!(!retro.takes_textures() && Material::lambert(Vec3::ONE).takes_textures());
    let gold = Material::from(MetallicRoughness::new(Vec3::ONE, 1.0, 0.3).unwrap());
    let materials = [Material::lambert(Vec3::ONE), retro, gold];
    let receivers: Vec<Receiver> = receivers().into_iter().cycle().take(64).collect();
    let of: Vec<u32> = (0..64).map(|i| (i * i + i / 7) % 3).collect();
    let mut tile = Tile::default();
    tile.set(&receivers);
    let mut lobes = TileLobes::default();
    let are_single = |tiled: &TileLobes, lobes_of: fn(&Material, &Receiver, &mut Vec<lobe_core::BrdfLobe>)| {
        for (i, at) in receivers.iter().enumerate() {
            let mut want = Vec::new();
            lobes_of(&materials[of[i] as usize], at, &mut want);
            let got: Vec<_> = tiled.of(i).map(|(_, lobe)| lobe).collect();
            assert_eq!(got, want, "{i}");
        }
    };
    Material::tile_lobes(&materials, &of, &receivers, &tile, &mut lobes);
    are_single(&lobes, Material::brdf_lobes);
    Material::tile_cosine_lobes(&materials, &of, &receivers, &tile, &mut lobes);
    are_single(&lobes, Material::cosine_lobes);
    assert!(crate::PackedMaterials::new(&materials).unwrap_err().contains("`retro`"));
}
