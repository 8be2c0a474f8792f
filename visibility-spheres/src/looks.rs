//! What eight spheres hide of one receiver's light, side by side.

use crate::block::Candidates;
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};
use glam::Vec3;
use lobe_core::VisibilityQuery;

/// The light of a query as a ball.
pub(crate) struct LightBall {
    axis: Vec3,
    sin: f32,
    cos: f32,
    distance: f32,
    radius: f32,
    /// Power of the receiver with respect to it.
    power: f32,
}

/// The directions that eight spheres block, as [`BlockedCone`](crate::splat::BlockedCone)s.
pub(crate) struct Looks<S: Simd> {
    pub(crate) to: [f32x8<S>; 3],
    pub(crate) radius: f32x8<S>,
    pub(crate) tangent_radius: f32x8<S>,
    pub(crate) cos: f32x8<S>,
    /// Lanes that hide something; all; that meet the light.
    pub(crate) hides: u32,
    pub(crate) darkens: u32,
    pub(crate) meets: u32,
}

/// The cones that spheres block under their self-distances τ: `d sin β`, `cos β`, and whether there is one.
#[inline(always)]
pub(crate) fn cones<S: Simd>(
    simd: S,
    to: [f32x8<S>; 3],
    radius: f32x8<S>,
    tau: f32x8<S>,
) -> (f32x8<S>, f32x8<S>, mask32x8<S>) {
    let (zero, one, two) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0), f32x8::splat(simd, 2.0));
    let d_sq = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
    let power = d_sq - radius * radius;
    let d = d_sq.sqrt();
    let tangent = power.simd_gt(zero) & (tau * tau).simd_le(power);
    // Inside the sphere of another object.
    let inside = !tangent & tau.simd_le(zero);
    // 1 − cos β = (r² − (d − τ)²)/(2τd).
    let above = (radius - (d - tau)) * (radius + (d - tau));
    let one_minus_cos = d.simd_gt(zero).select((above / (two * tau * d)).min(two), two);
    let chord = d * (one_minus_cos * (two - one_minus_cos)).max(zero).sqrt();
    let cos = tangent.select((power / d_sq).sqrt(), inside.select(-one, one - one_minus_cos));
    let tangent_radius = tangent.select(radius, inside.select(zero, chord));
    (tangent_radius, cos, tangent | inside | above.simd_gt(zero))
}

/// [`cones`] where every τ is zero.
#[inline(always)]
pub(crate) fn whole_cones<S: Simd>(simd: S, to: [f32x8<S>; 3], radius: f32x8<S>) -> (f32x8<S>, f32x8<S>, mask32x8<S>) {
    let zero = f32x8::splat(simd, 0.0);
    let d_sq = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
    let power = d_sq - radius * radius;
    let tangent = power.simd_gt(zero);
    let cos = tangent.select((power / d_sq).sqrt(), f32x8::splat(simd, -1.0));
    (tangent.select(radius, zero), cos, zero.simd_eq(zero))
}

impl LightBall {
    pub(crate) fn new(query: &VisibilityQuery<'_>) -> Self {
        let cone = query.cone;
        let (sin, cos) = (cone.sin_sq().sqrt(), cone.cos());
        let (distance, radius) = (cone.distance, cone.distance * sin);
        Self { axis: cone.axis, sin, cos, distance, radius, power: distance * distance * (cos * cos) }
    }

    /// What eight candidates hide from the receiver of a query. Where in doubt, something.
    #[inline(always)]
    pub(crate) fn look<S: Simd>(&self, simd: S, query: &VisibilityQuery<'_>, block: &Candidates) -> Looks<S> {
        let at = query.at.position;
        let own = u32x8::simd_from(simd, block.object).simd_eq(u32x8::splat(simd, query.at.object));
        let whole = f32x8::simd_from(simd, block.spheres.radius);
        let to = [
            f32x8::simd_from(simd, block.spheres.x) - at.x,
            f32x8::simd_from(simd, block.spheres.y) - at.y,
            f32x8::simd_from(simd, block.spheres.z) - at.z,
        ];
        let (radius, (tangent_radius, cos, exists)) = if own.any_true() {
            let radius = own.select(f32x8::simd_from(simd, block.own_radius), whole);
            let tau = own.select(f32x8::simd_from(simd, block.tau), f32x8::splat(simd, 0.0));
            (radius, cones(simd, to, radius, tau))
        } else {
            (whole, whole_cones(simd, to, whole))
        };
        let (meets, behind) = self.order(simd, to, radius);
        let (lit, dark) = self.cover(simd, to, tangent_radius, cos);
        let hides = exists & !behind & !lit;
        Looks {
            to,
            radius,
            tangent_radius,
            cos,
            hides: hides.to_bitmask() as u32,
            darkens: (hides & !meets & dark).to_bitmask() as u32,
            meets: meets.to_bitmask() as u32,
        }
    }

    /// Which spheres meet the light, which are behind it.
    #[inline(always)]
    fn order<S: Simd>(&self, simd: S, to: [f32x8<S>; 3], radius: f32x8<S>) -> (mask32x8<S>, mask32x8<S>) {
        if !self.distance.is_finite() {
            let none = radius.simd_lt(f32x8::splat(simd, f32::NEG_INFINITY));
            return (none, none);
        }
        let center = self.axis * self.distance;
        let [x, y, z] = [to[0] - center.x, to[1] - center.y, to[2] - center.z];
        let apart = (x * x + y * y + z * z).sqrt().simd_ge(radius + self.radius);
        let power = to[0] * to[0] + to[1] * to[1] + to[2] * to[2] - radius * radius;
        (!apart, apart & power.simd_ge(f32x8::splat(simd, self.power)))
    }

    /// Which cones leave all of the light (axis, sin θ, cos θ), and which cover it.
    #[inline(always)]
    fn cover<S: Simd>(
        &self,
        simd: S,
        to: [f32x8<S>; 3],
        tangent_radius: f32x8<S>,
        cos: f32x8<S>,
    ) -> (mask32x8<S>, mask32x8<S>) {
        let zero = f32x8::splat(simd, 0.0);
        let u = self.axis;
        let along = to[0] * u.x + to[1] * u.y + to[2] * u.z;
        let [x, y, z] = [to[0] - along * u.x, to[1] - along * u.y, to[2] - along * u.z];
        let aside = (x * x + y * y + z * z).sqrt();
        // d sin(γ ∓ θ) and d cos(γ ∓ θ), γ the angle between the two axes.
        let (near, near_toward) = (aside * self.cos - along * self.sin, along * self.cos + aside * self.sin);
        let (far, far_toward) = (aside * self.cos + along * self.sin, along * self.cos - aside * self.sin);
        let narrow = cos.simd_ge(zero);
        let lit = near.simd_ge(tangent_radius) | near_toward.simd_le(zero);
        let dark = far_toward.simd_gt(zero) & far.simd_le(tangent_radius);
        if narrow.all_true() {
            return (lit, dark);
        }
        // Wider than a hemisphere: against d cos β.
        let edge = cos * (to[0] * to[0] + to[1] * to[1] + to[2] * to[2]).sqrt();
        let wide_lit = near.simd_ge(zero) & near_toward.simd_le(edge);
        let wide_dark = far.simd_ge(zero) & far_toward.simd_gt(edge);
        let all = cos.simd_le(f32x8::splat(simd, -1.0));
        ((narrow & lit) | (!narrow & !all & wide_lit), (narrow & dark) | (!narrow & (all | wide_dark)))
    }
}
