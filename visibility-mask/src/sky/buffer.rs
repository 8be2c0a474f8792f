use super::arcs::{FIRST, NORMAL, ROWS, STEP};
use super::crowd::{Crowd, Part};
use super::meridians::LINES;
use super::witnesses::{WITNESSES, Witnesses};
use super::{Horizon, Meridians, SkyArcs, SkyResolution, SkyWindow};
use fearless_simd::{Simd, f32x8, i32x8, mask32x8, prelude::*};
use glam::Vec3;
use lobe_core::vec3x8::LANES;

/// Half a surface, which is also the number of places in a sample.
pub(crate) const HALF: i32 = 1 << 11;
const ONE: i32 = 2 * HALF;
/// Half a surface on each line of a row, in sum [`HALF`]. No fewer of them come to whole halves, not even twice or four times: these would look as if no
/// outline passed through the sample.
const HALF_OF_LINES: [i32; LINES] = [503, 515, 508, 522];
/// The lowest digits of a count say how often outlines cut the sample.
pub(crate) const CUTS: u32 = 9;
/// Samples whose lower end is so near to the horizon are not certain to be above it.
pub(crate) const MARGIN: f32 = 0.01;
/// The most samples of a row: the unit of runs.
pub(crate) const RUN: usize = SkyResolution::MOST[1];
/// The most half surfaces behind each other.
const MOST: i32 = (i32::MAX >> CUTS) / HALF;
/// How many surfaces lie before each sample of a receiver's meridians, up to one constant, which is 0 at the pole.
///
/// Outlines add their steps where they cross a meridian: a step in the middle of a sample is shared between that and the next one. Of a
/// step by two surfaces, as at the folds of open ones, one is shared so, and the other lies outside of the sample, which sees no light there
/// anyway. That is right where no other outline passes through the sample; else a fold takes half a surface back, since of blades as thin as
/// a sample nothing else would be left (measured: half the error of none or of all). Where outlines cross rows very often,
/// their crossings are put in order instead, and what is seen of a sample is exact along its row. All numbers are whole ones, in half surfaces, so that no order of drawing changes
/// them. Up to 1000 surfaces behind each other are counted.
///
/// Where a row has several lines, each adds its part of the step: a sample's count is a mean over its area.
///
/// Eight rows stand side by side, their counts one after the other.
#[derive(Clone, Debug, Default)]
pub struct SkyBuffer {
    /// Differences of counts, [`resolve`](Self::resolve)d to counts.
    counts: Vec<[i32; LANES]>,
    /// The part that the folds in a sample hide besides, if more than one outline passes through it; and whether there is any.
    folds: Vec<[i32; LANES]>,
    has_folds: bool,
    crowd: Crowd,
    crossings: u32,
    columns: usize,
    /// For each block of rows which are crossed, as bits, and the first sample in which any is.
    crossed: Vec<u8>,
    firsts: Vec<u32>,
    blocks: usize,
    /// Lines of a row: two to this power.
    line_bits: u32,
    /// The samples that are drawn.
    window: SkyWindow,
    /// The fewest surfaces before any sample, as a count.
    fewest: i32,
    /// For each row the longest run of samples with the fewest, times [`RUN`], plus its last sample.
    runs: Vec<i32>,
}

