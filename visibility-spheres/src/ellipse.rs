//! Spheres wholly in front of the receiver, on the mask.

use crate::block::LANES;
use crate::splat::IN_FRONT;
use core::ops::Range;
use fearless_simd::{Simd, f32x8, i32x8, prelude::*};
use visibility_mask::{LitBounds, Mask, Raster};

// Rows are taken eight at once, too.
pub(crate) const LANE: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
const HEIGHTS: [f32; LANES] = Raster::HEIGHTS;
/// An edge that runs along more than so many cells within one row is taken by area.
pub(crate) const FLAT: f32 = 4.0;

/// Eight spheres wholly in front of the plane through the receiver: ellipses, in their centre form.
///
/// With (X, Y, H) the sphere's centre in the frame of the square, `g = H² − r²`, `u = Y² + g`, `w = X² + u`: centre
/// `(XH, YH)/g`, shear `XY/u`, half-height `r√u/g`, half-width `r√(X² + g)/g`, and at height `t` above the centre half the
/// span is `√(K₀ − K₂t²)`, `K₀ = r²w/(gu)`, `K₂ = wg/u²`. Only `g` is a difference. Lengths are in rows and samples of the
/// mask.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ellipses {
    /// Lanes that are wholly in front.
    in_front: u32,
    x: [f32; LANES],
    y: [f32; LANES],
    shear: [f32; LANES],
    k0: [f32; LANES],
    k2: [f32; LANES],
    half_height: [f32; LANES],
    /// Rows and samples that it lies in: from, to. The samples are those of a row with any shift.
    rows: [[i32; LANES]; 2],
    samples: [[i32; LANES]; 2],
    /// Samples that an edge runs along within one row before it is taken by area.
    flat: f32,
    raster: Raster,
}

impl Ellipses {
    /// `c` are the centres in the frame of the mask's square; lanes that are not in front are anything.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(simd: S, c: [f32x8<S>; 3], r: f32x8<S>, mask: &Mask) -> Self {
        let raster = mask.raster();
        let Raster { left, bottom, samples, rows, width } = raster;
        let one = f32x8::splat(simd, 1.0);
        let [x, y, z] = c;
        let g = (z - r) * (z + r);
        let across = x * x + g;
        let u = y * y + g;
        let w = x * x + u;
        let (of_g, of_u) = (one / g, one / u);
        let aspect = samples / rows;
        let (cx, cy) = ((x * z * of_g - left) * samples, (y * z * of_g - bottom) * rows);
        let half_height = r * u.sqrt() * of_g * rows;
        let half_width = r * across.sqrt() * of_g * samples;
        let side = mask.side() as f32;
        Self {
            in_front: z.simd_gt(r * IN_FRONT).to_bitmask() as u32,
            x: cx.into(),
            y: cy.into(),
            shear: (x * y * of_u * aspect).into(),
            k0: (r * r * w * of_g * of_u * (samples * samples)).into(),
            k2: (w * g * of_u * of_u * (aspect * aspect)).into(),
            half_height: half_height.into(),
            rows: [whole(simd, cy - half_height, side), whole(simd, cy + half_height + one, side)],
            samples: [whole(simd, cx - half_width - one, width), whole(simd, cx + half_width + one, width)],
            flat: FLAT * width / side,
            raster,
        }
    }

    /// Lanes whose spheres are wholly in front, as bits: the others are no ellipses.
    pub(crate) fn are_in_front(&self) -> u32 {
        self.in_front
    }

    /// Lanes that lie outside of all that is lit, as bits.
    #[inline(always)]
    pub(crate) fn misses<S: Simd>(&self, simd: S, lit: &LitBounds) -> u32 {
        let [first, end] = [i32x8::simd_from(simd, self.rows[0]), i32x8::simd_from(simd, self.rows[1])];
        let [left, right] = [i32x8::simd_from(simd, self.samples[0]), i32x8::simd_from(simd, self.samples[1])];
        let at = |k: u32| i32x8::splat(simd, k as i32);
        let misses = end.simd_le(at(lit.rows[0]))
            | first.simd_ge(at(lit.rows[1]))
            | right.simd_le(at(lit.samples[0]))
            | left.simd_ge(at(lit.samples[1]));
        misses.to_bitmask() as u32
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Ellipse {
        let (first, end) = (self.rows[0][lane] as usize, self.rows[1][lane] as usize);
        let (left, right) = (self.samples[0][lane] as u32, self.samples[1][lane] as u32);
        Ellipse {
            x: self.x[lane],
            y: self.y[lane],
            shear: self.shear[lane],
            k0: self.k0[lane],
            k2: self.k2[lane],
            half_height: self.half_height[lane],
            rows: first..end,
            samples: [left, right],
            flat: self.flat,
            raster: self.raster,
        }
    }

    /// Blocks that of a lane.
    #[inline(always)]
    pub(crate) fn splat<S: Simd>(&self, simd: S, lane: usize, mask: &mut Mask) {
        self.get(lane).splat(simd, mask);
    }
}

/// Rounded down, within 0…`most`.
#[inline(always)]
fn whole<S: Simd>(simd: S, x: f32x8<S>, most: f32) -> [i32; LANES] {
    i32x8::truncate_from(x.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, most))).into()
}

/// One of [`Ellipses`].
struct Ellipse {
    x: f32,
    y: f32,
    shear: f32,
    k0: f32,
    k2: f32,
    half_height: f32,
    rows: Range<usize>,
    samples: [u32; 2],
    flat: f32,
    raster: Raster,
}

impl Ellipse {
    #[inline(always)]
    fn splat<S: Simd>(&self, simd: S, mask: &mut Mask) {
        let Range { start: first, end } = self.rows;
        let [left, right] = self.samples;
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
            let lit = mask.rows_lit_between(simd, base, left, right);
            if lit == 0 {
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
            mask.block_rows(simd, base, self.raster.indices(simd, middle - mean), self.raster.indices(simd, to));
            let mut flat = flat.to_bitmask() as u32 & lit & ((1 << (end - base).min(LANES)) - 1);
            while flat != 0 {
                self.area(simd, base + flat.trailing_zeros() as usize, mask);
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
        mask.block_lines(simd, j, self.raster.indices(simd, middle - half), self.raster.indices(simd, middle + half));
    }
}
