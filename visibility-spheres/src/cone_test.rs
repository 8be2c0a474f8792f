use crate::block::{Block, LANES, bits};
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
    pub(crate) fn meets(&self, block: &Block) -> u32 {
        if !self.narrow {
            return u32::MAX;
        }
        let (o, u) = (self.at, self.axis);
        let mut apart = [false; LANES];
        for (i, apart) in apart.iter_mut().enumerate() {
            let r = block.radius[i];
            let (x, y, z) = (block.x[i] - o.x, block.y[i] - o.y, block.z[i] - o.z);
            let along = x * u.x + y * u.y + z * u.z;
            let (a, b, c) = (x - u.x * along, y - u.y * along, z - u.z * along);
            let aside_sq = a * a + b * b + c * c;
            // d sin(γ − θ) > r, γ the angle between the axes, θ the light's half-angle.
            let reach = r + along * self.sin + SLACK * (along.abs() + r);
            let outside = (aside_sq * self.cos_sq > reach * reach) | (reach < 0.0);
            // γ − θ > 90°, and not inside the sphere.
            let back = -along - SLACK * r;
            let behind = (back > 0.0)
                & (back * back * self.cos_sq > aside_sq * self.sin_sq)
                & (x * x + y * y + z * z > r * r * (1.0 + SLACK));
            *apart = outside | behind;
        }
        !bits(apart)
    }
}
