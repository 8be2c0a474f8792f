//! Sums and choices over all sides of a polygon.

use crate::lanes::{Lane, Level, WIDTH, map, row, set_row};

/// Takes a function of each corner and the next one around, sixteen side by side, and hands its values on in the corners' order.
pub(super) fn each<const N: usize, const D: usize>(
    side: &impl Lane<N, N, D>,
    corners: &[impl Copy + Into<[f32; N]>],
    mut take: impl FnMut([f32; D]),
) {
    let level = Level::new();
    for first in (0..corners.len()).step_by(WIDTH) {
        let (mut from, mut to, mut out) = ([[0.0; WIDTH]; N], [[0.0; WIDTH]; N], [[0.0; WIDTH]; D]);
        let rows = WIDTH.min(corners.len() - first);
        for j in 0..rows {
            let next = if first + j + 1 < corners.len() { first + j + 1 } else { 0 };
            set_row(&mut from, j, &corners[first + j].into());
            set_row(&mut to, j, &corners[next].into());
        }
        map(level, side, &from, &to, &mut out);
        (0..rows).for_each(|j| take(row(&out, j)));
    }
}
