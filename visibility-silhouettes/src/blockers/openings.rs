//! Openings between the samples of a mask, from the crossings of outlines with its rows.

use super::{SilhouetteBlockers, SilhouetteScratch};
use crate::project::{Crossing, View};
use core::ops::Range;
use glam::Vec2;
use shading::VisibilityQuery;
use visibility_mask::{Mask, Raster};

/// Openings between samples are marked if they are more than 1/HIDDEN of the lit samples.
const HIDDEN: f32 = 128.0;
/// Masks do not measure the lit part if they are more than 1/MUCH of these.
const MUCH: f32 = 4.0;

/// An interval of a row with the fewest surfaces before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opening {
    pub(crate) row: usize,
    /// Its ends, in samples without the row's shift.
    pub(crate) ends: [f32; 2],
}

impl Opening {
    pub(crate) fn width(&self) -> f32 {
        self.ends[1] - self.ends[0]
    }

    /// Whether there is a sample in it.
    pub(crate) fn is_seen(&self, raster: &Raster) -> bool {
        let [from, to] = self.ends.map(|at| raster.index(at - Raster::shift(self.row)));
        from < to
    }
}

/// Openings are looked for in one of so many rows of a mask.
pub(crate) fn stride(rows: usize) -> usize {
    (rows / LINES).max(1)
}

/// Rows in which openings are looked for.
const LINES: usize = 32;

/// Intervals of rows between outlines.
#[derive(Clone, Debug, Default)]
pub(crate) struct Openings {
    found: Vec<Opening>,
    /// The crossings by their first rows, and those of one row with their positions, from left to right.
    order: Vec<u32>,
    active: Vec<(f32, u32)>,
}

/// Sorts the crossings of a row from left to right; returns by how much the number of surfaces falls at those where it does.
fn sort(active: &mut [(f32, u32)], crossings: &[Crossing], row: usize) -> i32 {
    let mut falls = 0;
    for (at, k) in &mut *active {
        let c = &crossings[*k as usize];
        *at = c.at(row);
        falls += (-c.step).max(0);
    }
    // The order changes little from row to row, but where they are many.
    let mut moves = MOVES * active.len();
    for i in 0..active.len() {
        let moved = active[i];
        let mut j = i;
        while j > 0 && active[j - 1].0 > moved.0 {
            active[j] = active[j - 1];
            j -= 1;
        }
        active[j] = moved;
        if i - j > moves {
            // Both ways leave equal ones in the order in which they were.
            active.sort_by(|a, b| a.0.total_cmp(&b.0));
            break;
        }
        moves -= i - j;
    }
    falls
}

/// Moves for each crossing of a row beyond which another way to sort them is faster.
const MOVES: usize = 6;

impl Openings {
    /// The intervals with the fewest surfaces among those that are at least `narrowest` samples wide, in the emitting samples of each row. `starts` has the numbers of surfaces left of all crossings, as
    /// [`Counter::start`](crate::count::Counter::start) returns them.
    pub(crate) fn find(
        &mut self,
        view: &View,
        crossings: &[Crossing],
        starts: &[u32],
        emitting: impl Fn(usize) -> Range<u32>,
        narrowest: f32,
    ) -> &mut Vec<Opening> {
        let Self { found, order, active } = self;
        found.clear();
        active.clear();
        order.clear();
        order.extend((0..).zip(crossings).filter(|(_, c)| c.step != 0 && c.rows[0] < c.rows[1]).map(|(k, _)| k));
        order.sort_unstable_by_key(|k| crossings[*k as usize].rows[0]);
        let mut rest = &order[..];
        let mut least = i32::MAX;
        for (row, start) in starts[..view.rows].iter().enumerate().step_by(stride(view.rows)) {
            let line = row as i32;
            active.retain(|(_, k)| crossings[*k as usize].rows[1] > line);
            while let [k, others @ ..] = rest
                && crossings[*k as usize].rows[0] <= line
            {
                active.push((0.0, *k));
                rest = others;
            }
            let emits = emitting(row);
            if emits.is_empty() {
                continue;
            }
            let mut number = start.cast_signed() + sort(active, crossings, row);
            let [first, last] = [emits.start, emits.end].map(|sample| sample as f32 + Raster::shift(row));
            let mut from = first;
            for i in 0..=active.len() {
                let (to, step) = match active.get(i) {
                    Some((at, k)) => (at.clamp(first, last), crossings[*k as usize].step),
                    None => (last, 0),
                };
                if number <= least && to - from >= narrowest {
                    if number < least {
                        found.clear();
                        least = number;
                    }
                    found.push(Opening { row, ends: [from, to] });
                }
                number += step;
                from = to;
            }
        }
        found
    }
}

