//! The lit part of a window between outlines, as trapezoids.

use super::cells::{CellMemory, Cells};
use super::parts::Bounds;
use crate::project::{View, ends_of, line_through};
use crate::select::{STEP, Silhouettes};
use glam::{Vec2, Vec2Swizzles, Vec3};
use lobe_core::Outline;
use visibility_mask::{LitArea, Mask, UnitSquare};

/// Trapezoids are found where at most this number of outlines is before the light: they take 0.02 s then.
const MOST: usize = 16384;
/// Half the distance of the two points of Gauss and Legendre's rule, in heights of a trapezoid.
pub(crate) const GAUSS: f32 = 0.288_675_13;
/// The sides of the light divide trapezoids if they are at most this number: a round light has many short ones.
const SIDES: usize = 8;
/// Where they are more, the horizon and those do that are not shorter than this part of the longest, if there are a few: the two along a tube.
const SHORT: f32 = 0.25;
/// Numbers of surfaces that may be those of slivers alone, which rounding leaves between outlines that coincide.
pub(super) const DOUBTFUL: usize = 3;

/// A part of a window that may be slivers alone.
pub(crate) const SLIVER: f32 = 1e-6;
/// They may also be as large as its sides times this part of how far it reaches from the origin across them: what pieces along them are rounded by.
const ROUNDED: f32 = 64.0 * f32::EPSILON;

/// A second ray is traced into a trapezoid that is not smaller than this part of the largest.
const SECOND: f32 = 0.01;

/// A piece that moves by more than this to the side on its way up is nearly level.
const STEEP: f32 = 1e3;

/// A piece of an outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Between which heights it is, and its line `x = s + t y`.
    pub(super) heights: [f32; 2],
    pub(super) line: [f32; 2],
    /// Where its lower and its higher end are, and between which places it is.
    ends: [f32; 2],
    pub(super) places: [f32; 2],
    /// The growth of the number of surfaces to its right.
    pub(super) step: i32,
    /// Whether each end, the lower one first, is left of the path, and the height at which it crosses that if both are not.
    is_left: [bool; 2],
    crosses: f32,
}

impl Piece {
    /// Its place at a height between its ends.
    #[inline(always)]
    pub(super) fn at(&self, y: f32) -> f32 {
        let ([start, slope], [low, high]) = (self.line, self.places);
        // The line of one that is nearly level is ill-conditioned.
        let x = start + slope * y;
        let x = if x > low { x } else { low };
        if x < high { x } else { high }
    }

    /// The same, or that of the nearest end: exactly where others begin.
    #[inline(always)]
    pub(super) fn at_or_end(&self, y: f32) -> f32 {
        if y <= self.heights[0] {
            self.ends[0]
        } else if y >= self.heights[1] {
            self.ends[1]
        } else {
            self.at(y)
        }
    }

    /// Whether it crosses a height.
    pub(super) fn is_at(&self, y: f32) -> bool {
        self.heights[0] <= y && y < self.heights[1]
    }

    /// From where to where it is at one of its heights.
    pub(super) fn ends_at(&self, y: f32) -> [f32; 2] {
        if self.heights[0] == self.heights[1] { self.places } else { [self.at(y); 2] }
    }

    /// Whether it is left of the path at a height.
    fn is_left_at(&self, y: f32) -> bool {
        self.is_left[usize::from(self.is_left[0] != self.is_left[1] && y >= self.crosses)]
    }

    /// Its step where it is left of the path: that is between the number left of all pieces and the number on the path.
    pub(super) fn step_left_at(&self, y: f32) -> i32 {
        if self.is_left_at(y) { self.step } else { 0 }
    }

    /// The height at which it crosses the path, and the growth of the number there, upward.
    pub(super) fn on_path(&self) -> Option<(f32, i32)> {
        let step = if self.is_left[0] { -self.step } else { self.step };
        (self.is_left[0] != self.is_left[1]).then_some((self.crosses, step))
    }

