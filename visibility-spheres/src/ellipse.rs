//! A ball wholly in front of the receiver, on the mask.

use fearless_simd::{Simd, f32x8, prelude::*, u32x8};
use glam::Vec3;
use lighting::{Mask, Raster};

/// Rows that are taken at once.
const LANES: usize = 8;
const LANE: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
const HEIGHTS: [f32; LANES] = Raster::HEIGHTS;
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
    /// Samples in a row.
    width: f32,
}

impl Ellipse {
    /// `c` is the centre in the frame of the mask's square, `c.z > r`.
    #[inline(always)]
    pub(crate) fn new(c: Vec3, r: f32, mask: &Mask) -> Self {
        let Raster { left, bottom, samples, rows, width } = mask.raster();
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
            width,
        }
    }

    /// Blocks it.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(&self, simd: S, mask: &mut Mask) {
        let first = (self.y - self.half_height).max(0.0).min(self.rows as f32) as usize;
        let end = (self.y + self.half_height + 1.0).max(0.0).min(self.rows as f32) as usize;
        // A row's mean span is shorter than that at its centre by the second derivative.
        let bend = self.k0 * self.k2 * (1.0 / 24.0);
        let (k0, k2, shear, steep) = (
            f32x8::splat(simd, self.k0),
            f32x8::splat(simd, self.k2),
            f32x8::splat(simd, self.shear),
            f32x8::splat(simd, self.shear.abs()),
        );
        let mut t = f32x8::splat(simd, first as f32 + (0.5 - self.y)) + f32x8::simd_from(simd, LANE);
        let mut base = first;
        while base < end {
            if mask.are_rows_dark(base) {
                base += LANES;
                t += f32x8::splat(simd, LANES as f32);
                continue;
            }
            let square = (k0 - k2 * t * t).max(f32x8::splat(simd, 0.0));
            let (half, away) = (square.sqrt(), t.abs());
            let ends = (f32x8::splat(simd, self.half_height) - away).simd_lt(f32x8::splat(simd, 0.5));
            let flat = (steep * half + k2 * away).simd_gt(f32x8::splat(simd, self.flat) * half) | ends;
            let mean = half - half * f32x8::splat(simd, bend) / (square * square);
            let middle = f32x8::splat(simd, self.x) + shear * t - f32x8::simd_from(simd, *Raster::shifts(base));
            // Rows by area, and beyond the end, are empty.
            let to = flat.select(middle - mean, middle + mean);
            mask.block_rows(simd, base, self.samples(simd, middle - mean), self.samples(simd, to));
            let mut flat = flat.to_bitmask() & ((1 << (end - base).min(LANES)) - 1);
            while flat != 0 {
                let j = base + flat.trailing_zeros() as usize;
                if !mask.is_row_dark(j) {
                    self.area(simd, j, mask);
                }
                flat &= flat - 1;
            }
            base += LANES;
            t += f32x8::splat(simd, LANES as f32);
        }
    }

    /// A row by area.
    #[inline(always)]
    fn area<S: Simd>(&self, simd: S, j: usize, mask: &mut Mask) {
        let t = f32x8::splat(simd, j as f32 + (0.5 - self.y)) + f32x8::simd_from(simd, HEIGHTS);
        // Nothing, in a way that needs no branch: an interval that ends where it begins.
        let half =
            (f32x8::splat(simd, self.k0) - f32x8::splat(simd, self.k2) * t * t).max(f32x8::splat(simd, 0.0)).sqrt();
        let middle = f32x8::splat(simd, self.x) + f32x8::splat(simd, self.shear) * t;
        mask.block_lines(simd, j, self.samples(simd, middle - half), self.samples(simd, middle + half));
    }

    /// The first sample at or after each position: the last bits of a float that is large enough.
    #[inline(always)]
    fn samples<S: Simd>(&self, simd: S, position: f32x8<S>) -> u32x8<S> {
        let clamped = position.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, self.width));
        (clamped + f32x8::splat(simd, 12_582_912.0)).bitcast::<u32x8<S>>() & u32x8::splat(simd, 0x1ff)
    }
}
