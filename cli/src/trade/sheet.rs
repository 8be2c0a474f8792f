//! Pictures at equal time, side by side.

use super::row::Row;
use super::setting::Setting;
use super::stage::Stage;
use super::truth::Truth;
use crate::args::TradeArgs;
use crate::drawing::{font, smaller};
use crate::failure::Failure;
use cosine_lobes::{Output, signed_difference, srgb_bytes, write_png};
use plotters::prelude::*;

/// The widest picture; larger ones are shown smaller.
const WIDTH: usize = 320;
const GAP: usize = 8;
/// Two lines of text over each picture.
const TEXT: usize = 40;
/// Techniques next to each other.
const COLUMNS: usize = 4;
/// Difference of luminance that has full colour, as a fraction of the picture's mean.
const FULL: f64 = 0.02;

/// For each technique its best setting within the time of the fastest lobes below 0.3 %, or its fastest where all take longer:
/// pictures and, below them, their differences from the reference.
pub(super) fn write(
    args: &TradeArgs,
    stage: &mut Stage<'_>,
    settings: &[Setting],
    rows: &[Row],
    truth: &Truth,
) -> Result<(), Failure> {
    let time = equal_time(rows);
    let factor = truth.picture.width().div_ceil(WIDTH).max(1);
    let mean = truth.picture.pixels().iter().map(|p| cosine_lobes::luminance(*p)).sum::<f64>()
        / truth.picture.pixels().len().max(1) as f64;
    let mut cells = vec![Cell {
        title: "reference".to_owned(),
        note: format!("{} samples", truth.samples),
        bytes: srgb_bytes(&smaller(&truth.picture, factor), stage.exposure()),
        difference: None,
    }];
    for row in chosen(rows, time) {
        let Some(setting) = settings.iter().find(|s| row.is(s)) else { continue };
        let shot = stage.shoot(setting)?;
        let picture = stage.picture(&shot.radiance);
        let [test, reference] = [&picture, &truth.picture].map(|p| smaller(p, factor));
        cells.push(Cell {
            title: format!("{}, {}", row.technique(), row.knobs()),
            note: format!("{:.1} ms, error {:.3} %", 1e3 * row.seconds, 100.0 * row.mean),
            bytes: srgb_bytes(&test, stage.exposure()),
            difference: Some(signed_difference(&test, &reference, FULL * mean.max(1e-12))?),
        });
    }
    let size = (truth.picture.width() / factor, truth.picture.height() / factor);
    let sheet = Sheet::draw(&cells, size)?;
    let output = Output::create(args.output.join("sheet.png"))?;
    Ok(write_png(output, sheet.width, sheet.height, &sheet.bytes)?)
}

/// Seconds of the fastest moments row below 0.3 % in penumbra; else of the one nearest to the reference.
fn equal_time(rows: &[Row]) -> f64 {
    let lobes = || rows.iter().filter(|r| r.spp.is_none());
    let good = lobes().filter(|r| r.mean <= 0.003).map(|r| r.seconds).min_by(f64::total_cmp);
    let best = lobes().min_by(|a, b| a.mean.total_cmp(&b.mean)).map(|r| r.seconds);
    good.or(best).unwrap_or(f64::INFINITY)
}

/// One row a technique, in the order of the rows.
fn chosen(rows: &[Row], time: f64) -> Vec<&Row> {
    let mut techniques = Vec::new();
    for row in rows {
        if !techniques.contains(&row.technique()) {
            techniques.push(row.technique());
        }
    }
    let of = |technique: &String| {
        let own = || rows.iter().filter(|r| r.technique() == *technique);
        let within = own().filter(|r| r.seconds <= 1.1 * time).min_by(|a, b| a.mean.total_cmp(&b.mean));
        within.or_else(|| own().min_by(|a, b| a.seconds.total_cmp(&b.seconds)))
    };
    techniques.iter().filter_map(of).collect()
}

struct Cell {
    title: String,
    note: String,
    bytes: Vec<u8>,
    difference: Option<Vec<u8>>,
}

struct Sheet {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
}

impl Sheet {
    fn draw(cells: &[Cell], size: (usize, usize)) -> Result<Self, Failure> {
        // Room for the text also over narrow pictures.
        let column = size.0.max(WIDTH) + GAP;
        let row = TEXT + 2 * size.1 + 2 * GAP;
        let width = GAP + column * cells.len().min(COLUMNS);
        let height = GAP + row * cells.len().div_ceil(COLUMNS);
        let mut sheet = Self { width, height, bytes: vec![255; 3 * width * height] };
        let corner = |i: usize| (GAP + i % COLUMNS * column, GAP + i / COLUMNS * row);
        for (i, cell) in cells.iter().enumerate() {
            let (x, y) = corner(i);
            sheet.paste(&cell.bytes, size, (x, y + TEXT));
            if let Some(difference) = &cell.difference {
                sheet.paste(difference, size, (x, y + TEXT + size.1 + GAP));
            }
        }
        font()?;
        let failed = |e: &dyn std::fmt::Display| Failure::new(format_args!("the sheet cannot be drawn: {e}"));
        let area = BitMapBackend::with_buffer(&mut sheet.bytes, (width as u32, height as u32)).into_drawing_area();
        let text = |text: &str, at: (usize, usize)| {
            let style = ("sans-serif", 15).into_font().color(&BLACK);
            area.draw_text(text, &style, (at.0 as i32, at.1 as i32)).map_err(|e| failed(&e))
        };
        for (i, cell) in cells.iter().enumerate() {
            let (x, y) = corner(i);
            text(&cell.title, (x, y))?;
            text(&cell.note, (x, y + TEXT / 2))?;
        }
        area.present().map_err(|e| failed(&e))?;
        drop(area);
        Ok(sheet)
    }

    fn paste(&mut self, bytes: &[u8], size: (usize, usize), at: (usize, usize)) {
        for (y, line) in bytes.chunks_exact(3 * size.0).enumerate() {
            let start = 3 * ((at.1 + y) * self.width + at.0);
            self.bytes[start..start + line.len()].copy_from_slice(line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::tests::row;
    use super::*;

    #[test]
    fn within_the_time_or_the_fastest() {
        let mut rows =
            [row("a", 1.0, 0.01), row("a", 2.0, 0.002), row("s", 0.5, 0.5), row("s", 1.9, 0.3), row("t", 9.0, 0.1)];
        rows[2].spp = Some(1);
        rows[3].spp = Some(2);
        assert_eq!(equal_time(&rows), 2.0);
        let times: Vec<f64> = chosen(&rows, 2.0).iter().map(|r| r.seconds).collect();
        assert_eq!(times, [2.0, 1.9, 9.0]);
    }
}
