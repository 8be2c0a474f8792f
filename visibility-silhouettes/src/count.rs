//! How many surfaces lie before each sample, from where their outlines cross the rows.

use crate::project::{Crossing, View};
use fearless_simd::{Simd, f32x8, i8x32, prelude::*, u8x32};
use lighting::{MAX_DEPTH, Raster};

/// Rows that are counted side by side: one in each lane.
const ROWS: usize = 32;
/// Rows of the largest mask.
const MOST: usize = 1 << MAX_DEPTH;

/// Samples of a row as bits.
pub(crate) type Samples = [u64; 4];

/// Numbers of surfaces, up to one constant: those of the sample with the fewest become 0 or are asked for by a ray.
///
/// `counts[column][row]` is by how much the number changes from the sample before; the sums along the columns are taken of
/// all rows at once. The number left of the first sample changes from row to row by the outlines between them, which is
/// what their ends say ([`Crossing::left`]).
#[derive(Clone, Debug)]
pub(crate) struct Counter {
    /// Column by column, 32 rows each; for deep masks then those of the upper rows.
    counts: Vec<i8>,
    /// What the first number of a row is more than the first one.
    starts: [i32; ROW_LINES],
    /// Sum of the steps' sizes in a row: no number is larger.
    sizes: [i32; ROW_LINES],
}

const ROW_LINES: usize = MOST + 1;

/// The samples of each row before which the fewest surfaces lie, and which sample shows best whether these are none.
#[derive(Clone, Debug)]
pub(crate) struct Fewest {
    /// How many surfaces these are, up to the constant.
    level: i32,
    pub(crate) rows: [Samples; MOST],
    /// Row and sample in the middle of the longest run.
    pub(crate) middle: Option<(usize, usize)>,
    /// How many there are, and how many samples emit.
    count: u32,
    emitting: u32,
}

/// Where fewer than this part of what emits has the fewest surfaces, the next number is asked about as well.
const FEW: u32 = 128;

impl Default for Counter {
    fn default() -> Self {
        Self { counts: Vec::new(), starts: [0; ROW_LINES], sizes: [0; ROW_LINES] }
    }
}

impl Counter {
    /// Counts the samples of each row that matter: from, to.
    #[inline(always)]
    pub(crate) fn fewest<S: Simd>(
        &mut self,
        simd: S,
        view: &View,
        crossings: &[Crossing],
        spans: &[(u32, u32)],
    ) -> Fewest {
        let (rows, width) = (view.rows, view.raster.width as usize);
        self.starts = [0; ROW_LINES];
        self.sizes = [0; ROW_LINES];
        for c in crossings {
            let [from, to] = c.rows.map(|r| r as usize);
            self.starts[from] -= c.step * i32::from(c.left[0]);
            self.starts[to] += c.step * i32::from(c.left[1]);
            self.sizes[from] += c.step.abs();
            self.sizes[to] -= c.step.abs();
        }
        let (mut start, mut size, mut largest) = (0, 0, 0);
        for j in 0..rows {
            start += self.starts[j];
            size += self.sizes[j];
            self.starts[j] = start;
            largest = largest.max(size);
        }
        if largest > i32::from(i8::MAX) {
            self.next(simd, view, crossings, spans, i32::MIN)
        } else {
            self.few(simd, view, crossings, spans, width)
        }
    }

