//! Masks around the lit part of a light, if it is small.

use crate::row::{self, Row};
use crate::{Mask, UnitSquare};
use core::ops::Range;
use glam::Vec2;

/// Masks may be drawn again if less than 1/LITTLE of their emitting samples is lit,
pub(crate) const LITTLE: u32 = 3;
/// and if either less than 1/LEAST of these is lit,
pub(crate) const LEAST: u32 = 40;
/// or fewer than FEW of OF rows have a lit sample: with few rows the ends of the lit part matter.
pub(crate) const FEW: u32 = 3;
pub(crate) const OF: u32 = 8;
/// A mask is fine enough if 1/FILLED of its samples is lit.
pub(crate) const FILLED: u32 = 4;
/// If less than 1/SLIGHT is lit, masks are drawn again for ordinary penumbrae as well: the light seen through an opening may end at its own
/// outline.
pub(crate) const SLIGHT: u32 = 10;
/// The lit part is an opening's if less than 1/ENDS of its rows, or of its columns, end where the light does.
pub(crate) const ENDS: u32 = 4;
/// The most masks for a window.
const MOST: usize = 16;
/// The lit part ends between two samples, of which one is dark: a window around it has this much room, in samples and in rows.
pub(crate) const ROOM_SAMPLES: f32 = 2.0;
pub(crate) const ROOM_ROWS: f32 = 1.0;

/// Numbers of lit and of emitting samples of masks; numbers of rows with any lit sample, and of all rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LitCounts {
    lit: u32,
    emitting: u32,
    lit_rows: u32,
    rows: u32,
}

impl LitCounts {
    pub(crate) fn add(&mut self, mask: &Mask) {
        self.lit += mask.lit_count();
        self.emitting += mask.emitting_count();
        self.lit_rows += (0..mask.side()).map(|j| u32::from(!mask.is_row_dark(j))).sum::<u32>();
        self.rows += mask.side() as u32;
    }

    /// Whether so little is lit that few samples measure its size.
    pub(crate) fn are_few(self) -> bool {
        let Self { lit, emitting, lit_rows, rows } = self;
        LITTLE * lit < emitting && (LEAST * lit < emitting || OF * lit_rows < FEW * rows)
    }

    /// Whether that is looked at again whatever bounds the lit part.
    pub(crate) fn are_slight(self) -> bool {
        SLIGHT * self.lit < self.emitting
    }

    /// Whether no sample is lit.
    pub(crate) fn are_none(self) -> bool {
        self.lit == 0
    }
}

/// A rectangle of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) low: Vec2,
    pub(crate) high: Vec2,
}

impl Rect {
    pub(crate) const NOTHING: Self = Self { low: Vec2::INFINITY, high: Vec2::NEG_INFINITY };

    pub(crate) fn of(square: &UnitSquare) -> Self {
        Self { low: square.center - square.half, high: square.center + square.half }
    }

    pub(crate) fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub(crate) fn within(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    /// The rectangle in the coordinates of a [turned](UnitSquare::turned) window.
    pub(crate) fn turned(self) -> Self {
        if self == Self::NOTHING {
            return self;
        }
        Self { low: Vec2::new(self.low.y, -self.high.x), high: Vec2::new(self.high.y, -self.low.x) }
    }

    fn quarters(self) -> [Self; 4] {
        let middle = 0.5 * (self.low + self.high);
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| Self {
            low: Vec2::new([self.low.x, middle.x][x], [self.low.y, middle.y][y]),
            high: Vec2::new([middle.x, self.high.x][x], [middle.y, self.high.y][y]),
        })
    }

    fn size(self) -> Vec2 {
        (self.high - self.low).max(Vec2::ZERO)
    }

    pub(crate) fn area(self) -> f32 {
        self.size().element_product()
    }
}

/// Along the rows and across them: how many rows, or columns, have lit samples, and how many of these where nothing beside the lit part
/// emits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LitEnds {
    lit: [u32; 2],
    ends: [u32; 2],
}

