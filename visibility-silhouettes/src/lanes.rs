//! Rows of edges as columns.

use crate::edge_list::{Block, COLUMNS, ENDS, ID, SOMETIMES};
use fearless_simd::{Simd, prelude::*};
use lobe_core::vec3x8::LANES;

/// Writes the first numbers of eight rows of four as columns.
#[inline(always)]
pub(crate) fn columns<S: Simd>(simd: S, rows: &[[f32; 4]; LANES], out: &mut [[f32; LANES]]) {
    for (half, four) in rows.as_chunks::<4>().0.iter().enumerate() {
        let mut flat = [0.0; 16];
        flat.copy_from_slice(four.as_flattened());
        let columns = simd.load_four_interleaved_f32x4(&flat);
        for (column, out) in columns.into_iter().zip(out.iter_mut()) {
            column.store_slice(&mut out[4 * half..4 * half + 4]);
        }
    }
}

/// The ends of the edges in `lanes`, upward. `of` has the ends of an edge in the order of its first triangle, and whether that runs down.
#[inline(always)]
pub(crate) fn upward(mut lanes: u32, of: impl Fn(usize) -> ([[f32; 4]; 2], bool)) -> [[[f32; 4]; LANES]; 2] {
    let mut ends = [[[0.0; 4]; LANES]; 2];
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & (LANES - 1);
        lanes &= lanes - 1;
        let ([p, q], is_down) = of(lane);
        ends[usize::from(is_down)][lane] = p;
        ends[usize::from(!is_down)][lane] = q;
    }
    ends
}

/// Writes the two ends of eight edges, and their numbers from `id` on, into a block. The first of `marks` has the lanes that are not always drawn;
/// the second is set in all numbers.
#[inline(always)]
pub(crate) fn put_ends<S: Simd>(
    simd: S,
    ends: &[[[f32; 4]; LANES]; 2],
    id: u32,
    marks: [u32; 2],
    out: &mut Block<COLUMNS>,
) {
    for (rows, first) in ends.iter().zip(ENDS) {
        columns(simd, rows, &mut out[first..first + 3]);
    }
    number(id, marks, out);
}

/// Numbers the eight edges of a block from `id` on.
#[inline(always)]
pub(crate) fn number(id: u32, marks: [u32; 2], out: &mut Block<COLUMNS>) {
    for (lane, number) in (0..).zip(&mut out[ID]) {
        let sometimes = if marks[0] >> lane & 1 == 1 { SOMETIMES } else { 0 };
        *number = f32::from_bits((id + lane) | sometimes | marks[1]);
    }
}