impl SkyBuffer {
    /// Begins a receiver, or another window of its: no surfaces.
    pub fn clear(&mut self, resolution: SkyResolution, window: SkyWindow) {
        let (columns, blocks) = (resolution.samples() + 2, resolution.blocks());
        let [_, end] = self.window.columns();
        let last = core::mem::replace(&mut self.window, window);
        self.crossings = 0;
        let last_bits = core::mem::replace(&mut self.line_bits, window.lines().trailing_zeros());
        if (self.columns, self.blocks) != (columns, blocks) {
            let crowd = Crowd::new(self.crowd.is_on, blocks * LANES * resolution.lines());
            *self = Self { window, crowd, columns, blocks, line_bits: self.line_bits, ..Self::default() };
            self.counts.resize(columns * blocks, [0; LANES]);
            self.folds.resize(columns * blocks, [0; LANES]);
            self.crossed.resize(blocks, 0);
            self.firsts.resize(blocks, u32::MAX);
            self.runs.resize(blocks * LANES, 0);
            return;
        }
        let has_folds = core::mem::take(&mut self.has_folds);
        // A step in the last sample reaches into the next.
        let end = end + 1;
        for block in last.blocks() {
            if core::mem::take(&mut self.crossed[block]) != 0 {
                let first = core::mem::replace(&mut self.firsts[block], u32::MAX) as usize;
                let samples = block * columns + first..block * columns + end;
                self.counts[samples.clone()].fill([0; LANES]);
                if has_folds {
                    self.folds[samples.clone()].fill([0; LANES]);
                }
                if self.crowd.is_on {
                    self.counts[block * columns..(block + 1) * columns].fill([0; LANES]);
                    lines_of(block, last_bits).for_each(|line| self.crowd.clear(line));
                }
            }
        }
    }

    /// The samples that are drawn.
    #[must_use]
    pub const fn window(&self) -> &SkyWindow {
        &self.window
    }

    /// Whether outlines cross rows as often as those of a crowd, and are not counted as one, or the reverse.
    pub(super) fn is_to_begin_again(&self, resolution: SkyResolution) -> bool {
        Crowd::is_of(self.crossings >> self.line_bits, resolution) != self.crowd.is_on
    }

    /// Whether it counts a crowd.
    pub(super) const fn is_crowd(&self) -> bool {
        self.crowd.is_on
    }

    /// Begins the receiver again, with a crowd if it had none, or the reverse: so do the receivers after it.
    pub(super) fn begin_again(&mut self, resolution: SkyResolution) {
        let crowd = Crowd::new(!self.crowd.is_on, 0);
        *self = Self { crowd, window: self.window, ..Self::default() };
        self.clear(resolution, self.window);
    }

    /// Adds a step of a number of half surfaces to a line, at `place` samples from the pole.
    pub fn add(&mut self, line: usize, place: f32, step: i32) {
        let column = place.floor();
        self.put(line, column as usize, ((place - column) * HALF as f32 + 0.5) as i32, step);
    }

    #[inline(always)]
    fn put(&mut self, line: usize, column: usize, fraction: i32, step: i32) {
        let row = line >> self.line_bits;
        self.crossings += 1;
        if column >= self.window.columns()[1] {
            return;
        }
        if self.crowd.is_on {
            self.crowd.put(line, column as i32 * HALF + fraction, step);
            return self.cross(row, column);
        }
        let (block, lane) = (row / LANES, row % LANES);
        let first = block * self.columns + column;
        let half = if self.line_bits == 0 { HALF } else { HALF_OF_LINES[line % LINES] };
        let fraction = (fraction * half + HALF / 2) / HALF;
        let shared = step.clamp(-2, 2);
        let others = (step - shared) * half;
        let [here, next] = if step > 0 { [0, others] } else { [others, 0] };
        let counts = &mut self.counts[first..first + 2];
        add(&mut counts[0][lane], here + shared * (half - fraction), 1);
        add(&mut counts[1][lane], next + shared * fraction, -1);
        if others != 0 {
            self.has_folds = true;
            self.folds[first][lane] += if step > 0 { half - fraction } else { fraction };
        }
        self.cross(row, column);
    }

    /// Notes that an outline crosses a row in a sample.
    #[inline(always)]
    fn cross(&mut self, row: usize, column: usize) {
        let block = row / LANES;
        self.crossed[block] |= 1 << (row % LANES);
        self.firsts[block] = self.firsts[block].min(column as u32);
    }

