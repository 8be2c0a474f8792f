//! Where a light is lit, as segments of its plane, and narrow windows around them.

use crate::row;
use crate::{Mask, Raster, UnitSquare};
use glam::{Vec2, Vec3};

/// A window is turned along a shape if that makes it smaller than this part of the one that is not turned.
const TURNED: f32 = 0.6;
/// A thin window, whose sides have less than this ratio, is divided if both parts together are smaller than this part of it.
const THIN: f32 = 0.2;
const DIVIDED: f32 = 0.8;
/// Where a window may be divided, in parts of its sides.
const CUTS: [f32; 3] = [0.25, 0.5, 0.75];
/// Lit samples of a row that are no farther apart than 1/NEAR of it are one segment.
const NEAR: u32 = 16;
/// The lit part ends between two samples, of which one is dark: a window around it has this much room, in samples and in rows.
pub(crate) const ROOM_SAMPLES: f32 = 2.0;
pub(crate) const ROOM_ROWS: f32 = 1.0;
/// The number of places that show the direction of a shape.
const SURE: usize = 3;
/// A side is along a window's own if it turns from it by no more than this.
const ALONG: f32 = 1e-5;
/// The room beside exact segments, in parts of their width.
const BESIDE: f32 = 0.15;

/// A lit segment of a row or of a column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    ends: [Vec2; 2],
    /// The distance of the lines that it is one of, and whether these are columns.
    line: f32,
    is_column: bool,
    /// How far its ends may be from those of the lit part of the line.
    room: f32,
}

/// A half-plane `a x + b y + c > 0`.
pub(crate) type Side = Vec3;

/// Adds the lit places of a mask, in the plane's coordinates of a window.
pub(crate) fn add(mask: &Mask, window: &UnitSquare, out: &mut Vec<Place>) {
    let turn = window.turn_to(mask.square());
    let Raster { left, samples, width, rows, .. } = mask.raster();
    let line = rows.recip();
    let near = width as u32 / NEAR;
    for j in (0..mask.side()).filter(|j| !mask.is_row_dark(*j)) {
        let lit = mask.lit(j);
        let y = mask.row_y(j);
        let at = |sample: u32| turn.rotate(Vec2::new(left + (sample as f32 + Raster::shift(j)) / samples, y));
        let mut first = None;
        let mut last = 0;
        row::each(&lit, |[from, to]| {
            let start = *first.get_or_insert(from);
            if from > last + near && last > start {
                out.push(Place { ends: [at(start), at(last)], line, is_column: false, room: samples.recip() });
                first = Some(from);
            }
            last = to;
        });
        if let Some(start) = first {
            out.push(Place { ends: [at(start), at(last)], line, is_column: false, room: samples.recip() });
        }
    }
    for (ends, line) in mask.openings() {
        let is_column = ends[0].x == ends[1].x;
        out.push(Place { ends: ends.map(|p| turn.rotate(p)), line: *line, is_column, room: 0.0 });
    }
}

/// A rectangle of the plane whose right side has any direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    pub(crate) right: Vec2,
    pub(crate) low: Vec2,
    pub(crate) high: Vec2,
}

impl Turned {
    /// Around places, with room for what lies between lines. `None` without places.
    fn around(right: Vec2, places: &[Place]) -> Option<Self> {
        let back = Vec2::new(right.x, -right.y);
        let (mut low, mut high, mut room) = (Vec2::INFINITY, Vec2::NEG_INFINITY, Vec2::ZERO);
        for place in places {
            for end in place.ends {
                let p = back.rotate(end);
                (low, high) = (low.min(p), high.max(p));
            }
            room = room.max(Vec2::new(ROOM_SAMPLES * place.room, ROOM_ROWS * place.line));
        }
        let beside = Vec2::new(BESIDE * (high.x - low.x), 0.0);
        // The direction of a shape that few lines cross is not known.
        let across = if places.len() < SURE { room.y } else { room.x };
        let room = Vec2::new(across, room.y) + beside;
        (!places.is_empty()).then(|| Self { right, low: low - room, high: high + room })
    }

    /// Along the places if they are long and thin, else not turned.
    fn along(places: &[Place], may_turn: bool) -> Option<Self> {
        let plain = Self::around(Vec2::X, places)?;
        if !may_turn {
            return Some(plain);
        }
        let ends = || places.iter().flat_map(|place| place.ends);
        let middle = ends().sum::<Vec2>() / (2 * places.len()) as f32;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for p in ends() {
            let d = p - middle;
            xx += d.x * d.x;
            xy += d.x * d.y;
            yy += d.y * d.y;
        }
        // Rows run across the shape: of the two main directions the one of the least spread.
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy) + core::f32::consts::FRAC_PI_2;
        let turned = Self::around(Vec2::from_angle(angle), places)?;
        Some(if turned.area() < TURNED * plain.area() { turned } else { plain })
    }

    pub(crate) fn size(&self) -> Vec2 {
        (self.high - self.low).max(Vec2::ZERO)
    }

    pub(crate) fn area(&self) -> f32 {
        self.size().element_product()
    }

    /// The window on the plane of another one.
    pub(crate) fn window(&self, of: &UnitSquare, smallest: f32) -> UnitSquare {
        let (center, half) = (0.5 * (self.low + self.high), (0.5 * self.size()).max(Vec2::splat(smallest)));
        if self.right == Vec2::X {
            return UnitSquare { center, half, ..*of };
        }
        let right = of.right * self.right.x + of.up * self.right.y;
        let up = of.up * self.right.x - of.right * self.right.y;
        UnitSquare { right, up, center, half, ..*of }
    }

    /// The part of it inside of those sides of a cell that are along its own. Rows that end where the light does see all of it; others see a row
    /// more or less.
    pub(crate) fn within(mut self, cell: &[Side]) -> Self {
        for side in cell {
            let Vec3 { x, y, z } = self.local(*side);
            let axis = usize::from(x.abs() < y.abs());
            let [along, other] = [[x, y], [y, x]][axis];
            if other.abs() > ALONG * along.abs() {
                continue;
            }
            let end = -z / along;
            if along > 0.0 {
                self.low[axis] = self.low[axis].max(end).min(self.high[axis]);
            } else {
                self.high[axis] = self.high[axis].min(end).max(self.low[axis]);
            }
        }
        self
    }

    /// A half-plane in the coordinates of this window.
    pub(crate) fn local(&self, side: Side) -> Side {
        let normal = Vec2::new(self.right.x, -self.right.y).rotate(side.truncate());
        normal.extend(side.z)
    }
}

