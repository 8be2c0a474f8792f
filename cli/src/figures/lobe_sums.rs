//! Fig. 14 and 15: the integrals of method `paper`, point by point.

use super::canvas::{Cell, Sheet, heat};
use super::gallery::Page;
use super::lab::{above, accuracy, cell, resolve};
use super::measure::{How, frames, spheres};
use super::scenes::Case;
use super::studio::Studio;
use crate::failure::Failure;
use core::f32::consts::TAU;
use cosine_lobes::lighting::Light;
use cosine_lobes::lobe_core::{BrdfLobe, Lobe, Receiver, VisibilitySum, orthonormal_basis};
use cosine_lobes::paper::{PaperIntegrator, PaperVisibility, Tables};
use cosine_lobes::scene::{BlockerSet, Scene, ShadingPoints};
use cosine_lobes::shading::{
    BrdfLobes, Integrator, Interaction, LightCoverage, LightId, LightLobes, LightVisibility, Observer, Visibility,
};
use cosine_lobes::{Comparison, Picture};
use glam::Vec3;
use rayon::prelude::*;

/// Does something for every point of a scene with one light, on all threads; `work` gets the point's reflectance lobes, the light, and a
/// visit with the paper's visibility.
fn each_point<T: Send>(
    scene: &Scene,
    blockers: &BlockerSet,
    points: &ShadingPoints,
    tables: &Tables,
    work: impl Fn(usize, &Receiver, &[BrdfLobe], &Light, &mut PaperVisit<'_, '_>, &mut VisibilitySum) -> T + Sync,
) -> Result<Vec<T>, Failure> {
    let strategy = PaperVisibility::new(spheres(blockers), tables);
    let light = scene.lights.first().ok_or_else(|| Failure::new("the scene has no light"))?;
    let memory = || {
        let sum = VisibilitySum::default();
        (strategy.scratch(), sum, Vec::new())
    };
    let found = points
        .receivers
        .par_iter()
        .zip(&points.materials)
        .enumerate()
        .map_init(memory, |(scratch, sum, brdf), (i, (at, material))| {
            brdf.clear();
            scene.materials[*material as usize].cosine_lobes(at, brdf);
            work(i, at, brdf, light, &mut LightVisibility::alone(&strategy, LightId(0), accuracy(), scratch), sum)
        })
        .collect();
    Ok(found)
}

type PaperVisit<'v, 't> = LightVisibility<'v, PaperVisibility<'t, cosine_lobes::visibility_spheres::SphereBlockers>>;

/// Samples of each integral of Fig. 14.
const SAMPLES: usize = 1024;

/// A direction of a lobe, with a density in proportion to its value.
fn sample(lobe: &Lobe, (right, up): (Vec3, Vec3), [x, y]: [f32; 2]) -> Vec3 {
    // Of cos θ; its distance from 1 keeps its digits where exponents are large.
    let behind = -(x.max(1e-7).ln() / (lobe.exponent + 1.0)).exp_m1();
    let sin = (behind * (2.0 - behind)).sqrt();
    let (s, c) = (TAU * y).sin_cos();
    (lobe.axis * (1.0 - behind) + sin * (c * right + s * up)).normalize()
}

/// `∫ Σ f·L·V` of the paper's lobe sums by Monte Carlo: samples of the light's lobe, the same sequence shifted from point to point.
fn by_samples(
    scene: &Scene,
    blockers: &BlockerSet,
    points: &ShadingPoints,
    tables: &Tables,
) -> Result<Vec<Vec3>, Failure> {
    each_point(scene, blockers, points, tables, |i, at, brdf, light, visit, sum| {
        let term = light.seen_from(at);
        let lobe = tables.light_lobe(&term.cone, term.radiance);
        let basis = orthonormal_basis(lobe.axis);
        let seen = visit.coverage(at, &term.cone, None);
        if let (LightCoverage::Partial(seen), Some(first)) = (&seen, brdf.first()) {
            visit.lobes(seen, &first.cosine_lobe(at.normal), 1.0, sum);
        }
        let mut all = vec![Vec3::ZERO; brdf.len()];
        let shift = [0.754_877_7, 0.569_840_3].map(|step: f64| step * (i as f64 * 97.0 + 0.5));
        for k in 0..SAMPLES {
            let [x, y] = [0.819_172_5, 0.671_043_6].map(|step: f64| step * k as f64);
            let v = sample(&lobe, basis, [(x + shift[0]).fract() as f32, (y + shift[1]).fract() as f32]);
            let visibility = match &seen {
                LightCoverage::Lit => 1.0,
                LightCoverage::Dark => 0.0,
                LightCoverage::Partial(_) => sum.base + sum.lobes.lobes().eval(at.normal, v).x,
            };
            for (all, f) in all.iter_mut().zip(brdf.iter()) {
                *all += f.eval_at(at.normal, v) * visibility;
            }
        }
        all.into_iter().map(|f| (f * lobe.flux / SAMPLES as f32).max(Vec3::ZERO)).sum()
    })
}