    /// Numbers that fit into eight bits.
    #[inline(always)]
    fn few<S: Simd>(
        &mut self,
        simd: S,
        view: &View,
        crossings: &[Crossing],
        spans: &[(u32, u32)],
        width: usize,
    ) -> Fewest {
        let parts = view.rows.div_ceil(ROWS);
        // One more column, for what is right of all samples.
        let part = (width + 1) * ROWS;
        self.counts.clear();
        self.counts.resize(parts * part, 0);
        for c in crossings {
            let step = c.step as i8;
            let [from, to] = c.rows.map(|r| r as usize);
            for base in (from..to).step_by(8) {
                for (j, column) in (base..to.min(base + 8)).zip(columns(simd, view, c, base)) {
                    let count = &mut self.counts[(j / ROWS) * part + column as usize * ROWS + j % ROWS];
                    *count = count.wrapping_add(step);
                }
            }
        }
        let mut fewest = Fewest::none();
        let mut least = i32::MAX;
        let mut lowest = [[0_i8; ROWS]; MOST / ROWS];
        let mut emitting = [[[0_u8; ROWS]; 2]; MOST / ROWS];
        for p in 0..parts {
            for (lane, j) in (p * ROWS..view.rows.min((p + 1) * ROWS)).enumerate() {
                let (from, to) = spans[j];
                // First and last; empty the other way round.
                let (first, last) = if from < to { (from as u8, (to - 1) as u8) } else { (1, 0) };
                fewest.emitting += to.saturating_sub(from);
                emitting[p][0][lane] = first;
                emitting[p][1][lane] = last;
            }
            // Rows that are not there emit nothing.
            emitting[p][0][view.rows.saturating_sub(p * ROWS).min(ROWS)..].fill(1);
            let [first, last] = [u8x32::simd_from(simd, emitting[p][0]), u8x32::simd_from(simd, emitting[p][1])];
            let mut sum = i8x32::splat(simd, 0);
            let mut low = i8x32::splat(simd, i8::MAX);
            for (column, counts) in self.counts[p * part..][..width * ROWS].chunks_exact_mut(ROWS).enumerate() {
                sum += i8x32::from_slice(simd, counts);
                sum.store_slice(counts);
                let column = u8x32::splat(simd, column as u8);
                let emits = first.simd_le(column) & column.simd_le(last);
                low = emits.select(low.min(sum), low);
            }
            lowest[p] = low.into();
            for (lane, j) in (p * ROWS..view.rows.min((p + 1) * ROWS)).enumerate() {
                if emitting[p][0][lane] <= emitting[p][1][lane] {
                    least = least.min(self.starts[j] + i32::from(lowest[p][lane]));
                }
            }
        }
        fewest.level = least;
        for p in 0..parts {
            let mut wanted = [0_i8; ROWS];
            let mut any = [false; ROWS];
            for (lane, j) in (p * ROWS..view.rows.min((p + 1) * ROWS)).enumerate() {
                let want = least.wrapping_sub(self.starts[j]);
                any[lane] = want == i32::from(lowest[p][lane]) && emitting[p][0][lane] <= emitting[p][1][lane];
                wanted[lane] = want as i8;
            }
            let wanted = i8x32::simd_from(simd, wanted);
            let zero = u8x32::splat(simd, 0);
            for (byte, eight) in self.counts[p * part..][..width * ROWS].chunks_exact(8 * ROWS).enumerate() {
                let mut bits = zero;
                for (k, counts) in eight.chunks_exact(ROWS).enumerate() {
                    let is_least = i8x32::from_slice(simd, counts).simd_eq(wanted);
                    bits |= is_least.select(u8x32::splat(simd, 1 << k), zero);
                }
                let bits: [u8; ROWS] = bits.into();
                for (row, bits) in fewest.rows[p * ROWS..].iter_mut().zip(bits) {
                    row[byte / 8] |= u64::from(bits) << (8 * (byte % 8));
                }
            }
            for (lane, any) in any.iter().enumerate() {
                let row = &mut fewest.rows[p * ROWS + lane];
                *row = if *any { within(row, emitting[p][0][lane], emitting[p][1][lane]) } else { [0; 4] };
            }
        }
        fewest.find_middle(view.rows);
        fewest
    }

