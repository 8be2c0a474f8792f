//! Projects silhouettes onto the square that faces the light.

use crate::select::{STEP, Silhouettes};
use fearless_simd::{Simd, f32x8, i32x8, prelude::*};
use glam::{Vec2, Vec3};
use lobe_core::vec3x8::Vec3x8;
use lobe_core::{Capsule, Outline};
use shading::VisibilityQuery;
use visibility_mask::{Raster, UnitSquare};

/// Ends nearer than this, or than this fraction of the light's distance, are clipped: they are far outside the window.
pub(crate) const NEAR: f32 = 1e-7;
/// The largest position outside.
pub(crate) const FAR_OUTSIDE: f32 = 1e7;

/// The window, its rows and samples, and the depths between which surfaces block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) square: UnitSquare,
    pub(crate) raster: Raster,
    pub(crate) rows: usize,
    near: f32,
    /// Depth of the light along the square's axis: of the circle where the cone touches it.
    pub(crate) far: f32,
    /// The depth at which silhouettes are clipped: `far`, or infinite if they have been clipped already.
    pub(crate) clip: f32,
    /// Where a tube of light ends rays before that.
    body: Option<Capsule>,
    /// Position at row 0, in samples, of a line that crosses the visible part of the light in every row, and its growth from row to row.
    middle: [f32; 2],
}

impl View {
    /// Rays end at a tube's surface. Outlines end at its plane, or, where triangles touch it, behind it: they are cut by its surface then.
    pub(crate) fn new(
        square: UnitSquare,
        raster: Raster,
        rows: usize,
        query: &VisibilityQuery<'_>,
        is_touched: bool,
    ) -> Self {
        let (cone, cos) = (query.cone, query.cone.cos());
        let distance = cone.distance;
        // The square of a flat light is in its plane.
        let far = query.outline.map_or(distance * cos * cos, |outline| outline.depth_to(is_touched));
        let near = NEAR * distance.min(1.0);
        let left = square.center.x - square.half.x;
        let middle = query.outline.map_or([-left * raster.samples, 0.0], |outline| {
            let bottom = square.center.y - square.half.y;
            let place = |p: Vec2| Vec2::new((p.x - left) * raster.samples, (p.y - bottom) * raster.rows - 0.5);
            line_through(ends_of(outline, &square).map(place))
        });
        let far = far.max(near);
        let body = query.outline.and_then(Outline::body).copied();
        Self { square, raster, rows, near, far, clip: far, body, middle }
    }

    /// The unit direction of a sample, and the distance to the light along it: to its plane, or to a tube's surface.
    pub(crate) fn ray(&self, row: usize, sample: usize) -> (Vec3, f32) {
        self.ray_at(row, sample as f32 + 0.5 + Raster::shift(row))
    }

    /// The same for a position in a row, in samples of the row without shift.
    pub(crate) fn ray_at(&self, row: usize, at: f32) -> (Vec3, f32) {
        self.ray_to(self.point(row, at))
    }

    /// The same for a point in plane coordinates.
    pub(crate) fn ray_to(&self, p: Vec2) -> (Vec3, f32) {
        let length = (1.0 + p.length_squared()).sqrt();
        let direction = self.square.world(p.extend(1.0)) / length;
        (direction, self.body.and_then(|body| body.entry(direction)).unwrap_or(self.far * length))
    }

    /// Such a position, in plane coordinates.
    pub(crate) fn point(&self, row: usize, at: f32) -> Vec2 {
        let Raster { left, bottom, samples, rows, .. } = self.raster;
        Vec2::new(left + at / samples, bottom + (row as f32 + 0.5) / rows)
    }

    /// The corners of the window.
    pub(crate) fn corners(&self) -> (Vec2, Vec2) {
        (self.square.center - self.square.half, self.square.center + self.square.half)
    }

    /// The ends of the part of a piece of an outline that is before the light's plane, in plane coordinates, and its line `x = s + t y` there as `[s, t]`, which is not finite if
    /// it is level.
    pub(crate) fn on_plane(&self, ends: [Vec3; 2]) -> Option<([Vec2; 2], [f32; 2])> {
        let [mut a, mut b] = ends.map(|p| self.square.local(p));
        // Clipped ends would be too far outside for it.
        let line = a.cross(b - a);
        for (plane, sign) in [(self.near, 1.0), (self.clip, -1.0)] {
            match [a, b].map(|p| sign * p.z > sign * plane) {
                [false, false] => return None,
                [true, true] => {}
                [is_before, _] => {
                    let cut = (a.lerp(b, (plane - a.z) / (b.z - a.z))).with_z(plane);
                    (a, b) = if is_before { (a, cut) } else { (cut, b) };
                }
            }
        }
        Some(([a, b].map(|p| p.truncate() / p.z), [-line.z / line.x, -line.y / line.x]))
    }

