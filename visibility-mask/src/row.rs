//! One row of a mask: 256 samples as bits, and operations on them.

use fearless_simd::{Simd, prelude::*, u32x8};

/// The deepest quad-tree: 64 × 64 cells.
pub const MAX_DEPTH: u32 = 6;
/// The most rows of a mask, and the most cells in a row.
pub(crate) const SIDE: usize = 1 << MAX_DEPTH;
/// Samples in a row, and in a row of a coarse mask, which uses the first word.
pub(crate) const WIDTH: usize = 256;
pub(crate) const COARSE: usize = 64;
/// Rows that are processed at once.
pub(crate) const EIGHT: usize = 8;
/// Heights within a row at which shapes along the row are sampled.
pub(crate) const SUBLINES: usize = 8;

/// Bit `k % 64` of word `k / 64` is sample `k`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(32))]
pub(crate) struct Row(pub(crate) [u64; WIDTH / 64]);

/// 64 samples of eight rows: bit `k` of `[j]` is sample `k` of the row `j`.
pub type EightRows = [u64; EIGHT];

/// No sample.
pub(crate) const NONE: Row = Row([0; WIDTH / 64]);

/// A row of 64 samples from its halves.
#[inline(always)]
pub(crate) fn coarse(low: u32, high: u32) -> Row {
    let mut row = NONE;
    row.0[0] = u64::from(low) | u64::from(high) << 32;
    row
}

/// `FROM[k]`: samples k and above. Twice as long as needed: an index of nine bits needs no check.
static FROM: [Row; 2 * WIDTH] = {
    let mut rows = [NONE; 2 * WIDTH];
    let mut k = 0;
    while k < WIDTH {
        let mut word = k / 64;
        rows[k].0[word] = u64::MAX << (k % 64);
        word += 1;
        while word < WIDTH / 64 {
            rows[k].0[word] = u64::MAX;
            word += 1;
        }
        k += 1;
    }
    rows
};

/// Shifts of the rows' samples, in samples: multiples of the golden section, whose fractions fill an interval evenly.
///
/// Eight more than there are rows, since eight rows are read at once.
pub(crate) static PHASE: [f32; SIDE + 8] = {
    let mut phase = [0.0; SIDE + 8];
    let mut j = 0;
    while j < phase.len() {
        let x = (j as f64 + 0.5) * 0.618_033_988_749_894_9;
        phase[j] = (x - (x as u32) as f64 - 0.5) as f32;
        j += 1;
    }
    phase
};

/// The shifts of eight rows from `j` on.
#[inline(always)]
pub(crate) fn phases(j: usize) -> &'static [f32; 8] {
    PHASE[j & (SIDE - 1)..].first_chunk().unwrap_or(&[0.0; 8])
}

/// The order in which eight neighbouring samples take the eight heights: bits reversed, so that any few of them are spread evenly.
const ORDER: [u32; SUBLINES] = [0, 4, 2, 6, 1, 5, 3, 7];

/// Height of line `k` above the row's own, in rows.
#[inline(always)]
pub(crate) const fn height(k: usize) -> f32 {
    (k as f32 + 0.5) / SUBLINES as f32 - 0.5
}

/// The first sample at or after a position (sample k is at k + ½), 0…256; 0 for NaN.
#[inline(always)]
pub(crate) fn index(position: f32) -> u32 {
    // Comparisons that are false for NaN, and the float's own last bits: a cast takes more steps.
    let x = if position > 0.0 { position } else { 0.0 };
    let x = if x < WIDTH as f32 { x } else { WIDTH as f32 };
    (x + 12_582_912.0).to_bits() & 0x1ff
}

/// Samples from `from` up to `to`.
#[inline(always)]
pub(crate) fn span(from: u32, to: u32) -> Row {
    without(&FROM[(from & 0x1ff) as usize], &FROM[(to & 0x1ff) as usize])
}

/// The same for a row of 64 samples: `from` and `to` are at most 64.
#[inline(always)]
pub(crate) fn span_of_64(from: u32, to: u32) -> u64 {
    u64::MAX.unbounded_shl(from) & !u64::MAX.unbounded_shl(to)
}

#[inline(always)]
pub(crate) fn without(a: &Row, b: &Row) -> Row {
    let mut out = NONE;
    for k in 0..out.0.len() {
        out.0[k] = a.0[k] & !b.0[k];
    }
    out
}

#[inline(always)]
pub(crate) fn and(a: &Row, b: &Row) -> Row {
    let mut out = NONE;
    for k in 0..out.0.len() {
        out.0[k] = a.0[k] & b.0[k];
    }
    out
}

#[inline(always)]
pub(crate) fn with(a: &Row, b: &Row) -> Row {
    let mut out = NONE;
    for k in 0..out.0.len() {
        out.0[k] = a.0[k] | b.0[k];
    }
    out
}

/// The first sample, and the one after the last; the first is not below the second if there are no samples.
#[inline(always)]
pub(crate) fn bounds(row: &Row) -> [u32; 2] {
    let mut bounds = [WIDTH as u32, 0];
    for (k, word) in row.0.iter().enumerate().filter(|(_, word)| **word != 0) {
        let start = 64 * k as u32;
        bounds = [bounds[0].min(start + word.trailing_zeros()), start + 64 - word.leading_zeros()];
    }
    bounds
}

