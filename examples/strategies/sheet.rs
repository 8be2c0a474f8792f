use cosine_lobes::{Output, write_png};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::error::Error;
use std::path::Path;

/// Left of the pictures, for the names of the scenes.
const NAMES: usize = 150;
/// Above them, for the names of the columns.
const HEAD: usize = 30;
const GAP: usize = 4;

/// A picture of a scene and, below it, its difference from the first one of its row.
pub(crate) struct Cell {
    pub(crate) picture: Vec<u8>,
    pub(crate) difference: Option<Vec<u8>>,
    /// In the corner of the difference.
    pub(crate) note: String,
}

/// Pictures side by side, a row a scene, with names.
pub(crate) struct Sheet {
    size: (usize, usize),
    columns: Vec<String>,
    rows: Vec<(String, Vec<Option<Cell>>)>,
}

impl Sheet {
    /// No rows yet; pictures have this many pixels.
    pub(crate) fn new(size: (u32, u32), columns: Vec<String>) -> Self {
        Self { size: (size.0 as usize, size.1 as usize), columns, rows: Vec::new() }
    }

    /// Adds a scene; missing pictures stay empty.
    pub(crate) fn push(&mut self, name: &str, cells: Vec<Option<Cell>>) {
        self.rows.push((name.replace('_', " "), cells));
    }

    /// Upper left corner of a cell.
    fn corner(&self, row: usize, column: usize) -> (usize, usize) {
        (NAMES + column * (self.size.0 + GAP), HEAD + row * (2 * (self.size.1 + GAP) + GAP))
    }

    pub(crate) fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let (width, height) = self.corner(self.rows.len(), self.columns.len());
        let mut rgb = vec![255; 3 * width * height];
        let mut paste = |bytes: &[u8], at: (usize, usize)| {
            for (y, line) in bytes.chunks_exact(3 * self.size.0).enumerate() {
                let start = 3 * ((at.1 + y) * width + at.0);
                rgb[start..start + line.len()].copy_from_slice(line);
            }
        };
        let mut texts = Vec::new();
        let line = |k: usize| (8, HEAD + 8 + 20 * k);
        for (i, name) in self.columns.iter().enumerate() {
            texts.push((name.clone(), (self.corner(0, i).0 + 4, 7)));
        }
        for (j, (name, cells)) in self.rows.iter().enumerate() {
            let top = self.corner(j, 0).1 - HEAD;
            texts.push((name.clone(), (line(0).0, top + line(0).1)));
            texts.push(("difference ×10".to_owned(), (line(0).0, top + line(0).1 + self.size.1 + GAP)));
            for (i, cell) in cells.iter().enumerate() {
                let (x, y) = self.corner(j, i);
                let below = y + self.size.1 + GAP;
                match cell {
                    Some(cell) => {
                        paste(&cell.picture, (x, y));
                        if let Some(difference) = &cell.difference {
                            paste(difference, (x, below));
                        }
                        texts.push((cell.note.clone(), (x + 6, below + 6)));
                    }
                    None => texts.push(("no spheres fit".to_owned(), (x + 6, y + 6))),
                }
            }
        }
        register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
            .map_err(|_| "the built-in font cannot be read")?;
        let area = BitMapBackend::with_buffer(&mut rgb, (width as u32, height as u32)).into_drawing_area();
        for (text, (x, y)) in texts {
            area.draw_text(&text, &("sans-serif", 17).into_font().color(&BLACK), (x as i32, y as i32))?;
        }
        area.present()?;
        drop(area);
        Ok(write_png(Output::create(path)?, width, height, &rgb)?)
    }
}