    /// Whether the side of it on which a point is may be lost in rounding.
    pub(super) fn is_nearly_level(&self) -> bool {
        !self.line[1].is_finite() || self.line[1].abs() >= STEEP
    }

    /// By how much the number falls at most where it is crossed on the way from a point.
    #[inline(always)]
    pub(super) fn falls_from(&self, p: Vec2) -> i32 {
        let [start, slope] = self.line;
        let is_left = start + slope * p.y < p.x;
        if self.is_nearly_level() { self.step.abs() } else { (if is_left { self.step } else { -self.step }).max(0) }
    }

    /// The change of the number from one point to another, if the line between them crosses it.
    #[inline(always)]
    pub(super) fn change(&self, [a, b]: [Vec2; 2]) -> i32 {
        let slope = (b.x - a.x) / (b.y - a.y);
        let is_left = |x: f32, y: f32| i32::from(x < a.x + slope * (y - a.y));
        let [from, to] = self.heights;
        if from == to {
            let up = i32::from(b.y >= from) - i32::from(a.y >= from);
            return up * self.step * (is_left(self.ends[1], from) - is_left(self.ends[0], from));
        }
        let is_left_at = |y: f32| is_left(self.at_or_end(y), y.max(from).min(to));
        self.step * (is_left_at(b.y) - is_left_at(a.y))
    }
}

/// A line that is inside the light at all of its heights: `x = s + t y`.
///
/// Outlines beside the light are not all known, so that numbers of surfaces are known but for a constant from this path on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path(pub(super) [f32; 2]);

impl Path {
    fn new(view: &View, outline: Option<&Outline>) -> Self {
        Self(outline.map_or([0.0; 2], |outline| line_through(ends_of(outline, &view.square))))
    }

    /// How far a point is to its right.
    fn beside(self, p: Vec2) -> f32 {
        p.x - (self.0[0] + self.0[1] * p.y)
    }
}

/// A trapezoid between two outlines, with level sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trapezoid {
    /// The line halfway between its level sides, and by how much its ends move from the lower one to the higher one.
    pub(super) ends: [f32; 2],
    pub(super) leans: [f32; 2],
    pub(super) y: f32,
    pub(super) height: f32,
    /// The surfaces before it, but for a constant.
    pub(super) number: i32,
}

impl Trapezoid {
    pub(super) fn area(&self) -> f32 {
        (self.ends[1] - self.ends[0]) * self.height
    }

    fn middle(&self) -> Vec2 {
        Vec2::new(0.5 * (self.ends[0] + self.ends[1]), self.y)
    }
}

/// Where the light emits, besides the mask's own bounds.
pub(super) struct Emits<'a> {
    pub(super) mask: &'a Mask,
    pub(super) outline: Option<&'a Outline>,
    /// The half-plane above the receiver's facet.
    pub(super) facet: Option<Vec3>,
}

impl Emits<'_> {
    /// From where to where the light emits at a height.
    pub(super) fn at(&self, y: f32) -> [f32; 2] {
        let [from, to] = self.mask.emits_at(y, self.facet);
        if from < to { [from, to] } else { [0.5 * (from + to); 2] }
    }

    /// Whether more bounds it than a few lines.
    fn is_round(&self) -> bool {
        self.outline.is_none() || self.half_planes().count() > SIDES
    }

    fn half_planes(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.mask.half_planes().chain(self.facet)
    }
}

/// The lit part of a window, and working memory.
///
/// # Method
/// [`Cells`] find the parts between pieces of outlines, trapezoids with one number of surfaces each. The fewest are none if one ray meets nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Trapezoids {
    pub(super) pieces: Vec<Piece>,
    pub(super) cells: CellMemory,
    found: Vec<Trapezoid>,
}