/// Calls `visit` for each run of samples: from, to.
pub(crate) fn each(row: &Row, mut visit: impl FnMut([u32; 2])) {
    for (k, word) in row.0.iter().enumerate() {
        let (mut rest, mut at) = (*word, 64 * k as u32);
        while rest != 0 {
            let skip = rest.trailing_zeros();
            rest >>= skip;
            let count = rest.trailing_ones();
            visit([at + skip, at + skip + count]);
            rest = rest.unbounded_shr(count);
            at += skip + count;
        }
    }
}

/// Those samples of row `j` that are at height `k`: one of every eight, a different one in each row.
#[inline(always)]
pub(crate) fn of_line(row: &Row, j: usize, k: usize) -> Row {
    let which = 0x0101_0101_0101_0101 << ((ORDER[k] + j as u32) & 7);
    let mut out = NONE;
    for k in 0..out.0.len() {
        out.0[k] = row.0[k] & which;
    }
    out
}

// Functions instead of closures: a closure may not be inlined into the code that has the wide instructions.

/// The samples `from..to` of eight rows of 64, as their lower and upper halves.
#[inline(always)]
pub(crate) fn halves<S: Simd>(simd: S, from: u32x8<S>, to: u32x8<S>) -> [u32x8<S>; 2] {
    let ([a, b], [c, d]) = (up_from(simd, from), up_from(simd, to));
    [a & !c, b & !d]
}

/// Samples from `k` on, `k` ≤ 64, in halves.
#[inline(always)]
fn up_from<S: Simd>(simd: S, k: u32x8<S>) -> [u32x8<S>; 2] {
    let (none, all) = (u32x8::splat(simd, 0), u32x8::splat(simd, u32::MAX));
    // A shift by 32 is not defined.
    let part = all << (k & u32x8::splat(simd, 31));
    let is_low = k.simd_lt(u32x8::splat(simd, 32));
    let is_within = k.simd_lt(u32x8::splat(simd, 64));
    [is_low.select(part, none), is_low.select(all, is_within.select(part, none))]
}

/// A row of 64 samples of which eight lines are partly covered, each with its own samples as in [`of_line`].
#[inline(always)]
pub(crate) fn of_lines<S: Simd>(simd: S, j: usize, from: u32x8<S>, to: u32x8<S>) -> [u32; 2] {
    let turn = j as u32 & 7;
    let order = (u32x8::simd_from(simd, ORDER) + u32x8::splat(simd, turn)) & u32x8::splat(simd, 7);
    let which = u32x8::splat(simd, 0x0101_0101) << order;
    let [low, high] = halves(simd, from, to);
    [either(low & which), either(high & which)]
}

/// Room for a mask's rows, and for eight that begin at any of them.
pub(crate) const ROWS: usize = SIDE + EIGHT;

/// The eight rows from `j` on, in a form without bounds checks.
#[inline(always)]
pub(crate) fn eight<T: Copy>(rows: &[T; ROWS], j: usize) -> [T; EIGHT] {
    let j = j & (SIDE - 1);
    core::array::from_fn(|k| rows[j + k])
}

/// [`eight`], mutable.
#[inline(always)]
pub(crate) fn eight_mut<T>(rows: &mut [T; ROWS], j: usize) -> &mut [T] {
    let j = j & (SIDE - 1);
    &mut rows[j..j + EIGHT]
}

#[inline(always)]
fn either<S: Simd>(words: u32x8<S>) -> u32 {
    let (low, high) = words.split();
    let [a, b, c, d]: [u32; SUBLINES / 2] = (low | high).into();
    (a | c) | (b | d)
}

/// The number of spans of a row.
#[inline(always)]
pub(crate) fn spans(row: &Row) -> u32 {
    let begin = |(last, spans): (u64, u32), word: &u64| (word >> 63, spans + (word & !(word << 1 | last)).count_ones());
    row.0.iter().fold((0, 0), begin).1
}

/// Number of samples.
#[inline(always)]
pub(crate) fn count(row: &Row) -> u32 {
    row.0.iter().map(|word| word.count_ones()).sum()
}

/// Which cells of a row, `width` samples each, have any sample.
pub(crate) fn any(row: &Row, width: usize) -> u64 {
    if width == 1 {
        return row.0[0];
    }
    if width >= 64 {
        // Two or four cells.
        let words = width / 64;
        return row.0.chunks(words).enumerate().map(|(i, w)| u64::from(w.iter().any(|w| *w != 0)) << i).sum();
    }
    let mut out = 0;
    for (k, word) in row.0.iter().enumerate() {
        // Folds each cell onto its lowest bit, then packs those.
        let mut w = *word;
        let mut step = width / 2;
        while step > 0 {
            w |= w >> step;
            step /= 2;
        }
        let mut cells = 0;
        let count = 64 / width;
        for i in 0..count {
            cells |= (w >> (i * width) & 1) << i;
        }
        // The words that a coarse mask leaves empty add nothing.
        out |= cells.checked_shl((k * count) as u32).unwrap_or(0);
    }
    out
}
