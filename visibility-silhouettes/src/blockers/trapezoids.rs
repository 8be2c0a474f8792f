//! The lit part of a window between outlines, as trapezoids.

use crate::project::{View, ends_of, line_through};
use crate::select::{STEP, Silhouettes};
use glam::{Vec2, Vec3};
use lobe_core::Outline;
use visibility_mask::{LitArea, Mask, UnitSquare};

/// Trapezoids are found where at most this number of outlines is before the light: the time is that of each two at one height.
const MOST: usize = 1024;
/// They are given up where all slabs together have more pieces than this.
const MOST_CROSSED: usize = 800_000;
/// Half the distance of the two points of Gauss and Legendre's rule, in heights of a slab.
pub(crate) const GAUSS: f32 = 0.288_675_13;
/// The sides of the light and its window divide slabs if they are at most this number: a round light has many short ones.
const SIDES: usize = 10;
/// Where they are more, those do that are not shorter than this part of the longest, if there are a few: the two along a tube.
const SHORT: f32 = 0.25;
/// Numbers of surfaces that may be those of slivers alone, which rounding leaves between outlines that coincide.
const DOUBTFUL: usize = 3;

/// A part of a window that may be slivers alone.
pub(crate) const SLIVER: f32 = 1e-6;

/// A second ray is traced into a trapezoid that is not smaller than this part of the largest.
const SECOND: f32 = 0.01;

/// A piece of an outline.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Between which heights it is, and its line `x = s + t y`.
    heights: [f32; 2],
    line: [f32; 2],
    /// Between which places it is.
    places: [f32; 2],
    /// The growth of the number of surfaces to its right.
    step: i32,
    /// Whether each end, the lower one first, is left of the path, and the height at which it crosses that if both are not.
    is_left: [bool; 2],
    crosses: f32,
}

impl Piece {
    fn at(&self, y: f32) -> f32 {
        let [start, slope] = self.line;
        // The line of one that is nearly level is ill-conditioned.
        (start + slope * y).max(self.places[0]).min(self.places[1])
    }

    /// Whether it is left of the path at a height.
    fn is_left_at(&self, y: f32) -> bool {
        self.is_left[usize::from(self.is_left[0] != self.is_left[1] && y >= self.crosses)]
    }
}

/// A line that is inside the light at all of its heights: `x = s + t y`.
///
/// Outlines beside the light are not all known, so that numbers of surfaces are known but for a constant from this path on.
#[derive(Clone, Copy, Debug)]
struct Path([f32; 2]);

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
struct Trapezoid {
    /// The line halfway between its level sides, and by how much its ends move from the lower one to the higher one.
    ends: [f32; 2],
    leans: [f32; 2],
    y: f32,
    height: f32,
    /// The surfaces before it, but for a constant.
    number: i32,
}

impl Trapezoid {
    fn area(&self) -> f32 {
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
    fn at(&self, y: f32) -> [f32; 2] {
        let [from, to] = self.mask.emits_at(y, self.facet);
        if from < to { [from, to] } else { [0.5 * (from + to); 2] }
    }

    fn half_planes(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.mask.half_planes().chain(self.facet)
    }
}

/// The lit part of a window, and working memory.
///
/// # Method
/// Pieces of outlines end, and cross each other and the bounds of the light, at heights; between two neighbouring heights they follow each other from left
/// to right in one order, so that the parts between them are trapezoids with one number of surfaces each. The number grows at pieces by what each of them adds; the fewest are
/// none if one ray meets nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Trapezoids {
    pieces: Vec<Piece>,
    heights: Vec<f32>,
    /// The heights at which pieces cross the path, and the growth of the number there.
    path: Vec<(f32, i32)>,
    /// The pieces at a height, and their places there.
    active: Vec<u32>,
    crossed: Vec<(f32, u32)>,
    found: Vec<Trapezoid>,
}

