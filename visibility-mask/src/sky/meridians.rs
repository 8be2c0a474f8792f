use super::{Horizon, Pole, SkyWindow};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::{DVec3, Vec3};
use lobe_core::vec3x8::{LANES, Vec3x8};

/// A little more than 1, for the rounding of a box's sides.
pub(crate) const AROUND: f32 = 1.000_01;
/// `|x| + |y|` is at most as many times the distance as the inverse of this.
pub(crate) const DIAGONAL: f32 = 0.707;
/// Rounding of azimuth numbers.
pub(crate) const SPREAD: f32 = 1e-5;

/// Directions around a receiver: half great circles from a pole to the opposite one, and samples along each.
///
/// A meridian is the middle of a wedge of directions. Wedges are of equal width in the *azimuth number* `p` in −2…2, samples in the
/// *elevation number* `e` in 1…−1, which need no arc tangents:
///
/// ```text
/// p = y/(|x| + |y|), 2 − p behind (x < 0, y ≥ 0), −2 − p (x < 0, y < 0)      e = z/(√(x² + y²) + |z|)
/// ```
///
/// Both are monotone in their angles; steps are 0.64 to 1.28 times the mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Meridians {
    resolution: SkyResolution,
    /// Cosine and sine of each meridian's azimuth.
    circle: Vec<[f32; 2]>,
    /// The same of the lines that stand for it.
    lines: Vec<[f32; 2]>,
}

/// How many meridians there are, how many samples on each, and on how many half circles in the wedge of each outlines are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SkyResolution {
    rows: usize,
    samples: usize,
    lines: usize,
}

/// The most lines of a meridian. Under narrow lobes an edge along meridians would move by whole wedges.
pub(super) const LINES: usize = 4;

/// The most meridians that are worth it.
const ROWS_FOR_LITTLE: usize = 256;

impl SkyResolution {
    /// The most of both.
    pub const MOST: [usize; 2] = [1024, 512];

    /// So many of both: multiples of 8 up to the [most](Self::MOST), to which other numbers are rounded.
    #[must_use]
    pub const fn new(rows: usize, samples: usize) -> Self {
        Self { rows: even(rows, Self::MOST[0]), samples: even(samples, Self::MOST[1]), lines: 1 }
    }

    /// The next finer resolution, for narrow lobes: a quarter of the pitch, and four lines for each meridian. None from the finest on.
    #[must_use]
    pub fn finer(self) -> Option<Self> {
        let finer = Self::new(4 * self.rows, (2 * self.rows).max(2 * self.samples));
        (finer.rows > self.rows).then_some(Self { lines: LINES, ..finer })
    }

    /// The finer one through which diffuse receivers look that see little of a sky. None where masks of its patches cost less.
    #[must_use]
    pub fn for_little(self) -> Option<Self> {
        self.finer().filter(|finer| finer.rows <= ROWS_FOR_LITTLE)
    }

    /// The resolution for a tolerance, a part of the unshadowed radiance.
    #[must_use]
    pub fn of_tolerance(tolerance: f32) -> Self {
        if tolerance >= 0.01 {
            Self::new(32, 64)
        } else if tolerance >= 0.005 {
            Self::new(64, 64)
        } else if tolerance >= 0.003 {
            Self::new(128, 64)
        } else {
            Self::new(256, 128)
        }
    }

    /// Meridians.
    #[must_use]
    pub const fn rows(self) -> usize {
        self.rows
    }

    /// Half great circles on which outlines are drawn in the wedge of each meridian, evenly, through windows that are not whole.
    #[must_use]
    pub const fn lines(self) -> usize {
        self.lines
    }

    /// Samples on each.
    #[must_use]
    pub const fn samples(self) -> usize {
        self.samples
    }

    /// The mean angle between two meridians at right angles to the pole, in radians.
    #[must_use]
    pub fn pitch(self) -> f32 {
        core::f32::consts::TAU / self.rows as f32
    }

