//! Fig. 2 and 4: integrals of one lobe, and of random products.

use super::canvas::Draw;
use super::chart::{Axis, Chart, Curve};
use super::gallery::Page;
use crate::failure::Failure;
use core::f64::consts::TAU;
use cosine_lobes::lobe_core::products_of_angle;
use cosine_lobes::paper;
use plotters::prelude::SeriesLabelPosition;
use rayon::prelude::*;

pub(super) fn of_one_lobe(name: &str) -> Result<Page, Failure> {
    let exact = |e: f64| TAU / (e + 1.0);
    let table = |e: f64| f64::from(paper::integral(e as f32));
    let along =
        |f: &dyn Fn(f64) -> f64| (0..=120).map(|i| 10f64.powf(-1.0 + f64::from(i) / 40.0)).map(|e| (e, f(e))).collect();
    let chart = Chart {
        title: "Integral of a lobe of scale 1",
        x: Axis::log("exponent e", 0.099..100.0),
        y: Axis::linear("∫ max(a·v, 0)^e dv, steradians", 0.0..6.0),
        curves: vec![
            Curve { width: 6, ..Curve::line("table of §4.2, interpolated", 5, along(&table)) },
            Curve::line("2π/(e + 1)", 0, along(&exact)),
        ],
        key: SeriesLabelPosition::UpperRight,
    };
    // As densely as the table's own steps, over all of its range.
    let worst =
        (0..60_000).map(|i| 10f64.powf(-1.0 + f64::from(i) / 10_000.0)).map(|e| (table(e) / exact(e) - 1.0).abs());
    let worst = worst.fold(0.0, f64::max);
    Ok(Page {
        title: "integral of a lobe by its exponent",
        images: chart.images(name)?,
        shows: "The integral falls steeply at small exponents and slowly at large ones.".into(),
        paper: "The curve falls from about 6 to nearly 0 between exponents 0.1 and 100; no numbers (Fig. 2, §4.1). A table of 128 samples a \
                decade replaces the integral (§4.2)."
            .into(),
        here: format!(
            "The integral is 2π/(e + 1), exactly: {:.3} at e = 0.1, {:.3} at 1, {:.4} at 100. The interpolated table differs from it by \
             {:.3} % at most, for exponents between 0.1 and 10⁵.",
            exact(0.1),
            exact(1.0),
            exact(100.0),
            100.0 * worst
        ),
        differs: String::new(),
    })
}

/// As many as the paper has.
const PRODUCTS: usize = 10_000_000;
/// The largest exponents of its three environments.
const LARGEST: [f64; 3] = [10.0, 100.0, 1000.0];
/// Thresholds a decade.
const STEPS: usize = 20;
/// Its axis: from 10⁻² to 10.
const DECADES: usize = 3;

pub(super) fn of_products(name: &str) -> Result<Page, Failure> {
    let shares = LARGEST.map(|largest| shares_above(largest, PRODUCTS));
    let threshold = |k: usize| 10f64.powf(-2.0 + k as f64 / STEPS as f64);
    let curve = |(i, share): (usize, &Vec<f64>)| {
        let points = share.iter().enumerate().map(|(k, share)| (threshold(k), 100.0 * share)).collect();
        Curve::line(format!("exponents in [0, {}]", LARGEST[i]), [0, 2, 1][i], points)
    };
    let chart = Chart {
        title: "Products of two lobes whose integral reaches a threshold",
        x: Axis::log("threshold, steradians", 0.0099..10.0),
        y: Axis::linear("% of the products", 0.0..100.0),
        curves: shares.iter().enumerate().map(curve).collect(),
        key: SeriesLabelPosition::UpperRight,
    };
    let mut here = String::from("Of each environment's products this many reach the threshold:\n\n| exponents in | ");
    let shown = [0, STEPS / 2, STEPS, 2 * STEPS];
    shown.iter().for_each(|k| here += &format!("t = {:.3} | ", threshold(*k)));
    here += "\n|---|---|---|---|---|";
    for (largest, share) in LARGEST.iter().zip(&shares) {
        here += &format!("\n| [0, {largest}] |");
        shown.iter().for_each(|k| here += &format!(" {:.1} % |", 100.0 * share[*k]));
    }
    Ok(Page {
        title: "products that a threshold leaves",
        images: chart.images(name)?,
        shows: "Ten million products of two random lobes of scale 1: the share whose integral is at least the threshold. Exponents are uniform \
                in [0, 10], [0, 10²] or [0, 10³], axes uniform over the sphere."
            .into(),
        paper: "Even a small threshold avoids many products (Fig. 4, §4.3). The curves have no numbers.".into(),
        here,
        differs: "The paper does not say how it draws axes.".into(),
    })
}

/// The fraction of random products whose integral reaches each threshold.
fn shares_above(largest: f64, count: usize) -> Vec<f64> {
    const BLOCK: usize = 1 << 14;
    let limits: Vec<f32> = (0..=DECADES * STEPS).map(|k| 10f32.powf(-2.0 + k as f32 / STEPS as f32)).collect();
    let block = |first: usize| {
        let n = BLOCK.min(count - first);
        let [mut e1, mut e2, mut behind] = [(); 3].map(|()| Vec::with_capacity(n));
        for i in first..first + n {
            let [x, y, z] = spread(i);
            e1.push((largest * x) as f32);
            e2.push((largest * y) as f32);
            // 1 − cos α is uniform where axes are.
            behind.push((2.0 * z) as f32);
        }
        let mut integrals = vec![0.0; n];
        products_of_angle(&e1, &e2, &behind, &mut integrals);
        let mut reached = vec![0_u64; limits.len()];
        for integral in integrals {
            let below = limits.partition_point(|limit| *limit <= integral);
            if below > 0 {
                reached[below - 1] += 1;
            }
        }
        reached
    };
    let add = |a: Vec<u64>, b: Vec<u64>| a.iter().zip(&b).map(|(a, b)| a + b).collect();
    let starts = (0..count).into_par_iter().step_by(BLOCK);
    let mut reached = starts.map(block).reduce(|| vec![0; limits.len()], add);
    for k in (1..reached.len()).rev() {
        reached[k - 1] += reached[k];
    }
    reached.into_iter().map(|n| n as f64 / count as f64).collect()
}

/// Points that fill the unit cube evenly: multiples of the powers of the root of x⁴ = x + 1.
fn spread(i: usize) -> [f64; 3] {
    const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_960_8];
    STEPS.map(|step| (0.5 + step * (i + 1) as f64).fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two hemispheres (exponents 0) the product's integral is 2(π − α): it reaches t where α ≤ π − t/2.
    #[test]
    fn shares_of_hemispheres_are_known() {
        let shares = shares_above(0.0, 200_000);
        for (k, share) in shares.iter().enumerate() {
            let t = 10f64.powf(-2.0 + k as f64 / STEPS as f64);
            let exact = if t > TAU { 0.0 } else { 0.5 * (1.0 - (core::f64::consts::PI - 0.5 * t).cos()) };
            assert!((share - exact).abs() < 2e-3, "{t}: {share} {exact}");
        }
    }
}
