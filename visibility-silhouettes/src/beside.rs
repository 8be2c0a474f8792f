//! Edges beside the outline of a flat light.

use fearless_simd::{Level, Simd, dispatch, f32x8, mask32x8, prelude::*};
use glam::{Vec2, Vec3};
use lobe_core::vec3x8::Vec3x8;
use lobe_core::{Outline, orthonormal_basis};

/// Edges count as far beside an outline as this part of its size, a sample and a half of 64 from its middle: [`Outline::BEYOND`] holds them.
pub(crate) const MARGIN: f32 = 0.046_875;
/// Sides that are shorter than this part of the margin bound nothing.
pub(crate) const SHORTEST: f32 = 1e-3;
/// Outlines of more corners stand in a polygon of so many.
pub(crate) const MOST: usize = 8;

/// The outline of a light, or a polygon around it, with a margin.
pub(crate) struct Beside {
    /// Inward normals of planes through the receiver, in units of the plane at distance 1.
    planes: [Vec3; MOST],
    /// Corners on that plane.
    corners: [Vec3; MOST],
    count: usize,
    margin: f32,
    axis: Vec3,
    far: f32,
}

impl Beside {
    /// Of an outline, before which surfaces block up to a depth.
    pub(crate) fn new(outline: &Outline, far: f32) -> Self {
        let axis = outline.axis();
        let scale = 1.0 / outline.height();
        let mut out =
            Self { planes: [Vec3::ZERO; MOST], corners: [Vec3::ZERO; MOST], count: 0, margin: 0.0, axis, far };
        let corners = outline.corners();
        let middle = outline.middle() * scale;
        let square = corners.iter().map(|p| (*p * scale).distance_squared(middle)).fold(0.0, f32::max);
        out.margin = MARGIN * square.sqrt();
        if corners.len() <= MOST {
            corners.iter().for_each(|p| out.push(*p * scale));
        } else {
            out.push_around(outline);
        }
        for i in 0..out.count {
            let (p, q) = (out.corners[i], out.corners[(i + 1) % out.count]);
            let normal = p.cross(q - p);
            let aside = (normal - axis * axis.dot(normal)).length();
            // The direction of a shorter side is rounding.
            let normal = if aside > SHORTEST * out.margin { normal / aside } else { Vec3::ZERO };
            out.planes[i] = normal + axis * out.margin;
        }
        out
    }

    fn push(&mut self, corner: Vec3) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    /// An octagon around an outline of many corners, along the longest way between two of them.
    fn push_around(&mut self, outline: &Outline) {
        let corners = outline.corners();
        let half = corners.len() / 2;
        let across = |i: usize| corners[i + half] - corners[i];
        let long =
            (0..half).map(across).fold(Vec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
        let u = (long - self.axis * self.axis.dot(long)).normalize_or(orthonormal_basis(self.axis).0);
        let frame = [u, self.axis.cross(u)];
        let points = outline.on_plane(frame);
        let reach = |n: Vec2| points.clone().map(|p| n.dot(p)).fold(f32::NEG_INFINITY, f32::max);
        // Corners of the box, cut at 45° about a middle that stretches it to a square.
        let [right, left, top, bottom] = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y].map(reach);
        let (center, size) = (0.5 * Vec2::new(right - left, top - bottom), 0.5 * Vec2::new(right + left, top + bottom));
        let size = size.max(Vec2::splat(f32::MIN_POSITIVE));
        for (x, y) in [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let sign = Vec2::new(x, y);
            let cut =
                points.clone().map(|p| (sign * (p - center) / size).element_sum()).fold(f32::NEG_INFINITY, f32::max);
            // From the box's side to the cut, and from the cut to the next side.
            let rest = (cut - 1.0).clamp(0.0, 1.0);
            let ends = [Vec2::new(1.0, rest), Vec2::new(rest, 1.0)];
            for end in if x * y > 0.0 { ends } else { [ends[1], ends[0]] } {
                let p = center + sign * end * size;
                self.push(frame[0] * p.x + frame[1] * p.y + self.axis);
            }
        }
    }

    /// Which of eight edges certainly pass beside, or lie behind the light's plane.
    #[inline(always)]
    pub(crate) fn misses_edges<S: Simd>(&self, simd: S, a: Vec3x8<S>, b: Vec3x8<S>) -> mask32x8<S> {
        let far = f32x8::splat(simd, self.far);
        (a.dot_one(self.axis).simd_gt(far) & b.dot_one(self.axis).simd_gt(far)) | self.misses(simd, a, b)
    }

    /// Whether a chord in which the light's plane or the light cuts a surface certainly passes beside.
    pub(crate) fn misses_chord(&self, a: Vec3, b: Vec3) -> bool {
        dispatch!(Level::new(), simd => self.misses(simd, Vec3x8::splat(simd, a), Vec3x8::splat(simd, b)).any_true())
    }

    /// Which of eight segments certainly pass beside.
    ///
    /// A convex polygon and a segment are apart if one of the polygon's sides or the segment's own line parts them.
    #[inline(always)]
    fn misses<S: Simd>(&self, simd: S, a: Vec3x8<S>, b: Vec3x8<S>) -> mask32x8<S> {
        let zero = f32x8::splat(simd, 0.0);
        let normal = a.cross(b - a);
        let size = normal.dot(normal).sqrt() * self.margin;
        let (mut low, mut high) = (f32x8::splat(simd, f32::INFINITY), f32x8::splat(simd, f32::NEG_INFINITY));
        for p in &self.corners[..self.count] {
            let at = normal.dot_one(*p);
            low = low.min(at);
            high = high.max(at);
        }
        let mut beside = low.simd_gt(size) | high.simd_lt(zero - size);
        for n in &self.planes[..self.count] {
            beside |= a.dot_one(*n).max(b.dot_one(*n)).simd_lt(zero);
        }
        beside
    }
}
