use super::SkyResolution;
use super::buffer::HALF;
use super::witnesses::WITNESSES;

/// Outlines are a crowd if they cross more samples than one in this number: several in one sample hide parts of it that overlap.
pub(crate) const SPARSE: usize = 4;
/// The samples of a crowd for each of the table's, on a GPU.
pub(crate) const FINER: usize = 4;
/// Shorter parts of a row say nothing about the fewest surfaces: rounding may order the outlines at their ends.
const LEAST: i32 = HALF / 64;
/// The bits of a crossing below its place: its step, largest first, so that between surfaces which touch there is no opening.
const STEP: u32 = 12;
const MOST_STEP: i32 = (1 << (STEP - 1)) - 1;
const MOST_PLACE: i32 = (1 << (32 - STEP)) - 1;

/// The outlines that cross each row of a crowded buffer: foliage, grass, hair.
///
/// The parts of a sample that several surfaces hide overlap, so what is seen is more than 1 less their sum. Here the crossings of a row are put in order, and
/// what is open between them is what is seen: exact along rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Crowd {
    /// Whether the receiver's outlines are counted so.
    pub(super) is_on: bool,
    /// For each row its crossings: place in [`HALF`]ths of samples, and step.
    rows: Vec<Vec<u32>>,
    /// The longest parts of rows with the fewest surfaces, and their rows.
    longest: [Option<(Part, usize)>; WITNESSES],
}

/// A part of a row between two crossings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Its ends, in [`HALF`]ths of samples.
    pub(super) from: i32,
    pub(super) to: i32,
    /// Half surfaces before it.
    pub(super) number: i32,
}

impl Part {
    /// Whether it is long enough to say how many the fewest surfaces are.
    pub(super) const fn is_sure(&self) -> bool {
        self.length() >= LEAST
    }

    pub(super) const fn length(&self) -> i32 {
        self.to - self.from
    }
}

impl Crowd {
    /// Whether so many crossings of outlines and rows are those of a crowd.
    pub(super) const fn is_of(crossings: u32, samples: SkyResolution) -> bool {
        crossings as usize * SPARSE > samples.rows() * samples.samples()
    }

    /// Of a number of rows, if there is a crowd.
    pub(super) fn new(is_on: bool, rows: usize) -> Self {
        Self { is_on, rows: vec![Vec::new(); if is_on { rows } else { 0 }], longest: [None; WITNESSES] }
    }

    /// Forgets the crossings of a row.
    pub(super) fn clear(&mut self, row: usize) {
        self.rows[row].clear();
    }

    /// A step in a row, at a place in [`HALF`]ths of samples.
    #[inline(always)]
    pub(super) fn put(&mut self, row: usize, place: i32, step: i32) {
        let step = MOST_STEP - step.clamp(-MOST_STEP, MOST_STEP);
        self.rows[row].push(place.min(MOST_PLACE).cast_unsigned() << STEP | step.cast_unsigned());
    }

    /// Puts the crossings of a row in order.
    pub(super) fn sort(&mut self, row: usize) {
        self.rows[row].sort_unstable();
    }

    /// The parts of a row between two places, after [`sort`](Self::sort).
    pub(super) fn parts(&self, row: usize, [start, end]: [i32; 2]) -> impl Iterator<Item = Part> + '_ {
        let (mut last, mut number) = (0, 0);
        let crossings = self.rows[row].iter().map(|crossing| {
            let step = MOST_STEP - (crossing & ((1 << STEP) - 1)).cast_signed();
            ((crossing >> STEP).cast_signed(), step)
        });
        crossings.chain([(i32::MAX, 0)]).filter_map(move |(place, step)| {
            let part = Part { from: start.max(last), to: place.min(end), number };
            (last, number) = (place, number + step);
            (part.from < part.to).then_some(part)
        })
    }

    /// Forgets the longest parts.
    pub(super) const fn keep_none(&mut self) {
        self.longest = [None; WITNESSES];
    }

    /// Keeps a part of a row if it is one of the longest.
    pub(super) fn keep(&mut self, part: Option<Part>, row: usize) {
        let Some(part) = part else { return };
        let is_shorter = |other: &Option<(Part, usize)>| other.is_none_or(|(other, _)| other.length() < part.length());
        if let Some(place) = self.longest.iter().position(is_shorter) {
            self.longest[place..].rotate_right(1);
            self.longest[place] = Some((part, row));
        }
    }

    /// The longest parts that were kept, and their rows, the longest first.
    pub(super) fn longest(&self) -> impl Iterator<Item = (Part, usize)> + '_ {
        self.longest.iter().flatten().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::Random;

    /// Surfaces in any order leave those places of a row open that none of them has.
    #[test]
    fn parts_are_those_between_surfaces() {
        let mut random = Random::new(3);
        let mut crowd = Crowd::new(true, 1);
        for _ in 0..200 {
            crowd.clear(0);
            let mut hidden = [0; 600];
            for _ in 0..40 {
                let [from, width] = [(0.0, 550.0), (0.0, 40.0)].map(|(low, high)| random.between(low, high) as usize);
                crowd.put(0, (from + width) as i32, -2);
                crowd.put(0, from as i32, 2);
                hidden[from..from + width].iter_mut().for_each(|number| *number += 2);
            }
            crowd.sort(0);
            let mut found = [i32::MAX; 600];
            for part in crowd.parts(0, [20, 580]) {
                found[part.from as usize..part.to as usize].fill(part.number);
            }
            assert_eq!(found[20..580], hidden[20..580]);
            assert!(found[..20].iter().chain(&found[580..]).all(|number| *number == i32::MAX));
        }
        // The farthest place and any step fit.
        crowd.clear(0);
        crowd.put(0, MOST_PLACE + 1, i32::MAX);
        crowd.sort(0);
        let parts: Vec<i32> = crowd.parts(0, [0, i32::MAX]).map(|part| part.number).collect();
        assert_eq!(parts, [0, MOST_STEP]);
    }
}