    /// Position, in samples, of a line that crosses the visible part of the light in every row and stays inside of the window: a light
    /// and a window are convex.
    fn middle(&self, row: f32) -> f32 {
        let [start, slope] = self.middle;
        (start + slope * row.clamp(-1.0, self.rows as f32)).clamp(0.0, self.raster.width)
    }

    /// A point on the square, in samples and rows.
    fn place(&self, x: f32, y: f32) -> Vec2 {
        let at =
            Vec2::new((x - self.raster.left) * self.raster.samples, (y - self.raster.bottom) * self.raster.rows - 0.5);
        at.clamp(Vec2::splat(-FAR_OUTSIDE), Vec2::splat(FAR_OUTSIDE))
    }
}

/// The lowest and the highest corner of a light's outline. The line through both is inside of it at all heights between them, since it is convex.
pub(crate) fn ends_of(outline: &Outline, square: &UnitSquare) -> [Vec2; 2] {
    let points = outline.on_plane([square.right, square.up]);
    let low = points.clone().reduce(|a, b| if b.y < a.y { b } else { a }).unwrap_or_default();
    let high = points.reduce(|a, b| if b.y > a.y { b } else { a }).unwrap_or_default();
    [low, high]
}

/// The line `x = s + t y` through two points, as `[s, t]`; upright where these are at one height.
pub(crate) fn line_through([low, high]: [Vec2; 2]) -> [f32; 2] {
    let slope = (high.x - low.x) / (high.y - low.y);
    let slope = if slope.is_finite() { slope } else { 0.0 };
    [low.x - slope * low.y, slope]
}

/// A piece of an outline that crosses row lines, from a lower one to a higher one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Position in samples at row 0, and its growth from row to row.
    pub(crate) start: f32,
    pub(crate) slope: f32,
    /// Positions of the two ends, in order.
    pub(crate) low: f32,
    pub(crate) high: f32,
    /// The first row line at or above each end.
    pub(crate) rows: [i32; 2],
    /// Whether each end is left of the view's middle.
    pub(crate) left: [bool; 2],
    /// The growth of the number of surfaces from left to right.
    pub(crate) step: i32,
}

impl Crossing {
    /// From its two ends, whose rows are known; `None` if it changes no number.
    #[inline(always)]
    fn new(
        view: &View,
        [a, b]: [f32; 2],
        [start, slope]: [f32; 2],
        [row_a, row_b]: [i32; 2],
        left: [bool; 2],
        step: i32,
    ) -> Option<Self> {
        let none = row_a == row_b && (left[0] == left[1] || row_a == 0 || row_a == view.rows as i32);
        let beside = a.min(b) > view.raster.width + 1.0 || a.max(b) < -1.0;
        if none || beside {
            return None;
        }
        let up = row_a <= row_b;
        Some(Self {
            start,
            slope,
            low: a.min(b) - 1.0,
            high: a.max(b) + 1.0,
            rows: if up { [row_a, row_b] } else { [row_b, row_a] },
            left: if up { left } else { [left[1], left[0]] },
            step: if up { step } else { -step },
        })
    }

    /// Its position in a row, in samples without the row's shift.
    pub(crate) fn at(&self, row: usize) -> f32 {
        (row as f32 * self.slope + self.start).max(self.low).min(self.high)
    }

    /// One piece of an outline, between two points in front of the light's plane, as [`project`] projects it.
    pub(crate) fn of_segment(view: &View, a: Vec3, b: Vec3, step: i32) -> Option<Self> {
        let ends = [a, b].map(|p| {
            let p = view.square.local(p);
            let z = p.z.max(view.near);
            view.place(p.x / z, p.y / z)
        });
        let rows = ends.map(|p| p.y.ceil().clamp(0.0, view.rows as f32) as i32);
        let slope = (ends[1].x - ends[0].x) / (ends[1].y - ends[0].y);
        let line = if slope.is_finite() { [ends[0].x - slope * ends[0].y, slope] } else { [ends[0].x, 0.0] };
        let left = ends.map(|p| p.x < view.middle(p.y));
        Self::new(view, ends.map(|p| p.x), line, rows, left, step)
    }
}

