//! The properties that every reflectance model has to keep, as a suite that anyone can run on their own.

use crate::{Report, Run};
use brdf::Brdf;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{BrdfLobe, Receiver, Tile, TileLobes};

/// How far a model may be off.
#[derive(Clone, Copy, Debug)]
pub struct BrdfLimits {
    /// How much more than it receives it may reflect, relative.
    pub energy: f64,
    /// Relative difference of `f_r` when light and eye change places; infinite for a model that is not reciprocal.
    pub reciprocity: f64,
    /// Difference of the sum of lobes from [`eval`](brdf::Brdf::eval), relative to the largest value.
    pub lobes: f64,
    /// Relative difference of the energy that drawn directions carry from that of `eval`.
    pub sampling: f64,
}

impl Default for BrdfLimits {
    /// Those of a model whose lobes are the model.
    fn default() -> Self {
        Self { energy: 1e-3, reciprocity: 1e-4, lobes: 1e-4, sampling: 0.05 }
    }
}

/// The measurements of [`check_brdf`]; the fields are those of [`BrdfLimits`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredBrdf {
    /// The largest fraction of the light from one direction that is reflected.
    pub energy: f64,
    /// See [`BrdfLimits::reciprocity`].
    pub reciprocity: f64,
    /// See [`BrdfLimits::lobes`].
    pub lobes: f64,
    /// See [`BrdfLimits::sampling`].
    pub sampling: f64,
}

/// Rows and columns of the hemisphere that energy is summed over: errors below 1e-3 for exponents up to some hundred.
const GRID: [u32; 2] = [128, 256];

/// Directions that are drawn for each view.
const DRAWN: u32 = 20_000;

/// Tries a model from views straight above to grazing: nothing is NaN or negative, the horizon is dark, energy, reciprocity, lobes
/// against `eval`, drawn directions against `eval`, and tiles against single receivers, bit for bit.
///
/// # Errors
/// [`Report`]: every property that does not hold, each with its worst case.
///
/// ```
/// use conformance::{BrdfLimits, check_brdf};
/// use brdf::{Lambert, Phong};
/// use glam::Vec3;
/// check_brdf(&Lambert { albedo: Vec3::splat(0.8) }, &BrdfLimits::default()).unwrap();
/// // The original Phong model is not reciprocal.
/// let phong = Phong { kd: Vec3::ZERO, ks: Vec3::splat(0.1), exponent: 20.0 };
/// let report = check_brdf(&phong, &BrdfLimits::default()).unwrap_err();
/// assert_eq!(report.broken[0].property, "light and eye change places");
/// ```
pub fn check_brdf<B: Brdf>(model: &B, limits: &BrdfLimits) -> Result<MeasuredBrdf, Report> {
    let (mut run, mut random) = (Run::<MeasuredBrdf>::default(), Random::new(5));
    let normal = Vec3::new(0.3, -0.5, 0.8).normalize();
    let (t, b) = normal.any_orthonormal_pair();
    let around = 0.6 * t + 0.8 * b;
    let toward = |angle: f32| normal * angle.cos() + around * angle.sin();
    let receiver = |view: Vec3| Receiver::on_surface(Vec3::ZERO, normal, view);
    let mut receivers = Vec::new();
    for angle in [0.0_f32, 0.3, 0.8, 1.2, 1.5] {
        let at = receiver(toward(angle).normalize());
        receivers.push(at);
        lobes(model, &at, limits, &mut random, &mut run);
        energy(model, &at, limits, &mut random, &mut run);
        // f_r of the pair, both ways.
        for _ in 0..200 {
            let v = above(&mut random, normal);
            let (cos, back) = (normal.dot(v), normal.dot(at.view));
            if cos < 1e-2 || back < 1e-2 {
                continue;
            }
            let there = model.eval(&at, v).as_dvec3() / f64::from(cos);
            let swapped = model.eval(&receiver(v), at.view).as_dvec3() / f64::from(back);
            let size = there.max(swapped).max_element().max(1e-6);
            let error = (there - swapped).abs().max_element() / size;
            run.measured.reciprocity = run.measured.reciprocity.max(error);
            run.within(error, ("reciprocity", limits.reciprocity), "light and eye change places", || {
                format!("{there} and {swapped} for {v} and {}", at.view)
            });
        }
    }
    // From below the horizon nothing must break.
    receivers.push(receiver(toward(1.65).normalize()));
    tiles(model, &receivers, &mut run);
    run.end()
}

/// A direction above the horizon.
fn above(random: &mut Random, normal: Vec3) -> Vec3 {
    let off = random.between(0.0, FRAC_PI_2 - 1e-3);
    random.axis_at(normal.as_dvec3(), off).as_vec3().normalize()
}

