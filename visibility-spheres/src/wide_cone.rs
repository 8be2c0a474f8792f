//! Cones that reach the plane through the receiver across the light, on the mask: spheres beside the receiver, or about it.

use crate::block::LANES;
use crate::ellipse::{FLAT, LANE};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};
use glam::{Vec2, Vec3};
use visibility_mask::{MAX_DEPTH, Mask, Raster};

/// Farther than any window reaches.
pub(crate) const LIMIT: f32 = 1e9;
/// Rows of the finest mask, one more on either side, and room for eight at once.
const ROWS: usize = (1 << MAX_DEPTH) + 2 * LANES;

/// A cone of less than a hemisphere, or all directions outside it.
struct WideCone {
    /// Its axis in the square's frame, and the cosine of its half-angle, not below zero.
    axis: Vec3,
    cos: f32,
    outside: bool,
}

/// Blocks the directions about `to` (in the square's frame, not zero) of at least this cosine.
#[inline(always)]
pub(crate) fn splat_wide<S: Simd>(simd: S, to: Vec3, cos: f32, mask: &mut Mask) {
    if cos <= -1.0 {
        mask.block_all();
        return;
    }
    let sign = if cos < 0.0 { -1.0 } else { 1.0 };
    let cone = WideCone { axis: to * (sign / to.length()), cos: sign * cos, outside: sign < 0.0 };
    let (Vec2 { x: across, y: cell }, side) = (mask.cell(), mask.side());
    // Row j is at j + 1: its neighbours tell how its ends move.
    let mut from = [0.0; ROWS];
    let mut to = [0.0; ROWS];
    let mut y = f32x8::simd_from(simd, LANE) * cell + (mask.row_y(0) - cell);
    for (from, to) in from.chunks_exact_mut(LANES).zip(to.chunks_exact_mut(LANES)).take((side + 2).div_ceil(LANES)) {
        let ends = cone.row(simd, y);
        ends[0].store_slice(from);
        ends[1].store_slice(to);
        y += f32x8::splat(simd, LANES as f32 * cell);
    }
    let raster = mask.raster();
    for base in (0..side).step_by(LANES) {
        if mask.rows_lit_between(simd, base, 0, raster.width as u32) == 0 {
            continue;
        }
        // An end that is farther than the window on both sides of the row moves there unseen.
        let flat = moves(simd, &from, base, across) | moves(simd, &to, base, across);
        let shift = f32x8::simd_from(simd, *Raster::shifts(base));
        let ends = [load(simd, &from, base + 1), load(simd, &to, base + 1)];
        let [from, to] =
            [(ends[0] - raster.left) * raster.samples - shift, (ends[1] - raster.left) * raster.samples - shift];
        if cone.outside {
            let (nothing, all) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, raster.width));
            let before = raster.indices(simd, flat.select(nothing, from));
            let behind = raster.indices(simd, flat.select(all, to));
            mask.block_rows(simd, base, u32x8::splat(simd, 0), before);
            mask.block_rows(simd, base, behind, u32x8::splat(simd, raster.width as u32));
        } else {
            mask.block_rows(simd, base, raster.indices(simd, from), raster.indices(simd, flat.select(from, to)));
        }
        let mut flat = flat.to_bitmask() & ((1 << (side - base).min(LANES)) - 1);
        while flat != 0 {
            let j = base + flat.trailing_zeros() as usize;
            flat &= flat - 1;
            if !mask.is_row_dark(j) {
                cone.area(simd, j, &raster, mask);
            }
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, rows: &[f32; ROWS], at: usize) -> f32x8<S> {
    f32x8::simd_from(simd, rows[at..].first_chunk().copied().unwrap_or_default())
}

/// Whether an end moves by more than an edge that is taken by rows may, from the row before to the row behind.
#[inline(always)]
fn moves<S: Simd>(simd: S, ends: &[f32; ROWS], base: usize, cell: f32) -> mask32x8<S> {
    (load(simd, ends, base) - load(simd, ends, base + 2)).abs().simd_gt(f32x8::splat(simd, 2.0 * FLAT * cell))
}

impl WideCone {
    /// Where the rows at heights y enter and leave it: `m·p ≥ cos|p|`, `p = (x, y, 1)`, which squared is
    /// `a x² + 2b x + c = 0`, has one interval in each row. An empty one ends before it begins.
    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, y: f32x8<S>) -> [f32x8<S>; 2] {
        let (m, cos) = (self.axis, self.cos);
        let [zero, limit] = [f32x8::splat(simd, 0.0), f32x8::splat(simd, LIMIT)];
        let along = y * m.y + m.z;
        let e = y * y + 1.0;
        // Differences of squares are products: what is near zero at the edge of a small window keeps its digits.
        let rim = e.sqrt() * cos;
        let a = (m.x - cos) * (m.x + cos);
        let b = along * m.x;
        let c = (along - rim) * (along + rim);
        // b² − ac = cos²(m.x² e + c).
        let discriminant = e * (m.x * m.x) + c;
        let root = discriminant.max(zero).sqrt() * cos;
        let q = -(b + b.simd_lt(zero).select(-root, root));
        let (r1, r2) = (quotient(simd, q, f32x8::splat(simd, a)), quotient(simd, c, q));
        let (left, right) = (r1.min(r2), r1.max(r2));
        if a >= 0.0 && m.x > 0.0 {
            [right, limit]
        } else if a >= 0.0 && m.x < 0.0 {
            [-limit, left]
        } else {
            let (some, ends) = if a < 0.0 {
                (discriminant.simd_gt(zero) & along.simd_gt(zero), [left, right])
            } else {
                // A plane along the rows.
                (along.simd_gt(zero), [-limit, limit])
            };
            [some.select(ends[0], limit), some.select(ends[1], -limit)]
        }
    }

    /// A row by area.
    #[inline(always)]
    fn area<S: Simd>(&self, simd: S, j: usize, raster: &Raster, mask: &mut Mask) {
        let y = f32x8::simd_from(simd, Raster::HEIGHTS) * mask.cell().y + mask.row_y(j);
        let ends = self.row(simd, y);
        let from = raster.indices(simd, (ends[0] - raster.left) * raster.samples);
        let to = raster.indices(simd, (ends[1] - raster.left) * raster.samples);
        if self.outside {
            mask.block_lines(simd, j, u32x8::splat(simd, 0), from);
            mask.block_lines(simd, j, to, u32x8::splat(simd, raster.width as u32));
        } else {
            mask.block_lines(simd, j, from, to);
        }
    }
}

/// Within ±[`LIMIT`]; the limit for 0/0.
#[inline(always)]
fn quotient<S: Simd>(simd: S, a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    let [zero, limit] = [f32x8::splat(simd, 0.0), f32x8::splat(simd, LIMIT)];
    let below = (a.simd_lt(zero) ^ b.simd_lt(zero)) & a.simd_ne(zero);
    a.abs().simd_ge(b.abs() * limit).select(below.select(-limit, limit), a / b)
}
