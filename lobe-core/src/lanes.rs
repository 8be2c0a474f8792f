//! Loops that become vector instructions: a function of a row of numbers, taken of sixteen rows at once.

use fearless_simd::{Level, dispatch};

/// Rows of a block: one AVX-512 register of f32, two of AVX2, four of SSE2.
pub(crate) const WIDTH: usize = 16;

/// `C` columns of a block.
pub(crate) type Columns<const C: usize> = [[f32; WIDTH]; C];

/// A function of a row, to be taken of all rows of a block. A trait and not a closure, because only a method can be told to
/// stay inside the loop.
pub(crate) trait Lane<const C: usize, const D: usize> {
    fn value(row: [f32; C]) -> [f32; D];
}

/// `F` of every row.
pub(crate) fn map<F: Lane<C, D>, const C: usize, const D: usize>(level: Level, columns: &Columns<C>) -> Columns<D> {
    dispatch!(level, _simd => {
        let mut out = [[0.0; WIDTH]; D];
        for j in 0..WIDTH {
            let values = F::value(row(columns, j));
            for (column, value) in out.iter_mut().zip(values) {
                column[j] = value;
            }
        }
        out
    })
}

/// Row `j`.
#[inline(always)]
pub(crate) fn row<const C: usize>(columns: &Columns<C>, j: usize) -> [f32; C] {
    let mut row = [0.0; C];
    for (value, column) in row.iter_mut().zip(columns) {
        *value = column[j];
    }
    row
}

/// Rows that wait until there are [`WIDTH`] of them, and where their results go. A column is a cache line: vector loads that
/// cross one cost twice.
#[repr(C, align(64))]
pub(crate) struct Block<const C: usize> {
    pub(crate) columns: Columns<C>,
    pub(crate) of: [u32; WIDTH],
    pub(crate) len: usize,
}

impl<const C: usize> Block<C> {
    pub(crate) const fn new() -> Self {
        Self { columns: [[0.0; WIDTH]; C], of: [0; WIDTH], len: 0 }
    }

    /// True when it is full now.
    #[inline(always)]
    pub(crate) fn push(&mut self, row: [f32; C], k: usize) -> bool {
        let j = self.len % WIDTH;
        for (column, value) in self.columns.iter_mut().zip(row) {
            column[j] = value;
        }
        self.of[j] = k as u32;
        self.len = j + 1;
        self.len == WIDTH
    }

    /// Adds a value for each row to its output, and empties the block. Rows that an earlier block has left behind the last
    /// have been computed too; nobody looks at them.
    #[inline(always)]
    pub(crate) fn flush(&mut self, values: &[f32; WIDTH], out: &mut [f32]) {
        for (value, k) in values.iter().zip(&self.of[..self.len]) {
            out[*k as usize] += value;
        }
        self.len = 0;
    }
}
