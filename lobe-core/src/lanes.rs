//! Loops that become vector instructions: a function of a row of numbers, taken of sixteen rows at once.
//!
//! Written once for one row, it gives the same bits at every width.

pub use fearless_simd::Level;

use fearless_simd::dispatch;

/// Rows of a block: one AVX-512 register of f32, two of AVX2, four of SSE2.
pub const WIDTH: usize = 16;

/// `C` columns of a block.
pub type Columns<const C: usize> = [[f32; WIDTH]; C];

/// Columns that are kept. Each is a cache line: vector loads that cross one cost twice.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Kept<const C: usize>(pub Columns<C>);

impl<const C: usize> Default for Kept<C> {
    fn default() -> Self {
        Self([[0.0; WIDTH]; C])
    }
}

/// A function of two rows, to be taken of all rows of two blocks. A trait and not a closure, because only a method can be
/// told to stay inside the loop (`#[inline(always)]`). `self` is common to all rows.
pub trait Lane<const A: usize, const B: usize, const D: usize> {
    /// The function. To become vector instructions it must have no loops and no calls, and its branches must be choices
    /// between two numbers.
    fn value(&self, a: [f32; A], b: [f32; B]) -> [f32; D];
}

/// Writes `lane` of every row.
pub fn map<F: Lane<A, B, D>, const A: usize, const B: usize, const D: usize>(
    level: Level,
    lane: &F,
    a: &Columns<A>,
    b: &Columns<B>,
    out: &mut Columns<D>,
) {
    dispatch!(level, _simd => {
        for j in 0..WIDTH {
            set_row(out, j, &lane.value(row(a, j), row(b, j)));
        }
    });
}

/// Puts `lane` of every row in the place of the row.
pub fn update<F: Lane<A, B, A>, const A: usize, const B: usize>(
    level: Level,
    lane: &F,
    a: &mut Columns<A>,
    b: &Columns<B>,
) {
    dispatch!(level, _simd => {
        for j in 0..WIDTH {
            let values = lane.value(row(a, j), row(b, j));
            set_row(a, j, &values);
        }
    });
}

/// Row `j`.
#[inline(always)]
#[must_use]
pub fn row<const C: usize>(columns: &Columns<C>, j: usize) -> [f32; C] {
    let mut row = [0.0; C];
    for (value, column) in row.iter_mut().zip(columns) {
        *value = column[j];
    }
    row
}

/// Writes row `j`.
#[inline(always)]
pub fn set_row<const C: usize>(columns: &mut Columns<C>, j: usize, row: &[f32; C]) {
    for (column, value) in columns.iter_mut().zip(row) {
        column[j] = *value;
    }
}

/// Which rows of a column hold this number, one bit each.
#[inline(always)]
pub(crate) fn rows_with(column: &[f32; WIDTH], number: f32) -> u32 {
    column.iter().enumerate().fold(0, |bits, (j, x)| bits | u32::from(*x == number) << j)
}

/// Which rows of a column are above this number, one bit each.
#[inline(always)]
pub fn rows_above(column: &[f32; WIDTH], number: f32) -> u32 {
    column.iter().enumerate().fold(0, |bits, (j, x)| bits | u32::from(*x > number) << j)
}

/// The bits' numbers, ascending.
#[inline(always)]
pub fn ones(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let j = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        j
    })
}

/// Rows that wait until there are [`WIDTH`] of them, and where their results go.
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
    pub(crate) fn push(&mut self, row: &[f32; C], k: usize) -> bool {
        let j = self.len % WIDTH;
        set_row(&mut self.columns, j, row);
        self.of[j] = k as u32;
        self.len = j + 1;
        self.len == WIDTH
    }

    /// Adds a value for each row to its output, and empties the block. Rows that an earlier block has left behind the last
    /// have been computed too, and are not used.
    #[inline(always)]
    pub(crate) fn flush(&mut self, values: &[f32; WIDTH], out: &mut [f32]) {
        for (value, k) in values.iter().zip(&self.of[..self.len]) {
            out[*k as usize] += value;
        }
        self.len = 0;
    }
}