impl Trapezoids {
    /// Adds the lit part of a window. `false` if outlines are too many or meet too often, or if rays do not confirm what was found.
    pub(super) fn find(
        &mut self,
        silhouettes: &Silhouettes,
        view: &View,
        emits: &Emits<'_>,
        narrowest: f32,
        lit: &mut LitArea,
        mut is_open: impl FnMut(Vec2) -> bool,
    ) -> bool {
        if silhouettes.len() + lit.hidden().len() > MOST {
            return false;
        }
        let path = Path::new(view, emits.outline);
        self.gather(silhouettes, lit.hidden(), view, path);
        self.found.clear();
        let (low, high) = view.corners();
        let UnitSquare { right, up, .. } = view.square;
        let corners: Vec<Vec2> = emits.outline.iter().flat_map(|outline| outline.on_plane([right, up])).collect();
        let sides = sides(emits, &corners);
        let slivers = slivers(&view.square, narrowest);
        let bounds = Bounds {
            emits,
            sides: &sides,
            corners: &corners,
            is_in_rows: emits.is_round() || lit.shows_image(),
            low,
            high,
            rows: lit.rows(),
            narrowest,
            slivers,
        };
        let mut is_open = |p: Vec2| !lit.is_hidden(p) && is_open(p);
        if !Cells::new(&self.pieces, &bounds, &mut self.found).run(&mut self.cells, &mut is_open) {
            return false;
        }
        let Some(open) = open_numbers(&self.found, slivers, &mut is_open) else { return false };
        for part in self.found.iter().filter(|part| open.contains(&Some(part.number))) {
            lit.add(&view.square, part.ends, part.leans, part.y, part.height);
        }
        true
    }

    /// Projects outlines, and takes the sides of what is hidden besides.
    fn gather(&mut self, silhouettes: &Silhouettes, hidden: &[[Vec2; 2]], view: &View, path: Path) {
        self.pieces.clear();
        for k in 0..silhouettes.len() {
            let end = |first: usize| Vec3::from_array(core::array::from_fn(|axis| silhouettes.get(first + axis, k)));
            let step = silhouettes.get(STEP, k) as i32;
            if let Some((ends, line)) = view.on_plane([end(0), end(3)])
                && step != 0
            {
                self.add(ends, line, step, path);
            }
        }
        for [a, b] in hidden {
            let slope = (b.x - a.x) / (b.y - a.y);
            self.add([*a, *b], [a.x - slope * a.y, slope], -1, path);
        }
    }

    /// Adds a piece.
    pub(super) fn add(&mut self, ends: [Vec2; 2], line: [f32; 2], step: i32, to_path: Path) {
        let beside = ends.map(|p| to_path.beside(p));
        let is_left = beside.map(|beside| beside < 0.0);
        let is_up = ends[0].y <= ends[1].y;
        let [low, high] = if is_up { ends } else { [ends[1], ends[0]] };
        let mut crosses = f32::INFINITY;
        if is_left[0] != is_left[1] {
            let at = ends[0].y + (ends[1].y - ends[0].y) * (beside[0] / (beside[0] - beside[1]));
            crosses = at.clamp(low.y, high.y);
        }
        self.pieces.push(Piece {
            heights: [low.y, high.y],
            line,
            places: [low.x.min(high.x), low.x.max(high.x)],
            ends: [low.x, high.x],
            step: if is_up { step } else { -step },
            is_left: if is_up { is_left } else { [is_left[1], is_left[0]] },
            crosses,
        });
    }
}

/// Parts of a window that are not larger may be slivers alone.
pub(super) fn slivers(window: &UnitSquare, narrowest: f32) -> f32 {
    let UnitSquare { center, half, .. } = window;
    let reach = center.abs() + *half;
    narrowest * narrowest + SLIVER * half.element_product() + ROUNDED * half.dot(reach.yx())
}

