//! Openings between the rows of a mask, on lines between the ends of outlines there.

use crate::project::View;
use crate::select::{STEP, Silhouettes};
use glam::{Vec2, Vec3};

/// Lines are drawn where at most this number of outlines is before the light: each line crosses all of them.
const MOST: usize = 64;

/// A piece of an outline.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// The heights of its ends.
    heights: [f32; 2],
    /// `x = s + t y`.
    line: [f32; 2],
    /// The growth of the number of surfaces to its right.
    step: i32,
}

/// Openings on lines between rows, and working memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Between {
    pieces: Vec<Piece>,
    heights: Vec<f32>,
    /// Where a line is crossed, and the growth of the number of surfaces there.
    crossed: Vec<(f32, i32)>,
    /// Intervals of lines, and how far these are from the next ones.
    pub(super) found: Vec<([Vec2; 2], f32)>,
}

impl Between {
    /// Finds the intervals of lines with the fewest surfaces that have more on both sides, if they are open. An opening that no row crosses has corners at ends of outlines: of
    /// lines halfway between each two heights of these some cross it. `stride` rows are between those that were searched; intervals are at least `narrowest` wide and end where
    /// `emitting` ends at that height.
    pub(super) fn find(
        &mut self,
        silhouettes: &Silhouettes,
        view: &View,
        [stride, narrowest]: [f32; 2],
        emitting: impl Fn(f32) -> [f32; 2],
        mut is_open: impl FnMut(Vec2) -> bool,
    ) {
        let Self { pieces, heights, crossed, found } = self;
        found.clear();
        if silhouettes.len() > MOST {
            return;
        }
        pieces.clear();
        pieces.extend((0..silhouettes.len()).filter_map(|k| {
            let end = |first: usize| Vec3::from_array(core::array::from_fn(|axis| silhouettes.get(first + axis, k)));
            let (heights, line) = view.on_plane([end(0), end(3)])?;
            Some(Piece { heights, line, step: silhouettes.get(STEP, k) as i32 })
        }));
        let (low, high) = view.corners();
        heights.clear();
        heights.extend(pieces.iter().flat_map(|piece| piece.heights).filter(|y| (low.y..high.y).contains(y)));
        heights.sort_unstable_by(f32::total_cmp);
        let row = |y: f32| ((y - low.y) * view.raster.rows - 0.5).div_euclid(stride);
        for pair in heights.windows(2) {
            let line = pair[1] - pair[0];
            // Rows between them would have crossed what is open there.
            if line < narrowest || row(pair[0]) != row(pair[1]) {
                continue;
            }
            let y = pair[0] + 0.5 * line;
            cross(pieces, y, crossed);
            let [first, last] = emitting(y);
            fewest(crossed, narrowest, |[from, to]| {
                let ends = [from.max(first), to.min(last)];
                if ends[1] - ends[0] >= narrowest && is_open(Vec2::new(0.5 * (ends[0] + ends[1]), y)) {
                    found.push((ends.map(|x| Vec2::new(x, y)), line));
                }
            });
        }
    }
}

/// Lists where a line at a height crosses outlines, from left to right.
fn cross(pieces: &[Piece], y: f32, out: &mut Vec<(f32, i32)>) {
    out.clear();
    out.extend(pieces.iter().filter_map(|Piece { heights: [from, to], line: [start, slope], step }| {
        let is_up = *from <= y;
        (is_up == (*to > y)).then_some((start + slope * y, if is_up { *step } else { -step }))
    }));
    out.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
}

/// Calls `each` for the intervals with the fewest surfaces among those between two crossings that are at least this wide: where outlines coincide, the number falls and rises at once.
fn fewest(crossed: &[(f32, i32)], narrowest: f32, mut each: impl FnMut([f32; 2])) {
    let intervals = || {
        let numbers = crossed.windows(2).scan(0, |number, pair| {
            *number += pair[0].1;
            Some((*number, [pair[0].0, pair[1].0]))
        });
        numbers.filter(|(_, [from, to])| to - from >= narrowest)
    };
    // Left of all crossings the number is 0, right of them it is their sum.
    let beside = crossed.iter().map(|(_, step)| step).sum::<i32>().min(0);
    if let Some(least) = intervals().map(|(number, _)| number).min()
        && least < beside
    {
        intervals().filter(|(number, _)| *number == least).for_each(|(_, ends)| each(ends));
    }
}
