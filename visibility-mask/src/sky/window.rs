use super::SkyResolution;
use core::f32::consts::{FRAC_PI_2, PI};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;
use lobe_core::vec3x8::LANES;

/// A part of a sky's samples: some of the rows, around the pole and in blocks of eight, and a range of the samples of each.
///
/// The default is nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkyWindow {
    /// The first block, how many follow it around, and how many there are.
    first: usize,
    count: usize,
    all: usize,
    columns: [usize; 2],
    /// Lines of each row.
    lines: usize,
    is_whole: bool,
}

impl SkyWindow {
    /// All samples.
    #[must_use]
    pub const fn whole(resolution: SkyResolution) -> Self {
        // The end of the last sample is a place of its own.
        let columns = [0, resolution.samples() + 1];
        let count = resolution.blocks();
        Self { first: 0, count, all: count, columns, lines: 1, is_whole: true }
    }

    /// Those that are within an angle of a unit direction in the pole's frame, and some more; each row by as many lines as the resolution has.
    #[must_use]
    pub fn around(resolution: SkyResolution, direction: Vec3, angle: f32) -> Self {
        let whole = Self { lines: resolution.lines(), is_whole: false, ..Self::whole(resolution) };
        let across = direction.truncate().length();
        let polar = across.atan2(direction.z);
        let place = |polar: f32| {
            let (sin, cos) = polar.clamp(0.0, PI).sin_cos();
            (0.5 - 0.5 * cos / (sin.abs() + cos.abs())) * resolution.samples() as f32
        };
        let columns = [
            place(polar - angle).floor().max(0.0) as usize,
            (place(polar + angle).ceil() as usize).min(resolution.samples()) + 1,
        ];
        let beside = angle.sin() / across;
        if angle >= FRAC_PI_2 || polar <= angle || polar >= PI - angle || beside >= 1.0 || beside.is_nan() {
            return Self { columns, ..whole };
        }
        let (turn, azimuth) = (beside.asin(), direction.y.atan2(direction.x));
        let row = |azimuth: f32| {
            let (sin, cos) = azimuth.sin_cos();
            let p = sin / (sin.abs() + cos.abs());
            let p = if cos >= 0.0 { p } else { (2.0 - p.abs()).copysign(p) };
            (p + 2.0) * 0.25 * resolution.rows() as f32
        };
        let all = whole.all as f32;
        let block = |azimuth: f32| row(azimuth) / LANES as f32;
        // A little more on both sides than rounding might miss.
        let begin = (block(azimuth - turn) - 0.01).rem_euclid(all);
        let length = (block(azimuth + turn) + 0.01 - begin).rem_euclid(all);
        let first = begin.floor() as usize % whole.all;
        let count = (begin - begin.floor() + length).floor() as usize + 1;
        if count >= whole.all {
            return Self { columns, ..whole };
        }
        Self { first, count, columns, ..whole }
    }

    /// Whether it is made as all samples.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// On so many half circles of each row outlines are drawn.
    #[inline(always)]
    pub(super) const fn lines(&self) -> usize {
        self.lines
    }

    /// Its blocks of rows.
    pub(super) fn blocks(&self) -> impl Iterator<Item = usize> + use<> {
        let all = self.all;
        (self.first..self.first + self.count).map(move |block| if block >= all { block - all } else { block })
    }

    /// The first of its samples on each row, and the first that is none.
    #[inline(always)]
    pub(super) const fn columns(&self) -> [usize; 2] {
        self.columns
    }

    #[inline(always)]
    pub(super) const fn has_row(&self, row: usize) -> bool {
        let block = row / LANES;
        let beyond = if block >= self.first { block - self.first } else { block + self.all - self.first };
        beyond < self.count
    }

    /// Which of eight runs of lines hold any in the window. A run goes from its first line to before its end, whose numbers go on around the pole.
    #[inline(always)]
    pub(super) fn meets<S: Simd>(&self, first: f32x8<S>, end: f32x8<S>) -> mask32x8<S> {
        let [begin, len, all] = [self.first, self.count, self.all].map(|blocks| (blocks * LANES * self.lines) as f32);
        let start = first - begin;
        let start = start - (start / all).floor() * all;
        // Into the window, or round and into it again.
        start.simd_lt(len) | (start + (end - first)).simd_gt(all)
    }