pub(super) fn integration(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let (tables, cow) = (studio.tables()?, studio.model(64)?);
    let case = Case::fig15();
    let (scene, blockers, gbuffer) = case.make(&cow);
    let truth = resolve(&gbuffer, &by_samples(&scene, &blockers, &gbuffer.points, &tables)?);
    let how = How { threshold: 0.0, tables: Some(&tables) };
    let (_, radiance) = frames(&scene, &blockers, &gbuffer.points, how, 1).map_err(Failure::new)?;
    let picture = resolve(&gbuffer, &radiance);
    let error = Comparison::of(&picture, &truth)?;
    let brightest = truth.pixels().iter().map(|p| p.max_element()).fold(0.0, f32::max);
    let full = 0.02 * error.reference_mean as f32;
    let map = |title: &str, a: &Picture, b: &Picture| Cell {
        title: title.into(),
        note: format!("white: {full:.4}, 2 % of the mean"),
        size: (a.width(), a.height()),
        rgb: above(a, b, full),
    };
    let cells = vec![
        cell("Monte Carlo of the lobe sums", format!("{SAMPLES} samples"), &truth, 0.0),
        cell("products by the table", "method paper", &picture, 0.0),
        map("products − Monte Carlo", &picture, &truth),
        map("Monte Carlo − products", &truth, &picture),
    ];
    let mean = error.reference_mean;
    Ok(Page {
        title: "integrals of lobe sums, by Monte Carlo and by products",
        images: vec![Sheet::new(4, cells).image(name)?],
        shows: "The same sums of lobes for reflectance, light and visibility, integrated in two ways: by Monte Carlo, and by the tabulated products \
                of method `paper`. The difference is the error of the products alone."
            .into(),
        paper: "The largest radiance is 0.701961, the mean 0.127906; the largest difference is 0.054902, 43 % of the mean, the mean difference \
                0.003884, 3.0 % of the mean (Fig. 14, §6). The error of the integration is also given as 10.02 % (§6)."
            .into(),
        here: format!(
            "The largest radiance is {brightest:.3}, the mean {mean:.3}; the largest difference is {:.3}, {:.0} % of the mean, the mean difference \
             {:.4}, {:.1} % of the mean. From pixel to pixel it is {:.2} %.",
            error.max,
            100.0 * error.max / mean,
            error.mae,
            100.0 * error.mae / mean,
            100.0 * error.mean_relative
        ),
        differs: "The paper's 3.0 % and 10.02 % are said of the same thing; the first is measured on values of a displayed picture (0.701961 is 179/255), \
                  the second perhaps from pixel to pixel."
            .into(),
    })
}

/// Counts the products of one point.
#[derive(Default)]
struct Products {
    computed: usize,
    dropped: usize,
}

impl Observer for Products {
    fn count(&mut self, _: usize, integrals: usize) {
        self.computed += integrals;
    }

    fn prune(&mut self) {
        self.dropped += 1;
    }
}

/// The number of products that each point keeps.
fn kept(
    scene: &Scene,
    blockers: &BlockerSet,
    points: &ShadingPoints,
    tables: &Tables,
    threshold: f32,
) -> Result<Vec<f32>, Failure> {
    let integrator = PaperIntegrator { tables };
    each_point(scene, blockers, points, tables, |_, at, brdf, light, visit, sum| {
        let mut products = Products::default();
        let light = light.seen_from(at);
        let point = Interaction { at, brdf, light: &light, threshold };
        integrator.radiance(&point, visit, sum, &mut products);
        (products.computed - products.dropped) as f32
    })
}

