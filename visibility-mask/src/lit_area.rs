//! The lit part of a window as trapezoids of exact area.

use crate::lit_sums::Focus;
use crate::{Mask, Raster, UnitSquare};
use glam::{Vec2, Vec3};
use lobe_core::LightImage;

/// Pieces of a window's width: each has two points, so that there are as many as columns of a fine mask.
const PIECES: f32 = 16.0;
/// At most, where a light shows an image.
const MOST_PIECES: f32 = 48.0;

/// The size of parts about a peak, in its widths or in distances from it.
const PART: f32 = 0.7;

/// Half the distance of the two points of Gauss and Legendre's rule, in lengths of their piece.
const GAUSS: f32 = 0.288_675_13;

/// The lit part of a window, which blockers with exact outlines find: trapezoids of its plane. [`Blockers::find_lit`](crate::Blockers::find_lit) fills it.
///
/// The area is exact. A lobe is integrated over parts of the trapezoids that grow with the distance from its peak: it is taken to be a polynomial of third order in each. Diffuse ones before an
/// image are over points at even distances, of which a window has 32 to 96 a row.
#[derive(Clone, Debug)]
pub struct LitArea {
    /// Of a window's width.
    pieces: f32,
    shows_image: bool,
    /// `x`, `y`, area.
    points: Vec<Vec3>,
    trapezoids: Vec<Trapezoid>,
    hidden: Vec<[Vec2; 2]>,
    /// Whether it ends at the light's own outline.
    is_ordinary: bool,
    /// The box in which alone it matters what is hidden: from, to.
    looked_at: Option<[Vec2; 2]>,
}

impl Default for LitArea {
    fn default() -> Self {
        Self {
            pieces: PIECES,
            shows_image: false,
            points: Vec::new(),
            trapezoids: Vec::new(),
            hidden: Vec::new(),
            is_ordinary: false,
            looked_at: None,
        }
    }
}

impl LitArea {
    /// Begins again. Rows have as many points as an image has texels there, from 32 to 96.
    pub(crate) fn begin(&mut self, image: Option<&LightImage>, is_ordinary: bool, shows_image: bool) {
        self.is_ordinary = is_ordinary;
        self.shows_image = shows_image;
        self.pieces = image.map_or(PIECES, |image| (0.5 * image.texels() as f32).clamp(PIECES, MOST_PIECES));
        self.truncate(0);
        self.clear_hidden();
    }

    /// Whether the lit part ends at the light's own outline, as in an ordinary penumbra, so that masks around it measure it as well.
    #[must_use]
    pub const fn is_ordinary(&self) -> bool {
        self.is_ordinary
    }

    /// Rows of a window in which its pieces are at most one row high.
    #[must_use]
    pub fn rows(&self) -> u32 {
        2 * self.pieces as u32
    }

    /// Whether the light shows an image: parts are to be cut along rows then.
    #[must_use]
    pub const fn shows_image(&self) -> bool {
        self.shows_image
    }

    /// Lets only those parts be hidden that may meet the lit one, whose points are those from one on.
    pub(crate) fn look_at(&mut self, start: usize, window: &UnitSquare) {
        let none = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        let around = |[low, high]: [Vec2; 2], p: &Vec3| [low.min(p.truncate()), high.max(p.truncate())];
        let [low, high] = self.points[start..].iter().fold(none, around);
        // No point is farther from the rim of its piece.
        let more = Vec2::splat(2.0 / PIECES * window.half.max_element());
        self.looked_at = Some([low - more, high + more]);
    }

    /// Adds the sides of a part of a window that other blockers hide, by its corners in plane coordinates. [`Blockers::find_lit`](crate::Blockers::find_lit) leaves it out.
    pub fn hide(&mut self, corners: &[Vec2]) {
        let none = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        let [low, high] = corners.iter().fold(none, |[low, high], p| [low.min(*p), high.max(*p)]);
        if self.looked_at.is_some_and(|[from, to]| low.cmpgt(to).any() || high.cmplt(from).any()) {
            return;
        }
        let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
        let is_left = sides().map(|(p, q)| p.perp_dot(*q)).sum::<f32>() >= 0.0;
        self.hidden.extend(sides().map(|(p, q)| if is_left { [*p, *q] } else { [*q, *p] }));
    }

    /// The sides of all such parts, with these on the left.
    #[must_use]
    pub fn hidden(&self) -> &[[Vec2; 2]] {
        &self.hidden
    }

