//! Rows of edges as columns.

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
