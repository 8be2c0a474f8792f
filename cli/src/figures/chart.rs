//! Curves over two axes, each linear or logarithmic.

use super::canvas::{Draw, failed};
use crate::drawing::COLORS;
use core::ops::Range;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

pub(super) struct Chart {
    pub(super) title: &'static str,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) curves: Vec<Curve>,
    /// The place of the legend.
    pub(super) key: SeriesLabelPosition,
}

pub(super) struct Axis {
    pub(super) label: &'static str,
    pub(super) range: Range<f64>,
    pub(super) is_log: bool,
}

pub(super) struct Curve {
    pub(super) name: String,
    pub(super) points: Vec<(f64, f64)>,
    /// The number of its colour.
    pub(super) color: usize,
    /// With dots at its points; else the line alone.
    pub(super) has_dots: bool,
    pub(super) width: u32,
}

impl Axis {
    pub(super) const fn linear(label: &'static str, range: Range<f64>) -> Self {
        Self { label, range, is_log: false }
    }

    pub(super) const fn log(label: &'static str, range: Range<f64>) -> Self {
        Self { label, range, is_log: true }
    }
}

impl Curve {
    pub(super) fn line(name: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, color, has_dots: false, width: 2 }
    }

    pub(super) fn dots(name: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self { has_dots: true, ..Self::line(name, color, points) }
    }
}

impl Draw for Chart {
    fn size(&self) -> (u32, u32) {
        (640, 420)
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static,
    {
        let (x, y) = (self.x.range.clone(), self.y.range.clone());
        match (self.x.is_log, self.y.is_log) {
            (false, false) => self.plot(root, x, y),
            (true, false) => self.plot(root, x.log_scale(), y),
            (false, true) => self.plot(root, x, y.log_scale()),
            (true, true) => self.plot(root, x.log_scale(), y.log_scale()),
        }
    }
}

/// A number as short as it can be written.
pub(super) fn plain(x: &f64) -> String {
    // Counting an axis up leaves a rounding error at zero.
    if x.abs() < 1e-9 {
        return "0".to_owned();
    }
    if x.abs() >= 1e5 || x.abs() < 1e-3 {
        return format!("{x:e}");
    }
    let text = format!("{x:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

impl Chart {
    fn plot<B, X, Y>(&self, root: &DrawingArea<B, Shift>, x: X, y: Y) -> Result<(), String>
    where
        B: DrawingBackend,
        B::ErrorType: 'static,
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut chart = ChartBuilder::on(root)
            .caption(self.title, ("sans-serif", 18))
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(62)
            .build_cartesian_2d(x, y)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .x_labels(9)
            .y_labels(8)
            .x_label_formatter(&plain)
            .y_label_formatter(&plain)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .light_line_style(RGBColor(244, 244, 244))
            .bold_line_style(RGBColor(218, 218, 218))
            .draw()
            .map_err(failed)?;
        for curve in &self.curves {
            let color = COLORS[curve.color % COLORS.len()];
            let style = color.stroke_width(curve.width);
            let line = LineSeries::new(curve.points.iter().copied(), style);
            let series = chart.draw_series(line).map_err(failed)?;
            if !curve.name.is_empty() {
                series
                    .label(curve.name.as_str())
                    .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], style));
            }
            if curve.has_dots {
                let dots = curve.points.iter().map(|p| Circle::new(*p, 4, color.filled()));
                chart.draw_series(dots).map_err(failed)?;
            }
        }
        if self.curves.iter().any(|c| !c.name.is_empty()) {
            chart
                .configure_series_labels()
                .position(self.key.clone())
                .margin(12)
                .background_style(WHITE.mix(0.9))
                .border_style(RGBColor(180, 180, 180))
                .label_font(("sans-serif", 14))
                .draw()
                .map_err(failed)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 0.01, 0.5, 1.0, 100.0, 1e5, 1e-4].map(|x| plain(&x)),
            ["0", "0.01", "0.5", "1", "100", "1e5", "1e-4"]
        );
    }
}