    /// Whether a point is in such a part.
    #[must_use]
    pub fn is_hidden(&self, p: Vec2) -> bool {
        let turn = |[a, b]: &[Vec2; 2]| match ((a.y > p.y) != (b.y > p.y), (*b - *a).perp_dot(p - *a) > 0.0) {
            (true, true) if b.y > a.y => 1,
            (true, false) if b.y < a.y => -1,
            _ => 0,
        };
        self.hidden.iter().map(turn).sum::<i32>() != 0
    }

    pub(crate) fn clear_hidden(&mut self) {
        self.hidden.clear();
        self.looked_at = None;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    pub(crate) fn truncate(&mut self, count: usize) {
        self.points.truncate(count);
        let kept = self.trapezoids.partition_point(|trapezoid| trapezoid.first < count);
        self.trapezoids.truncate(kept);
    }

    /// Whether all samples of a mask that emit are lit beside all points from one on.
    pub(crate) fn is_clear(&self, start: usize, mask: &Mask) -> bool {
        let raster = mask.raster();
        self.points[start..].iter().all(|point| {
            let row = ((point.y - raster.bottom) * raster.rows) as usize;
            (row.saturating_sub(1)..(row + 2).min(mask.side())).all(|row| {
                let at = ((point.x - raster.left) * raster.samples - Raster::shift(row)) as u32;
                let (from, to) = mask.emitting(row);
                let lit = mask.lit(row).0;
                (at.saturating_sub(1).max(from)..(at + 2).min(to)).all(|k| lit[k as usize / 64] >> (k % 64) & 1 == 1)
            })
        })
    }

    /// Adds a trapezoid with two level sides, in plane coordinates of a window: the ends of the line halfway between these, by how much these ends move from the lower side to
    /// the higher one, and the height. It may be as high as the window.
    pub fn add(&mut self, window: &UnitSquare, ends: [f32; 2], leans: [f32; 2], y: f32, height: f32) {
        let rows = self.rows() as f32;
        // The last digit of a row's own height makes no second one.
        let count = (0.5 * rows * height / window.half.y - 1e-3).ceil().min(rows).max(1.0);
        for k in 0..count as u32 {
            let up = (k as f32 + 0.5) / count - 0.5;
            let ends = [ends[0] + up * leans[0], ends[1] + up * leans[1]];
            self.add_row(window, ends, leans.map(|lean| lean / count), y + up * height, height / count);
        }
    }

    /// Adds one that is no higher than a row.
    fn add_row(&mut self, window: &UnitSquare, ends: [f32; 2], leans: [f32; 2], y: f32, height: f32) {
        self.trapezoids.push(Trapezoid { ends, leans, y, height, first: self.points.len() });
        let pieces = |length: f32| (0.5 * self.pieces * length / window.half.x).ceil().clamp(1.0, self.pieces);
        let rows = pieces(leans[0].abs().max(leans[1].abs()));
        for row in 0..rows as u32 {
            let up = (row as f32 + 0.5) / rows - 0.5;
            let [from, to] = [0, 1].map(|side| ends[side] + up * leans[side]);
            let count = pieces(to - from);
            let piece = (to - from) / count;
            let area = 0.5 * piece * (height / rows);
            for k in 0..count as u32 {
                let middle = from + (k as f32 + 0.5) * piece;
                self.points.extend([-GAUSS, GAUSS].map(|at| Vec3::new(middle + at * piece, y + up * height, area)));
            }
        }
    }

    /// The sum of all areas.
    pub(crate) fn area(&self) -> f32 {
        self.points.iter().map(|point| point.z).sum()
    }

    /// The integrals of `weight(x, y, area)` where it is positive.
    pub(crate) fn integrals<const N: usize>(&self, weight: impl Fn(f32, f32, f32) -> [f32; N]) -> [f32; N] {
        self.points.iter().fold([0.0; N], |mut sums, Vec3 { x, y, z: area }| {
            for (sum, w) in sums.iter_mut().zip(weight(*x, *y, *area)) {
                *sum += if w > 0.0 { w * area } else { 0.0 };
            }
            sums
        })
    }

    /// The same of weights with a peak: from there on points are the farther apart the farther they are from it.
    pub(crate) fn integrals_about<const N: usize>(
        &self,
        focus: Focus,
        weight: impl Fn(f32, f32, f32) -> [f32; N],
    ) -> [f32; N] {
        let mut sums = [0.0; N];
        let mut add = |x: f32, y: f32, area: f32| {
            for (sum, w) in sums.iter_mut().zip(weight(x, y, area)) {
                *sum += if w > 0.0 { w * area } else { 0.0 };
            }
        };
        self.trapezoids.iter().for_each(|trapezoid| trapezoid.each_point(focus, &mut add));
        sums
    }
}

/// A trapezoid with two level sides: the ends of the line halfway between these, how far these ends move from the lower side to the higher one,
/// and the height.
#[derive(Clone, Copy, Debug)]
struct Trapezoid {
    ends: [f32; 2],
    leans: [f32; 2],
    y: f32,
    height: f32,
    /// The number of its first point.
    first: usize,
}

impl Trapezoid {
    /// Calls `add` with the points and areas of Gauss's rule in parts that are as large as the peak, or in proportion to their distance from it.
    fn each_point(&self, focus: Focus, add: &mut impl FnMut(f32, f32, f32)) {
        let Self { ends: [from, to], leans, y, height, .. } = *self;
        let lean = leans[0].abs().max(leans[1].abs());
        let half = 0.5 * Vec2::new((to - from) + lean, height);
        let beside = |p: Vec2| ((p - Vec2::new(0.5 * (from + to), y)).abs() - half).max(Vec2::ZERO).length();
        let most = PART * focus.size(beside(focus.place)).min(Focus::FOOT.size(beside(Vec2::ZERO)));
        let [tall, wide] = [lean.max(height) > most, to - from > most];
        if tall && (!wide || lean.max(height) > to - from) {
            return [-0.25, 0.25].into_iter().for_each(|at| self.level_half(at).each_point(focus, add));
        } else if wide {
            let (middle, lean) = (0.5 * (from + to), 0.5 * (leans[0] + leans[1]));
            Self { ends: [from, middle], leans: [leans[0], lean], ..*self }.each_point(focus, add);
            return Self { ends: [middle, to], leans: [lean, leans[1]], ..*self }.each_point(focus, add);
        }
        // One row of points does for a part that is much lower than it may be.
        let rows: &[f32] = if 4.0 * lean.max(height) < most { &[0.0] } else { &[-GAUSS, GAUSS] };
        for up in rows {
            let [from, to] = [from + up * leans[0], to + up * leans[1]];
            let area = 0.5 * (to - from) * height / rows.len() as f32;
            for at in [-GAUSS, GAUSS] {
                add(0.5 * (from + to) + at * (to - from), y + up * height, area);
            }
        }
    }

