//! The cones of directions that eight spheres block of one receiver's light, side by side.

use crate::block::{Block, Candidates};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};
use glam::Vec3;
use lobe_core::{Capsule, Outline};
use shading::VisibilityQuery;

/// Relative to distances; f32 rounds the terms of the cheap question by some 1e-7.
pub(crate) const SLACK: f32 = 4e-6;

/// The light of a query as a sphere.
pub(crate) struct LightSphere {
    at: Vec3,
    axis: Vec3,
    sin: f32,
    cos: f32,
    distance: f32,
    radius: f32,
    /// Power of the receiver with respect to it.
    power: f32,
    /// The light is seen within less than a hemisphere.
    narrow: bool,
    /// Whether the cheap question comes before the exact one.
    culls: bool,
    /// Of a flat light the normal of its plane, and how far that is.
    plane: Option<(Vec3, f32)>,
    /// The tube that is the light, as the receiver sees it.
    body: Option<Capsule>,
}

/// The directions that eight spheres block, as [`BlockedCone`](crate::splat::BlockedCone)s.
pub(crate) struct BlockedCones<S: Simd> {
    pub(crate) to: [f32x8<S>; 3],
    pub(crate) tangent_radius: f32x8<S>,
    /// Of cones as wide as a hemisphere or wider the cosine, of others 1.
    pub(crate) wide: f32x8<S>,
    /// Of spheres that meet the light the radius, of others 0.
    pub(crate) meeting: f32x8<S>,
    /// Lanes that hide something; whether one hides all.
    pub(crate) hides: mask32x8<S>,
    pub(crate) darkens: bool,
}

/// The cones that spheres block under their self-distances τ: `d sin β`; `cos β` where that is not above zero, else 1;
/// and whether there is one. `half_of_tau` is `1/(2τ)`, anything where τ is zero.
#[inline(always)]
pub(crate) fn cones<S: Simd>(
    simd: S,
    to: [f32x8<S>; 3],
    radius: f32x8<S>,
    tau: f32x8<S>,
    half_of_tau: f32x8<S>,
) -> (f32x8<S>, f32x8<S>, mask32x8<S>) {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let d_sq = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
    let power = d_sq - radius * radius;
    let d = d_sq.sqrt();
    let tangent = power.simd_gt(zero) & (tau * tau).simd_le(power);
    // Inside the sphere of another object.
    let inside = !tangent & tau.simd_le(zero);
    // d(1 − cos β) = (r² − (d − τ)²)/(2τ), and (d sin β)² = d(1 − cos β)·(2d − d(1 − cos β)).
    let above = (radius - (d - tau)) * (radius + (d - tau));
    let rest = (above * half_of_tau).min(d + d);
    let chord = (rest * (d + d - rest)).max(zero).sqrt();
    let tangent_radius = tangent.select(radius, inside.select(zero, chord));
    let wide = !tangent & (inside | rest.simd_ge(d));
    let cos = if wide.any_true() {
        let cos = (!inside & d.simd_gt(zero)).select(one - rest / d, -one);
        wide.select(cos, one)
    } else {
        one
    };
    (tangent_radius, cos, tangent | inside | above.simd_gt(zero))
}

/// [`cones`] where every τ is zero: all exist.
#[inline(always)]
pub(crate) fn whole_cones<S: Simd>(simd: S, to: [f32x8<S>; 3], radius: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let tangent = (to[0] * to[0] + to[1] * to[1] + to[2] * to[2] - radius * radius).simd_gt(zero);
    (tangent.select(radius, zero), tangent.select(one, -one))
}

/// How far centres are along a unit direction, and the square of how far beside it.
#[inline(always)]
fn beside<S: Simd>(to: [f32x8<S>; 3], u: Vec3) -> (f32x8<S>, f32x8<S>) {
    let along = to[0] * u.x + to[1] * u.y + to[2] * u.z;
    let [x, y, z] = [to[0] - along * u.x, to[1] - along * u.y, to[2] - along * u.z];
    (along, x * x + y * y + z * z)
}

impl LightSphere {
    pub(crate) fn new(query: &VisibilityQuery<'_>, culls: bool) -> Self {
        let cone = query.cone;
        let (sin, cos) = (cone.sin_sq().sqrt(), cone.cos());
        let (distance, radius) = (cone.distance, cone.distance * sin);
        let power = distance * distance * (cos * cos);
        let narrow = cos > 0.0;
        let plane = query.outline.map(|light| (light.axis(), light.depth()));
        let body = query.outline.and_then(Outline::body).copied();
        Self { at: query.at.position, axis: cone.axis, sin, cos, distance, radius, power, narrow, culls, plane, body }
    }