    /// Draws arcs.
    #[inline(always)]
    pub fn draw<S: Simd>(&mut self, simd: S, meridians: &Meridians, arcs: &SkyArcs) {
        let lines = self.window.lines();
        let all = (meridians.resolution().rows() * lines) as i32;
        let zero = f32x8::splat(simd, 0.0);
        for index in (0..arcs.len()).step_by(LANES) {
            let normal = [
                arcs.load(simd, NORMAL, index),
                arcs.load(simd, NORMAL + 1, index),
                arcs.load(simd, NORMAL + 2, index),
            ];
            let (first, rows) = (arcs.load(simd, FIRST, index), arcs.load(simd, ROWS, index));
            // Away from the pole is to the left of an arc that runs counter-clockwise.
            let step = arcs.load(simd, STEP, index);
            let steps: [i32; LANES] = rows.simd_gt(zero).select(-step, step).to_int::<i32x8<S>>().into();
            let mut firsts: [i32; LANES] = (first + rows.min(zero)).to_int::<i32x8<S>>().into();
            let mut counts: [i32; LANES] = rows.abs().to_int::<i32x8<S>>().into();
            if !self.window.is_whole() {
                for (first, count) in firsts.iter_mut().zip(&mut counts) {
                    [*first, *count] = self.window.clipped(*first, *count);
                }
            }
            let across = normal[2].abs();
            let is_up = normal[2].simd_gt(zero);
            let mut live = arcs.lanes(index);
            for done in 0..all {
                for lane in 0..LANES as u32 {
                    if counts[lane as usize] <= done {
                        live &= !(1 << lane);
                    }
                }
                if live == 0 {
                    break;
                }
                let (mut cos, mut sin, mut row) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
                for lane in 0..LANES {
                    row[lane] = (firsts[lane] + done).rem_euclid(all) as usize;
                    [cos[lane], sin[lane]] = meridians.line(row[lane], lines);
                }
                let along = normal[0] * f32x8::simd_from(simd, cos) + normal[1] * f32x8::simd_from(simd, sin);
                // Without a plane at the pole.
                let place = meridians.place(simd, is_up.select(-along, along) + f32::MIN_POSITIVE, across);
                let column = place.floor();
                let fractions: [i32; LANES] = ((place - column) * HALF as f32 + 0.5).to_int::<i32x8<S>>().into();
                let columns: [i32; LANES] = column.to_int::<i32x8<S>>().into();
                let mut left = live;
                while left != 0 {
                    let lane = left.trailing_zeros() as usize & (LANES - 1);
                    left &= left - 1;
                    if self.window.has_row(row[lane] >> self.line_bits) {
                        self.put(row[lane], columns[lane] as usize, fractions[lane], steps[lane]);
                    }
                }
            }
        }
    }

    /// Draws the outline of a cone of blocked directions about a unit axis: all `v` with `axis·v ≥ cos`.
    #[inline(always)]
    pub fn draw_cone<S: Simd>(&mut self, simd: S, meridians: &Meridians, horizon: &Horizon, axis: Vec3, cos: f32) {
        // More than a hemisphere is all but the opposite cone.
        let (axis, cos, step) = if cos < 0.0 { (-axis, -cos, -2) } else { (axis, cos, 2) };
        let axis = horizon.pole().local(axis);
        let zero = f32x8::splat(simd, 0.0);
        // Decided once for all rows. Whoever holds a pole crosses each row once.
        let (has_pole, has_opposite) = (axis.z > cos, -axis.z > cos);
        let lines = self.window.lines();
        for (block, line) in self.window.blocks().flat_map(|block| (0..lines).map(move |line| (block, line))) {
            let [cos_row, sin_row] = meridians.block_of(simd, block, (line, lines));
            // The height over the cone's plane along the row: along sin θ + axis.z cos θ = R cos(θ − θ₀).
            let along = cos_row * axis.x + sin_row * axis.y;
            let beside = along * along + (axis.z * axis.z - cos * cos);
            let is_crossed = if has_pole || has_opposite {
                mask32x8::splat(simd, true)
            } else {
                beside.simd_gt(zero) & along.simd_gt(zero)
            };
            let root = beside.max(zero).sqrt();
            for (sign, step, is_drawn) in [(-1.0, step, !has_pole), (1.0, -step, !has_opposite)] {
                if !is_drawn {
                    continue;
                }
                // θ₀ ∓ acos(cos/R), times R².
                let up = axis.z * cos - along * root * sign;
                let across = (along * cos + root * (axis.z * sign)).max(zero);
                let places: [f32; LANES] = meridians.place(simd, up, across).into();
                let mut left = is_crossed.to_bitmask();
                while left != 0 {
                    let lane = left.trailing_zeros() as usize & (LANES - 1);
                    left &= left - 1;
                    self.add((block * LANES + lane) * lines + line, places[lane], step);
                }
            }
        }
    }

