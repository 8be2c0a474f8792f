//! Masks around the lit part of a light, if it is small.

use crate::places::{self, Group, Place, Side, Turned};
use crate::{Mask, UnitSquare, row};
use glam::{Vec2, Vec3};

/// Masks may be drawn again if less than 1/LITTLE of their emitting samples is lit,
pub(crate) const LITTLE: u32 = 3;
/// and if either less than 1/LEAST of these is lit,
pub(crate) const LEAST: u32 = 40;
/// or fewer than FEW of OF rows have a lit sample: with few rows the ends of the lit part matter.
pub(crate) const FEW: u32 = 3;
pub(crate) const OF: u32 = 8;
/// The lit part of an opening is narrow if rows have less than 1/NARROW of their samples lit.
pub(crate) const NARROW: u32 = 16;
/// A mask is fine enough if 1/FILLED of its samples is lit.
pub(crate) const FILLED: u32 = 4;
/// A window is divided before it has a mask if less than this part of it is lit, as far as segments tell.
const SPARSE: f32 = 0.1;
/// Openings between the samples of such a mask matter if less than 1/FAINT is lit.
const FAINT: u32 = 16;
/// If less than 1/SLIGHT is lit, masks are drawn again for ordinary penumbrae as well: the light seen through an opening may end at its own
/// outline.
pub(crate) const SLIGHT: u32 = 10;
/// The lit part is an opening's if less than 1/ENDS of its rows, or of its columns, end where the light does.
pub(crate) const ENDS: u32 = 4;
/// The most masks for a window.
const MOST: usize = 24;
/// A mask is replaced by others if these are together smaller than this part of it.
pub(crate) const SMALLER: f32 = 0.75;
/// How often a window may grow.
const MOST_GROWN: u32 = 3;

/// Numbers of lit and of emitting samples of masks; numbers of rows with any lit sample, and of all rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LitCounts {
    lit: u32,
    emitting: u32,
    lit_rows: u32,
    rows: u32,
    /// Samples in a row.
    width: u32,
}

impl LitCounts {
    pub(crate) fn add(&mut self, mask: &Mask) {
        self.lit += mask.lit_count();
        self.emitting += mask.emitting_count();
        self.lit_rows += (0..mask.side()).map(|j| u32::from(!mask.is_row_dark(j))).sum::<u32>();
        self.rows += mask.side() as u32;
        self.width = mask.width() as u32;
    }

    /// Whether the smaller part is lit.
    pub(crate) fn are_little(self) -> bool {
        LITTLE * self.lit < self.emitting
    }

    /// Whether so little is lit that few samples measure its size.
    pub(crate) fn are_few(self) -> bool {
        let Self { lit, emitting, lit_rows, rows, .. } = self;
        self.are_little() && (LEAST * lit < emitting || OF * lit_rows < FEW * rows)
    }

    /// Whether rows have so few lit samples that these may all be one more, or one less, in a row after another.
    pub(crate) fn are_narrow(self) -> bool {
        NARROW * self.lit < self.lit_rows * self.width
    }

    /// Whether no sample is lit.
    pub(crate) fn are_none(self) -> bool {
        self.lit == 0
    }

