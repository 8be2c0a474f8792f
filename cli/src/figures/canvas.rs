//! Drawings to files: curves and diagrams by one routine as SVG and PNG, sheets of pictures as PNG only.

use crate::drawing::font;
use crate::failure::Failure;
use cosine_lobes::{ImageFileError, Output, write_png};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::fmt::Display;
use std::io::Write;
use std::path::Path;

/// A file of a figure, written when the whole figure is complete.
pub(super) struct Image {
    pub(super) name: String,
    content: Content,
}

enum Content {
    Svg(String),
    Png { size: (u32, u32), rgb: Vec<u8> },
}

impl Image {
    pub(super) fn png(name: &str, size: (u32, u32), rgb: Vec<u8>) -> Self {
        Self { name: format!("{name}.png"), content: Content::Png { size, rgb } }
    }

    pub(super) fn write(&self, folder: &Path) -> Result<(), Failure> {
        let path = folder.join(&self.name);
        match &self.content {
            Content::Svg(text) => write_text(&path, text),
            Content::Png { size, rgb } => Ok(write_png(Output::create(path)?, size.0 as usize, size.1 as usize, rgb)?),
        }
    }
}

/// A text file, whole or not at all.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    let failed = |source| ImageFileError::Io { path: path.to_owned(), source };
    Ok(Output::create(path)?.finish(|file| writeln!(file, "{}", text.trim_end()).map_err(failed))?)
}

/// The message for an error of the drawing library.
pub(super) fn failed(error: impl Display) -> String {
    format!("the figure cannot be drawn: {error}")
}

/// Something that is drawn on any backend.
pub(super) trait Draw {
    fn size(&self) -> (u32, u32);

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), String>
    where
        B::ErrorType: 'static;

    /// The drawing as both kinds of file.
    fn images(&self, name: &str) -> Result<Vec<Image>, Failure> {
        font()?;
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, self.size()).into_drawing_area();
        area.fill(&WHITE).map_err(failed).map_err(Failure::new)?;
        self.draw(&area).map_err(Failure::new)?;
        area.present().map_err(failed).map_err(Failure::new)?;
        drop(area);
        let svg = Image { name: format!("{name}.svg"), content: Content::Svg(text) };
        Ok(vec![self.picture(name)?, svg])
    }

    /// The drawing as PNG only.
    fn picture(&self, name: &str) -> Result<Image, Failure> {
        font()?;
        let (width, height) = self.size();
        let mut rgb = vec![255; 3 * width as usize * height as usize];
        let area = BitMapBackend::with_buffer(&mut rgb, (width, height)).into_drawing_area();
        self.draw(&area).map_err(Failure::new)?;
        area.present().map_err(failed).map_err(Failure::new)?;
        drop(area);
        Ok(Image::png(name, (width, height), rgb))
    }
}

/// Pictures side by side, each with a title and a note above it.
pub(super) struct Sheet {
    columns: usize,
    cells: Vec<Cell>,
}

/// One of them.
#[derive(Clone)]
pub(super) struct Cell {
    pub(super) title: String,
    pub(super) note: String,
    /// Columns and rows.
    pub(super) size: (usize, usize),
    pub(super) rgb: Vec<u8>,
}

const GAP: usize = 8;
/// Two lines of text.
const TEXT: usize = 38;

impl Sheet {
    pub(super) fn new(columns: usize, cells: Vec<Cell>) -> Self {
        Self { columns, cells }
    }

    pub(super) fn image(&self, name: &str) -> Result<Image, Failure> {
        font()?;
        let columns = self.columns.min(self.cells.len()).max(1);
        let (wide, high) = self.cells.iter().fold((0, 0), |(w, h), c| (w.max(c.size.0), h.max(c.size.1)));
        let rows = self.cells.len().div_ceil(columns);
        let (width, height) = (GAP + columns * (wide + GAP), GAP + rows * (TEXT + high + GAP));
        let mut rgb = vec![255; 3 * width * height];
        let corner = |i: usize| (GAP + i % columns * (wide + GAP), GAP + i / columns * (TEXT + high + GAP));
        for (i, cell) in self.cells.iter().enumerate() {
            let (x, y) = corner(i);
            for (row, line) in cell.rgb.chunks_exact(3 * cell.size.0).enumerate() {
                let start = 3 * ((y + TEXT + row) * width + x);
                rgb[start..start + line.len()].copy_from_slice(line);
            }
        }
        let size = (width as u32, height as u32);
        let area = BitMapBackend::with_buffer(&mut rgb, size).into_drawing_area();
        for (i, cell) in self.cells.iter().enumerate() {
            let (x, y) = corner(i);
            let text = |text: &str, y: usize, size: i32, color: RGBColor| {
                let style = ("sans-serif", size).into_font().color(&color);
                area.draw_text(text, &style, (x as i32, y as i32)).map_err(failed).map_err(Failure::new)
            };
            text(&cell.title, y, 16, BLACK)?;
            text(&cell.note, y + TEXT / 2, 14, RGBColor(90, 90, 90))?;
        }
        area.present().map_err(failed).map_err(Failure::new)?;
        drop(area);
        Ok(Image::png(name, size, rgb))
    }
}

/// A colour between white, through yellow and red, and black: for a value in [0, 1], lightest first.
pub(super) fn heat(value: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] =
        [[255.0, 255.0, 250.0], [254.0, 217.0, 118.0], [240.0, 100.0, 40.0], [150.0, 10.0, 50.0], [20.0, 0.0, 20.0]];
    let place = value.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let below = (place as usize).min(STOPS.len() - 2);
    let t = place - below as f64;
    core::array::from_fn(|k| (STOPS[below][k] + t * (STOPS[below + 1][k] - STOPS[below][k])) as u8)
}
