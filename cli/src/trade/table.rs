//! The rows as CSV and Markdown.

use super::row::Row;
use std::fmt::Write;

/// Errors at which techniques are compared in time.
const EQUAL_ERRORS: [f64; 4] = [0.01, 0.003, 0.001, 0.0003];

pub(super) fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,method,visibility,device,tolerance,depth,spp,seconds,spread,lower_quartile,upper_quartile,frame_seconds,own_mean,own_p99,mean,p99,\
         flip,front\n",
    );
    let quoted =
        |s: &str| if s.contains([',', '"']) { format!("\"{}\"", s.replace('"', "\"\"")) } else { s.to_owned() };
    let some = |x: Option<String>| x.unwrap_or_default();
    for r in rows {
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            quoted(&r.scene),
            quoted(&r.method),
            r.visibility,
            r.device,
            some(r.tolerance.map(|t| t.to_string())),
            some(r.depth.map(|d| d.to_string())),
            some(r.spp.map(|n| n.to_string())),
            r.seconds,
            r.spread,
            r.quartiles[0],
            r.quartiles[1],
            r.frame_seconds,
            r.own_mean,
            r.own_p99,
            r.mean,
            r.p99,
            r.flip,
            u8::from(r.front),
        );
    }
    text
}

pub(super) fn markdown(rows: &[Row], about: &str, points: usize) -> String {
    let mut text = format!("# Error against time\n\n{about}\n\n![Error against time](trade.png)\n\n");
    equal_errors(&mut text, rows);
    text.push_str("## All settings\n\nOn the Pareto front: ●. Errors of own radiance, then in penumbra of unshadowed radiance.\n\n");
    text.push_str(
        "| | method | visibility | device | setting | ms (quartiles) | frame ms | ns a point | own mean | own 99 % | mean | 99 % | FLIP |\n",
    );
    text.push_str("|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    let mut sorted: Vec<&Row> = rows.iter().collect();
    sorted.sort_by(|a, b| a.technique().cmp(&b.technique()).then(a.seconds.total_cmp(&b.seconds)));
    for r in sorted {
        let [low, high] = r.quartiles.map(|s| 1e3 * s);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.2} ({low:.2}–{high:.2}) | {:.2} | {:.0} | {:.4} % | {:.3} % | {:.4} % | {:.3} % | {:.5} |",
            if r.front { "●" } else { "" },
            r.method,
            r.visibility,
            r.device,
            r.knobs(),
            1e3 * r.seconds,
            1e3 * r.frame_seconds,
            1e9 * r.seconds / points.max(1) as f64,
            100.0 * r.own_mean,
            100.0 * r.own_p99,
            100.0 * r.mean,
            100.0 * r.p99,
            r.flip,
        );
    }
    text
}

/// The time that each technique takes to come below an error.
fn equal_errors(text: &mut String, rows: &[Row]) {
    let mut techniques: Vec<String> = rows.iter().map(Row::technique).collect();
    techniques.sort();
    techniques.dedup();
    text.push_str("## At equal error\n\nMilliseconds of the fastest setting whose penumbra mean is below; samplers between their ");
    text.push_str("settings by the line through both logarithms.\n\n| |");
    EQUAL_ERRORS.iter().for_each(|e| text.push_str(&format!(" {} % |", 100.0 * e)));
    text.push_str("\n|---|");
    EQUAL_ERRORS.iter().for_each(|_| text.push_str("---|"));
    text.push('\n');
    for technique in &techniques {
        let own: Vec<&Row> = rows.iter().filter(|r| r.technique() == *technique).collect();
        let _ = write!(text, "| {technique} |");
        for error in EQUAL_ERRORS {
            let time = time_for(&own, error).map_or("–".to_owned(), |s| format!("{:.2}", 1e3 * s));
            let _ = write!(text, " {time} |");
        }
        text.push('\n');
    }
    text.push('\n');
}

/// Seconds that a technique needs for an error.
fn time_for(rows: &[&Row], error: f64) -> Option<f64> {
    let below = rows.iter().filter(|r| r.mean <= error).min_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
    // Samples can be had in any number: the slower of two settings would be too much.
    let above = rows.iter().filter(|r| r.spp.is_some() && r.mean > error && r.seconds < below.seconds);
    match above.max_by(|a, b| a.seconds.total_cmp(&b.seconds)) {
        Some(above) if below.mean > 0.0 => {
            let t = (error / above.mean).ln() / (below.mean / above.mean).ln();
            Some(above.seconds * (below.seconds / above.seconds).powf(t))
        }
        _ => Some(below.seconds),
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::tests::row;
    use super::*;

    #[test]
    fn samplers_are_interpolated_and_lobes_are_not() {
        let mut rows = [row("samples", 1.0, 0.1), row("samples", 4.0, 0.025)];
        // An error that falls with time: half of it in twice the time.
        rows.iter_mut().for_each(|r| r.spp = Some(1));
        let refs: Vec<&Row> = rows.iter().collect();
        assert!((time_for(&refs, 0.05).unwrap() - 2.0).abs() < 1e-9);
        assert_eq!((time_for(&refs, 0.2), time_for(&refs, 0.01)), (Some(1.0), None));
        rows.iter_mut().for_each(|r| r.spp = None);
        let refs: Vec<&Row> = rows.iter().collect();
        assert_eq!(time_for(&refs, 0.05), Some(4.0));
    }

    #[test]
    fn tables_have_a_line_a_row() {
        let rows = [row("samples, unculled", 1.0, 0.1), row("b", 2.0, 0.05)];
        assert_eq!(csv(&rows).lines().count(), 3);
        assert!(csv(&rows).lines().all(|l| l.replace("samples, unculled", "").matches(',').count() == 17));
        assert!(markdown(&rows, "about", 10).contains("| b | spheres |"));
    }
}