    /// Makes counts of differences, above a horizon, and finds the fewest.
    #[inline(always)]
    pub fn resolve<S: Simd>(&mut self, simd: S, meridians: &Meridians, horizon: &Horizon) {
        if self.crowd.is_on {
            return self.resolve_crowd(simd, meridians, horizon);
        }
        let mut low = i32x8::splat(simd, i32::MAX);
        let mut any = i32x8::splat(simd, i32::MAX);
        let (whole, zero) = (i32x8::splat(simd, (HALF << CUTS) - 1), i32x8::splat(simd, 0));
        let [start, finish] = self.window.columns();
        let mut is_open = false;
        for block in self.window.blocks() {
            let end = meridians.crossing(simd, block, horizon.local());
            let sure = end - (1.0 + MARGIN);
            // Rows that nothing crosses are as the pole is.
            let is_seen = sure.simd_ge(f32x8::splat(simd, start as f32));
            is_open |= is_seen.to_bitmask() as u8 & !self.crossed[block] != 0;
            if self.crossed[block] == 0 {
                continue;
            }
            let last = last_column(simd, end, self.columns).min(finish);
            let first = self.firsts[block] as usize;
            // Before their first outline rows are as the pole is.
            is_open |= first > start && is_seen.any_true();
            let samples = block * self.columns + first.min(last)..block * self.columns + last;
            let mut sum = zero;
            for (column, counts) in (first..).zip(&mut self.counts[samples]) {
                sum += i32x8::simd_from(simd, *counts);
                *counts = sum.into();
                if column < start {
                    continue;
                }
                let is_above = f32x8::splat(simd, column as f32).simd_le(sure);
                let is_whole = (sum & whole).simd_eq(zero);
                low = (is_above & is_whole).select(low.min(sum), low);
                any = is_above.select(any.min(sum), any);
            }
        }
        let least = |lanes: i32x8<S>| <[i32; LANES]>::from(lanes).into_iter().min().unwrap_or(0);
        let fewest = least(low);
        self.fewest = if is_open { fewest.min(0) } else { fewest };
        if self.fewest == i32::MAX {
            // Outlines pass through all samples: the fewest of which something is seen.
            self.fewest = least(any) >> CUTS << CUTS;
        }
    }