    /// The samples with the fewest surfaces of those that have more than `above`: any numbers, one row after the other. Only
    /// after [`fewest`](Self::fewest) of the same.
    #[inline(always)]
    pub(crate) fn next<S: Simd>(
        &self,
        simd: S,
        view: &View,
        crossings: &[Crossing],
        spans: &[(u32, u32)],
        above: i32,
    ) -> Fewest {
        let width = view.raster.width as usize;
        let mut counts = vec![0_i32; view.rows * (width + 1)];
        for c in crossings {
            let [from, to] = c.rows.map(|r| r as usize);
            for base in (from..to).step_by(8) {
                for (j, column) in (base..to.min(base + 8)).zip(columns(simd, view, c, base)) {
                    counts[j * (width + 1) + column as usize] += c.step;
                }
            }
        }
        let mut least = i32::MAX;
        for (j, row) in counts.chunks_exact_mut(width + 1).enumerate() {
            let (from, to) = spans[j];
            let mut sum = self.starts[j];
            for (i, count) in (0..).zip(row) {
                sum += *count;
                *count = sum;
                if from <= i && i < to && sum > above {
                    least = least.min(sum);
                }
            }
        }
        let mut fewest = Fewest { level: least, ..Fewest::none() };
        for (j, row) in counts.chunks_exact(width + 1).enumerate() {
            let (from, to) = spans[j];
            fewest.emitting += to.saturating_sub(from);
            for i in (from as usize..to as usize).filter(|i| row[*i] == least) {
                fewest.rows[j][i / 64] |= 1 << (i % 64);
            }
        }
        fewest.find_middle(view.rows);
        fewest
    }
}

/// The first sample right of a crossing in each of eight rows from `base` on.
#[inline(always)]
fn columns<S: Simd>(simd: S, view: &View, c: &Crossing, base: usize) -> [u32; 8] {
    let rows = f32x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) + base as f32;
    let at = rows * c.slope + c.start;
    let at = at.max(f32x8::splat(simd, c.low)).min(f32x8::splat(simd, c.high));
    view.raster.indices(simd, at - f32x8::simd_from(simd, *Raster::shifts(base))).into()
}

fn within(row: &Samples, first: u8, last: u8) -> Samples {
    core::array::from_fn(|word| {
        let start = 64 * word as u32;
        let low = u32::from(first).saturating_sub(start);
        let high = (u32::from(last) + 1).saturating_sub(start);
        row[word] & u64::MAX.unbounded_shl(low) & !u64::MAX.unbounded_shl(high)
    })
}

impl Fewest {
    fn none() -> Self {
        Self { level: i32::MAX, rows: [[0; 4]; MOST], middle: None, count: 0, emitting: 0 }
    }

    /// How many surfaces lie before these samples, up to the constant; none where there are enough of them to be sure that
    /// no others have fewer in truth. Two edges that lie on each other to the last digit may be taken in the wrong order:
    /// then a few samples between them have too few.
    pub(crate) fn doubtful(&self) -> Option<i32> {
        (self.count < self.emitting / FEW && self.middle.is_some()).then_some(self.level)
    }

    /// Those of another as well.
    pub(crate) fn add(&mut self, other: &Self) {
        for (row, more) in self.rows.as_flattened_mut().iter_mut().zip(other.rows.as_flattened()) {
            *row |= more;
        }
    }

    /// The row with the most samples and the middle of its longest run.
    fn find_middle(&mut self, rows: usize) {
        let mut best = (0, 0);
        for (j, row) in self.rows[..rows].iter().enumerate() {
            let count = row.iter().map(|word| word.count_ones()).sum();
            self.count += count;
            if count > best.0 {
                best = (count, j);
            }
        }
        if best.0 == 0 {
            return;
        }
        let mut longest = (0, 0);
        for (word, bits) in self.rows[best.1].iter().enumerate() {
            let (mut bits, mut length) = (*bits, 0);
            let mut runs = bits;
            while runs != 0 {
                bits = runs;
                length += 1;
                runs &= runs >> 1;
            }
            if length > longest.0 {
                longest = (length, 64 * word + bits.trailing_zeros() as usize + (length - 1) / 2);
            }
        }
        self.middle = Some((best.1, longest.1));
    }
}