    /// Of so many lines from a first one on, counted around the pole, a run that holds those in the window: its first line and how many.
    #[inline(always)]
    pub(super) fn clipped(&self, first: i32, count: i32) -> [i32; 2] {
        let [begin, len, all] = [self.first, self.count, self.all].map(|blocks| (blocks * LANES * self.lines) as i32);
        let start = (first - begin).rem_euclid(all);
        let end = start + count;
        match (start < len, end > all) {
            // Into the window, round, and into it again.
            (true, true) => [first, count],
            (true, false) => [first, end.min(len) - start],
            (false, true) => [begin, (end - all).min(len)],
            (false, false) => [first, 0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Meridians;
    use super::*;
    use fearless_simd::{Level, dispatch};
    use lobe_core::oracle::Random;

    /// Each sample within the angle is in the window, and a window is not much larger than its cone.
    #[test]
    fn windows_hold_their_cones() {
        let resolution = SkyResolution::new(256, 128);
        let meridians = Meridians::new(resolution);
        let mut random = Random::new(3);
        let mut part = 0.0;
        for _ in 0..200 {
            let axis = random.axis().as_vec3();
            let angle = random.between(0.02, 1.8) as f32;
            let window = SkyWindow::around(resolution, axis, angle);
            let [first, last] = window.columns();
            let mut count = 0;
            for row in 0..resolution.rows() {
                for sample in 0..resolution.samples() {
                    let is_in = window.has_row(row) && (first..last).contains(&sample);
                    let v = meridians.direction(row as f64 + 0.5, sample as f64 + 0.5);
                    assert!(is_in || v.dot(axis) < angle.cos(), "{axis} {angle}: {row} {sample}");
                    count += usize::from(is_in);
                }
            }
            let blocks: Vec<usize> = window.blocks().collect();
            assert!((0..resolution.rows()).all(|row| window.has_row(row) == blocks.contains(&(row / LANES))));
            if axis.z.abs() < 0.5 && angle < 0.5 {
                part += count as f32 / (0.5 * (1.0 - angle.cos()) * (256.0 * 128.0)) / 200.0;
            }
        }
        assert!(part < 1.0, "{part}");
    }

    /// Runs of lines lose none in the window, and none are counted twice.
    #[test]
    fn runs_are_clipped_to_the_window() {
        for (window, all) in windows() {
            for (start, len) in (-70..70).flat_map(|start| (0..=all).map(move |len| (start, len))) {
                let kept = |first: i32, count: i32| -> Vec<i32> {
                    let lines = (first..first + count).map(|line| line.rem_euclid(all));
                    let mut lines: Vec<i32> =
                        lines.filter(|line| window.has_row(*line as usize / window.lines)).collect();
                    lines.sort_unstable();
                    lines
                };
                let [a, b] = window.clipped(start, len);
                assert_eq!(kept(a, b), kept(start, len), "{window:?} {start} {len}: {a} {b}");
            }
        }
    }

    /// Runs meet the window if any of their lines is in it, whichever numbers they have.
    #[test]
    fn runs_that_meet_the_window_have_lines_in_it() {
        for (window, all) in windows() {
            for (start, len) in (-70..70).flat_map(|start| (1..=2 * all).map(move |len| (start, len))) {
                let is_in = |line: i32| window.has_row(line.rem_euclid(all) as usize / window.lines);
                let wanted = (start..start + len).any(is_in);
                let meets = dispatch!(Level::new(), simd => {
                    let [first, end] = [start, start + len].map(|line| f32x8::splat(simd, line as f32));
                    window.meets(first, end).any_true()
                });
                assert_eq!(meets, wanted, "{window:?} {start} {len}");
            }
        }
    }

    /// Windows of 64 rows, of one line each and of several, and how many lines there are.
    fn windows() -> impl Iterator<Item = (SkyWindow, i32)> {
        let all = [1, 4].map(|lines| [(0, 3), (6, 4), (2, 8), (5, 1)].map(|(first, count)| (first, count, lines)));
        all.into_iter().flatten().map(|(first, count, lines)| {
            let window = SkyWindow { first, count, all: 64 / LANES, columns: [0, 1], lines, is_whole: false };
            (window, 64 * lines as i32)
        })
    }
}
