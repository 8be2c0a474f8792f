//! The cone that a sphere blocks, and what of it is in front of a light that the sphere meets.

use glam::Vec3;
use lobe_core::{Cone, VisibilityQuery};
use visibility_mask::Mask;

/// The directions that a sphere blocks, seen from a receiver: a cone about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BlockedCone {
    /// From the receiver to the sphere's centre.
    pub(crate) to: Vec3,
    /// Its radius, if it meets the light.
    pub(crate) radius: f32,
    /// Radius of the ball about the same centre whose tangent cone it is: `d sin β`.
    pub(crate) tangent_radius: f32,
    /// `cos β` of the half-angle.
    pub(crate) cos: f32,
    /// Whether sphere and light intersect.
    pub(crate) meets_light: bool,
}

impl BlockedCone {
    /// From a hit's numbers: `wide` is the cosine of a cone as wide as a hemisphere or wider, else 1; `meeting` the radius of
    /// a sphere that meets the light, else 0.
    pub(crate) fn new(to: Vec3, tangent_radius: f32, wide: f32, meeting: f32) -> Self {
        let d = to.length();
        // d > d sin β, but for rounding; both are zero only where the cone is wide.
        let cos = ((d - tangent_radius).max(0.0) * (d + tangent_radius)).sqrt() / d;
        let cos = if wide > 0.0 { cos } else { wide };
        Self { to, radius: meeting, tangent_radius, cos, meets_light: meeting > 0.0 }
    }

    /// `1 − cos β`.
    #[cfg(test)]
    pub(crate) fn one_minus_cos(&self) -> f32 {
        1.0 - self.cos
    }

    /// Whether a unit direction is in the cone.
    pub(crate) fn contains(&self, v: Vec3) -> bool {
        let along = self.to.dot(v);
        if self.cos > 0.0 {
            // Not by the cosine, which for a small cone has lost its digits.
            along > 0.0 && (self.to - v * along).length_squared() <= self.tangent_radius * self.tangent_radius
        } else {
            self.cos <= -1.0 || along >= self.cos * self.to.length()
        }
    }

    /// Blocks where the ball is in front of the light that it meets: runs of cell centres, their ends found between two
    /// centres by bisection.
    pub(crate) fn splat_in_front(&self, light: &Front, mask: &mut Mask) {
        let square = *mask.square();
        for j in 0..mask.side() {
            if mask.is_row_dark(j) {
                continue;
            }
            let hides = |x: f32| {
                let v = square.world(Vec3::new(x, mask.row_y(j), 1.0)).normalize();
                self.contains(v) && light.is_behind(v, self)
            };
            let center = |i: usize| mask.cell_center(i, j).x;
            let mut spans = [(0.0, 0.0); 2];
            let (mut count, mut start) = (0, hides(center(0)).then_some(f32::NEG_INFINITY));
            for i in 1..mask.side() {
                if hides(center(i)) == start.is_some() {
                    continue;
                }
                let (mut before, mut after) = (center(i - 1), center(i));
                for _ in 0..8 {
                    let middle = 0.5 * (before + after);
                    if hides(middle) == start.is_some() { before = middle } else { after = middle }
                }
                let edge = 0.5 * (before + after);
                match start.take() {
                    None => start = Some(edge),
                    Some(from) if count < spans.len() => {
                        spans[count] = (from, edge);
                        count += 1;
                    }
                    Some(_) => {}
                }
            }
            for &(from, to) in &spans[..count] {
                mask.block_span(j, from, to);
            }
            if let Some(from) = start {
                mask.block_span(j, from, f32::INFINITY);
            }
        }
    }
}

/// Where a light begins, seen from the receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Front {
    /// A ball's centre and radius.
    Ball(Vec3, f32),
    /// The normal of a plane, and how far that is.
    Plane(Vec3, f32),
}

impl Front {
    pub(crate) fn new(query: &VisibilityQuery<'_>) -> Self {
        match query.outline {
            None => Self::of_cone(query.cone),
            Some(light) => Self::Plane(light.axis(), light.depth()),
        }
    }

    pub(crate) fn of_cone(cone: &Cone) -> Self {
        Self::Ball(cone.axis * cone.distance, cone.distance * cone.sin_sq().sqrt())
    }

    /// Whether, along the unit direction `v`, a ball is entered before it.
    fn is_behind(&self, v: Vec3, ball: &BlockedCone) -> bool {
        match self {
            Self::Ball(center, radius) => order_by_ray(v, ball, *center, *radius),
            Self::Plane(normal, height) => entry(v, ball.to, ball.radius) * normal.dot(v) < *height,
        }
    }
}

/// Where a ray enters a ball.
fn entry(v: Vec3, center: Vec3, radius: f32) -> f32 {
    let along = center.dot(v);
    // The distance of ray and centre directly: as a difference of squares it drowns a few hundred radii away.
    let half_sq = radius * radius - (center - v * along).length_squared();
    (along - half_sq.max(0.0).sqrt()).max(0.0)
}

/// Whether, along the unit direction `v`, the ball is entered before the light (both seen from the origin). Inside the
/// ball counts as entered at 0.
pub(crate) fn order_by_ray(v: Vec3, ball: &BlockedCone, light: Vec3, light_radius: f32) -> bool {
    entry(v, ball.to, ball.radius) < entry(v, light, light_radius)
}
