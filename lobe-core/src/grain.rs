//! Microfacets that differ along and across a direction of the surface: brushed metal.

use crate::Microfacets;
use crate::microfacets::{alpha_sq, schlick, seen_from};
use crate::vec3x8::Vec3x8;
use core::f32::consts::{FRAC_1_PI, PI};
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::{Vec2, Vec3};

/// The direction along which microfacets are rougher than across it, and by how much: the anisotropic GGX distribution
/// `D = 1/(π α_t α_b ((h·t)²/α_t² + (h·b)²/α_b² + (h·n)²)²)` (B. Burley, *Physically Based Shading at Disney*, 2012).
///
/// Two numbers of eleven bits, so that a [`PackedLobe`](crate::PackedLobe) holds them in its kind: a turn from the eye's side of the surface, and `q` with
/// `α_t = α_b + (1 − α_b) q²`. Directions are within 0.05°.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::Grain;
/// let (normal, view) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
/// let grain = Grain::new(normal, view, Vec3::new(1.0, 1.0, 0.0), 0.7);
/// let along = grain.direction(normal, view);
/// assert!((along.dot(Vec3::new(1.0, 1.0, 0.0).normalize()).abs() - 1.0).abs() < 1e-5);
/// assert!((grain.alpha(0.1) - (0.1 + 0.9 * 0.49)).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grain {
    bits: u32,
}

/// Steps of each of both numbers.
pub(crate) const STEPS: u32 = 1 << 11;

impl Grain {
    /// Rougher along a tangent (of any length, projected onto the surface), by a strength in [0, 1], seen from a direction.
    #[must_use]
    pub fn new(normal: Vec3, view: Vec3, tangent: Vec3, strength: f32) -> Self {
        let (_, _, forward) = seen_from(normal, view);
        let turn = tangent.dot(normal.cross(forward)).atan2(tangent.dot(forward)) / PI;
        let turn = ((turn.rem_euclid(1.0) * STEPS as f32).round() as u32) % STEPS;
        let strength = (strength.clamp(0.0, 1.0) * (STEPS - 1) as f32).round() as u32;
        Self { bits: turn * STEPS + strength }
    }

    /// No stretch.
    pub(crate) const NONE: Self = Self { bits: 0 };

    pub(crate) const fn from_bits(bits: u32) -> Self {
        Self { bits: bits % (STEPS * STEPS) }
    }

    pub(crate) const fn bits(self) -> u32 {
        self.bits
    }

    /// `α_t` for an `α_b`.
    #[must_use]
    pub fn alpha(self, across: f32) -> f32 {
        let strength = (self.bits % STEPS) as f32 / (STEPS - 1) as f32;
        across + (1.0 - across) * (strength * strength)
    }

    /// Cosine and sine of the turn from the eye's side of the surface.
    #[inline]
    pub(crate) fn turn(self) -> Vec2 {
        let (sin, cos) = (PI * (self.bits / STEPS) as f32 / STEPS as f32).sin_cos();
        Vec2::new(cos, sin)
    }

    /// Where a mirror's direction spreads most, along the plane of incidence and aside of it, and the widths of the highlight along that and across it,
    /// for an `α_b` and the eye's cosine.
    pub(crate) fn highlight(self, across: f32, cos: f32) -> (Vec2, [f32; 2]) {
        let (turn, rough) = (self.turn(), self.alpha(across));
        // Half vectors that turn aside turn the mirror's direction by less.
        let (a, b) = (Vec2::new(turn.x, turn.y * cos) * rough, Vec2::new(-turn.y, turn.x * cos) * across);
        let (xx, yy, xy) = (a.x * a.x + b.x * b.x, a.y * a.y + b.y * b.y, a.x * a.y + b.x * b.y);
        let (half, mean) = ((0.5 * (xx - yy)).hypot(xy), 0.5 * (xx + yy));
        let double = if half > 1e-30 { 0.5 * (xx - yy) / half } else { 1.0 };
        let (x, y) = ((0.5 * (1.0 + double)).sqrt(), (0.5 * (1.0 - double)).max(0.0).sqrt());
        let (long, short) = ((mean + half).sqrt(), (mean - half).max(0.0).sqrt());
        (Vec2::new(x, if xy < 0.0 { -y } else { y }), [2.0 * long, 2.0 * short.max(across * across)])
    }

    /// By how much the highlight's least width is smaller than `2α_b`, for an `α_b` and the eye's cosine to the normal.
    #[must_use]
    pub fn narrowing(self, across: f32, cos: f32) -> f32 {
        let [_, short] = self.highlight(across, cos).1;
        short / (2.0 * across)
    }

    /// The unit tangent along which it is rougher.
    #[must_use]
    pub fn direction(self, normal: Vec3, view: Vec3) -> Vec3 {
        let (_, _, forward) = seen_from(normal, view);
        let turn = self.turn();
        forward * turn.x + normal.cross(forward) * turn.y
    }
}

