//! Fig. 3 and 6: the product of two lobes as one lobe.

use super::canvas::{Draw, failed, heat};
use super::gallery::Page;
use super::studio::Studio;
use crate::failure::Failure;
use core::f64::consts::TAU;
use cosine_lobes::lobe_core::product_of_angle;
use cosine_lobes::paper::{Population, ProductTable, Resolution, table_error};
use plotters::coord::Shift;
use plotters::prelude::*;

/// Pairs of which the mean error is taken.
const PAIRS: usize = 200_000;
/// The paper's numbers (§4.2).
const PAPER_MEAN: f64 = 7.1379e-4;

/// |∫ c_r − ∫ c1·c2| and the exact integral, for lobes of scale 1.
fn difference(table: &ProductTable, e1: f64, e2: f64, degrees: f64) -> (f64, f64) {
    let angle = degrees.to_radians();
    let (scale, exponent) = table.lookup(e1 as f32, e2 as f32, angle as f32);
    let exact = f64::from(product_of_angle(e1 as f32, e2 as f32, (1.0 - angle.cos()) as f32));
    ((f64::from(scale) * TAU / (f64::from(exponent) + 1.0) - exact).abs(), exact)
}

/// An error that may be nothing.
fn tiny(error: f64) -> String {
    if error < 1e-12 { "below 1e-12".to_owned() } else { format!("{error:.1e}") }
}

const ANGLES: [f64; 4] = [45.0, 90.0, 135.0, 160.0];
/// Cells a side of a map.
const CELLS: usize = 40;
/// The error that is black.
const BLACKEST: f64 = 0.2;

/// Errors over both exponents, a map for each angle: all of the range above, the small exponents below.
struct Maps<'a> {
    table: &'a ProductTable,
}

/// Exponents along an axis of the upper maps, from 10⁻² to 10⁵.
fn wide(t: f64) -> f64 {
    10f64.powf(-2.0 + 7.0 * t)
}

/// Of the lower ones.
fn narrow(t: f64) -> f64 {
    2.0 * t
}

impl Draw for Maps<'_> {
    fn size(&self) -> (u32, u32) {
        (800, 500)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        const SIDE: i32 = 160;
        let cell = SIDE / CELLS as i32;
        let small = ("sans-serif", 14).into_font();
        let text = |words: String, at: (i32, i32)| root.draw(&Text::new(words, at, small.clone())).map_err(failed);
        for (k, degrees) in ANGLES.into_iter().enumerate() {
            for (row, of) in [(0, wide as fn(f64) -> f64), (1, narrow)] {
                let (left, top) = (60 + k as i32 * (SIDE + 24), 34 + row * (SIDE + 62));
                for j in 0..CELLS {
                    let value = |i: usize| {
                        let at = |i: usize| of((i as f64 + 0.5) / CELLS as f64);
                        // In 24 steps, so that equal neighbours are one rectangle.
                        (24.0 * difference(self.table, at(i), at(j), degrees).0 / BLACKEST).round().min(24.0)
                    };
                    let mut from = 0;
                    while from < CELLS {
                        let color = value(from);
                        let to = (from + 1..CELLS).find(|i| value(*i) != color).unwrap_or(CELLS);
                        let y = top + SIDE - cell * (j as i32 + 1);
                        let corners = [(left + cell * from as i32, y), (left + cell * to as i32, y + cell)];
                        let [r, g, b] = heat(color / 24.0);
                        root.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled())).map_err(failed)?;
                        from = to;
                    }
                }
                root.draw(&Rectangle::new([(left, top), (left + SIDE, top + SIDE)], BLACK)).map_err(failed)?;
                text(format!("α = {degrees}°"), (left + 55, top - 18))?;
                let ends = if row == 0 { ["0.01", "10⁵"] } else { ["0", "2"] };
                text(ends[0].into(), (left, top + SIDE + 4))?;
                text(ends[1].into(), (left + SIDE - 8 * ends[1].chars().count() as i32, top + SIDE + 4))?;
                text(if row == 0 { "e1 (log)" } else { "e1" }.into(), (left + 60, top + SIDE + 4))?;
                if k == 0 {
                    text(if row == 0 { "e2 (log)" } else { "e2" }.into(), (4, top + 70))?;
                    text(ends[1].into(), (26, top))?;
                    text(ends[0].into(), (26, top + SIDE - 14))?;
                }
            }
        }
        // The key.
        let (left, top) = (60, 466);
        for i in 0..32 {
            let [r, g, b] = heat(f64::from(i) / 31.0);
            let corners = [(left + 8 * i, top), (left + 8 * i + 8, top + 14)];
            root.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled())).map_err(failed)?;
        }
        root.draw(&Rectangle::new([(left, top), (left + 256, top + 14)], BLACK)).map_err(failed)?;
        text("0".into(), (left - 12, top))?;
        text(format!("{BLACKEST} steradians: |∫ c_r − ∫ c1·c2|"), (left + 264, top))
    }
}