    /// The longest chord from the middle of a run of samples of a row to any direction in it, and another such chord within one sample.
    pub(super) fn chord(self, samples: usize) -> f32 {
        // Twice as long as the mean, where a row or a height is half way between two axes.
        let [along, across] = [4.0 / self.samples as f32, 8.0 / self.rows as f32];
        0.5 * along * samples as f32 + along.hypot(across)
    }

    /// Rows that are kept side by side.
    pub(crate) const fn blocks(self) -> usize {
        self.rows / LANES
    }
}

const fn even(count: usize, most: usize) -> usize {
    let count = count.next_multiple_of(LANES);
    if count < LANES {
        LANES
    } else if count > most {
        most
    } else {
        count
    }
}

/// Cosine and sine of an azimuth by its number.
pub(super) fn circle(p: f64) -> [f64; 2] {
    let y = if p > 1.0 {
        2.0 - p
    } else if p < -1.0 {
        -2.0 - p
    } else {
        p
    };
    let x = 1.0 - y.abs();
    let length = x.hypot(y);
    [if p.abs() > 1.0 { -x } else { x } / length, y / length]
}

/// Sine and cosine of the angle to the pole by the elevation's number.
pub(super) fn elevation(e: f64) -> [f64; 2] {
    let across = 1.0 - e.abs();
    let length = across.hypot(e);
    [across / length, e / length]
}

impl Meridians {
    /// Of a resolution.
    #[must_use]
    pub fn new(resolution: SkyResolution) -> Self {
        let all = |rows: usize| (0..rows).map(|j| circle(row_number(j as f64 + 0.5, rows)).map(|x| x as f32)).collect();
        Self { resolution, circle: all(resolution.rows), lines: all(resolution.rows * resolution.lines()) }
    }

    /// Their number.
    #[must_use]
    pub const fn resolution(&self) -> SkyResolution {
        self.resolution
    }

    /// The unit direction, in the pole's frame, of a place in rows and samples: `(j + ½, i + ½)` is the middle of sample i of row j.
    #[must_use]
    pub fn direction(&self, row: f64, sample: f64) -> Vec3 {
        let [cos, sin] = circle(row_number(row, self.resolution.rows));
        let [across, up] = elevation(1.0 - 2.0 * sample / self.resolution.samples as f64);
        DVec3::new(cos * across, sin * across, up).as_vec3()
    }

    /// Cosine and sine of the azimuth of a line, for a number of lines in each row.
    #[inline(always)]
    pub(super) fn line(&self, line: usize, lines: usize) -> [f32; 2] {
        if lines == 1 { self.circle[line] } else { self.lines[line] }
    }

    /// Cosine and sine of a row's azimuth.
    #[inline(always)]
    pub(crate) fn row(&self, row: usize) -> [f32; 2] {
        self.circle[row]
    }

    /// The same of the eight rows of a block.
    #[inline(always)]
    pub(crate) fn block<S: Simd>(&self, simd: S, block: usize) -> [f32x8<S>; 2] {
        self.block_of(simd, block, (0, 1))
    }

    /// The same of one line of each of these rows, for a number of lines in each.
    #[inline(always)]
    pub(super) fn block_of<S: Simd>(&self, simd: S, block: usize, (line, lines): (usize, usize)) -> [f32x8<S>; 2] {
        let (mut cos, mut sin) = ([0.0; LANES], [0.0; LANES]);
        for (lane, (cos, sin)) in cos.iter_mut().zip(&mut sin).enumerate() {
            [*cos, *sin] = self.line((block * LANES + lane) * lines + line, lines);
        }
        [f32x8::simd_from(simd, cos), f32x8::simd_from(simd, sin)]
    }

    /// How many lines lie before eight vectors, of which x and y in the pole's frame are given, for a number of lines in each row: from 0 to all, where 0 and all are the
    /// same place.
    #[inline(always)]
    pub(crate) fn lines_before<S: Simd>(&self, simd: S, x: f32x8<S>, y: f32x8<S>, lines: usize) -> f32x8<S> {
        self.before(simd, azimuth(simd, x, y), lines)
    }

    /// The same of azimuth numbers.
    #[inline(always)]
    fn before<S: Simd>(&self, _: S, azimuth: f32x8<S>, lines: usize) -> f32x8<S> {
        let scale = (self.resolution.rows * lines) as f32 * 0.25;
        ((azimuth + 2.0) * scale - 0.5).ceil()
    }

