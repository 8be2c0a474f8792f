//! The parts of one cell of a window.

use super::cells::Cells;
use super::trapezoids::{Emits, GAUSS, Piece, Trapezoid};
use core::cmp::Ordering;
use glam::{Vec2, Vec3};

/// Parts lower than this part of the narrowest are left out.
const THINNEST: f32 = 0.01;

/// The light and the window, which bound parts besides pieces.
pub(super) struct Bounds<'a> {
    pub(super) emits: &'a Emits<'a>,
    /// Half-planes in which the light emits, those with long sides, and all corners.
    pub(super) sides: &'a [Vec3],
    pub(super) corners: &'a [Vec2],
    /// Whether cells are cut along rows as well: before round bounds, which are no lines, and images.
    pub(super) is_in_rows: bool,
    /// The window.
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    /// If so, no part is higher than that of the window's height by this number.
    pub(super) rows: u32,
    /// Narrower parts are left out, and smaller ones may be slivers.
    pub(super) narrowest: f32,
    pub(super) slivers: f32,
}

/// A point whose number of surfaces is known, but for a constant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    pub(super) at: Vec2,
    pub(super) number: i32,
}

/// A cell, or some without pieces beside each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    /// Whether all of it emits.
    pub(super) is_inside: bool,
    /// A point of the light in it, if one is known.
    pub(super) anchor: Option<Anchor>,
}

impl Cell {
    fn has(&self, [from, to]: [f32; 2]) -> bool {
        to >= self.low.x && from <= self.high.x
    }
}

/// A piece in a cell.
#[derive(Clone, Copy, Debug)]
struct Part {
    piece: Piece,
    /// Between which heights of the cell it is, and where it is at these.
    heights: [f32; 2],
    ends: [f32; 2],
}

impl Part {
    fn of(piece: &Piece, cell: &Cell) -> Option<Self> {
        let heights = [piece.heights[0].max(cell.low.y), piece.heights[1].min(cell.high.y)];
        let ends = heights.map(|y| piece.at_or_end(y));
        (heights[0] <= heights[1]).then_some(Self { piece: *piece, heights, ends })
    }

    /// By lower ends; the same in whatever order outlines are listed.
    fn order(&self, other: &Self) -> Ordering {
        let numbers =
            |part: &Self| [part.heights[0], part.ends[0], part.ends[1], part.heights[1], part.piece.step as f32];
        let pairs = numbers(self).into_iter().zip(numbers(other));
        pairs.map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    }
}

/// A piece at one height.
#[derive(Clone, Copy, Debug)]
struct Place {
    x: f32,
    step: i32,
    part: u32,
}

/// Puts a piece among others from left to right.
fn insert(places: &mut Vec<Place>, place: Place) {
    places.push(place);
    let mut k = places.len() - 1;
    while k > 0 && places[k - 1].x > place.x {
        places.swap(k - 1, k);
        k -= 1;
    }
}

/// Working memory of one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct PartMemory {
    /// At which parts change.
    heights: Vec<f32>,
    /// By their lower ends, and those that have begun.
    parts: Vec<Part>,
    begun: Vec<u32>,
    /// From left to right.
    places: Vec<Place>,
}

/// Parts of a cell at the same heights.
#[derive(Clone, Copy, Debug)]
struct Slab {
    heights: [f32; 2],
    /// The light's ends, or the cell's, halfway between, and how far they move.
    ends: [f32; 2],
    leans: [f32; 2],
}

impl Slab {
    fn height(&self) -> f32 {
        self.heights[1] - self.heights[0]
    }

    fn middle(&self) -> f32 {
        self.heights[0] + 0.5 * self.height()
    }
}

