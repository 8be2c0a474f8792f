//! One row of a mask: 256 samples as bits, and what is done to them.

use crate::MAX_DEPTH;

/// Samples in a row.
pub(crate) const WIDTH: usize = 256;
/// Heights within a row at which shapes along the row are sampled.
pub(crate) const SUBLINES: usize = 8;

/// Bit `k % 64` of word `k / 64` is sample `k`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(align(32))]
pub(crate) struct Row(pub(crate) [u64; WIDTH / 64]);

/// No sample.
pub(crate) const NONE: Row = Row([0; WIDTH / 64]);

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
pub(crate) const PHASE: [f32; 1 << MAX_DEPTH] = {
    let mut phase = [0.0; 1 << MAX_DEPTH];
    let mut j = 0;
    while j < phase.len() {
        let x = (j as f64 + 0.5) * 0.618_033_988_749_894_9;
        phase[j] = (x - (x as u32) as f64 - 0.5) as f32;
        j += 1;
    }
    phase
};

/// The order in which eight neighbouring samples take the eight heights: bits reversed, so that any few of them are spread.
const ORDER: [u32; SUBLINES] = [0, 4, 2, 6, 1, 5, 3, 7];

/// Height of line `k` above the row's own, in rows.
#[inline(always)]
pub(crate) const fn height(k: usize) -> f32 {
    (k as f32 + 0.5) / SUBLINES as f32 - 0.5
}

/// The first sample at or after a position (sample k is at k + ½), 0…256; 0 for NaN.
#[inline(always)]
pub(crate) fn index(position: f32) -> u32 {
    // Comparisons that NaN fails, and the float's own last bits: what a cast does in many steps.
    let x = if position > 0.0 { position } else { 0.0 };
    let x = if x < WIDTH as f32 { x } else { WIDTH as f32 };
    (x + 12_582_912.0).to_bits() & 0x1ff
}

/// Samples from `from` up to `to`.
#[inline(always)]
pub(crate) fn span(from: u32, to: u32) -> Row {
    without(&FROM[(from & 0x1ff) as usize], &FROM[(to & 0x1ff) as usize])
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

/// Of some samples of row `j` those at height `k`: one of every eight, another one in each row.
#[inline(always)]
pub(crate) fn of_line(row: &Row, j: usize, k: usize) -> Row {
    let which = 0x0101_0101_0101_0101 << ((ORDER[k] + j as u32) & 7);
    let mut out = NONE;
    for k in 0..out.0.len() {
        out.0[k] = row.0[k] & which;
    }
    out
}

/// Number of samples.
pub(crate) fn count(row: &Row) -> u32 {
    row.0.iter().map(|word| word.count_ones()).sum()
}

/// Which of the `2^depth` cells of a row have any sample.
pub(crate) fn any(row: &Row, depth: u32) -> u64 {
    let width = WIDTH >> depth;
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
        out |= cells << (k * count);
    }
    out
}