impl SilhouetteBlockers<'_> {
    /// Marks openings that are between the samples of a mask's rows, and those that are lower than a row.
    pub(super) fn mark(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut SilhouetteScratch,
        mask: &mut Mask,
        narrowest: f32,
    ) {
        let (of_rows, hidden) = self.list_hidden(query, scratch, mask, narrowest);
        if HIDDEN * hidden > mask.lit_count() as f32 {
            let (rows, columns) = scratch.marks.split_at(of_rows);
            let lines = stride(mask.side()) as f32 * mask.cell();
            rows.iter().for_each(|ends| mask.mark_opening(*ends, lines.y));
            columns.iter().for_each(|ends| mask.mark_opening(*ends, lines.x));
        }
    }

    /// Whether openings between the samples of a mask's rows, or between its rows, are more than a part of its lit samples.
    pub(super) fn hides_openings(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut SilhouetteScratch,
        mask: &Mask,
        narrowest: f32,
    ) -> bool {
        let (_, hidden) = self.list_hidden(query, scratch, mask, narrowest);
        MUCH * hidden > mask.lit_count() as f32
    }

    /// Lists the openings between the samples of a mask's rows, and then those in its columns that are lower than a row. Returns the number of the first ones, and how many samples
    /// all would have.
    fn list_hidden(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut SilhouetteScratch,
        mask: &Mask,
        narrowest: f32,
    ) -> (usize, f32) {
        let raster = mask.raster();
        scratch.marks.clear();
        self.open_between(query, scratch, mask, narrowest, |_, opening| !opening.is_seen(&raster));
        let of_rows = scratch.marks.len();
        let turned = scratch.turned_mask(query, mask, mask.depth());
        self.open_between(query, scratch, &turned, narrowest, |view, opening| {
            // Rows count all of a lower one, or nothing.
            opening.width() * raster.rows < view.raster.samples
        });
        scratch.turned = turned;
        let (rows, columns) = scratch.marks.split_at_mut(of_rows);
        columns.iter_mut().for_each(|ends| *ends = ends.map(|p| Vec2::new(-p.y, p.x)));
        let samples = rows.iter().map(|[from, to]| (to.x - from.x) * raster.samples).sum::<f32>()
            + columns.iter().map(|[from, to]| (to.y - from.y).abs() * raster.rows).sum::<f32>() * raster.width
                / mask.side() as f32;
        (of_rows, stride(mask.side()) as f32 * samples)
    }

    /// Lists those openings between the outlines in a mask's rows that a test keeps.
    fn open_between(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut SilhouetteScratch,
        mask: &Mask,
        narrowest: f32,
        is_hidden: impl Fn(&View, &Opening) -> bool,
    ) {
        let mut view = scratch.view(query, mask);
        let light = scratch.project_outlines(query, &mut view);
        let SilhouetteScratch { crossings, counter, openings, marks, facet, origin, hits, .. } = scratch;
        let facet = facet.map(|face| mask.square().local(face));
        let emitting = |row: usize| {
            let (from, to) = facet.map_or_else(|| mask.emitting(row), |n| mask.emitting_above(n, row));
            from..to
        };
        // Between surfaces that all end, or all begin, there is no opening.
        if !(crossings.iter().any(|c| c.step < 0) && crossings.iter().any(|c| c.step > 0)) {
            return;
        }
        let starts = counter.start(crossings, view.rows.div_ceil(8));
        let found = openings.find(&view, crossings, &starts, emitting, narrowest * view.raster.samples);
        found.retain(|opening| is_hidden(&view, opening));
        // All have the same number of surfaces.
        let Some(widest) = found.iter().max_by(|a, b| a.width().total_cmp(&b.width())) else { return };
        let ray = view.ray_at(widest.row, 0.5 * (widest.ends[0] + widest.ends[1]));
        if self.is_open(ray, light, *origin, hits) {
            marks.extend(found.iter().map(|opening| opening.ends.map(|at| view.point(opening.row, at))));
        }
    }
}
