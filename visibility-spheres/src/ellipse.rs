//! A ball wholly in front of the receiver, on the mask.

use glam::Vec3;
use lighting::{Mask, Raster};

/// Rows that are taken at once.
const LANES: usize = 8;
/// An edge that runs along more than so many cells within one row is taken by area.
const FLAT: f32 = 4.0;

/// A ball wholly in front of the plane through the receiver: an ellipse, in its centre form.
///
/// With (X, Y, H) the ball's centre in the frame of the square, `g = H² − r²`, `u = Y² + g`, `w = X² + u`: centre
/// `(XH, YH)/g`, shear `XY/u`, half-height `r√u/g`, and at height `t` above the centre half the span is `√(K₀ − K₂t²)`,
/// `K₀ = r²w/(gu)`, `K₂ = wg/u²`. Only `g` is a difference. Lengths are in rows and samples of the mask.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ellipse {
    x: f32,
    y: f32,
    shear: f32,
    k0: f32,
    k2: f32,
    half_height: f32,
    /// Samples that an edge runs along within one row before it is taken by area.
    flat: f32,
    rows: usize,
}

impl Ellipse {
    /// `c` is the centre in the frame of the mask's square, `c.z > r`.
    #[inline(always)]
    pub(crate) fn new(c: Vec3, r: f32, mask: &Mask) -> Self {
        let Raster { left, bottom, samples, rows } = mask.raster();
        let g = (c.z - r) * (c.z + r);
        let u = c.y * c.y + g;
        let w = c.x * c.x + u;
        let (of_g, of_u) = (1.0 / g, 1.0 / u);
        let (aspect, root) = (samples / rows, u.sqrt());
        Self {
            x: (c.x * c.z * of_g - left) * samples,
            y: (c.y * c.z * of_g - bottom) * rows,
            shear: c.x * c.y * of_u * aspect,
            k0: r * r * w * of_g * of_u * (samples * samples),
            k2: w * g * of_u * of_u * (aspect * aspect),
            half_height: r * root * of_g * rows,
            flat: FLAT * aspect,
            rows: mask.side(),
        }
    }

    /// Blocks it.
    #[inline(always)]
    pub(crate) fn splat(&self, mask: &mut Mask) {
        let row = |y: f32| Raster::index(y - 0.5) as usize;
        let first = row(self.y - self.half_height).min(self.rows);
        let end = row(self.y + self.half_height + 1.0).min(self.rows);
        // A row's mean span is shorter than that at its centre by the second derivative.
        let bend = self.k0 * self.k2 * (1.0 / 24.0);
        let mut base = first;
        while base < end {
            let mut from = [0; LANES];
            let mut to = [0; LANES];
            let mut flat = [false; LANES];
            let mut shift = [0.0; LANES];
            for k in 0..LANES {
                shift[k] = Raster::shift((base + k) & 63);
            }
            for k in 0..LANES {
                let t = (base + k) as f32 + (0.5 - self.y);
                let square = self.k0 - self.k2 * t * t;
                let square = if square > 0.0 { square } else { 0.0 };
                let half = square.sqrt();
                let ends = self.half_height - t.abs() < 0.5;
                flat[k] = ends | (self.shear.abs() * half + self.k2 * t.abs() > self.flat * half);
                let mean = half - half * bend / (square * square);
                let middle = self.x + self.shear * t - shift[k];
                from[k] = Raster::index(middle - mean);
                to[k] = Raster::index(middle + mean);
            }
            for k in 0..LANES.min(end - base) {
                if flat[k] {
                    self.area(base + k, mask);
                } else {
                    mask.block_samples(base + k, from[k], to[k]);
                }
            }
            base += LANES;
        }
    }

    /// A row by area.
    #[inline(always)]
    fn area(&self, j: usize, mask: &mut Mask) {
        let mut from = [0.0; LANES];
        let mut to = [0.0; LANES];
        for k in 0..LANES {
            let t = j as f32 + 0.5 + Raster::height(k) - self.y;
            let square = self.k0 - self.k2 * t * t;
            // Nothing, in a way that needs no branch: an interval that ends where it begins.
            let half = if square > 0.0 { square } else { 0.0 }.sqrt();
            let middle = self.x + self.shear * t;
            (from[k], to[k]) = (middle - half, middle + half);
        }
        mask.block_lines(j, &from, &to);
    }
}
