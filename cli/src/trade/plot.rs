//! Error against time, both as logarithms.

use super::record;
use super::row::Row;
use crate::drawing::{COLORS, font};
use crate::failure::Failure;
use cosine_lobes::{Output, write_png};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;

const SIZE: (u32, u32) = (1100, 680);
/// At the right, for the names of the curves.
const KEY_WIDTH: i32 = 220;

pub(super) fn write(folder: &Path, title: &str, rows: &[Row]) -> Result<(), Failure> {
    font()?;
    let mut text = String::new();
    draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area(), title, rows).map_err(Failure::new)?;
    record::write(&folder.join("trade.svg"), &text)?;
    let mut pixels = vec![255; 3 * SIZE.0 as usize * SIZE.1 as usize];
    draw(&BitMapBackend::with_buffer(&mut pixels, SIZE).into_drawing_area(), title, rows).map_err(Failure::new)?;
    Ok(write_png(Output::create(folder.join("trade.png"))?, SIZE.0 as usize, SIZE.1 as usize, &pixels)?)
}

/// The rows of one technique that none of its others beats, by time.
fn own_front<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let mut sorted = rows.to_vec();
    sorted.sort_by(|a, b| a.seconds.total_cmp(&b.seconds).then(a.mean.total_cmp(&b.mean)));
    let mut best = f64::INFINITY;
    sorted.retain(|row| {
        let better = row.mean < best;
        best = best.min(row.mean);
        better
    });
    sorted
}

/// Milliseconds and per cent, both above zero.
fn place(row: &Row) -> (f64, f64) {
    (1e3 * row.seconds.max(1e-7), 100.0 * row.mean.max(1e-7))
}

/// Up to a whole 1, 2 or 5 times a power of ten, or down.
fn round(x: f64, up: bool) -> f64 {
    let power = 10.0_f64.powf(x.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * power);
    let (above, below) = (steps.iter().find(|s| **s >= x), steps.iter().rev().find(|s| **s <= x));
    *(if up { above } else { below }).unwrap_or(&x)
}

/// The techniques of rows, in their order.
fn techniques(rows: &[Row]) -> Vec<String> {
    let mut techniques: Vec<String> = Vec::new();
    for row in rows {
        if !techniques.contains(&row.technique()) {
            techniques.push(row.technique());
        }
    }
    techniques
}

/// The range of an axis.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
    if low > high { 0.1..1.0 } else { round(0.9 * low, false)..round(1.1 * high, true) }
}

/// The names of curves beside pieces of them.
fn draw_keys<B: DrawingBackend>(
    margin: &DrawingArea<B, Shift>,
    keys: Vec<(String, RGBColor, u32)>,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    for (i, (name, color, stroke)) in keys.into_iter().enumerate() {
        let y = 60 + 24 * i as i32;
        margin.draw(&PathElement::new(vec![(4, y), (26, y)], color.stroke_width(stroke)))?;
        margin.draw(&Text::new(name, (34, y - 8), ("sans-serif", 15)))?;
    }
    Ok(())
}

fn draw<B: DrawingBackend>(root: &DrawingArea<B, Shift>, title: &str, rows: &[Row]) -> Result<(), String>
where
    B::ErrorType: 'static,
{
    let failed = |e: DrawingAreaErrorKind<B::ErrorType>| format!("the plot cannot be drawn: {e}");
    root.fill(&WHITE).map_err(failed)?;
    let (area, margin) = root.split_horizontally(SIZE.0 as i32 - KEY_WIDTH);
    let times = range(rows.iter().map(|row| place(row).0));
    let errors = range(rows.iter().map(|row| place(row).1));
    let caption = format!("{title}: error in penumbra against time of shading");
    let mut chart = ChartBuilder::on(&area)
        .caption(caption, ("sans-serif", 20))
        .margin(18)
        .x_label_area_size(48)
        .y_label_area_size(76)
        .build_cartesian_2d(times.log_scale(), errors.log_scale())
        .map_err(failed)?;
    let plain = |x: &f64| {
        let text = format!("{x:.6}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    chart
        .configure_mesh()
        .x_desc("milliseconds a frame, visible points given")
        .y_desc("mean error in penumbra, % of the unshadowed radiance")
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .light_line_style(RGBColor(240, 240, 240))
        .bold_line_style(RGBColor(215, 215, 215))
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .draw()
        .map_err(failed)?;

    let mut front: Vec<&Row> = rows.iter().filter(|r| r.front).collect();
    front.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let line = LineSeries::new(front.iter().map(|r| place(r)), RGBColor(200, 200, 200).stroke_width(9));
    chart.draw_series(line).map_err(failed)?;
    let mut keys = vec![("Pareto front".to_owned(), RGBColor(200, 200, 200), 9)];

    for (i, technique) in techniques(rows).iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let own: Vec<&Row> = rows.iter().filter(|r| r.technique() == *technique).collect();
        let dots = own.iter().map(|r| Circle::new(place(r), 3, color.mix(0.45).filled()));
        chart.draw_series(dots).map_err(failed)?;
        let best = own_front(&own);
        let line = LineSeries::new(best.iter().map(|r| place(r)), color.stroke_width(2)).point_size(4);
        chart.draw_series(line).map_err(failed)?;
        keys.push((technique.clone(), color, 3));
    }
    let rings = front.iter().map(|r| Circle::new(place(r), 7, BLACK.stroke_width(2)));
    chart.draw_series(rings).map_err(failed)?;
    draw_keys(&margin, keys).map_err(failed)?;
    root.present().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::super::row::{mark_front, tests::row};
    use super::*;

    #[test]
    fn both_files_are_drawn() {
        let folder = tempfile::tempdir().unwrap();
        let mut rows = [row("a", 0.001, 0.01), row("a", 0.01, 0.001), row("b", 0.1, 0.0), row("b", 0.02, 0.002)];
        mark_front(&mut rows);
        write(folder.path(), "scene", &rows).unwrap();
        let svg = std::fs::read_to_string(folder.path().join("trade.svg")).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("Pareto front") && svg.contains("b / spheres"));
        assert!(std::fs::metadata(folder.path().join("trade.png")).unwrap().len() > 1000);
        write(folder.path(), "none", &[]).unwrap();
    }

    #[test]
    fn ends_of_axes() {
        assert_eq!((round(0.03, false), round(0.03, true), round(7.0, true)), (0.02, 0.05, 10.0));
    }
}