/// Places in a convex cell of the plane, and the window around them.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub(crate) window: Turned,
    pub(crate) cell: Vec<Side>,
    places: Vec<Place>,
}

impl Group {
    /// `None` without places.
    pub(crate) fn new(places: Vec<Place>, cell: Vec<Side>, may_turn: bool) -> Option<Self> {
        Some(Self { window: Turned::along(&places, may_turn)?.within(&cell), cell, places })
    }

    /// Whether the window is filled by a part of it, as far as the lines show.
    fn is_filled(&self, part: f32) -> bool {
        let mut areas = [0.0; 2];
        for place in &self.places {
            areas[usize::from(place.is_column)] += place.line * place.ends[0].distance(place.ends[1]);
        }
        areas[0].max(areas[1]) > part * self.window.area()
    }

    /// Two groups whose windows are the smallest together; `None` if this one's is filled by a part of it.
    pub(crate) fn divided(&self, part: f32, may_turn: bool) -> Option<[Self; 2]> {
        if self.places.len() < 2 * SURE || self.is_filled(part) {
            return None;
        }
        let Turned { right, low, .. } = self.window;
        let size = self.window.size();
        let mut best = (f32::INFINITY, None);
        for (axis, direction) in [right, right.perp()].into_iter().enumerate() {
            let cuts = CUTS.map(|cut| low[axis] + cut * size[axis]);
            for cut in cuts.into_iter().chain(widest_gap(&self.places, direction)) {
                let side = direction.extend(-cut);
                let parts = [side, -side].map(|side| beyond(&self.places, side));
                let [Some(a), Some(b)] = parts.each_ref().map(|places| Turned::along(places, may_turn)) else {
                    continue;
                };
                if a.area() + b.area() < best.0 {
                    best = (a.area() + b.area(), Some((side, parts, [a, b])));
                }
            }
        }
        let (sum, best) = best;
        if sum > DIVIDED * self.window.area() && size.min_element() < THIN * size.max_element() {
            return None;
        }
        let (side, [first, second], [a, b]) = best?;
        let part = |side: Side, places, window: Turned| {
            let mut cell = self.cell.clone();
            cell.push(side);
            Self { window: window.within(&cell), cell, places }
        };
        Some([part(side, first, a), part(-side, second, b)])
    }
}

/// The middle of the widest gap between places along a direction.
fn widest_gap(places: &[Place], direction: Vec2) -> Option<f32> {
    let mut spans: Vec<[f32; 2]> = places
        .iter()
        .map(|place| place.ends.map(|p| direction.dot(p)))
        .map(|[a, b]| if a < b { [a, b] } else { [b, a] })
        .collect();
    spans.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut end, mut widest) = (f32::INFINITY, None);
    let mut gap = 0.0;
    for [from, to] in spans {
        if from - end > gap {
            (gap, widest) = (from - end, Some(0.5 * (from + end)));
        }
        end = if end.is_finite() { end.max(to) } else { to };
    }
    widest
}

/// The places in a half-plane.
fn beyond(places: &[Place], side: Side) -> Vec<Place> {
    let mut out = Vec::with_capacity(places.len());
    for place in places {
        let at = place.ends.map(|p| side.truncate().dot(p) + side.z);
        let cut = || place.ends[0].lerp(place.ends[1], at[0] / (at[0] - at[1]));
        match at.map(|at| at >= 0.0) {
            [true, true] => out.push(*place),
            [true, false] => out.push(Place { ends: [place.ends[0], cut()], ..*place }),
            [false, true] => out.push(Place { ends: [cut(), place.ends[1]], ..*place }),
            [false, false] => {}
        }
    }
    out
}

/// The half-planes whose common part is a window.
pub(crate) fn sides(window: &UnitSquare) -> Vec<Side> {
    let (low, high) = (window.center - window.half, window.center + window.half);
    vec![
        Vec3::new(1.0, 0.0, -low.x),
        Vec3::new(-1.0, 0.0, high.x),
        Vec3::new(0.0, 1.0, -low.y),
        Vec3::new(0.0, -1.0, high.y),
    ]
}