    /// The same for a crowd: its counts become the seen parts of samples, in parts of [`ONE`].
    fn resolve_crowd<S: Simd>(&mut self, simd: S, meridians: &Meridians, horizon: &Horizon) {
        let ends = |block: usize| <[f32; LANES]>::from(meridians.crossing(simd, block, horizon.local()));
        let [start, finish] = self.window.columns().map(|column| column as i32 * HALF);
        let sure = |end: f32| [start, finish.min(((end - (1.0 + MARGIN)) * HALF as f32) as i32)];
        let mut fewest = [i32::MAX; 2];
        for block in self.window.blocks() {
            let ends = ends(block);
            for line in lines_of(block, self.line_bits) {
                let end = ends[(line >> self.line_bits) % LANES];
                self.crowd.sort(line);
                for part in self.crowd.parts(line, sure(end)) {
                    let kind = usize::from(!part.is_sure());
                    fewest[kind] = fewest[kind].min(part.number);
                }
            }
        }
        let fewest = fewest.into_iter().find(|number| *number != i32::MAX).unwrap_or(0);
        // As many as counts hold.
        self.fewest = (fewest.clamp(-MOST, MOST) * HALF) << CUTS;
        self.crowd.keep_none();
        for block in self.window.blocks() {
            if self.crossed[block] == 0 {
                continue;
            }
            let ends = ends(block);
            for line in lines_of(block, self.line_bits) {
                let row = line >> self.line_bits;
                let lane = row % LANES;
                let end = ends[lane];
                let mut longest = None::<Part>;
                let [from, to] = sure(end);
                for part in self.crowd.parts(line, [start, finish]).filter(|part| part.number <= fewest) {
                    for column in part.from / HALF..=(part.to - 1) / HALF {
                        let seen = part.to.min((column + 1) * HALF) - part.from.max(column * HALF);
                        self.counts[block * self.columns + column as usize][lane] += 2 * seen;
                    }
                    let sure = Part { from: part.from.max(from), to: part.to.min(to), ..part };
                    if sure.from < sure.to && longest.is_none_or(|longest| longest.length() < sure.length()) {
                        longest = Some(sure);
                    }
                }
                self.crowd.keep(longest, row);
            }
        }
    }