/// The sum of lobes against `eval`, the horizon, and signs.
fn lobes<B: Brdf>(model: &B, at: &Receiver, limits: &BrdfLimits, random: &mut Random, run: &mut Run<MeasuredBrdf>) {
    let mut lobes = Vec::new();
    model.brdf_lobes(at, &mut lobes);
    let mirror = (2.0 * at.normal.dot(at.view) * at.normal - at.view).normalize();
    let mut directions: Vec<Vec3> = (0..400).map(|_| above(random, at.normal)).collect();
    directions.extend([at.view, mirror, at.normal]);
    for spread in [0.01, 0.1, 0.3] {
        for from in [at.view, mirror] {
            directions.extend((0..40).map(|_| (from + random.axis().as_vec3() * spread).normalize()));
        }
    }
    let values: Vec<(Vec3, Vec3)> =
        directions.into_iter().filter(|v| at.normal.dot(*v) > 0.0).map(|v| (v, model.eval(at, v))).collect();
    let peak = values.iter().map(|(_, f)| f.max_element()).fold(1e-20, f32::max);
    for (v, f) in &values {
        run.ensure(f.is_finite() && f.min_element() >= 0.0, "eval is finite and not negative", || {
            format!("{f} at {v}")
        });
        let sum = BrdfLobe::sum_at(&lobes, at.normal, *v);
        let error = f64::from((sum - *f).abs().max_element() / peak);
        run.measured.lobes = run.measured.lobes.max(error);
        run.within(error, ("lobes", limits.lobes), "lobes are the model", || {
            format!("{sum} for {f} at {v}, seen from {}", at.view)
        });
        let below = model.eval(at, *v - 2.0 * at.normal.dot(*v) * at.normal);
        run.ensure(below == Vec3::ZERO, "below the horizon is nothing", || format!("{below} opposite to {v}"));
    }
}

/// Reflected energy, by quadrature and by drawn directions.
fn energy<B: Brdf>(model: &B, at: &Receiver, limits: &BrdfLimits, random: &mut Random, run: &mut Run<MeasuredBrdf>) {
    let (t, b) = at.normal.any_orthonormal_pair();
    let [rows, columns] = GRID;
    let mut sum = DVec3::ZERO;
    for i in 0..rows {
        let theta = (f64::from(i) + 0.5) / f64::from(rows) * FRAC_PI_2;
        for j in 0..columns {
            let (s, c) = ((f64::from(j) + 0.5) / f64::from(columns) * TAU).sin_cos();
            let v = t.as_dvec3() * (c * theta.sin())
                + b.as_dvec3() * (s * theta.sin())
                + at.normal.as_dvec3() * theta.cos();
            sum += model.eval(at, v.as_vec3().normalize()).as_dvec3() * theta.sin();
        }
    }
    let all = sum * (FRAC_PI_2 / f64::from(rows) * TAU / f64::from(columns));
    run.measured.energy = run.measured.energy.max(all.max_element());
    run.within(all.max_element() - 1.0, ("energy", limits.energy), "no more goes out than comes in", || {
        format!("{all} toward {}", at.view)
    });
    let mut drawn = DVec3::ZERO;
    for _ in 0..DRAWN {
        let u = core::array::from_fn(|_| random.between(0.0, 1.0 - 1e-7) as f32);
        let Some(sample) = model.sample(at, u) else { continue };
        let fine = sample.pdf > 0.0 && at.normal.dot(sample.direction) > -1e-6 && sample.direction.is_normalized();
        run.ensure(fine, "drawn directions are above the horizon", || format!("{sample:?} of {u:?}"));
        let density = model.pdf(at, sample.direction);
        let same = (f64::from(density) / f64::from(sample.pdf) - 1.0).abs();
        run.within(same, ("", 1e-3), "pdf is that of sample", || format!("{density} for {sample:?}"));
        drawn += model.eval(at, sample.direction).as_dvec3() / f64::from(sample.pdf);
    }
    let drawn = drawn / f64::from(DRAWN);
    let error = (drawn - all).abs().max_element() / all.max_element().max(1e-3 / PI);
    run.measured.sampling = run.measured.sampling.max(error);
    run.within(error, ("sampling", limits.sampling), "drawn directions carry the energy", || {
        format!("{drawn} for {all} toward {}", at.view)
    });
}

/// The same bits in tiles, of the lobes and of the cosine lobes.
fn tiles<B: Brdf>(model: &B, receivers: &[Receiver], run: &mut Run<MeasuredBrdf>) {
    let (mut tile, mut out) = (Tile::default(), TileLobes::default());
    tile.set(receivers);
    let (of, models) = (vec![0; receivers.len()], core::slice::from_ref(model));
    B::tile_lobes(models, &of, receivers, &tile, &mut out);
    are_single(&out, receivers, |at, single| model.brdf_lobes(at, single), run);
    B::tile_cosine_lobes(models, &of, receivers, &tile, &mut out);
    are_single(&out, receivers, |at, single| model.cosine_lobes(at, single), run);
}

fn are_single(
    tiled: &TileLobes,
    receivers: &[Receiver],
    lobes: impl Fn(&Receiver, &mut Vec<BrdfLobe>),
    run: &mut Run<MeasuredBrdf>,
) {
    for (i, at) in receivers.iter().enumerate() {
        let mut single = Vec::new();
        lobes(at, &mut single);
        single.retain(|lobe| lobe.flux() != Vec3::ZERO);
        let tiled: Vec<_> = tiled.of(i).map(|(_, lobe)| lobe).collect();
        run.ensure(single == tiled, "tiles have the lobes of single receivers", || format!("{tiled:?} for {single:?}"));
    }
}