    /// Whether that is looked at again whatever bounds the lit part.
    pub(crate) fn are_slight(self) -> bool {
        SLIGHT * self.lit < self.emitting
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

/// Whether so little of a mask is lit that openings between its samples matter.
pub(crate) fn is_faint(mask: &Mask) -> bool {
    FAINT * mask.lit_count() < (mask.width() * mask.side()) as u32
}

/// Whether the lit part fills enough of a mask.
fn is_fine(mask: &Mask) -> bool {
    FILLED * mask.lit_count() >= (mask.width() * mask.side()) as u32
}

/// A window to be drawn.
#[derive(Clone, Debug)]
struct Job {
    window: Turned,
    cell: Vec<Side>,
    /// How often it has grown.
    grown: u32,
}

/// Masks around the lit parts of a window.
///
/// # Method
/// Lit samples, and openings between samples that the blockers have marked, are segments of rows and columns. A window is put around them, along
/// them if they are long and thin. If two windows on both sides of a line are much smaller together, these are taken instead, and each sees its
/// own side of the line. A mask is drawn in each window. If the lit part reaches the window's side, the next mask is larger there. If it fills
/// less than a quarter of the mask, the mask's own segments are used in the same way, as long as there are masks left of [`MOST`].
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

    /// Draws masks around the lit places that other masks of a window show. Without any, they look for some in the window's quarters.
    /// `may_turn`: whether windows may be turned.
    pub(crate) fn draw(
        &mut self,
        window: &UnitSquare,
        places: Vec<Place>,
        may_turn: bool,
        mut draw: impl FnMut(&UnitSquare, &mut Mask),
    ) {
        self.clear();
        self.jobs.clear();
        let smallest = window.smallest();
        match Group::new(places, places::sides(window), may_turn) {
            Some(group) => self.add(group, may_turn, MOST / 2),
            None => self.jobs.extend(quarters(window).map(|quarter| {
                let cell = places::sides(&quarter.window(window, smallest));
                Job { window: quarter, cell, grown: 0 }
            })),
        }
        let mut left = MOST;
        while let Some(job) = self.next() {
            if self.masks.len() == self.used {
                self.masks.push(Mask::default());
            }
            let mask = &mut self.masks[self.used];
            mask.set_cell(job.cell.iter().map(|side| job.window.local(*side)));
            draw(&job.window.window(window, smallest), mask);
            left -= 1;
            // Each waiting window is certain to get a mask.
            let room = left.saturating_sub(self.jobs.len());
            let mut places = Vec::new();
            places::add(mask, window, &mut places);
            if places.is_empty() {
                continue;
            }
            if room > 0
                && let Some(window) = grown(mask, &job)
            {
                self.jobs.push(Job { window, grown: job.grown + 1, ..job });
                continue;
            }
            let is_small = job.window.size().min_element() < 4.0 * smallest;
            if room > 0
                && !is_fine(mask)
                && !is_small
                && let Some(group) = Group::new(places, job.cell, may_turn)
            {
                let jobs = self.jobs.len();
                let area = job.window.area();
                self.add(group, may_turn, room);
                let new: f32 = self.jobs[jobs..].iter().map(|job| job.window.area()).sum();
                if new <= SMALLER * area {
                    continue;
                }
                self.jobs.truncate(jobs);
            }
            self.used += 1;
        }
    }

    /// Removes the largest window.
    fn next(&mut self) -> Option<Job> {
        let areas = self.jobs.iter().map(|job| job.window.area()).enumerate();
        let (largest, _) = areas.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(self.jobs.swap_remove(largest))
    }

    /// Adds the windows of a group, at most `room`.
    fn add(&mut self, group: Group, may_turn: bool, room: usize) {
        let mut groups = vec![group];
        let mut count = 1;
        while let Some(group) = groups.pop() {
            match if count < room { group.divided(SPARSE, may_turn) } else { None } {
                Some(parts) => {
                    count += 1;
                    groups.extend(parts);
                }
                None => self.jobs.push(Job { window: group.window, cell: group.cell, grown: 0 }),
            }
        }
    }
}

/// The quarters of a window.
fn quarters(window: &UnitSquare) -> [Turned; 4] {
    let middle = window.center;
    let (low, high) = (middle - window.half, middle + window.half);
    [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| Turned {
        right: Vec2::X,
        low: Vec2::new([low.x, middle.x][x], [low.y, middle.y][y]),
        high: Vec2::new([middle.x, high.x][x], [middle.y, high.y][y]),
    })
}

/// A larger window, if the lit part reaches a side of the mask where it may continue.
fn grown(mask: &Mask, job: &Job) -> Option<Turned> {
    let Turned { right, mut low, mut high } = job.window;
    if job.grown == MOST_GROWN {
        return None;
    }
    let (width, last) = (mask.width() as u32, mask.side() - 1);
    let cell: Vec<Side> = job.cell.iter().map(|side| job.window.local(*side)).collect();
    let step = mask.cell();
    // Whether the cell continues beside a place.
    let continues = |x: f32, y: f32| cell.iter().all(|side| side.dot(Vec3::new(x, y, 1.0)) > 0.0);
    let (mut at_low, mut at_high) = ([false; 2], [false; 2]);
    for j in 0..=last {
        let [from, to] = row::bounds(&mask.lit(j));
        if from >= to {
            continue;
        }
        let y = mask.row_y(j);
        let x = mask.square().center.x + mask.square().half.x * ((from + to) as f32 / width as f32 - 1.0);
        at_low[0] |= from == 0 && continues(low.x - step.x, y);
        at_high[0] |= to == width && continues(high.x + step.x, y);
        at_low[1] |= j == 0 && continues(x, low.y - step.y);
        at_high[1] |= j == last && continues(x, high.y + step.y);
    }
    let size = job.window.size();
    for k in 0..2 {
        low[k] -= if at_low[k] { size[k] } else { 0.0 };
        high[k] += if at_high[k] { size[k] } else { 0.0 };
    }
    let window = Turned { right, low, high }.within(&job.cell);
    (window.low != job.window.low || window.high != job.window.high).then_some(window)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::UnitSquare;
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
                is_opening(coarse, depth, &|mask| block_around(&[hole], &window, mask))
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

    /// A hole in the plane of a window.
    #[derive(Clone, Copy)]
    struct Rect {
        low: Vec2,
        high: Vec2,
    }

    impl Rect {
        fn area(self) -> f32 {
            (self.high - self.low).element_product()
        }

        /// The part of a line that passes through it, from a start in a direction.
        fn passed(self, start: Vec2, along: Vec2) -> [f32; 2] {
            let ends = [self.low, self.high].map(|side| (side - start) / along);
            let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            [from.max_element(), to.min_element()]
        }
    }

    /// Blocks everything except rectangles in a mask on the plane of a window, which may be turned.
    fn block_around(holes: &[Rect], window: &UnitSquare, mask: &mut Mask) {
        let turn = window.turn_to(mask.square());
        for j in 0..mask.side() {
            // Off the sides of the rectangles, lest a line runs along one.
            let start = turn.rotate(Vec2::new(0.0, mask.row_y(j)));
            let passed = holes.iter().map(|hole| hole.passed(start, turn + 1e-9));
            let mut open: Vec<[f32; 2]> = passed.filter(|[from, to]| from < to).collect();
            open.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut from = f32::NEG_INFINITY;
            for hole in &open {
                mask.block_span(j, from, hole[0]);
                from = hole[1];
            }
            mask.block_span(j, from, f32::INFINITY);
        }
    }

    /// The lit area of masks around all holes, the number of masks, and the lit area of a single mask.
    fn area(holes: &[Rect]) -> (f32, usize, f32) {
        let cone = Cone { axis: Vec3::Z, one_minus_cos: 0.01, distance: f32::INFINITY };
        let window = UnitSquare::facing(&cone, Vec3::X);
        let draw = |square: &UnitSquare, depth: u32, mask: &mut Mask| {
            mask.set_coarse(true);
            mask.reset(square, depth, Vec3::Z);
            block_around(holes, &window, mask);
        };
        let mut whole = Mask::default();
        draw(&window, 5, &mut whole);
        let mut places = Vec::new();
        places::add(&whole, &window, &mut places);
        if places.is_empty() {
            return (0.0, 0, 0.0);
        }
        let (mut near, mut drawn) = (NearMasks::default(), 0);
        near.draw(&window, places, true, |square, mask| {
            drawn += 1;
            draw(square, 6, mask);
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