impl LitEnds {
    /// Adds a mask. Of its sides, left and right, bottom and top, those that are `inner` to the window are no ends.
    pub(crate) fn add(&mut self, mask: &Mask, inner: [[bool; 2]; 2]) {
        let (side, width) = (mask.side(), mask.width() as u32);
        let (mut columns, mut ends) = (row::NONE, row::NONE);
        for j in (0..side).filter(|j| !mask.is_row_dark(*j)) {
            let lit = mask.lit(j);
            let ([first, end], (from, to)) = (row::bounds(&lit), mask.emitting(j));
            let ends_left = first <= from && !(from == 0 && inner[0][0]);
            let ends_right = end >= to && !(to == width && inner[0][1]);
            self.lit[0] += 1;
            self.ends[0] += u32::from(ends_left || ends_right);
            columns = row::with(&columns, &lit);
            for (is_last, other, is_inner) in
                [(j == 0, j.wrapping_sub(1), inner[1][0]), (j + 1 == side, j + 1, inner[1][1])]
            {
                let (from, to) = match (is_last, is_inner) {
                    (true, true) => (0, width),
                    (true, false) => (0, 0),
                    (false, _) => mask.emitting(other),
                };
                // Rows are shifted by up to half a sample.
                let emits = if from < to { row::span(from.saturating_sub(1), (to + 1).min(width)) } else { row::NONE };
                ends = row::with(&ends, &row::without(&lit, &emits));
            }
        }
        self.lit[1] += row::count(&columns);
        self.ends[1] += row::count(&ends);
    }

    /// Whether the lit part is that of an opening: between two opposite sides most of it ends at blockers. Where no sample is lit it may be:
    /// an opening between samples.
    pub(crate) fn are_of_an_opening(self) -> bool {
        self.lit == [0; 2] || (0..2).any(|axis| ENDS * self.ends[axis] < self.lit[axis])
    }
}

/// Samples and rows of a mask.
type Block = [Range<u32>; 2];

/// A window to be drawn, and the part of the light up to which it may grow.
#[derive(Clone, Copy, Debug)]
struct Job {
    window: Rect,
    limit: Rect,
}

/// Masks around the lit parts of a window.
///
/// # Method
/// A mask is drawn around the lit part. If that reaches the mask's side, the next mask is larger on that side. If it fills less
/// than a quarter of the mask, the next one is smaller; if no smaller rectangle contains all of it, it is divided in the middle.
/// This is repeated as long as there are masks left of [`MOST`].
#[derive(Clone, Debug, Default)]
pub(crate) struct NearMasks {
    masks: Vec<Mask>,
    used: usize,
    jobs: Vec<Job>,
}

impl NearMasks {
    /// Removes all masks.
    pub(crate) fn clear(&mut self) {
        self.used = 0;
    }

    pub(crate) fn masks(&self) -> &[Mask] {
        &self.masks[..self.used]
    }

    /// Draws masks around the lit part of a window, which lies in the rectangle `lit` as far as masks of the whole window show. If that is
    /// [`NOTHING`](Rect::NOTHING), they look for it in the window's quarters.
    pub(crate) fn draw(&mut self, window: &UnitSquare, lit: Rect, mut draw: impl FnMut(&UnitSquare, &mut Mask)) {
        self.clear();
        self.jobs.clear();
        let limit = Rect::of(window);
        if lit == Rect::NOTHING {
            self.jobs.extend(limit.quarters().map(|window| Job { window, limit: window }));
        } else {
            self.jobs.push(Job { window: lit.within(limit), limit });
        }
        let smallest = Vec2::splat(window.smallest());
        let mut left = MOST;
        while let Some(job) = self.jobs.pop() {
            if self.masks.len() == self.used {
                self.masks.push(Mask::default());
            }
            let mask = &mut self.masks[self.used];
            let half = (0.5 * job.window.size()).max(smallest);
            let center = 0.5 * (job.window.low + job.window.high);
            draw(&UnitSquare { center, half, ..*window }, mask);
            left -= 1;
            let Some(block) = mask.lit_block() else { continue };
            // Each waiting window is certain to get a mask.
            let room = left.saturating_sub(self.jobs.len());
            match next(mask, &job, &block, smallest) {
                [Some(one), None] if room >= 1 => self.jobs.push(one),
                [Some(one), Some(other)] if room >= 2 => self.jobs.extend([other, one]),
                _ => self.used += 1,
            }
        }
    }
}