    /// Which of eight ranges of azimuth numbers hold a line of any kind of window.
    #[inline(always)]
    fn has_line<S: Simd>(&self, simd: S, low: f32x8<S>, high: f32x8<S>) -> mask32x8<S> {
        let crosses = !self.before(simd, low, 1).simd_eq(self.before(simd, high, 1));
        if self.resolution.lines == 1 {
            return crosses;
        }
        let lines = self.resolution.lines;
        crosses | !self.before(simd, low, lines).simd_eq(self.before(simd, high, lines))
    }

    /// Which of eight edges may cross a line, whatever the window, for receivers that are within `off` of the place that the edges are seen from, at right
    /// angles to the pole.
    #[inline(always)]
    pub fn may_cross<S: Simd>(&self, simd: S, horizon: &Horizon, ends: [Vec3x8<S>; 2], off: f32x8<S>) -> mask32x8<S> {
        let (p, s) = spread(simd, horizon.pole(), ends[0], off);
        let (q, t) = spread(simd, horizon.pole(), ends[1], off);
        self.has_line(simd, (p - s).min(q - t), (p + s).max(q + t))
    }

    /// Which of eight boxes may hold edges that cross a line of a window for receivers that are within `off` of the place from which their middles are seen, at
    /// right angles to the pole; half the boxes' sides. Of the whole window: or any line, whatever the window.
    #[inline(always)]
    pub fn may_cross_boxes<S: Simd>(
        &self,
        simd: S,
        (horizon, window): (&Horizon, &SkyWindow),
        middle: Vec3x8<S>,
        (half, off): (Vec3x8<S>, f32),
    ) -> mask32x8<S> {
        // No wider than a circle around the box, seen along the pole.
        let off = horizon.pole().reach_of(half) * AROUND + off;
        let (p, s) = spread(simd, horizon.pole(), middle, off);
        let (low, high) = (p - s, p + s);
        if window.is_whole() {
            return self.has_line(simd, low, high);
        }
        let [first, last] = [self.before(simd, low, window.lines()), self.before(simd, high, window.lines())];
        !first.simd_eq(last) & window.meets(first, last)
    }

    /// Where on their rows eight directions are, in samples from the pole: z of the pole's frame, and the distance from its axis.
    #[inline(always)]
    pub(crate) fn place<S: Simd>(&self, simd: S, z: f32x8<S>, across: f32x8<S>) -> f32x8<S> {
        let samples = self.resolution.samples as f32;
        let e = z / (across + z.abs()).max(f32x8::splat(simd, f32::MIN_POSITIVE));
        let place = (0.5 - e * 0.5) * samples;
        place.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, samples))
    }

    /// Where the eight rows of a block cross a plane through the receiver whose unit normal, in the pole's frame, is on the pole's side.
    #[inline(always)]
    pub(crate) fn crossing<S: Simd>(&self, simd: S, block: usize, normal: Vec3) -> f32x8<S> {
        let [cos, sin] = self.block(simd, block);
        self.place(simd, -(cos * normal.x + sin * normal.y), f32x8::splat(simd, normal.z))
    }
}

/// The azimuth number of a place among so many rows.
pub(super) fn row_number(row: f64, rows: usize) -> f64 {
    row * 4.0 / rows as f64 - 2.0
}

/// The azimuth numbers of eight vectors, and how much they change within `off` of the receiver.
#[inline(always)]
fn spread<S: Simd>(simd: S, pole: Pole, v: Vec3x8<S>, off: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
    let [x, y, _] = pole.frame();
    let (x, y) = (v.dot_one(x), v.dot_one(y));
    // No longer than the distance. The azimuth number turns no faster than the azimuth.
    let (wide, high) = (x.abs(), y.abs());
    let distance = wide.max(high).max((wide + high) * DIAGONAL) - off;
    let spread = distance.simd_gt(f32x8::splat(simd, 0.0)).select(off / distance, f32x8::splat(simd, 4.0));
    (azimuth(simd, x, y), spread + SPREAD)
}