impl Cells<'_> {
    /// Adds the parts of a cell: it is cut at all heights where pieces begin, end, cross each other or leave it, and from one piece to the next.
    pub(super) fn divide(
        &mut self,
        cell: &Cell,
        list: &[u32],
        memory: &mut PartMemory,
        is_open: &mut impl FnMut(Vec2) -> bool,
    ) {
        let PartMemory { heights, parts, begun, places } = memory;
        parts.clear();
        parts.extend(list.iter().filter_map(|k| Part::of(&self.pieces[*k as usize], cell)));
        parts.sort_unstable_by(Part::order);
        self.cut(cell, parts, heights);
        begun.clear();
        let mut rest = 0;
        // A point of the slab below, and its number.
        let mut below: Option<Anchor> = None;
        let mut from = cell.low.y;
        for to in heights.iter().copied() {
            if to - from <= THINNEST * self.bounds.narrowest {
                continue;
            }
            let slab = self.slab(cell, [from, to]);
            from = to;
            if slab.ends[1] - slab.ends[0] < self.bounds.narrowest {
                continue;
            }
            let y = slab.middle();
            let at = Vec2::new(if cell.is_inside { cell.low.x } else { 0.5 * (slab.ends[0] + slab.ends[1]) }, y);
            while let Some(part) = parts.get(rest)
                && part.heights[0] <= y
            {
                begun.push(rest as u32);
                rest += 1;
            }
            let mut number = match (below, cell.anchor) {
                (Some(below), _) => {
                    let change = |k: &u32| parts[*k as usize].piece.change([below.at, at]);
                    below.number + begun.iter().map(change).sum::<i32>()
                }
                (None, Some(known)) => {
                    known.number + parts.iter().map(|part| part.piece.change([known.at, at])).sum::<i32>()
                }
                (None, None) => self.number(at),
            };
            below = Some(Anchor { at, number });
            begun.retain(|k| parts[*k as usize].piece.heights[1] > y);
            places.clear();
            for k in &*begun {
                let piece = &parts[*k as usize].piece;
                let x = piece.at(y);
                if x >= slab.ends[0] && x < slab.ends[1] {
                    number -= if x < at.x { piece.step } else { 0 };
                    insert(places, Place { x, step: piece.step, part: *k });
                }
            }
            self.keep(&slab, number, (parts, places), is_open);
        }
    }

    /// The light, or all of a cell, between two heights.
    fn slab(&self, cell: &Cell, heights: [f32; 2]) -> Slab {
        let all = [cell.low.x, cell.high.x];
        if cell.is_inside {
            return Slab { heights, ends: all, leans: [0.0; 2] };
        }
        let [from, to] = heights;
        let [y, height] = [from + 0.5 * (to - from), to - from];
        // The mean of two places is that of a parabola, as which arcs are taken.
        let [low, high] = [-GAUSS, GAUSS].map(|up| self.bounds.emits.at(y + up * height));
        let light = [0, 1].map(|side| 0.5 * (low[side] + high[side]));
        let ends = [light[0].max(all[0]), light[1].min(all[1])];
        let lean = |side: usize| (high[side] - low[side]) / (2.0 * GAUSS);
        Slab { heights, ends, leans: [0, 1].map(|side| if light[side] == ends[side] { lean(side) } else { 0.0 }) }
    }

    /// Adds the parts of a slab with few surfaces, from the number of the first one on.
    #[inline(always)]
    fn keep(
        &mut self,
        slab: &Slab,
        mut number: i32,
        (parts, places): (&[Part], &[Place]),
        is_open: &mut impl FnMut(Vec2) -> bool,
    ) {
        let [from, to] = slab.heights;
        let [height, y] = [slab.height(), slab.middle()];
        let lean = |place: &Place| {
            let piece = &parts[place.part as usize].piece;
            piece.at(to) - piece.at(from)
        };
        let mut left = (slab.ends[0], None);
        for k in 0..=places.len() {
            let right = places.get(k).map_or((slab.ends[1], None), |place| (place.x, Some(place)));
            let ends = [left.0, right.0];
            let width = ends[1] - ends[0];
            if number < self.limit() && width >= self.bounds.narrowest {
                self.least = self.least.min(number);
                // Fewer surfaces than before a part that is open are those of a sliver, or it was one.
                if number + 1 < self.closed && width * height > self.bounds.slivers {
                    self.closed = number + i32::from(is_open(Vec2::new(0.5 * (ends[0] + ends[1]), y)));
                }
                if number < self.closed {
                    let leans = [left.1.map_or(slab.leans[0], lean), right.1.map_or(slab.leans[1], lean)];
                    self.found.push(Trapezoid { ends, leans, y, height, number });
                }
            }
            number += right.1.map_or(0, |place| place.step);
            left = right;
        }
    }

    /// The heights at which parts of a cell change, the upper side of which is the last.
    fn cut(&self, cell: &Cell, parts: &[Part], heights: &mut Vec<f32>) {
        let (low, high) = (cell.low, cell.high);
        heights.clear();
        let mut add = |y: f32, [from, to]: [f32; 2]| {
            if y > from && y < to {
                heights.push(y);
            }
        };
        let whole = [low.y, high.y];
        if self.bounds.is_in_rows {
            let count = self.rows_in_cell();
            (1..count).for_each(|k| add(low.y + (high.y - low.y) * (k as f32 / count as f32), whole));
        }
        for (k, part) in parts.iter().enumerate() {
            let own = part.heights;
            let piece = &part.piece;
            // Where one that is nearly level crosses others is lost in rounding: it is cut off as a whole.
            let is_level = piece.is_nearly_level() && cell.has(piece.places);
            for y in piece.heights {
                if is_level || cell.has(piece.ends_at(y)) {
                    add(y, whole);
                }
            }
            let [start, slope] = piece.line;
            for x in [low.x, high.x] {
                if (part.ends[0] < x) != (part.ends[1] < x) {
                    add((x - start) / slope, own);
                }
            }
            for other in &parts[k + 1..] {
                let both = [own[0].max(other.heights[0]), own[1].min(other.heights[1])];
                let [a, b] = both.map(|y| piece.at(y) < other.piece.at(y));
                if both[0] < both[1] && a != b {
                    add((other.piece.line[0] - start) / (slope - other.piece.line[1]), both);
                }
            }
        }
        if !cell.is_inside {
            self.cut_by_light(cell, parts, &mut add);
        }
        heights.sort_unstable_by(f32::total_cmp);
        heights.push(high.y);
    }

    /// Adds the heights at which the light's bounds have corners, cross each other, the sides of a cell, and its pieces.
    fn cut_by_light(&self, cell: &Cell, parts: &[Part], add: &mut impl FnMut(f32, [f32; 2])) {
        let whole = [cell.low.y, cell.high.y];
        let Bounds { sides, corners, emits, .. } = self.bounds;
        let (middle, radius) = emits.mask.circle();
        // |(s + t y, y) - middle| = radius
        let on_circle = |[start, slope]: [f32; 2]| {
            let (a, b, c) = (1.0 + slope * slope, slope * (start - middle.x) - middle.y, start - middle.x);
            let root = (b * b - a * (c * c + middle.y * middle.y - radius * radius)).sqrt();
            [-root, root].map(|root| (root - b) / a)
        };
        corners.iter().for_each(|p| add(p.y, whole));
        for (k, side) in sides.iter().enumerate() {
            for other in &sides[..k] {
                let p = side.cross(*other);
                add(p.y / p.z, whole);
            }
            on_circle([-side.z / side.x, -side.y / side.x]).into_iter().for_each(|y| add(y, whole));
        }
        let upright = [cell.low.x, cell.high.x].map(|x| ([x, 0.0], whole));
        let pieces = parts.iter().map(|part| (part.piece.line, part.heights));
        for (line, heights) in upright.into_iter().chain(pieces) {
            on_circle(line).into_iter().for_each(|y| add(y, heights));
            sides.iter().for_each(|side| add(-(side.x * line[0] + side.z) / (side.x * line[1] + side.y), heights));
        }
    }

    /// The number at a point, by all pieces.
    fn number(&self, p: Vec2) -> i32 {
        let of = |piece: &Piece| {
            let on_path = piece.on_path().map_or(0, |(height, step)| if p.y >= height { step } else { 0 });
            let left = if piece.at_or_end(p.y) < p.x { piece.step } else { 0 };
            on_path + if piece.is_at(p.y) { left - piece.step_left_at(p.y) } else { 0 }
        };
        self.pieces.iter().map(of).sum()
    }
}