impl Trapezoids {
    /// Adds the lit part of a window. `false` if outlines are too many, or if rays do not confirm what was found.
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
        self.divide(view, emits, lit.rows());
        if !self.fill(emits, narrowest) {
            return false;
        }
        let slivers = narrowest * narrowest + SLIVER * view.square.half.element_product();
        let mut is_open = |p: Vec2| !lit.is_hidden(p) && is_open(p);
        let Some(open) = open_numbers(&self.found, slivers, &mut is_open) else { return false };
        for part in self.found.iter().filter(|part| open.contains(&Some(part.number))) {
            lit.add(&view.square, part.ends, part.leans, part.y, part.height);
        }
        true
    }

    /// Projects outlines, and takes the sides of what is hidden besides.
    fn gather(&mut self, silhouettes: &Silhouettes, hidden: &[[Vec2; 2]], view: &View, path: Path) {
        self.pieces.clear();
        self.path.clear();
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
        self.pieces.sort_unstable_by(|a, b| a.heights[0].total_cmp(&b.heights[0]));
        self.path.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// Adds a piece.
    fn add(&mut self, ends: [Vec2; 2], line: [f32; 2], step: i32, to_path: Path) {
        let beside = ends.map(|p| to_path.beside(p));
        let is_left = beside.map(|beside| beside < 0.0);
        let is_up = ends[0].y <= ends[1].y;
        let [low, high] = if is_up { ends } else { [ends[1], ends[0]] };
        let mut crosses = f32::INFINITY;
        if is_left[0] != is_left[1] {
            let at = ends[0].y + (ends[1].y - ends[0].y) * (beside[0] / (beside[0] - beside[1]));
            crosses = at.clamp(low.y, high.y);
            self.path.push((crosses, if is_left[0] { -step } else { step }));
        }
        self.pieces.push(Piece {
            heights: [low.y, high.y],
            line,
            places: [low.x.min(high.x), low.x.max(high.x)],
            step: if is_up { step } else { -step },
            is_left: if is_up { is_left } else { [is_left[1], is_left[0]] },
            crosses,
        });
    }

    /// Lists the heights between which the order of pieces and bounds is one, and those between a number of rows.
    fn divide(&mut self, view: &View, emits: &Emits<'_>, rows: u32) {
        let Self { pieces, heights, .. } = self;
        let (low, high) = view.corners();
        heights.clear();
        heights.extend((1..rows).map(|k| low.y + (high.y - low.y) * (k as f32 / rows as f32)));
        let UnitSquare { right, up, .. } = view.square;
        heights.extend(emits.outline.iter().flat_map(|outline| outline.on_plane([right, up])).map(|p| p.y));
        let bounds = [Vec3::new(1.0, 0.0, -low.x), Vec3::new(-1.0, 0.0, high.x)];
        let mut sides: Vec<Vec3> = bounds.into_iter().chain(emits.half_planes()).collect();
        if sides.len() > SIDES {
            // Bounds and horizon come first.
            let others = sides.split_off(3);
            let corners: Vec<Vec2> = emits.outline.iter().flat_map(|outline| outline.on_plane([right, up])).collect();
            sides.extend(long_sides(&others, &corners));
        }
        for (k, side) in sides.iter().enumerate() {
            heights.extend(sides[..k].iter().map(|other| {
                let p = side.cross(*other);
                p.y / p.z
            }));
        }
        let (middle, radius) = emits.mask.circle();
        let is_inside = |piece: &Piece| piece.places[1] > low.x && piece.places[0] < high.x;
        for (k, piece) in pieces.iter().enumerate().filter(|(_, piece)| is_inside(piece)) {
            let [from, to] = piece.heights;
            let [start, slope] = piece.line;
            heights.extend([from, to]);
            let mut meet = |y: f32| {
                if y > from && y < to {
                    heights.push(y);
                }
            };
            for side in &sides {
                meet(-(side.x * start + side.z) / (side.x * slope + side.y));
            }
            // |(s + t y, y) - middle| = radius
            let (a, b, c) = (1.0 + slope * slope, slope * (start - middle.x) - middle.y, start - middle.x);
            let root = (b * b - a * (c * c + middle.y * middle.y - radius * radius)).sqrt();
            [-root, root].iter().for_each(|root| meet((root - b) / a));
            for other in pieces[k + 1..].iter().take_while(|other| other.heights[0] < to) {
                let y = (other.line[0] - start) / (slope - other.line[1]);
                if y < other.heights[1] && y > other.heights[0] {
                    meet(y);
                }
            }
        }
        heights.retain(|y| *y > low.y && *y < high.y);
        heights.extend([low.y, high.y]);
        heights.sort_unstable_by(f32::total_cmp);
    }

    /// Finds the trapezoids. `false` where that takes too long.
    fn fill(&mut self, emits: &Emits<'_>, narrowest: f32) -> bool {
        let Self { pieces, heights, path, active, crossed, found } = self;
        found.clear();
        active.clear();
        let (mut rest, mut next, mut on_path, mut all, mut least) = (0, 0, 0, 0, i32::MAX);
        for slab in heights.windows(2) {
            let height = slab[1] - slab[0];
            let y = slab[0] + 0.5 * height;
            // The mean of two places is that of a parabola, as which arcs are taken.
            let [low, high] = [-GAUSS, GAUSS].map(|up| emits.at(y + up * height));
            let [first, last] = [0, 1].map(|side| 0.5 * (low[side] + high[side]));
            if height <= 1e-2 * narrowest || last - first < narrowest {
                continue;
            }
            while let Some(piece) = pieces.get(rest)
                && piece.heights[0] <= y
            {
                active.push(rest as u32);
                rest += 1;
            }
            while let Some((at, step)) = path.get(next)
                && *at <= y
            {
                on_path += step;
                next += 1;
            }
            active.retain(|k| pieces[*k as usize].heights[1] > y);
            all += active.len();
            if all > MOST_CROSSED {
                return false;
            }
            let mut number = on_path;
            crossed.clear();
            for k in &*active {
                let piece = &pieces[*k as usize];
                crossed.push((piece.at(y), *k));
                number -= if piece.is_left_at(y) { piece.step } else { 0 };
            }
            crossed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let of_light = [0, 1].map(|side| (high[side] - low[side]) / (2.0 * GAUSS));
            let mut left = (f32::NEG_INFINITY, None);
            for k in 0..=crossed.len() {
                let (to, piece) =
                    crossed.get(k).map_or((f32::INFINITY, None), |(to, k)| (*to, Some(&pieces[*k as usize])));
                let right = (to, piece);
                let ends = [left.0.max(first), right.0.min(last)];
                if ends[1] - ends[0] >= narrowest && number < least.saturating_add(DOUBTFUL as i32) {
                    least = least.min(number);
                    let lean = |(at, piece): (f32, Option<&Piece>), side: usize| match piece {
                        Some(piece) if at == ends[side] => piece.at(slab[1]) - piece.at(slab[0]),
                        _ => of_light[side],
                    };
                    found.push(Trapezoid { ends, leans: [lean(left, 0), lean(right, 1)], y, height, number });
                }
                number += piece.map_or(0, |piece| piece.step);
                left = right;
            }
        }
        true
    }
}

/// The numbers of surfaces of parts that are open, by rays. None if these contradict each other.
fn open_numbers(
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
    if long.len() > SIDES - 3 { Vec::new() } else { long }
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