/// The numbers of microfacets in a direction: [`MicrofacetsAt`](crate::MicrofacetsAt), or [`BrushedAt`] where they have a grain.
pub trait Facets: Copy {
    /// Both numbers `D·W·(1 − s)` and `D·W·s` in a direction `v` of unit length; 0 below the horizon.
    fn both(&self, v: Vec3) -> [f32; 2];

    /// The same in eight directions, to the bit.
    #[doc(hidden)]
    fn both_of_eight<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> [f32x8<S>; 2];
}

/// [`Microfacets`] with a grain at a receiver, ready to be evaluated in many directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrushedAt {
    normal: Vec3,
    /// The eye's direction; above the horizon.
    view: Vec3,
    /// `t/α_t` and `b/α_b`; `α_t t` and `α_b b`.
    pub(crate) fine: [Vec3; 2],
    rough: [Vec3; 2],
    /// `1/(π α_t α_b)`.
    scale: f32,
    /// The eye's `√(α_t²(t·ω_o)² + α_b²(b·ω_o)² + (n·ω_o)²)`.
    shadowing: f32,
}

impl BrushedAt {
    /// Those of this grain, at a receiver of this normal.
    #[must_use]
    pub fn new(facets: &Microfacets, grain: Grain, normal: Vec3) -> Self {
        let (cos, sin, forward) = seen_from(normal, facets.view);
        let (turn, aside) = (grain.turn(), normal.cross(forward));
        let (t, b) = (forward * turn.x + aside * turn.y, aside * turn.x - forward * turn.y);
        let across = alpha_sq(facets.exponent).sqrt();
        let along = grain.alpha(across);
        let (x, y) = (along * sin * turn.x, across * sin * turn.y);
        Self {
            normal,
            view: normal * cos + forward * sin,
            fine: [t / along, b / across],
            rough: [t * along, b * across],
            scale: FRAC_1_PI / (along * across),
            shadowing: (x * x + y * y + cos * cos).sqrt(),
        }
    }

    /// The square of the half vector's slope, in units of `α` along and across: `((h·t)²/α_t² + (h·b)²/α_b²)/(h·n)²`, of which alone the distribution
    /// depends. In eight directions.
    #[inline(always)]
    pub fn slope_square_of_eight<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> f32x8<S> {
        let h = v.plus(self.view);
        let up = h.dot_one(self.normal).max(f32x8::splat(simd, 1e-6));
        let (x, y) = (h.dot_one(self.fine[0]), h.dot_one(self.fine[1]));
        (x * x + y * y) / (up * up)
    }

    /// Whether this slope is larger than `slope`, and surely so, in all directions within chords of a length from any of eight.
    #[inline(always)]
    pub fn are_steeper<S: Simd>(&self, simd: S, v: Vec3x8<S>, slope: f32, chord: f32) -> bool {
        let h = v.plus(self.view);
        let up = h.dot_one(self.normal) * slope;
        // By so much numbers change along a chord.
        let [along, across] = self.fine.map(|fine| f32x8::splat(simd, (fine.length() + slope) * chord));
        let along = (h.dot_one(self.fine[0]).abs() - up).simd_gt(along);
        (along | (h.dot_one(self.fine[1]).abs() - up).simd_gt(across)).all_true()
    }
}

impl Facets for BrushedAt {
    #[inline(always)]
    fn both(&self, v: Vec3) -> [f32; 2] {
        let h = self.view + v;
        let (up, x, y, square) = (self.normal.dot(h), self.fine[0].dot(h), self.fine[1].dot(h), h.length_squared());
        let spread = up * up + x * x + y * y;
        let spread = if spread > 1e-30 { spread } else { 1e-30 };
        let d = self.scale * (square / spread) * (square / spread);
        let light = self.normal.dot(v);
        let light = if light > 0.0 { light } else { 0.0 };
        let (x, y) = (self.rough[0].dot(v), self.rough[1].dot(v));
        let shadowed = (light * light + x * x + y * y).sqrt();
        let fifth = schlick(0.5 * square.sqrt());
        let value = d * (0.5 * light / (light * self.shadowing + shadowed * self.normal.dot(self.view)));
        [value * (1.0 - fifth), value * fifth]
    }

    #[inline(always)]
    fn both_of_eight<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> [f32x8<S>; 2] {
        let [zero, one] = [0.0, 1.0].map(|x| f32x8::splat(simd, x));
        let h = v.plus(self.view);
        let (up, x, y) = (h.dot_one(self.normal), h.dot_one(self.fine[0]), h.dot_one(self.fine[1]));
        let square = h.length_squared();
        let spread = (up * up + x * x + y * y).max(f32x8::splat(simd, 1e-30));
        let d = (square / spread) * self.scale * (square / spread);
        let light = v.dot_one(self.normal).max(zero);
        let (x, y) = (v.dot_one(self.rough[0]), v.dot_one(self.rough[1]));
        let shadowed = (light * light + x * x + y * y).sqrt();
        let x = (one - square.sqrt() * 0.5).max(zero);
        let fifth = x * x * x * x * x;
        let value = d * (light * 0.5 / (light * self.shadowing + shadowed * self.normal.dot(self.view)));
        [value * (one - fifth), value * fifth]
    }
}
