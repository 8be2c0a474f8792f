use super::SkyResolution;
use super::buffer::HALF;
use fearless_simd::{Simd, i32x8, prelude::*};
use lobe_core::vec3x8::LANES;

/// Outlines are a crowd if they cross more samples than one in this number: several in one sample hide parts of it that overlap.
pub(crate) const SPARSE: usize = 4;
/// The samples of a crowd for each of the table's.
pub(crate) const FINER: usize = 4;
/// Bits of one of two parts of a sample.
const PART: u32 = 16;

/// The outlines in each sample of a crowded buffer: foliage, grass, hair.
///
/// The parts of a sample that several surfaces hide may overlap, so the rest is more than 1 less their sum. Surfaces that begin in a sample
/// hide all from the first beginning on, those that end in it all up to the last end. The part before the first beginning is seen if the
/// sample's left end is; so is the part behind the last end if the right end is, and the part between both if the other surfaces leave it
/// open. That is never more than is seen: only openings between two surfaces of which both begin, or both end, in one sample
/// are left out.
#[derive(Clone, Debug, Default)]
pub(super) struct Crowd {
    /// Whether the receiver's outlines are counted so.
    pub(super) is_on: bool,
    /// Half surfaces by which the number grows over a sample; after [`resolve`](Self::resolve), the number at its left end.
    steps: Vec<[i32; LANES]>,
    /// Those of them that end, as a negative number.
    falls: Vec<[i32; LANES]>,
    /// The largest hidden part behind a beginning and, [`PART`] bits lower, before an end, in [`HALF`]ths.
    parts: Vec<[i32; LANES]>,
}

impl Crowd {
    /// Whether so many crossings of outlines and rows are those of a crowd.
    pub(super) const fn is_of(crossings: u32, samples: SkyResolution) -> bool {
        crossings as usize * SPARSE > samples.rows() * samples.samples()
    }

    /// For so many samples in rows of eight, if there is a crowd.
    pub(super) fn new(is_on: bool, len: usize) -> Self {
        let values = vec![[0; LANES]; if is_on { len } else { 0 }];
        Self { is_on, steps: values.clone(), falls: values.clone(), parts: values }
    }

    /// Forgets samples.
    pub(super) fn clear(&mut self, samples: core::ops::Range<usize>) {
        for values in [&mut self.steps, &mut self.falls, &mut self.parts] {
            values[samples.clone()].fill([0; LANES]);
        }
    }

    /// A step in a sample, at so many [`HALF`]ths of it.
    #[inline(always)]
    pub(super) fn put(&mut self, sample: usize, lane: usize, fraction: i32, step: i32) {
        self.steps[sample][lane] += step;
        let parts = &mut self.parts[sample][lane];
        let [begun, ended] = [*parts >> PART, *parts & ((1 << PART) - 1)];
        if step > 0 {
            *parts = begun.max(HALF - fraction) << PART | ended;
        } else {
            self.falls[sample][lane] += step;
            *parts = begun << PART | ended.max(fraction);
        }
    }

    /// Makes numbers at the left ends of samples of steps. The sample behind the last one is there.
    pub(super) fn resolve(&mut self, samples: core::ops::Range<usize>) {
        let mut number = [0; LANES];
        for steps in &mut self.steps[samples.start..=samples.end] {
            for (steps, number) in steps.iter_mut().zip(&mut number) {
                (*steps, *number) = (*number, *number + *steps);
            }
        }
    }

    /// The numbers of surfaces at the left ends of eight samples, in [`HALF`]ths of half surfaces.
    #[inline(always)]
    pub(super) fn starts<S: Simd>(&self, simd: S, sample: usize) -> i32x8<S> {
        i32x8::simd_from(simd, self.steps[sample]) * HALF
    }

    /// The parts of eight samples, in [`HALF`]ths, that certainly have no more surfaces before them than `fewest`, in [`HALF`]ths of half surfaces.
    #[inline(always)]
    pub(super) fn open<S: Simd>(&self, simd: S, sample: usize, fewest: i32) -> i32x8<S> {
        let (zero, one) = (i32x8::splat(simd, 0), i32x8::splat(simd, HALF));
        let fewest = i32x8::splat(simd, fewest);
        let (left, right) = (self.starts(simd, sample), self.starts(simd, sample + 1));
        let parts = i32x8::simd_from(simd, self.parts[sample]);
        let begun = one - (parts >> PART);
        let ended = one - (parts & i32x8::splat(simd, (1 << PART) - 1));
        let middle = left + i32x8::simd_from(simd, self.falls[sample]) * HALF;
        let ends = left.simd_le(fewest).select(begun, zero) + right.simd_le(fewest).select(ended, zero);
        let between = middle.simd_le(fewest).select((begun + ended - one).max(zero), zero);
        ends.max(between)
    }
}
