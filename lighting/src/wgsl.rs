//! The same in WGSL: texts that are joined to a shader module, in any order.
//!
//! One workgroup of `LANES` threads makes the mask of one point and light, a row a thread. Functions have the names of
//! those that they mirror, after the type's: `mask_row_y` is [`Mask::row_y`](crate::Mask::row_y).

use crate::MAX_DEPTH;
use crate::row::{COARSE, WIDTH};

/// The unit square; needs `geometry.wgsl` and `lobe.wgsl` of `lobe-core`.
pub const SQUARE: &str = include_str!("square.wgsl");
/// The own row of the mask; needs [`header`] and [`SQUARE`].
pub const MASK: &str = include_str!("mask.wgsl");
/// The sum of edges that turns a mask; needs `geometry.wgsl`.
pub const EDGES: &str = include_str!("edges.wgsl");

/// The golden section by half, in units of 2⁻³²: shifts of rows are fractions of its odd multiples.
const GOLDEN: u32 = 0x4f1b_bcdd;

/// The constants `DEPTH`, `SIDE` (rows), `WIDTH` (samples in a row), `LANES` (threads) and `COLUMNS` (groups of samples with
/// one weight), and the type `Row` with its functions.
///
/// # Panics
/// When `depth` is not in 1…[`MAX_DEPTH`].
#[must_use]
pub fn header(depth: u32, coarse: bool) -> String {
    assert!((1..=MAX_DEPTH).contains(&depth), "mask depth {depth} is not in 1..={MAX_DEPTH}");
    let side = 1_u32 << depth;
    let lanes = side.max(32);
    let (width, columns, row) = if coarse {
        (COARSE, 16, include_str!("row_coarse.wgsl"))
    } else {
        (WIDTH, 32, include_str!("row.wgsl"))
    };
    format!(
        "const DEPTH = {depth}u;\nconst SIDE = {side}u;\nconst WIDTH = {width}u;\nconst LANES = {lanes}u;\nconst COLUMNS = \
         {columns}u;\nconst GOLDEN = {GOLDEN}u;\n{row}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::PHASE;

    #[test]
    fn shifts_of_rows_by_integers() {
        for (j, phase) in PHASE[..1 << MAX_DEPTH].iter().enumerate() {
            let bits = (2 * j as u32 + 1).wrapping_mul(GOLDEN) ^ 0x8000_0000;
            let got = bits as i32 as f32 * 2.0_f32.powi(-32);
            // The factor is rounded to 2⁻³³, its multiples go up to 127, results have 2⁻²⁵; positions of samples 2⁻¹⁷.
            assert!((got - phase).abs() < 6e-8, "row {j}: {got} {phase}");
        }
    }
}
