//! Counts the surfaces in front of each sample, from the crossings of their outlines with the rows.

use crate::project::{Crossing, View};
use fearless_simd::{Simd, f32x8, prelude::*};
use visibility_mask::{EightRows, MAX_DEPTH, Mask, Raster};

/// Rows that are counted side by side.
const EIGHT: usize = 8;
/// Samples in a word.
const WORD: usize = 64;
/// One line more than there are rows.
const ROW_LINES: usize = (1 << MAX_DEPTH) + 1;

/// Eight words of one digit, and a word for each that waits to be added.
#[derive(Clone, Copy, Debug)]
struct Digit {
    value: EightRows,
    more: EightRows,
}

impl Digit {
    /// Adds two words, one of which becomes the carry.
    #[inline(always)]
    fn add(&mut self, more: EightRows, carry: &mut EightRows) {
        for ((value, one), other) in self.value.iter_mut().zip(more).zip(carry) {
            let sum = *value ^ one ^ *other;
            *other = (one & *other) | (*value & (one ^ *other));
            *value = sum;
        }
    }
}

/// Numbers of surfaces, up to one constant: those of the sample with the fewest surfaces become 0, or a ray decides whether they
/// are.
///
/// A number is stored in binary, each digit of 64 samples in one word: adding 1 to all samples on one side of a crossing takes a
/// few operations on words, and the least number is found from the highest digit downward. The cost therefore depends on the
/// crossings and not on the samples, and numbers may have any size. A word to be added to a digit waits for a second one: both are
/// added at once, and their carry waits at the next digit (a carry-save adder, H. S. Warren, *Hacker's Delight*, 2nd ed., §5-1).
///
/// The number left of the first sample changes from row to row by the outlines that have an end between them, left of the
/// view's middle ([`Crossing::left`]).
#[derive(Clone, Debug, Default)]
pub(crate) struct Counter {
    /// Digits of a word side by side, lowest first, each with the word that waits; then the words of eight rows; then the blocks of
    /// rows.
    digits: Vec<Digit>,
    /// For the digits of each word, bits that say whether a word waits.
    waiting: Vec<u32>,
    /// Digits of a number.
    places: usize,
    /// Samples to be counted that were not yet among the fewest.
    rest: Vec<EightRows>,
    /// Words of a row, and those of the fewest samples that have a 0 in a digit.
    words: usize,
    lower: Vec<EightRows>,
    /// For each sample whether a surface ends, and whether one begins, between it and the sample before it.
    ends: Vec<EightRows>,
    begins: Vec<EightRows>,
}

/// The samples with the fewest surfaces in front of them, and the one through which a ray decides best whether these are none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fewest {
    /// The words of eight rows, then those of the next eight.
    rows: Vec<EightRows>,
    words: usize,
    /// Row and sample in the middle of the longest run.
    pub(crate) middle: Option<(usize, usize)>,
    /// Number of these samples, and of all others.
    count: u32,
    others: u32,
}

/// If fewer than one in this many counted samples has the fewest surfaces, a ray is also traced for the next number.
pub(crate) const FEW: u32 = 128;

impl Counter {
    /// Counts the surfaces in front of the lit samples of a mask.
    #[inline(always)]
    pub(crate) fn count<S: Simd>(&mut self, simd: S, view: &View, crossings: &[Crossing], mask: &Mask) {
        let blocks = view.rows.div_ceil(EIGHT);
        self.words = (view.raster.width as usize).div_ceil(WORD);
        self.rest.resize(blocks * self.words, [0; EIGHT]);
        for (block, rest) in self.rest.chunks_exact_mut(self.words).enumerate() {
            mask.lit_rows(block * EIGHT, rest);
        }
        let starts = self.start(crossings, blocks);
        self.digits.clear();
        self.waiting.clear();
        self.waiting.resize(blocks * self.words, 0);
        for starts in starts[..blocks * EIGHT].chunks_exact(EIGHT) {
            for _ in 0..self.words {
                for place in 0..self.places {
                    let mut value = [0; EIGHT];
                    for (value, start) in value.iter_mut().zip(starts) {
                        *value = u64::from(start >> place & 1).wrapping_neg();
                    }
                    self.digits.push(Digit { value, more: [0; EIGHT] });
                }
            }
        }
        for c in crossings {
            self.add(simd, view, c);
        }
        self.settle();
    }