    /// Whether nothing crosses any row: then all samples have the same number of surfaces before them.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.crossed.iter().all(|rows| *rows == 0)
    }

    /// Whether a block's rows have counts of their own.
    #[inline(always)]
    pub(super) fn is_crossed(&self, block: usize) -> bool {
        self.crossed[block] != 0
    }

    /// The first of the table's samples in which an outline crosses rows of a crossed block.
    #[inline(always)]
    pub(super) fn first_crossed(&self, block: usize) -> usize {
        self.firsts[block] as usize
    }

    /// The part of the light that is seen where no outline is before, if the samples with the fewest surfaces have none before them.
    #[inline(always)]
    pub(super) fn open_part(&self) -> f32 {
        ((self.fewest >> CUTS) + ONE).clamp(0, ONE) as f32 * (1.0 / ONE as f32)
    }

    /// The seen parts of eight samples of a crossed block, if those with the fewest surfaces have none before them.
    #[inline(always)]
    pub(super) fn seen<S: Simd>(&self, simd: S, block: usize, column: usize) -> f32x8<S> {
        let index = block * self.columns + column;
        let cut = i32x8::simd_from(simd, self.counts[index]);
        if self.crowd.is_on {
            return cut.to_float::<f32x8<S>>() * (1.0 / (ONE << self.line_bits) as f32);
        }
        let mut counts = cut >> CUTS;
        if self.has_folds {
            let is_shared = (cut & ((1 << CUTS) - 1)).simd_gt(i32x8::splat(simd, 1 << self.line_bits));
            counts += is_shared.select(i32x8::simd_from(simd, self.folds[index]), i32x8::splat(simd, 0));
        }
        let seen = i32x8::splat(simd, (self.fewest >> CUTS) + ONE) - counts;
        seen.max(i32x8::splat(simd, 0)).min(i32x8::splat(simd, ONE)).to_float::<f32x8<S>>() * (1.0 / ONE as f32)
    }

    /// Up to three directions, in the pole's frame, before which the fewest surfaces lie: those that are farthest from outlines. The first
    /// is always there.
    #[inline(always)]
    pub fn witnesses<S: Simd>(&mut self, simd: S, meridians: &Meridians, horizon: &Horizon) -> Witnesses {
        let mut all = Witnesses::default();
        let end =
            |row: usize| <[f32; LANES]>::from(meridians.crossing(simd, row / LANES, horizon.local()))[row % LANES];
        if self.fewest == 0
            && self.window.is_whole()
            && let Some((first, count)) = self.longest_open_run()
        {
            let rows = self.blocks * LANES;
            for part in [2, 1, 3] {
                let row = (first + count * part / 4) % rows;
                all.push(meridians.direction(row as f64 + 0.5, f64::from(end(row)) * 0.25 * f64::from(part as u32)));
            }
            return all;
        }
        if self.crowd.is_on {
            for (part, row) in self.crowd.longest() {
                let middle = f64::from(part.from + part.to) / f64::from(2 * HALF);
                all.push(meridians.direction(row as f64 + 0.5, middle));
            }
        } else {
            self.find_runs(simd, meridians, horizon);
            let mut runs: [(i32, usize); WITNESSES] = [(0, 0); WITNESSES];
            for row in self.window.blocks().flat_map(|block| block * LANES..(block + 1) * LANES) {
                let run = self.runs[row];
                if run > runs[WITNESSES - 1].0 {
                    runs[WITNESSES - 1] = (run, row);
                    runs.sort_by_key(|run| core::cmp::Reverse(run.0));
                }
            }
            for (run, row) in runs.into_iter().filter(|(run, _)| *run > 0) {
                let (length, last) = (run / RUN as i32, run % RUN as i32);
                all.push(meridians.direction(row as f64 + 0.5, f64::from(last) + 1.0 - 0.5 * f64::from(length)));
            }
        }
        if all.as_slice().is_empty() {
            all.push(horizon.local());
        }
        all
    }

    /// The longest run of rows, around, that nothing crosses: the first, and how many.
    fn longest_open_run(&self) -> Option<(usize, usize)> {
        let rows = self.blocks * LANES;
        let is_open = |row: usize| self.crossed[row % rows / LANES] >> (row % LANES) & 1 == 0;
        let Some(start) = (0..rows).find(|row| !is_open(*row)) else { return Some((0, rows)) };
        let (mut best, mut count) = ((0, 0), 0);
        for row in start..=start + rows {
            if row < start + rows && is_open(row) {
                count += 1;
            } else {
                if count > best.1 {
                    best = (row - count, count);
                }
                count = 0;
            }
        }
        (best.1 > 0).then_some(best)
    }

    /// The longest run of samples with the fewest surfaces in each row.
    #[inline(always)]
    fn find_runs<S: Simd>(&mut self, simd: S, meridians: &Meridians, horizon: &Horizon) {
        let (zero, fewest) = (i32x8::splat(simd, 0), i32x8::splat(simd, self.fewest));
        let [start, finish] = self.window.columns();
        for block in self.window.blocks() {
            let end = meridians.crossing(simd, block, horizon.local());
            let (mut run, mut best) = (zero, zero);
            if self.crossed[block] != 0 || !self.window.is_whole() {
                let last = last_column(simd, end, self.columns).min(finish);
                let counts = &self.counts[block * self.columns..][..last];
                for (column, counts) in counts.iter().enumerate().skip(start) {
                    let is_above: mask32x8<S> = f32x8::splat(simd, column as f32).simd_le(end - (1.0 + MARGIN));
                    let is_fewest = i32x8::simd_from(simd, *counts).simd_eq(fewest) & is_above;
                    run = is_fewest.select(run + RUN as i32, zero);
                    best = best.max(is_fewest.select(run + column as i32, zero));
                }
            }
            self.runs[block * LANES..][..LANES].copy_from_slice(&<[i32; LANES]>::from(best));
        }
    }
}

/// The lines of a block of rows, of which each has two to a power.
fn lines_of(block: usize, bits: u32) -> core::ops::Range<usize> {
    let lines = LANES << bits;
    block * lines..(block + 1) * lines
}

/// Adds to a count, and to the number of outlines through the sample.
#[inline(always)]
const fn add(count: &mut i32, more: i32, cuts: i32) {
    *count = count.wrapping_add((more << CUTS) + cuts);
}

/// The number of samples of which eight rows have any above their horizon.
#[inline(always)]
pub(super) fn last_column<S: Simd>(_: S, end: f32x8<S>, columns: usize) -> usize {
    let most = <[f32; LANES]>::from(end).into_iter().fold(0.0, f32::max);
    (most.ceil() as usize).min(columns - 2)
}