/// The windows that replace a mask whose lit samples are in a block: none, one, or two.
fn next(mask: &Mask, job: &Job, block: &Block, smallest: Vec2) -> [Option<Job>; 2] {
    let Job { window, limit } = *job;
    let all = Vec2::new(mask.width() as f32, mask.side() as f32);
    let [samples, rows] = block;
    // A lit part at a side continues beyond it.
    let room = 1e-3 * window.size();
    let at_low = [samples.start == 0, rows.start == 0];
    let at_high = [samples.end == mask.width() as u32, rows.end == mask.side() as u32];
    let mut around = rect(mask, block).within(limit);
    let mut grows = false;
    for k in 0..2 {
        if at_low[k] && window.low[k] > limit.low[k] + room[k] {
            around.low[k] = (window.low[k] - 0.5 * window.size()[k]).max(limit.low[k]);
            grows = true;
        }
        if at_high[k] && window.high[k] < limit.high[k] - room[k] {
            around.high[k] = (window.high[k] + 0.5 * window.size()[k]).min(limit.high[k]);
            grows = true;
        }
    }
    let one = |window| [Some(Job { window, limit }), None];
    if grows {
        return one(around);
    }
    let lit = mask.lit_count();
    if FILLED * lit >= (mask.width() * mask.side()) as u32 || window.size().cmple(2.0 * smallest).any() {
        return [None, None];
    }
    if 2.0 * around.area() <= window.area() {
        return one(around);
    }
    let across = usize::from(rows.len() as f32 / all.y > samples.len() as f32 / all.x);
    match [true, false].map(|first| part(mask, job, block, across, first)) {
        [None, only] => [only, None],
        parts => parts,
    }
}

/// The window for one half of a block, which is cut in the middle of its samples (0) or its rows (1).
fn part(mask: &Mask, job: &Job, block: &Block, across: usize, first: bool) -> Option<Job> {
    let Job { window, mut limit } = *job;
    let middle = (block[across].start + block[across].end) / 2;
    let count = [mask.width(), mask.side()][across] as f32;
    let cut = window.low[across] + window.size()[across] * (middle as f32 / count);
    let mut block = block.clone();
    if first {
        block[across].end = middle;
        limit.high[across] = cut;
    } else {
        block[across].start = middle;
        limit.low[across] = cut;
    }
    let [samples, rows] = block;
    // Shifts of rows may move a sample across the cut.
    lit_block(mask, samples, rows).map(|lit| Job { window: rect(mask, &lit).within(limit), limit })
}

/// The samples and rows that contain all lit samples of a part of a mask.
fn lit_block(mask: &Mask, samples: Range<u32>, rows: Range<u32>) -> Option<Block> {
    let within = row::span(samples.start, samples.end);
    let (mut columns, mut first, mut end) = (row::NONE, None, 0);
    for j in rows {
        let lit: Row = row::and(&mask.lit(j as usize), &within);
        if lit != row::NONE {
            columns = row::with(&columns, &lit);
            first = first.or(Some(j));
            end = j + 1;
        }
    }
    let [from, to] = row::bounds(&columns);
    first.map(|first| [from..to, first..end])
}