fn total(counts: &[f32]) -> f64 {
    counts.iter().map(|n| f64::from(*n)).sum()
}

pub(super) fn savings(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let (tables, cow) = (studio.tables()?, studio.model(64)?);
    let case = Case::fig15();
    let (scene, blockers, gbuffer) = case.make(&cow);
    let count = |threshold: f32| kept(&scene, &blockers, &gbuffer.points, &tables, threshold);
    // The threshold that leaves half of the products, as the paper's does, by bisection of its logarithm.
    let all = count(0.0)?;
    let (mut low, mut high) = (-20.0_f32, 0.0_f32);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if total(&count(middle.exp2())?) > 0.5 * total(&all) { low = middle } else { high = middle }
    }
    let threshold = high.exp2();
    let kept = [all, count(threshold)?];
    let (mut pictures, mut speeds) = (Vec::new(), Vec::new());
    for threshold in [0.0, threshold] {
        let how = How { threshold, tables: Some(&tables) };
        let (timing, radiance) = frames(&scene, &blockers, &gbuffer.points, how, 5).map_err(Failure::new)?;
        speeds.push(1.0 / timing.stats.seconds);
        pictures.push(resolve(&gbuffer, &radiance));
    }
    let most = kept.iter().flatten().fold(0.0_f32, |m, n| m.max(*n));
    let maps = kept.iter().map(|counts| {
        let rgb = gbuffer.resolve(counts, 0.0).iter().flat_map(|n| heat(f64::from(*n / most))).collect();
        Cell { title: "products kept".into(), note: format!("white 0, black {most:.0}"), size: (256, 256), rgb }
    });
    let titles = [("t = 0".to_owned(), "method paper"), (format!("t = {threshold:.5}"), "method paper")];
    let shown = titles.iter().zip(&pictures).map(|((title, note), p)| cell(title, *note, p, 0.0));
    let cells = shown.zip(maps).flat_map(|(picture, map)| [picture, map]).collect();
    let change = Comparison::of(&pictures[1], &pictures[0])?;
    Ok(Page {
        title: "the saving of the threshold",
        images: vec![Sheet::new(4, cells).image(name)?],
        shows: "A glossy object on a glossy floor without and with a threshold, and how many products of lobes each pixel keeps.".into(),
        paper: "65 536 points, one spherical light, 64 spheres: about 50 % fewer products with a threshold that leaves the picture \
                indistinguishable, which gains 2 frames a second (Fig. 15)."
            .into(),
        here: format!(
            "The same counts. The threshold {threshold:.5} leaves {:.0} % of the products. The picture changes by {:.2} % of its mean. On {} threads \
             frames a second go from {:.1} to {:.1}: a product is only known to be small once it is there.",
            100.0 * total(&kept[1]) / total(&kept[0]),
            100.0 * change.mae / change.reference_mean,
            rayon::current_num_threads(),
            speeds[0],
            speeds[1]
        ),
        differs: "The paper's model and its value of the threshold are not given.".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions that are drawn from a lobe have its mean cosine, (e + 1)/(e + 2).
    #[test]
    fn samples_follow_the_lobe() {
        for exponent in [1.0, 30.0, 2e4] {
            let lobe = Lobe::new(Vec3::new(0.6, 0.0, 0.8), exponent, Vec3::ONE);
            let basis = orthonormal_basis(lobe.axis);
            let at = |k: usize| [0.819_172_5, 0.671_043_6].map(|s: f64| (0.5 + s * k as f64).fract() as f32);
            // 1 − cos θ as half a squared chord.
            let behind = (0..4096).map(|k| 0.5 * (sample(&lobe, basis, at(k)) - lobe.axis).length_squared());
            let mean = behind.sum::<f32>() / 4096.0 * (exponent + 2.0);
            assert!((mean - 1.0).abs() < 0.01, "{exponent}: {mean}");
        }
    }
}