    /// The number left of all samples in each row, minus the least of them. Sets the number of digits for the largest number of all
    /// samples.
    #[inline(always)]
    pub(crate) fn start(&mut self, crossings: &[Crossing], blocks: usize) -> [u32; ROW_LINES] {
        let mut starts = [0_i32; ROW_LINES];
        let mut sizes = [0_i32; ROW_LINES];
        for c in crossings {
            let [from, to] = c.rows.map(|r| r as usize);
            let size = c.step.abs();
            // A step downward to the right is a step upward to the left.
            let less = if c.step < 0 { size } else { 0 };
            starts[from] -= c.step * i32::from(c.left[0]) + less;
            starts[to] += c.step * i32::from(c.left[1]) + less;
            sizes[from] += size;
            sizes[to] -= size;
        }
        let (mut start, mut size, mut least, mut most) = (0, 0, i32::MAX, i32::MIN);
        for j in 0..blocks * EIGHT {
            start += starts[j];
            size += sizes[j];
            starts[j] = start;
            least = least.min(start);
            most = most.max(start + size);
        }
        self.places = (32 - most.wrapping_sub(least).cast_unsigned().leading_zeros()) as usize;
        starts.map(|start| start.wrapping_sub(least).cast_unsigned())
    }

    /// Whether a surface ends and another one begins between two neighbouring samples of which one has the fewest surfaces: between them there
    /// may be fewer. Call it after [`fewest`](Self::fewest).
    #[inline(always)]
    pub(crate) fn may_hide_fewer<S: Simd>(
        &mut self,
        simd: S,
        view: &View,
        crossings: &[Crossing],
        fewest: &Fewest,
    ) -> bool {
        let Self { ends, begins, words, .. } = self;
        for marks in [&mut *ends, &mut *begins] {
            marks.clear();
            marks.resize(fewest.rows.len(), [0; EIGHT]);
        }
        for c in crossings.iter().filter(|c| c.step != 0 && c.rows[0] < c.rows[1]) {
            let marks = if c.step < 0 { &mut *ends } else { &mut *begins };
            let [from, to] = c.rows.map(|row| row as usize);
            for block in from / EIGHT..=(to - 1) / EIGHT {
                let columns = columns(simd, view, c, block * EIGHT);
                for row in from.max(block * EIGHT)..to.min((block + 1) * EIGHT) {
                    let column = columns[row % EIGHT] as usize;
                    if 0 < column && column < *words * WORD {
                        marks[block * *words + column / WORD][row % EIGHT] |= 1 << (column % WORD);
                    }
                }
            }
        }
        let beside = |k: usize| {
            (0..EIGHT).any(|row| {
                let here = fewest.rows[k][row];
                let before = if k.is_multiple_of(*words) { 0 } else { fewest.rows[k - 1][row] >> (WORD - 1) };
                ends[k][row] & begins[k][row] & (here | here << 1 | before) != 0
            })
        };
        (0..fewest.rows.len()).any(beside)
    }

    /// Adds the step of a crossing to all samples on its higher side.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, view: &View, c: &Crossing) {
        let [from, to] = c.rows.map(|r| r as usize);
        if from >= to || c.step == 0 {
            return;
        }
        let lowest = c.step.trailing_zeros() as usize;
        let left = if c.step < 0 { u64::MAX } else { 0 };
        for block in from / EIGHT..=(to - 1) / EIGHT {
            let base = block * EIGHT;
            let columns = columns(simd, view, c, base);
            let mut rows = [0; EIGHT];
            for (k, row) in rows.iter_mut().enumerate() {
                *row = if from <= base + k && base + k < to { u64::MAX } else { 0 };
            }
            for word in 0..self.words {
                let mut carry = [0; EIGHT];
                for ((carry, column), row) in carry.iter_mut().zip(columns).zip(rows) {
                    let first = column.saturating_sub((word * WORD) as u32);
                    *carry = (u64::MAX.unbounded_shl(first) ^ left) & row;
                }
                self.add_words(block * self.words + word, lowest, carry);
            }
        }
    }

    /// Adds one to a digit of some samples.
    #[inline(always)]
    fn add_words(&mut self, number: usize, lowest: usize, mut carry: EightRows) {
        let waiting = &mut self.waiting[number];
        let digits = &mut self.digits[number * self.places..][..self.places];
        for (place, digit) in digits.iter_mut().enumerate().skip(lowest) {
            *waiting ^= 1 << place;
            if *waiting >> place & 1 == 1 {
                digit.more = carry;
                return;
            }
            digit.add(digit.more, &mut carry);
        }
    }

    /// Adds the words that wait.
    #[inline(always)]
    fn settle(&mut self) {
        for (waiting, digits) in self.waiting.iter().zip(self.digits.chunks_exact_mut(self.places.max(1))) {
            if *waiting == 0 {
                continue;
            }
            let mut carry = [0; EIGHT];
            for (place, digit) in digits.iter_mut().enumerate() {
                let more = if waiting >> place & 1 == 1 { digit.more } else { [0; EIGHT] };
                digit.add(more, &mut carry);
            }
        }
    }

    /// The samples with the fewest surfaces, among those not returned before.
    #[inline(always)]
    pub(crate) fn fewest(&mut self, fewest: &mut Fewest) {
        let Self { digits, places, rest, words, lower, .. } = self;
        fewest.rows.clone_from(rest);
        fewest.words = *words;
        lower.resize(rest.len(), [0; EIGHT]);
        for place in (0..*places).rev() {
            // Samples with a 0 in this digit, if there are any.
            let mut any = [0; EIGHT];
            for ((lower, rows), digits) in lower.iter_mut().zip(&fewest.rows).zip(digits.chunks_exact(*places)) {
                for k in 0..EIGHT {
                    lower[k] = rows[k] & !digits[place].value[k];
                    any[k] |= lower[k];
                }
            }
            if any != [0; EIGHT] {
                core::mem::swap(&mut fewest.rows, lower);
            }
        }
        fewest.find_middle();
        fewest.others = 0;
        if fewest.count >= (rest.len() * EIGHT * WORD) as u32 / FEW {
            // Enough samples: not doubtful.
            return;
        }
        for (rest, rows) in rest.iter_mut().zip(&fewest.rows) {
            for (rest, row) in rest.iter_mut().zip(rows) {
                *rest &= !row;
                fewest.others += rest.count_ones();
            }
        }
    }
}