    /// The lower or the higher half, whose middle is a part `at` of the height above that of both.
    fn level_half(&self, at: f32) -> Self {
        let Self { ends, leans, y, height, .. } = *self;
        let ends = [ends[0] + at * leans[0], ends[1] + at * leans[1]];
        Self { ends, leans: leans.map(|lean| 0.5 * lean), y: y + at * height, height: 0.5 * height, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three rows for one that is 2.5 rows high, which fit together.
    #[test]
    fn rows_fill_a_trapezoid() {
        let (ends, leans, y, height) = ([0.2, 0.6], [0.3, -0.1], 1.0, 0.5);
        let cone = lobe_core::Cone { axis: Vec3::Z, one_minus_cos: 0.5, distance: 1.0 };
        let mut window = UnitSquare::facing(&cone, Vec3::X);
        let mut lit = LitArea::default();
        // Rows are 0.2 high.
        window.half.y = 0.1 * lit.rows() as f32;
        lit.add(&window, ends, leans, y, height);
        let rows = &lit.trapezoids;
        assert_eq!(rows.len(), 3);
        let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
        let edge = |ends: [f32; 2], leans: [f32; 2], up: f32| [0, 1].map(|side| ends[side] + up * leans[side]);
        let of = |row: &Trapezoid, up: f32| edge(row.ends, row.leans, up);
        let [low, high] = [-0.5, 0.5].map(|up| edge(ends, leans, up));
        assert!(near(rows[0].y - 0.5 * rows[0].height, 0.75) && near(rows[2].y + 0.5 * rows[2].height, 1.25));
        assert!((0..2).all(|k| near(of(&rows[0], -0.5)[k], low[k]) && near(of(&rows[2], 0.5)[k], high[k])));
        assert!(rows.windows(2).all(|two| (0..2).all(|k| near(of(&two[0], 0.5)[k], of(&two[1], -0.5)[k]))));
        assert!(near(lit.area(), (ends[1] - ends[0]) * height));
        let mut one = LitArea::default();
        one.add(&window, ends, leans, y, 0.2);
        assert_eq!(one.trapezoids.len(), 1);
    }

    #[test]
    fn points_are_in_hidden_parts() {
        let mut lit = LitArea::default();
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(Vec2::from);
        // Either way around, and two that overlap.
        lit.hide(&corners);
        lit.hide(&corners.map(|p| Vec2::new(1.5 - p.x, 0.5 + p.y)));
        for (p, want) in [
            ([0.5, 0.5], true),
            ([0.75, 0.75], true),
            ([1.25, 1.25], true),
            ([1.25, 0.25], false),
            ([-0.5, 0.5], false),
        ] {
            assert_eq!(lit.is_hidden(Vec2::from(p)), want, "{p:?}");
        }
    }

    /// A triangle in slabs of all widths: its area, and integrals of a smooth function against finer slabs.
    #[test]
    fn trapezoids_have_their_area() {
        let window = UnitSquare::default();
        let triangle = |slabs: u32| {
            let mut lit = LitArea::default();
            let height = 1.2 / slabs as f32;
            for k in 0..slabs {
                let y = -0.6 + (k as f32 + 0.5) * height;
                lit.add(&window, [-0.5 + 0.2 * y, 0.1 - 0.5 * y], [0.2 * height, -0.5 * height], y, height);
            }
            lit
        };
        let want: f32 = 1.2 * 0.6;
        for slabs in [1, 3, 20, 400] {
            assert!((triangle(slabs).area() / want - 1.0).abs() < 1e-5, "{slabs}");
        }
        let smooth = |lit: &LitArea| lit.integrals(|x, y, _| [(1.0 + 0.3 * x - 0.2 * y) / (1.0 + x * x + y * y)])[0];
        let [few, many] = [32, 2000].map(|slabs| smooth(&triangle(slabs)));
        assert!((few / many - 1.0).abs() < 2e-4, "{few} {many}");
        // Where the weight is negative nothing is.
        assert_eq!(triangle(20).integrals(|_, _, _| [-1.0]), [0.0]);
    }

    /// Peaks in a triangle and beside it: about their place few points are as good as many rows of narrow pieces.
    #[test]
    fn peaks_are_integrated_about_their_place() {
        let window = UnitSquare { half: Vec2::splat(2.0), ..UnitSquare::default() };
        let triangle = |slabs: u32| {
            let mut lit = LitArea::default();
            let height = 1.2 / slabs as f32;
            for k in 0..slabs {
                let y = -0.6 + (k as f32 + 0.5) * height;
                lit.add(&window, [-0.5 + 0.6 * y, 0.1 - 0.5 * y], [0.6 * height, -0.5 * height], y, height);
            }
            lit
        };
        let few = triangle(5);
        let many = |place: Vec2, weight: &dyn Fn(f32, f32) -> f32| {
            // Rows through the lines halfway up thousands of slabs, by the integral's own rule.
            let rows = 6000;
            let height = 1.2 / f64::from(rows);
            (0..rows)
                .map(|k| {
                    let y = (-0.6 + (f64::from(k) + 0.5) * height) as f32;
                    let row = Trapezoid {
                        ends: [-0.5 + 0.6 * y, 0.1 - 0.5 * y],
                        leans: [0.0; 2],
                        y,
                        height: height as f32,
                        first: 0,
                    };
                    let mut sum = 0.0;
                    row.each_point(Focus { place, width: 1e-3, slope: 1.0 }, &mut |x, y, area| {
                        sum += f64::from(weight(x, y) * area)
                    });
                    sum
                })
                .sum::<f64>()
        };
        for (x, y, width) in [(0.0, 0.0, 0.3), (0.05, 0.1, 0.02), (-0.9, 0.2, 0.01), (-0.52, -0.04, 0.005)] {
            let place = Vec2::new(x, y);
            let weight = |x: f32, y: f32| (1.0 + Vec2::new(x, y).distance_squared(place) / (width * width)).powi(-2);
            let focus = Focus { place, width, slope: 1.0 };
            let mut points = 0;
            few.trapezoids.iter().for_each(|t| t.each_point(focus, &mut |_, _, _| points += 1));
            let [sum] = few.integrals_about(focus, |x, y, _| [weight(x, y)]);
            let want = many(place, &weight);
            assert!((f64::from(sum) / want - 1.0).abs() < 3e-3, "{place} {width}: {sum} {want}");
            assert!(points < 1500, "{points}");
            println!("{place} {width}: {:.5}, {points} points", f64::from(sum) / want);
        }
    }
}