pub(super) fn error(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let table = &tables.products;
    let samples = table_error(table, Population::Samples, PAIRS, 1);
    let ten = table_error(table, Population::Uniform { max: 10.0 }, PAIRS, 1);
    let whole = table_error(table, Population::Uniform { max: 1e5 }, PAIRS, 1);
    // The worst of small exponents at a right angle.
    let grid = (0..=20).flat_map(|i| (0..=20).map(move |j| (f64::from(i) / 20.0, f64::from(j) / 20.0)));
    let right = grid
        .map(|(e1, e2)| difference(table, e1, e2, 90.0))
        .fold((0.0, 1.0), |worst: (f64, f64), found| if found.0 > worst.0 { found } else { worst });
    let (e1, e2, alpha) = samples.max_at;
    Ok(Page {
        title: "error of a product of two lobes",
        images: Maps { table }.images(name)?,
        shows: "How far the integral of the one lobe that stands for a product is from the integral of the product itself, over both exponents, \
                for four angles between the axes. Dark is far."
            .into(),
        paper: format!(
            "The mean error is {PAPER_MEAN:e}, the variance 1.2091e-8, the median 0 (§4.2). The largest error, about 50 %, is where both \
             exponents are below 1 and the angle is near 90° (Fig. 3)."
        ),
        here: format!(
            "In steradians:\n\n| exponents drawn | mean | variance | median | largest |\n|---|---|---|---|---|\n\
             | as the table samples them | {:.2e} | {:.1e} | {} | {:.3} |\n\
             | uniform in [0, 10] | {:.2e} | {:.1e} | {} | {:.3} |\n\
             | uniform in [0, 10⁵] | {:.2e} | {:.1e} | {} | {:.1e} |\n\n\
             The largest error of all, {:.3} steradians, is at exponents {e1:.3} and {e2:.3} and {:.0}°. At 90° and exponents up to 1 the \
             largest is {:.3} steradians, {:.0} % of the product's integral.",
            samples.mean,
            samples.variance,
            tiny(samples.median),
            samples.max,
            ten.mean,
            ten.variance,
            tiny(ten.median),
            ten.max,
            whole.mean,
            whole.variance,
            tiny(whole.median),
            whole.max,
            samples.max,
            alpha.to_degrees(),
            right.0,
            100.0 * right.0 / right.1,
        ),
        differs: "The paper does not say how its pairs are drawn. Its mean, median and variance contradict each other: a mean and a median are \
                  never farther apart than the standard deviation, here 1.1e-4."
            .into(),
    })
}

/// The angle of the axes in Fig. 6: the paper does not give it, at this one its vertical axis ends where the surface does.
const FIXED: f64 = 30.0;
/// The end of its horizontal axes.
const LAST: f64 = 9150.0;
/// Lines a direction.
const LINES: usize = 12;

/// The exponent of a product over those of its lobes.
struct Surface<'a> {
    table: &'a ProductTable,
}

impl Surface<'_> {
    fn at(&self, i: usize, j: usize) -> (f64, f64, f64) {
        let [e1, e2] = [i, j].map(|k| LAST * k as f64 / LINES as f64);
        (e1, f64::from(self.table.lookup(e1 as f32, e2 as f32, FIXED.to_radians() as f32).1), e2)
    }
}

impl Draw for Surface<'_> {
    fn size(&self) -> (u32, u32) {
        (640, 460)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        let mut chart = ChartBuilder::on(root)
            .caption("Exponent of the lobe that stands for c1·c2, α = 30°", ("sans-serif", 18))
            .margin(20)
            .build_cartesian_3d(0.0..LAST, 0.0..20_000.0, 0.0..LAST)
            .map_err(failed)?;
        chart.with_projection(|mut p| {
            (p.yaw, p.pitch, p.scale) = (3.75, 0.25, 0.8);
            p.into_matrix()
        });
        let thousands = |x: &f64| format!("{x:.0}");
        chart
            .configure_axes()
            .light_grid_style(RGBColor(240, 240, 240))
            .bold_grid_style(RGBColor(215, 215, 215))
            .label_style(("sans-serif", 13))
            .x_labels(5)
            .y_labels(5)
            .z_labels(5)
            .x_formatter(&thousands)
            .y_formatter(&thousands)
            .z_formatter(&thousands)
            .draw()
            .map_err(failed)?;
        for i in 0..=LINES {
            let along = |k: usize| [self.at(i, k), self.at(k, i)];
            for line in 0..2 {
                let points = (0..=LINES).map(|k| along(k)[line]);
                let color = crate::drawing::COLORS[line];
                chart.draw_series(LineSeries::new(points, color.stroke_width(2))).map_err(failed)?;
            }
        }
        let small = ("sans-serif", 15).into_font();
        for (words, at) in [("e1", (210, 420)), ("e2", (520, 390)), ("e_r", (30, 60))] {
            root.draw(&Text::new(words, at, small.clone())).map_err(failed)?;
        }
        Ok(())
    }
}

pub(super) fn exponent(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let table = &tables.products;
    let surface = Surface { table };
    let last = surface.at(LINES, LINES).1;
    // All samples of the table up to a right angle, and beyond.
    let (mut below, mut all) = ([0_usize; 2], [0_usize; 2]);
    let resolution = Resolution::PAPER;
    for i in 0..resolution.exponents() {
        for j in i..resolution.exponents() {
            for k in 0..resolution.angles - 1 {
                let (e1, e2, angle) = (resolution.exponent(i), resolution.exponent(j), resolution.angle(k));
                let wide = usize::from(angle > 0.5 * core::f64::consts::PI);
                let found = f64::from(table.lookup(e1 as f32, e2 as f32, angle as f32).1);
                all[wide] += 1;
                // Less by more than the table's rounding.
                below[wide] += usize::from(found < e2 * (1.0 - 1e-4) - 1e-4);
            }
        }
    }
    Ok(Page {
        title: "exponent of a product",
        images: surface.images(name)?,
        shows: "The exponent e_r of the one lobe that stands for the product of two, at a fixed angle between their axes.".into(),
        paper: "e_r is at least as large as e1 and e2, and the surface is no plane (Fig. 6). Its axes end at 9150, 9150 and 19 000.".into(),
        here: format!(
            "e_r is {last:.0} at e1 = e2 = 9150. Of the table's samples with axes up to 90° apart {} of {} have an e_r below the larger \
             exponent, of those farther apart {} of {}.",
            below[0], all[0], below[1], all[1]
        ),
        differs: "The paper does not give its angle. At 30° the surface ends where the paper's axis does.".into(),
    })
}