/// The rectangle of the plane that contains the lit part of a block.
pub(crate) fn rect(mask: &Mask, [samples, rows]: &Block) -> Rect {
    let Rect { low, high } = Rect::of(mask.square());
    let sample = (high - low) / Vec2::new(mask.width() as f32, mask.side() as f32);
    let from = Vec2::new(samples.start as f32, rows.start as f32);
    let to = Vec2::new(samples.end as f32, rows.end as f32);
    let room = Vec2::new(ROOM_SAMPLES, ROOM_ROWS);
    Rect { low: low + (from - room) * sample, high: low + (to + room) * sample }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use lobe_core::Cone;
    use lobe_core::oracle::Random;

    /// A hole in the middle of a round light ends at blockers on all sides; a slit on two; the part that a straight edge leaves of a disc
    /// does not, however the edge lies; nor does the corner of a rectangle.
    #[test]
    fn openings_are_told_from_penumbrae() {
        let cone = Cone { axis: Vec3::Z, one_minus_cos: 0.01, distance: f32::INFINITY };
        let window = UnitSquare::facing(&cone, Vec3::X);
        let is_opening = |coarse: bool, depth: u32, block: &dyn Fn(&mut Mask)| {
            let mut mask = Mask::default();
            mask.set_coarse(coarse);
            mask.reset(&window, depth, Vec3::Z);
            block(&mut mask);
            assert!(mask.lit_count() > 0 && 3 * mask.lit_count() < mask.emitting_count(), "a small part");
            let mut ends = LitEnds::default();
            ends.add(&mask, [[false; 2]; 2]);
            ends.are_of_an_opening()
        };
        let disc = window.disc;
        for (coarse, depth) in [(true, 4), (true, 5), (false, 5), (false, 6)] {
            let hole = |[x, y]: [f32; 2], [w, h]: [f32; 2]| {
                let hole = Rect { low: disc * Vec2::new(x - w, y - h), high: disc * Vec2::new(x + w, y + h) };
                is_opening(coarse, depth, &|mask| block_around(&[hole], mask))
            };
            assert!(hole([0.1, -0.2], [0.2, 0.3]), "window");
            assert!(hole([0.1, 0.0], [0.1, 2.0]) && hole([0.0, 0.3], [2.0, 0.15]), "slits");
            for step in 0..24_u16 {
                // Everything on one side of a line that leaves a segment 0.3 to 0.5 of the radius high.
                let (sin, cos) = (f32::from(step) * 0.27).sin_cos();
                let far = disc * (0.5 + 0.2 * (f32::from(step) * 0.618).fract());
                let told = is_opening(coarse, depth, &|mask| {
                    for j in 0..mask.side() {
                        let at = (far - sin * mask.row_y(j)) / cos;
                        let (from, to) = if cos > 0.0 { (f32::NEG_INFINITY, at) } else { (at, f32::INFINITY) };
                        mask.block_span(j, from, to);
                    }
                });
                assert!(!told, "{step} {coarse} {depth}");
            }
        }
    }

    /// Blocks everything except rectangles.
    fn block_around(holes: &[Rect], mask: &mut Mask) {
        for j in 0..mask.side() {
            let y = mask.row_y(j);
            let mut open: Vec<Rect> = holes.iter().copied().filter(|hole| hole.low.y < y && y < hole.high.y).collect();
            open.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
            let mut from = f32::NEG_INFINITY;
            for hole in &open {
                mask.block_span(j, from, hole.low.x);
                from = hole.high.x;
            }
            mask.block_span(j, from, f32::INFINITY);
        }
    }

    /// The lit area of masks around all holes, the number of masks, and the lit area of a single mask.
    fn area(holes: &[Rect]) -> (f32, usize, f32) {
        let cone = Cone { axis: Vec3::Z, one_minus_cos: 0.01, distance: f32::INFINITY };
        let window = UnitSquare::facing(&cone, Vec3::X);
        let draw = |square: &UnitSquare, mask: &mut Mask| {
            mask.set_coarse(true);
            mask.reset(square, 5, Vec3::Z);
            block_around(holes, mask);
        };
        let mut whole = Mask::default();
        draw(&window, &mut whole);
        let Some(block) = whole.lit_block() else {
            return (0.0, 0, 0.0);
        };
        let (mut near, mut drawn) = (NearMasks::default(), 0);
        near.draw(&window, rect(&whole, &block), |square, mask| {
            drawn += 1;
            draw(square, mask);
        });
        let area = |mask: &Mask| mask.lit_count() as f32 * mask.sample_area();
        (near.masks().iter().map(area).sum(), drawn, area(&whole))
    }

    #[test]
    fn small_holes_have_their_area() {
        let mut random = Random::new(5);
        let disc = 0.14;
        let (mut worst, mut without, mut most) = ([0.0_f32; 2], 0.0_f32, 0);
        for case in 0..400 {
            // Two holes may touch, but do not overlap.
            let count = 1 + case % 2;
            let holes: Vec<Rect> = (0..count)
                .map(|k| {
                    let mut size = || disc * random.log_uniform(0.08, 0.25) as f32;
                    let size = Vec2::new(size(), size());
                    let mut at = |from: f64, to: f64| disc * random.between(from, to) as f32;
                    let side = if count == 1 { at(-0.6, 0.35) } else { at(-0.6, -0.3) + k as f32 * 0.7 * disc };
                    let low = Vec2::new(side, at(-0.6, 0.35));
                    Rect { low, high: low + size }
                })
                .collect();
            let want: f32 = holes.iter().map(|hole| hole.area()).sum();
            let (got, drawn, alone) = area(&holes);
            let k = usize::from(count > 1);
            worst[k] = worst[k].max((got / want - 1.0).abs());
            without = without.max((alone / want - 1.0).abs());
            most = most.max(drawn);
        }
        println!("one hole {:.4}, two {:.4}, by one mask {without:.4}, {most} masks at most", worst[0], worst[1]);
        assert!(worst[0] < 0.08 && worst[1] < 0.08 && without > 0.3 && most <= MOST, "{worst:?} {without} {most}");
    }

    /// However many parts are lit, no more masks are drawn than allowed, and no part of the light counts twice.
    #[test]
    fn many_holes_keep_to_the_budget() {
        let at = |i: usize, j: usize| 0.14 * Vec2::new(i as f32 * 0.17 - 0.6, j as f32 * 0.17 - 0.6);
        let size = Vec2::splat(0.14 * 0.08);
        let holes: Vec<Rect> = (0..49).map(|k| at(k % 7, k / 7)).map(|low| Rect { low, high: low + size }).collect();
        let want: f32 = holes.iter().map(|hole| hole.area()).sum();
        let (got, drawn, _) = area(&holes);
        assert!(drawn <= MOST && (got / want - 1.0).abs() < 0.25, "{drawn} masks, {got} {want}");
    }
}
