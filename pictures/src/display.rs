//! Pictures as screens show them.

use crate::{ToneMap, Window};
use glam::Vec3;
use rayon::prelude::*;

/// How a PNG file or a window shows linear radiance: times `2^exposure`, through a tone map, as sRGB.
///
/// Eight bits are dithered: a pixel takes one of the two nearest values, so that a block of them has the right mean. Without it a wide
/// soft shadow shows bands. The pattern is a function of the pixel's place in the image, so parts of a picture fit together.
///
/// ```
/// use glam::Vec3;
/// use pictures::{Display, ToneMap, Window};
/// let display = Display { tone: ToneMap::Linear, ..Display::default() };
/// let bytes = display.bytes(&[Vec3::ONE, Vec3::ZERO], &Window::whole(2, 1));
/// assert_eq!(bytes, [255, 255, 255, 0, 0, 0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// In stops.
    pub exposure: f32,
    /// For radiance near white and beyond.
    pub tone: ToneMap,
    /// Bits of a channel in a file.
    pub depth: PngDepth,
}

/// Bits of a channel in a PNG file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PngDepth {
    /// Dithered.
    #[default]
    Eight,
    /// Rounded.
    Sixteen,
}

impl PngDepth {
    /// Bytes of a pixel of three channels.
    #[must_use]
    pub const fn pixel(self) -> usize {
        match self {
            Self::Eight => 3,
            Self::Sixteen => 6,
        }
    }
}

/// One of 1024 numbers between 0 and 1 for each pixel, evenly spread over any block of pixels: the R₂ sequence (Roberts 2018) by
/// column and row, in whole numbers. The ends are left out, so that a rounding error moves no value that a byte has exactly.
fn noise(column: usize, row: usize) -> f32 {
    let place = (column as u32).wrapping_mul(0xC13F_A9A9).wrapping_add((row as u32).wrapping_mul(0x91E1_0DA5));
    ((place >> 22) as f32 + 0.5) / 1024.0
}

impl Display {
    /// The values of pixels as a file of that depth has them, three channels a pixel; sixteen bits with the high byte first. `window`
    /// says where in the image the pixels are. All cores work.
    ///
    /// # Panics
    /// When there are not as many pixels as the window has.
    #[must_use]
    pub fn bytes(&self, pixels: &[Vec3], window: &Window) -> Vec<u8> {
        let mut bytes = vec![0; self.depth.pixel() * pixels.len()];
        self.bytes_into(pixels, window, &mut bytes);
        bytes
    }

    /// The same, written to memory that is borrowed.
    ///
    /// # Panics
    /// When there are not as many pixels as the window has, or not the bytes for them.
    pub fn bytes_into(&self, pixels: &[Vec3], window: &Window, bytes: &mut [u8]) {
        let [width, _] = window.size();
        assert_eq!(pixels.len(), window.pixels(), "pixels of the window");
        assert_eq!(bytes.len(), self.depth.pixel() * pixels.len(), "bytes of the pixels");
        if width == 0 {
            return;
        }
        let rows = pixels.par_chunks(width).zip(bytes.par_chunks_mut(self.depth.pixel() * width));
        rows.enumerate().for_each(|(row, (pixels, bytes))| {
            let place = [window.columns.start, window.rows.start + row];
            self.row_into(pixels.iter().copied(), place, bytes);
        });
    }

    /// The bytes of neighbours in a row from a column and row of the image on.
    pub(crate) fn row_into(&self, pixels: impl Iterator<Item = Vec3>, place: [usize; 2], bytes: &mut [u8]) {
        let gain = self.exposure.exp2();
        for (index, (pixel, bytes)) in pixels.zip(bytes.chunks_exact_mut(self.depth.pixel())).enumerate() {
            let shown = self.tone.encode(pixel * gain).to_array();
            match self.depth {
                PngDepth::Eight => {
                    let noise = noise(place[0] + index, place[1]);
                    // 0 and 1 are 0 and 255 whatever the noise.
                    bytes.copy_from_slice(&shown.map(|x| (x * 255.0 + noise) as u8));
                }
                PngDepth::Sixteen => {
                    for (x, bytes) in shown.into_iter().zip(bytes.chunks_exact_mut(2)) {
                        bytes.copy_from_slice(&((x * 65535.0 + 0.5) as u16).to_be_bytes());
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::srgb_to_linear as linear;

    const LINEAR: Display = Display { exposure: 0.0, tone: ToneMap::Linear, depth: PngDepth::Eight };

    /// The mean of a block is the value, far below one level; no pixel is further off than a level.
    #[test]
    fn dither_keeps_the_mean() {
        for value in [0.0, 0.1, 17.3, 100.5, 200.01, 254.9, 255.0_f32] {
            let pixels = vec![Vec3::splat(linear(value / 255.0)); 64 * 64];
            for place in [0, 1000, 16_000] {
                let window =
                    Window { image: [1 << 15; 2], columns: place..place + 64, rows: place / 3..place / 3 + 64 };
                let bytes = LINEAR.bytes(&pixels, &window);
                let sum: f32 = bytes.iter().map(|b| f32::from(*b)).sum();
                let mean = sum / bytes.len() as f32;
                assert!((mean - value).abs() < 0.01, "{value}: {mean}");
                assert!(bytes.iter().all(|b| (f32::from(*b) - value).abs() < 1.0), "{value}");
                assert!(bytes.chunks_exact(3).all(|p| p[0] == p[1] && p[1] == p[2]), "grey");
            }
        }
    }

    /// A slope of one level in 166 pixels: without dither as many are equal in a row, with it a handful.
    #[test]
    fn a_soft_gradient_has_no_bands() {
        let pixels: Vec<Vec3> = (0..1660).map(|x| Vec3::splat(linear((40.0 + x as f32 / 166.0) / 255.0))).collect();
        let bytes = LINEAR.bytes(&pixels, &Window::whole(1660, 1));
        let values: Vec<u8> = bytes.chunks_exact(3).map(|p| p[0]).collect();
        let longest = values.chunk_by(|a, b| a == b).map(<[u8]>::len).max();
        assert!(longest < Some(60), "{longest:?}");
    }

    /// Parts have the bytes of the whole, at either depth; sixteen bits are rounded to half a level.
    #[test]
    fn parts_fit_together() {
        let at = |x: usize, y: usize| Vec3::new(x as f32 / 60.0, y as f32 / 30.0, (x * y) as f32 / 500.0);
        let pixels = |w: &Window| -> Vec<Vec3> {
            w.rows.clone().flat_map(|y| w.columns.clone().map(move |x| at(x, y))).collect()
        };
        let whole = Window::whole(50, 37);
        for depth in [PngDepth::Eight, PngDepth::Sixteen] {
            let display = Display { exposure: 0.3, depth, ..Display::default() };
            let all = display.bytes(&pixels(&whole), &whole);
            for part in whole.parts([17, 9]) {
                let bytes = display.bytes(&pixels(&part), &part);
                for (row, bytes) in part.rows.clone().zip(bytes.chunks_exact(depth.pixel() * part.columns.len())) {
                    let start = depth.pixel() * (50 * row + part.columns.start);
                    assert_eq!(bytes, &all[start..start + bytes.len()]);
                }
            }
        }
        let fine = Display { depth: PngDepth::Sixteen, ..LINEAR };
        let bytes = fine.bytes(&[Vec3::new(0.0, linear(1234.4 / 65535.0), 1.0)], &Window::whole(1, 1));
        assert_eq!(bytes, [0, 0, 4, 210, 255, 255]);
    }
}
