use crate::block::Block;
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::VisibilityQuery;

/// Which spheres may hide something of one receiver's light: the cheap question before the exact one. Whatever it drops
/// is lit for [`BlockedCone::cover`](crate::splat::BlockedCone::cover) too.
pub(crate) struct ConeTest {
    at: Vec3,
    axis: Vec3,
    sin: f32,
    sin_sq: f32,
    cos_sq: f32,
    /// The light is seen within less than a hemisphere.
    narrow: bool,
}

/// Relative to distances; f32 rounds the terms of a test by some 1e-7.
const SLACK: f32 = 4e-6;

impl ConeTest {
    pub(crate) fn new(query: &VisibilityQuery<'_>) -> Self {
        let (sin_sq, cos) = (query.cone.sin_sq(), query.cone.cos());
        Self {
            at: query.at.position,
            axis: query.cone.axis,
            sin: sin_sq.sqrt(),
            sin_sq: sin_sq * (1.0 + SLACK),
            cos_sq: cos * cos * (1.0 - SLACK),
            narrow: cos > 0.0,
        }
    }

    /// The spheres of a block that the cone may meet, as bits; lanes without a sphere are anything.
    #[inline(always)]
    pub(crate) fn meets<S: Simd>(&self, simd: S, block: &Block) -> u32 {
        if !self.narrow {
            return u32::MAX;
        }
        let (o, u) = (self.at, self.axis);
        let r = f32x8::simd_from(simd, block.radius);
        let x = f32x8::simd_from(simd, block.x) - o.x;
        let y = f32x8::simd_from(simd, block.y) - o.y;
        let z = f32x8::simd_from(simd, block.z) - o.z;
        let along = x * u.x + y * u.y + z * u.z;
        let (a, b, c) = (x - along * u.x, y - along * u.y, z - along * u.z);
        let aside_sq = a * a + b * b + c * c;
        // d sin(γ − θ) > r, γ the angle between the axes, θ the light's half-angle.
        let reach = r + along * self.sin + (along.abs() + r) * SLACK;
        let zero = f32x8::splat(simd, 0.0);
        let outside = (aside_sq * self.cos_sq).simd_gt(reach * reach) | reach.simd_lt(zero);
        // γ − θ > 90°, and not inside the sphere.
        let back = -along - r * SLACK;
        let behind = back.simd_gt(zero)
            & (back * back * self.cos_sq).simd_gt(aside_sq * self.sin_sq)
            & (x * x + y * y + z * z).simd_gt(r * r * (1.0 + SLACK));
        !((outside | behind).to_bitmask() as u32)
    }
}