/// The first sample right of a crossing in each of eight rows from `base` on.
#[inline(always)]
fn columns<S: Simd>(simd: S, view: &View, c: &Crossing, base: usize) -> [u32; EIGHT] {
    let rows = f32x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) + base as f32;
    let at = rows * c.slope + c.start;
    let at = at.max(f32x8::splat(simd, c.low)).min(f32x8::splat(simd, c.high));
    view.raster.indices(simd, at - f32x8::simd_from(simd, *Raster::shifts(base))).into()
}

impl Fewest {
    /// The eight rows from `j` on, a multiple of eight.
    pub(crate) fn rows(&self, j: usize) -> &[EightRows] {
        &self.rows[j / EIGHT * self.words..][..self.words]
    }

    /// Whether these are so few that others may have fewer surfaces in truth: the order of two edges that coincide to the last
    /// digit may be wrong, and a few samples between them then have too small a number.
    pub(crate) fn is_doubtful(&self) -> bool {
        self.middle.is_some() && self.count < (self.count + self.others) / FEW
    }

    /// Adds the samples of another result.
    pub(crate) fn add(&mut self, other: &Self) {
        for (row, more) in self.rows.as_flattened_mut().iter_mut().zip(other.rows.as_flattened()) {
            *row |= more;
        }
    }

    /// Finds the row with the most samples, and the middle of its longest run.
    #[inline(always)]
    fn find_middle(&mut self) {
        (self.count, self.middle) = (0, None);
        let mut best = (0, 0);
        for (b, rows) in self.rows.chunks_exact(self.words).enumerate() {
            let mut counts = [0; EIGHT];
            for words in rows {
                for k in 0..EIGHT {
                    counts[k] += words[k].count_ones();
                }
            }
            for (k, count) in counts.into_iter().enumerate() {
                self.count += count;
                if count > best.0 {
                    best = (count, b * EIGHT + k);
                }
            }
        }
        let (count, j) = best;
        if count == 0 {
            return;
        }
        self.middle = Some((j, self.middle_of(j)));
    }

    /// The middle of the longest run in a row that has one.
    #[inline(always)]
    fn middle_of(&self, j: usize) -> usize {
        let mut longest = (0, 0);
        for (word, bits) in self.rows(j).iter().map(|words| words[j % EIGHT]).enumerate() {
            let (length, first) = longest_run(bits);
            if length > longest.0 {
                longest = (length, WORD * word + first as usize + (length as usize - 1) / 2);
            }
        }
        longest.1
    }

    /// Another sample for a ray: of the row with the most samples, except some rows.
    pub(crate) fn witness(&self, besides: &[usize]) -> Option<(usize, usize)> {
        let rows = self.rows.len() / self.words * EIGHT;
        let count = |j: usize| self.rows(j).iter().map(|words| words[j % EIGHT].count_ones()).sum::<u32>();
        let others = (0..rows).filter(|j| !besides.contains(j)).map(|j| (count(j), j));
        let (count, row) = others.max_by_key(|(count, j)| (*count, rows - j))?;
        (count > 0).then(|| (row, self.middle_of(row)))
    }
}

/// The length of the longest run of ones in a word, and the beginning of the first run of that length.
#[inline(always)]
fn longest_run(bits: u64) -> (u32, u32) {
    // Beginnings of runs of 1, 2, 4 … ones.
    let mut begins = [bits; 7];
    for k in 0..6 {
        begins[k + 1] = begins[k] & begins[k] >> (1 << k);
    }
    let (mut runs, mut length) = (u64::MAX, 0);
    for (k, begins) in begins.into_iter().enumerate().rev() {
        let longer = runs & begins.unbounded_shr(length);
        if longer != 0 {
            (runs, length) = (longer, length + (1 << k));
        }
    }
    (length, runs.trailing_zeros())
}
