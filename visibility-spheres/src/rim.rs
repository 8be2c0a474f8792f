//! The rims of blocked cones as polygons in a window.

use crate::splat::BlockedCone;
use glam::{Vec2, Vec3};
use lobe_core::orthonormal_basis;
use visibility_mask::{LitArea, UnitSquare};

/// Sides of a polygon.
pub(crate) const SIDES: usize = 32;
/// Its corners are so much farther out than the rim, so that both have one area.
const OUT: f32 = 1.003_223_6;
/// Cones are cut where they are this near to the plane through the receiver, at distance 1 from it.
const NEAR: f32 = 1e-3;
/// Wider cones, by the cosine, are left out.
const WIDEST: f32 = 0.02;

impl BlockedCone {
    /// Adds a polygon around the directions that it blocks. `false` where it is wide or meets the light.
    pub(crate) fn add_rim(&self, window: &UnitSquare, lit: &mut LitArea) -> bool {
        if self.meets_light || self.cos <= WIDEST {
            return false;
        }
        let axis = window.local(self.to).normalize_or(Vec3::Z);
        let (u, v) = orthonormal_basis(axis);
        let tan = OUT * self.tangent_radius / (self.to.length() * self.cos);
        let corner = |k: usize| {
            let (sin, cos) = (core::f32::consts::TAU * k as f32 / SIDES as f32).sin_cos();
            axis + tan * (cos * u + sin * v)
        };
        let mut corners = Vec::with_capacity(SIDES + 1);
        for k in 0..SIDES {
            let (a, b) = (corner(k), corner(k + 1));
            if a.z > NEAR {
                corners.push(a.truncate() / a.z);
            }
            if (a.z > NEAR) != (b.z > NEAR) {
                let cut = a.lerp(b, (NEAR - a.z) / (b.z - a.z));
                corners.push(Vec2::new(cut.x, cut.y) / NEAR);
            }
        }
        if corners.len() > 2 {
            lit.hide(&corners);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::oracle::Random;

    /// Points of a window are in the polygon where their directions are in the cone, but for a thin rim.
    #[test]
    fn rims_are_those_of_cones() {
        let mut random = Random::new(5);
        let (mut inside, mut wrong) = (0, 0);
        for _ in 0..300 {
            let axis = random.axis().as_vec3();
            let (right, up) = orthonormal_basis(axis);
            let window = UnitSquare { axis, right, up, half: Vec2::splat(2.0), ..UnitSquare::default() };
            let to = 3.0 * (axis + 0.9 * random.axis().as_vec3());
            let tangent_radius = random.between(0.1, 0.9) as f32 * to.length();
            let cone = BlockedCone::new(to, tangent_radius, 1.0, 0.0);
            let mut lit = LitArea::default();
            assert!(cone.add_rim(&window, &mut lit));
            for _ in 0..200 {
                let p = Vec2::new(random.between(-2.0, 2.0) as f32, random.between(-2.0, 2.0) as f32);
                let is_blocked = cone.contains(window.world(p.extend(1.0)).normalize());
                inside += i32::from(is_blocked);
                wrong += i32::from(is_blocked != lit.is_hidden(p));
            }
        }
        assert!(inside > 10_000 && wrong < inside / 200, "{wrong} of {inside}");
    }
}
