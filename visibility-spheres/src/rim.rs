//! The rims of blocked cones as polygons in a window.

use crate::splat::BlockedCone;
use core::f32::consts::PI;
use glam::{Vec2, Vec3};
use lobe_core::orthonormal_basis;
use visibility_mask::{LitArea, UnitSquare};

/// Sides of a polygon, and how many of these stand for the part of the rim that a window may show.
pub(crate) const SIDES: usize = 32;
const SHOWN: usize = 24;
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
        let sin = self.tangent_radius / self.to.length();
        let (shown, sides) = shown(window, axis, sin);
        let step = 2.0 * shown / sides as f32;
        let rest = 2.0 * (PI - shown) / (SIDES - sides).max(1) as f32;
        // Corners are so much farther out than the rim that both have one area.
        let tan = (step / step.sin()).sqrt() * sin / self.cos;
        // Toward the middle of the window.
        let (u, v) = orthonormal_basis(axis);
        let middle = window.center.extend(1.0);
        let toward = Vec2::new(u.dot(middle), v.dot(middle)).normalize_or(Vec2::X);
        let corner = |k: usize| {
            let angle = if k <= sides { k as f32 * step - shown } else { shown + (k - sides) as f32 * rest };
            let at = toward.rotate(Vec2::from_angle(angle));
            axis + tan * (at.x * u + at.y * v)
        };
        let mut corners = Vec::with_capacity(SIDES + 1);
        let mut a = corner(0);
        for k in 1..=SIDES {
            let b = corner(k);
            if a.z > NEAR {
                corners.push(a.truncate() / a.z);
            }
            if (a.z > NEAR) != (b.z > NEAR) {
                let cut = a.lerp(b, (NEAR - a.z) / (b.z - a.z));
                corners.push(Vec2::new(cut.x, cut.y) / NEAR);
            }
            a = b;
        }
        if corners.len() > 2 {
            lit.hide(&corners);
        }
        true
    }
}

/// Half the angle about a rim's axis that a window may show, and how many sides stand for it. `sin` of the rim's half-angle.
///
/// The point of the rim toward the window's middle is no farther from that than any other point, so that points in the window are no farther from it than twice as
/// far as the window reaches.
fn shown(window: &UnitSquare, axis: Vec3, sin: f32) -> (f32, usize) {
    let reach = window.half.length();
    let is_around = window.center.extend(1.0).cross(axis).length() <= reach;
    if reach < sin && !is_around { (2.0 * (reach / sin).asin(), SHOWN) } else { (PI, SIDES) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::oracle::Random;

    /// Of 200 points of a window around its origin: how many the cone blocks, and of how many the polygon says otherwise.
    fn blocked_and_wrong(cone: &BlockedCone, window: &UnitSquare, random: &mut Random) -> [i32; 2] {
        let mut lit = LitArea::default();
        assert!(cone.add_rim(window, &mut lit));
        let mut counts = [0; 2];
        for _ in 0..200 {
            let p = window.half * Vec2::new(random.between(-1.0, 1.0) as f32, random.between(-1.0, 1.0) as f32);
            let is_blocked = cone.contains(window.world(p.extend(1.0)).normalize());
            counts[0] += i32::from(is_blocked);
            counts[1] += i32::from(is_blocked != lit.is_hidden(p));
        }
        counts
    }

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
            let [more, off] = blocked_and_wrong(&cone, &window, &mut random);
            (inside, wrong) = (inside + more, wrong + off);
        }
        assert!(inside > 10_000 && wrong < inside / 200, "{wrong} of {inside}");
    }

    /// So are those of a window that shows a small part of a rim: what is left of a light beside a large sphere is as wide as it is.
    #[test]
    fn windows_show_a_part_of_a_rim_as_finely() {
        let mut random = Random::new(6);
        let (mut inside, mut wrong) = (0, 0);
        for _ in 0..300 {
            let axis = random.axis().as_vec3();
            let (right, up) = orthonormal_basis(axis);
            let half = random.log_uniform(1e-3, 0.3) as f32;
            let window = UnitSquare { axis, right, up, half: Vec2::splat(half), ..UnitSquare::default() };
            let angle = random.between(0.1, 1.2);
            let aside = angle + f64::from(half) * random.between(-0.8, 0.8);
            let to = random.axis_at(axis.as_dvec3().normalize(), aside.max(0.0)).as_vec3() * 3.0;
            let cone = BlockedCone::new(to, angle.sin() as f32 * to.length(), 1.0, 0.0);
            let [more, off] = blocked_and_wrong(&cone, &window, &mut random);
            (inside, wrong) = (inside + more, wrong + off);
        }
        assert!(inside > 10_000 && wrong < inside / 500, "{wrong} of {inside}");
    }
}