/// Projects silhouettes onto the square, and keeps those that cross row lines.
#[inline(always)]
pub(crate) fn project<S: Simd>(simd: S, silhouettes: &Silhouettes, view: &View, out: &mut Vec<Crossing>) {
    let UnitSquare { right, up, axis, .. } = view.square;
    let Raster { left, bottom, samples, rows, width } = view.raster;
    let (near, far) = (f32x8::splat(simd, view.near), f32x8::splat(simd, view.clip));
    let (zero, last) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, view.rows as f32));
    for first in (0..silhouettes.len()).step_by(8) {
        let [a, b] = [silhouettes.load3(simd, 0, first), silhouettes.load3(simd, 3, first)];
        let mut a = Vec3x8::new(a.dot_one(right), a.dot_one(up), a.dot_one(axis));
        let mut b = Vec3x8::new(b.dot_one(right), b.dot_one(up), b.dot_one(axis));
        // The line through both ends, from a × (b − a): clipped ends would be too far outside for it.
        let line = a.cross(b - a);
        let flat = line.x.simd_eq(zero);
        let inverse = f32x8::splat(simd, -1.0) / flat.select(f32x8::splat(simd, 1.0), line.x);
        let lean = line.y * inverse;
        let start = (lean * (bottom + 0.5 / rows) + (line.z * inverse - left)) * samples;
        let slope = lean * (samples / rows);
        let is_near = [a.z.simd_lt(near), b.z.simd_lt(near)];
        let is_far = [!a.z.simd_lt(far), !b.z.simd_lt(far)];
        let mut drop = (is_near[0] & is_near[1]) | (is_far[0] & is_far[1]);
        for (plane, cut) in [(near, is_near), (far, is_far)] {
            if (cut[0] | cut[1]).any_true() {
                let [from_b, from_a] = [clip_at(plane, b, a), clip_at(plane, a, b)];
                (a, b) = (a.or(cut[0], from_b), b.or(cut[1], from_a));
            }
        }
        let xa = limit(simd, (a.x / a.z - left) * samples);
        let xb = limit(simd, (b.x / b.z - left) * samples);
        let ya = limit(simd, (a.y / a.z - bottom) * rows - 0.5);
        let yb = limit(simd, (b.y / b.z - bottom) * rows - 0.5);
        let (ra, rb) = (ya.ceil().max(zero).min(last), yb.ceil().max(zero).min(last));
        drop |= ra.max(rb).simd_eq(zero) | ra.min(rb).simd_eq(last);
        drop |= xa.min(xb).simd_gt(f32x8::splat(simd, width + 1.0)) | xa.max(xb).simd_lt(f32x8::splat(simd, -1.0));
        // An edge between two rows matters only if it crosses the middle.
        let left = [xa.simd_lt(middle(simd, view, ya)), xb.simd_lt(middle(simd, view, yb))];
        drop |= ra.simd_eq(rb) & !(left[0] ^ left[1]);
        let mut keep = (!drop).to_bitmask() & u64::from(silhouettes.lanes(first));
        if keep == 0 {
            continue;
        }
        let start: [f32; 8] = flat.select((xa + xb) * 0.5, start).into();
        let slope: [f32; 8] = flat.select(zero, slope).into();
        let [xa, xb]: [[f32; 8]; 2] = [xa.into(), xb.into()];
        let ra: [i32; 8] = ra.to_int::<i32x8<S>>().into();
        let rb: [i32; 8] = rb.to_int::<i32x8<S>>().into();
        let [left_a, left_b] = left.map(|left| left.to_bitmask());
        let steps: [i32; 8] = silhouettes.load(simd, STEP, first).to_int::<i32x8<S>>().into();
        while keep != 0 {
            let l = keep.trailing_zeros() as usize & 7;
            keep &= keep - 1;
            let left = [left_a >> l & 1 == 1, left_b >> l & 1 == 1];
            out.extend(Crossing::new(view, [xa[l], xb[l]], [start[l], slope[l]], [ra[l], rb[l]], left, steps[l]));
        }
    }
}

/// [`View::middle`] at eight heights.
#[inline(always)]
fn middle<S: Simd>(simd: S, view: &View, row: f32x8<S>) -> f32x8<S> {
    let row = row.max(f32x8::splat(simd, -1.0)).min(f32x8::splat(simd, view.rows as f32));
    let [start, slope] = view.middle.map(|x| f32x8::splat(simd, x));
    (start + row * slope).max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, view.raster.width))
}

/// Limits a position to the largest one.
#[inline(always)]
fn limit<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    x.max(f32x8::splat(simd, -FAR_OUTSIDE)).min(f32x8::splat(simd, FAR_OUTSIDE))
}

/// The point at which an edge meets a plane of equal depth, from the end on the right side of it: all triangles of the edge find
/// the same point.
#[inline(always)]
fn clip_at<S: Simd>(plane: f32x8<S>, from: Vec3x8<S>, to: Vec3x8<S>) -> Vec3x8<S> {
    let t = (plane - from.z) / (to.z - from.z);
    Vec3x8::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y), plane)
}