/// The numbers of surfaces of parts that are open, by rays. None if these contradict each other.
pub(super) fn open_numbers(
    found: &[Trapezoid],
    slivers: f32,
    is_open: &mut impl FnMut(Vec2) -> bool,
) -> Option<[Option<i32>; DOUBTFUL]> {
    let mut open = [None; DOUBTFUL];
    let Some(least) = found.iter().map(|part| part.number).min() else { return Some(open) };
    for (number, open) in (least..).zip(&mut open) {
        let mut best = [None::<Trapezoid>; 2];
        let mut area = 0.0;
        for part in found.iter().filter(|part| part.number == number) {
            area += part.area();
            if best[0].is_none_or(|best| best.area() < part.area()) {
                best = [Some(*part), best[0]];
            } else if best[1].is_none_or(|best| best.area() < part.area()) {
                best[1] = Some(*part);
            }
        }
        let [Some(largest), next] = best else { continue };
        // The number of slivers, open ones as well, may be too small.
        let are_slivers = area <= slivers;
        if is_open(largest.middle()) {
            // Outlines that do not close would tell different numbers for one.
            let second = next.filter(|next| !are_slivers && next.area() > SECOND * largest.area());
            if second.is_some_and(|second| !is_open(second.middle())) {
                return None;
            }
            *open = Some(number);
        }
        if !are_slivers {
            break;
        }
    }
    Some(open)
}

/// The half-planes in which a light with some corners emits, if they are few; else those with long sides.
pub(super) fn sides(emits: &Emits<'_>, corners: &[Vec2]) -> Vec<Vec3> {
    let mut sides: Vec<Vec3> = emits.half_planes().collect();
    if sides.len() > SIDES {
        // The horizon comes first.
        let others = sides.split_off(1);
        sides.extend(long_sides(&others, corners));
    }
    sides
}

/// Those half-planes whose side between corners is long; none where they are not few.
fn long_sides(half_planes: &[Vec3], corners: &[Vec2]) -> Vec<Vec3> {
    let length = |side: &Vec3| {
        let away = |p: &Vec2| (side.truncate().dot(*p) + side.z).abs();
        let mut near: Vec<Vec2> = corners.to_vec();
        near.sort_unstable_by(|p, q| away(p).total_cmp(&away(q)));
        if let [p, q, ..] = near[..] { p.distance(q) } else { 0.0 }
    };
    let lengths: Vec<f32> = half_planes.iter().map(length).collect();
    let longest = lengths.iter().copied().fold(0.0, f32::max);
    let long: Vec<Vec3> = half_planes
        .iter()
        .zip(&lengths)
        .filter(|(_, length)| **length >= SHORT * longest)
        .map(|(side, _)| *side)
        .collect();
    if long.len() >= SIDES { Vec::new() } else { long }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding leaves a sliver between two outlines, with a surface less than there is: all around it is open as well.
    #[test]
    fn slivers_do_not_decide_what_is_open() {
        let part = |ends, height, number| Trapezoid { ends, leans: [0.0; 2], y: 0.0, height, number };
        let found = [part([0.0, 0.5], 0.1, 0), part([0.4, 0.400_01], 1e-7, -1), part([0.5, 1.0], 0.1, 1)];
        let numbers = |is_open: &mut dyn FnMut(Vec2) -> bool| open_numbers(&found, 1e-6, &mut |p| is_open(p));
        assert_eq!(numbers(&mut |p| p.x < 0.5), Some([Some(-1), Some(0), None]));
        // Or it is open alone, or nothing is.
        assert_eq!(numbers(&mut |p| p.x > 0.4 && p.x < 0.4001), Some([Some(-1), None, None]));
        assert_eq!(numbers(&mut |_| false), Some([None; 3]));
        assert_eq!(open_numbers(&[], 1e-6, &mut |_| true), Some([None; 3]));
        // Two large parts of one number are both open or both hidden.
        let contrary = [part([0.0, 0.5], 0.1, 0), part([0.6, 1.0], 0.1, 0)];
        assert_eq!(open_numbers(&contrary, 1e-6, &mut |p| p.x < 0.5), None);
    }
}