    /// The cones that those of eight candidates that `which` names hide from the receiver of a query. Where in doubt, something.
    #[inline(always)]
    pub(crate) fn blocked_cones<S: Simd>(
        &self,
        simd: S,
        object: u32,
        block: &Candidates,
        which: mask32x8<S>,
    ) -> Option<BlockedCones<S>> {
        let Block { x, y, z, radius } = block.spheres;
        let [x, y, z, whole] = [x, y, z, radius].map(|column| f32x8::simd_from(simd, column));
        let mut to = [x - self.at.x, y - self.at.y, z - self.at.z];
        let (zero, u) = (f32x8::splat(simd, 0.0), self.axis);
        let (mut along, mut aside_sq) = beside(to, u);
        let mut which = which;
        if self.narrow && self.culls {
            which &= self.may_meet(simd, to, whole, along, aside_sq);
        }
        if which.all_false() {
            return None;
        }
        let own = u32x8::simd_from(simd, block.object).simd_eq(u32x8::splat(simd, object));
        let mut radius = whole;
        let (tangent_radius, wide) = if own.any_true() {
            // `SelfShadow::seen`.
            let d = (to[0] * to[0] + to[1] * to[1] + to[2] * to[2]).sqrt();
            let w = own.select(whole / d.max(whole).max(f32::MIN_POSITIVE), zero);
            radius = whole - (whole - f32x8::simd_from(simd, block.own_radius)) * w;
            let [x, y, z] = block.offset.map(|column| f32x8::simd_from(simd, column) * w);
            to = [to[0] + x, to[1] + y, to[2] + z];
            (along, aside_sq) = beside(to, u);
            let tau = own.select(f32x8::simd_from(simd, block.tau), zero);
            let (tangent_radius, wide, exists) =
                cones(simd, to, radius, tau, f32x8::simd_from(simd, block.half_of_tau));
            which &= exists;
            (tangent_radius, wide)
        } else {
            whole_cones(simd, to, whole)
        };
        let (meets, behind) = self.order(simd, to, radius);
        let (lit, dark) = self.cover(simd, to, along, aside_sq, tangent_radius, wide);
        let hides = which & !behind & !lit;
        let darkens = (hides & !meets & dark).any_true();
        Some(BlockedCones { to, tangent_radius, wide, meeting: meets.select(radius, zero), hides, darkens })
    }

    /// Which spheres may hide something of the light: whatever this drops, [`cover`](Self::cover) calls lit too.
    #[inline(always)]
    fn may_meet<S: Simd>(
        &self,
        simd: S,
        to: [f32x8<S>; 3],
        radius: f32x8<S>,
        along: f32x8<S>,
        aside_sq: f32x8<S>,
    ) -> mask32x8<S> {
        let zero = f32x8::splat(simd, 0.0);
        let (sin_sq, cos_sq) = (self.sin * self.sin * (1.0 + SLACK), self.cos * self.cos * (1.0 - SLACK));
        // d sin(γ − θ) > r, γ the angle between the axes, θ the light's half-angle.
        let reach = radius + along * self.sin + (along.abs() + radius) * SLACK;
        let outside = (aside_sq * cos_sq).simd_gt(reach * reach) | reach.simd_lt(zero);
        // γ − θ > 90°, and not inside the sphere.
        let back = -along - radius * SLACK;
        let behind = back.simd_gt(zero)
            & (back * back * cos_sq).simd_gt(aside_sq * sin_sq)
            & (to[0] * to[0] + to[1] * to[1] + to[2] * to[2]).simd_gt(radius * radius * (1.0 + SLACK));
        !(outside | behind)
    }

