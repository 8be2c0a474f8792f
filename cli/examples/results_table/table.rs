//! The tables as Markdown.

use crate::counts::Count;
use crate::measure::Timing;
use crate::order::{NAMES, Orders};
use crate::rows::Row;
use crate::scaling::Measured;
use std::fmt::Write;

pub(crate) fn markdown(rows: &[Row], curves: &[Measured], orders: &[Orders], counts: &[Count]) -> String {
    let mut text = String::from("# Results\n\n");
    let threads = threads();
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "Shading of one frame, visible points given, {threads} threads, tolerance 0.5 %, depth 5, strategy `spheres`. Scenes \
         with the paper's numbers of points, spheres and lights, made by `cargo run --release --example results_table`; the \
         paper's figures are from an Intel Core i7 920 with an NVIDIA GTX 280. Median of repeated frames \
         with quartiles; `CPU ms` is the time that all threads spent on processors, a frame: divided by the threads it is what an idle \
         machine would take at best.\n"
    );
    if !rows.is_empty() {
        times(&mut text, rows);
        counters(&mut text, rows);
    }
    curves.iter().for_each(|curve| series(&mut text, curve));
    if !orders.is_empty() {
        in_orders(&mut text, orders);
    }
    if !counts.is_empty() {
        of_sets(&mut text, counts);
    }
    text
}

fn threads() -> usize {
    std::env::var("RAYON_NUM_THREADS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
}

fn times(text: &mut String, rows: &[Row]) {
    text.push_str(
        "| scene | points | spheres | lights | penumbra | dark | ms a frame (quartiles) | fps | best ms | CPU ms | target | paper |\n",
    );
    text.push_str("|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for Row { line, spheres, lights, timing } in rows {
        let (name, note, paper, target) = (line.name, line.note, line.paper, line.target);
        let [_, penumbra, dark] = timing.shares().map(|s| 100.0 * s);
        let asked = match target {
            t if t >= 10.0 => format!("≥ {t:.0} fps"),
            t if t > 0.0 => format!("≤ {:.2} s", 1.0 / t),
            _ => "–".to_owned(),
        };
        let paper = if paper.is_empty() { "–" } else { paper };
        let points = timing.points;
        let _ = writeln!(
            text,
            "| {name}: {note} | {points} | {spheres} | {lights} | {penumbra:.1} % | {dark:.1} % | {} | \
             {:.1} | {:.2} | {} | {asked} | {paper} |",
            timing.milliseconds(),
            1.0 / timing.stats.seconds,
            1e3 * timing.best,
            timing.processor_milliseconds()
        );
    }
    text.push('\n');
}

fn counters(text: &mut String, rows: &[Row]) {
    text.push_str(
        "Fractions of the time, as in the paper's Table 1 (its Fig. 13: 2.1, 1.5, 84.8, 4.5, 7.1 %), and counts a point–light \
         pair in penumbra:\n\n",
    );
    text.push_str(
        "| scene | reflectance | lighting | mask | visibility lobes | integration | lobes | integrals (all) |\n",
    );
    text.push_str("|---|---|---|---|---|---|---|---|\n");
    for row in rows {
        let [a, b, c, d, e] = row.timing.stages();
        let counts = row.timing.stats.counts;
        let lobes = counts.lobes as f64 / counts.penumbra_points.max(1) as f64;
        let _ = writeln!(
            text,
            "| {} | {a:.1} % | {b:.1} % | {c:.1} % | {d:.1} % | {e:.1} % | {lobes:.2} | {} |",
            row.line.name, counts.integrals
        );
    }
    text.push('\n');
}

fn series(text: &mut String, measured: &Measured) {
    let curve = &measured.curve;
    let _ = writeln!(text, "## {}\n\n{}. 65 536 points.\n", curve.name, curve.note);
    let _ = writeln!(
        text,
        "| {} | penumbra | ms (quartiles) | best ms | CPU ms | × the first |\n|---|---|---|---|---|---|",
        curve.of
    );
    let first = measured.timings.first().map_or(1.0, Timing::cost);
    for (value, timing) in measured.points() {
        let [_, penumbra, _] = timing.shares();
        let _ = writeln!(
            text,
            "| {value} | {:.1} % | {} | {:.2} | {} | {:.2} |",
            100.0 * penumbra,
            timing.milliseconds(),
            1e3 * timing.best,
            timing.processor_milliseconds(),
            timing.cost() / first
        );
    }
    text.push('\n');
}

fn in_orders(text: &mut String, orders: &[Orders]) {
    text.push_str(
        "## Order of points\n\nPoints that come in no order, as vertices may, and what `ShadingPoints::make_coherent` makes of \
         them. Sorting is needed once, not for each frame.\n\n| scene | order | ms (quartiles) | best ms | CPU ms | × tiles | sorting, ms |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for Orders { name, timings, sorting } in orders {
        for (k, timing) in timings.iter().enumerate() {
            let sorting = if k == 2 { format!("{:.1}", 1e3 * sorting) } else { "–".to_owned() };
            let _ = writeln!(
                text,
                "| {name} | {} | {} | {:.2} | {} | {:.2} | {sorting} |",
                NAMES[k],
                timing.milliseconds(),
                1e3 * timing.best,
                timing.processor_milliseconds(),
                timing.cost() / timings[0].cost()
            );
        }
    }
    text.push('\n');
}

fn of_sets(text: &mut String, counts: &[Count]) {
    text.push_str(
        "## Sets by count\n\nFig. 18 right, its object as more or fewer spheres: the time, and the error against rays to the true mesh, \
         a fraction of the unshadowed radiance over points in penumbra.\n\n| spheres | ms (quartiles) | best ms | CPU ms | mean error | \
         99 % below |\n|---|---|---|---|---|---|\n",
    );
    for Count { spheres, timing, penumbra } in counts {
        let _ = writeln!(
            text,
            "| {spheres} | {} | {:.2} | {} | {:.2} % | {:.1} % |",
            timing.milliseconds(),
            1e3 * timing.best,
            timing.processor_milliseconds(),
            100.0 * penumbra.mean,
            100.0 * penumbra.p99
        );
    }
    text.push('\n');
}