/// The azimuth number of eight vectors; 0 of those along the axis.
#[inline(always)]
fn azimuth<S: Simd>(simd: S, x: f32x8<S>, y: f32x8<S>) -> f32x8<S> {
    let zero = f32x8::splat(simd, 0.0);
    let p = y / (x.abs() + y.abs()).max(f32x8::splat(simd, f32::MIN_POSITIVE));
    let behind = y.simd_lt(zero).select(f32x8::splat(simd, -2.0), f32x8::splat(simd, 2.0)) - p;
    x.simd_lt(zero).select(behind, p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use lobe_core::oracle::Random;

    /// Sample middles lie on their rows, and rows before a direction are counted right, against arc tangents.
    #[test]
    fn directions_are_counted_as_by_angles() {
        let meridians = Meridians::new(SkyResolution::new(64, 64));
        let mut random = Random::new(5);
        for _ in 0..2000 {
            let v = random.axis().as_vec3();
            let (rows, place) = dispatch!(Level::new(), simd => {
                let [x, y, z] = v.to_array().map(|c| f32x8::splat(simd, c));
                let rows: [f32; 8] = meridians.lines_before(simd, x, y, 1).into();
                let place: [f32; 8] = meridians.place(simd, z, (x * x + y * y).sqrt()).into();
                (rows[0], place[0])
            });
            let angle = |j: usize| {
                let [cos, sin] = meridians.row(j);
                f64::from(sin).atan2(f64::from(cos))
            };
            let want = (0..64).filter(|j| angle(*j) < f64::from(v.y).atan2(f64::from(v.x))).count();
            assert_eq!(rows as usize, want, "{v}");
            let back = meridians.direction(f64::from(rows), f64::from(place));
            assert!((back.z - v.z).abs() < 1e-5, "{v} {back}");
        }
    }

    /// Points of a box that no meridian is said to cross lie between the same rows.
    #[test]
    fn boxes_between_meridians_are_crossed_by_none() {
        let meridians = Meridians::new(SkyResolution::new(64, 64));
        let whole = SkyWindow::whole(meridians.resolution());
        let mut random = Random::new(9);
        let mut between = 0;
        for case in 0..4000 {
            let pole = Pole::ALL[case % 6];
            let up = pole.world(Vec3::Z);
            let horizon = Horizon::new(&lobe_core::Receiver::on_surface(Vec3::ZERO, up, up), false);
            let middle = random.axis().as_vec3();
            let size = random.log_uniform(1e-3, 1.0) as f32;
            let half = random.axis().as_vec3().abs() * size;
            dispatch!(Level::new(), simd => {
                let boxes = [middle, half].map(|v| Vec3x8::splat(simd, v));
                let may = meridians.may_cross_boxes(simd, (&horizon, &whole), boxes[0], (boxes[1], 0.0));
                if may.any_true() {
                    return;
                }
                between += 1;
                let place = |v: Vec3| -> f32 {
                    let v = pole.local_of(Vec3x8::splat(simd, v));
                    let rows: [f32; 8] = meridians.lines_before(simd, v.x, v.y, 1).into();
                    rows[0] % 64.0
                };
                for corner in 0..8 {
                    let sign = [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 });
                    let p = middle + half * Vec3::from_array(sign);
                    assert_eq!(place(p), place(middle), "case {case}: {middle} {half}");
                }
            });
        }
        assert!((1000..3000).contains(&between), "{between}");
    }

    /// Wedges have the solid angles that are said of them.
    #[test]
    fn steps_are_nearly_even() {
        let n = 64;
        let angle = |p: f64| {
            let [cos, sin] = circle(p);
            sin.atan2(cos)
        };
        let steps: Vec<f64> = (0..n)
            .map(|j| angle(row_number(j as f64 + 1.0, n)) - angle(row_number(j as f64, n)))
            .map(|step| step.rem_euclid(core::f64::consts::TAU) * n as f64 / core::f64::consts::TAU)
            .collect();
        assert!(steps.iter().all(|step| (0.63..1.28).contains(step)), "{steps:?}");
    }
}