    /// Which spheres meet the light, which are behind it.
    #[inline(always)]
    fn order<S: Simd>(&self, simd: S, to: [f32x8<S>; 3], radius: f32x8<S>) -> (mask32x8<S>, mask32x8<S>) {
        if let Some(Capsule { ends: [a, b], radius: thick }) = self.body {
            // Beside the point of the middle line that is next to it, the tube is a sphere.
            let long = b - a;
            let from = [to[0] - a.x, to[1] - a.y, to[2] - a.z];
            let place = (from[0] * long.x + from[1] * long.y + from[2] * long.z) * (1.0 / long.length_squared());
            let place = place.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, 1.0));
            let next = [place * long.x + a.x, place * long.y + a.y, place * long.z + a.z];
            let [x, y, z] = [to[0] - next[0], to[1] - next[1], to[2] - next[2]];
            let both = radius + thick;
            let apart = (x * x + y * y + z * z).simd_ge(both * both);
            let power = |p: [f32x8<S>; 3], r: f32x8<S>| p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - r * r;
            let behind = power(to, radius).simd_ge(power(next, f32x8::splat(simd, thick)));
            return (!apart, apart & behind);
        }
        if let Some((normal, height)) = self.plane {
            let beyond = to[0] * normal.x + to[1] * normal.y + to[2] * normal.z - height;
            // Where all of the rim that is seen is before the plane, so is all that hides.
            let d_sq = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
            let tangent_sq = d_sq - radius * radius;
            let part = tangent_sq / d_sq;
            let along = beyond + height;
            let aside = (d_sq - along * along).max(f32x8::splat(simd, 0.0)).sqrt();
            let rim = along * part + radius * part.max(f32x8::splat(simd, 0.0)).sqrt() * aside / d_sq.sqrt();
            let is_before = tangent_sq.simd_gt(f32x8::splat(simd, 0.0)) & rim.simd_le(f32x8::splat(simd, height));
            return (beyond.abs().simd_lt(radius) & !is_before, beyond.simd_ge(radius));
        }
        if !self.distance.is_finite() {
            let none = radius.simd_lt(f32x8::splat(simd, f32::NEG_INFINITY));
            return (none, none);
        }
        let center = self.axis * self.distance;
        let [x, y, z] = [to[0] - center.x, to[1] - center.y, to[2] - center.z];
        let both = radius + self.radius;
        let apart = (x * x + y * y + z * z).simd_ge(both * both);
        let power = to[0] * to[0] + to[1] * to[1] + to[2] * to[2] - radius * radius;
        (!apart, apart & power.simd_ge(f32x8::splat(simd, self.power)))
    }

    /// Which cones leave all of the light, and which cover it.
    #[inline(always)]
    fn cover<S: Simd>(
        &self,
        simd: S,
        to: [f32x8<S>; 3],
        along: f32x8<S>,
        aside_sq: f32x8<S>,
        tangent_radius: f32x8<S>,
        wide: f32x8<S>,
    ) -> (mask32x8<S>, mask32x8<S>) {
        let zero = f32x8::splat(simd, 0.0);
        let narrow = wide.simd_gt(zero);
        let covers = self.cover_by_squares(simd, along, aside_sq, tangent_radius);
        if self.narrow && narrow.all_true() {
            return covers;
        }
        let aside = aside_sq.sqrt();
        // d sin(γ ∓ θ) and d cos(γ ∓ θ), γ the angle between the two axes.
        let (near, near_toward) = (aside * self.cos - along * self.sin, along * self.cos + aside * self.sin);
        let (far, far_toward) = (aside * self.cos + along * self.sin, along * self.cos - aside * self.sin);
        let (lit, dark) = if self.narrow {
            covers
        } else {
            let lit = near.simd_ge(tangent_radius) | near_toward.simd_le(zero);
            (lit, far_toward.simd_gt(zero) & far.simd_le(tangent_radius))
        };
        // Wider than a hemisphere: against d cos β.
        let edge = wide * (to[0] * to[0] + to[1] * to[1] + to[2] * to[2]).sqrt();
        let wide_lit = near.simd_ge(zero) & near_toward.simd_le(edge);
        let wide_dark = far.simd_ge(zero) & far_toward.simd_gt(edge);
        let all = wide.simd_le(f32x8::splat(simd, -1.0));
        ((narrow & lit) | (!narrow & !all & wide_lit), (narrow & dark) | (!narrow & (all | wide_dark)))
    }

    /// The same of cones and a light within less than a hemisphere: their squares decide.
    #[inline(always)]
    fn cover_by_squares<S: Simd>(
        &self,
        simd: S,
        along: f32x8<S>,
        aside_sq: f32x8<S>,
        tangent_radius: f32x8<S>,
    ) -> (mask32x8<S>, mask32x8<S>) {
        let zero = f32x8::splat(simd, 0.0);
        let (across, toward) = (aside_sq * (self.cos * self.cos), along * self.sin);
        // d sin(γ ∓ θ) against d sin β, and d cos(γ ∓ θ) against 0.
        let (near, far) = (tangent_radius + toward, tangent_radius - toward);
        let straight = (along * along * (self.cos * self.cos)).simd_gt(aside_sq * (self.sin * self.sin));
        let ahead = along.simd_gt(zero);
        let lit = near.simd_le(zero) | across.simd_ge(near * near) | (straight & !ahead);
        let dark = ahead & straight & far.simd_ge(zero) & across.simd_le(far * far);
        (lit, dark)
    }
}
