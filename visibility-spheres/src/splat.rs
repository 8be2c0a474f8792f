//! The cone that a sphere blocks, and what of it is in front of a light that the sphere meets.

use glam::Vec3;
use lobe_core::{Capsule, Cone};
use shading::VisibilityQuery;
use visibility_mask::Mask;

/// The squared sine between a plane and a mask that is along it.
const ALONG: f32 = 1e-10;
/// Spheres whose centre is at least so many radii in front of the plane through the receiver are ellipses on a mask.
pub(crate) const IN_FRONT: f32 = 1.001;

/// The directions that a sphere blocks, seen from a receiver: a cone about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BlockedCone {
    /// From the receiver to the sphere's centre.
    pub(crate) to: Vec3,
    /// Its radius, if it meets the light.
    pub(crate) radius: f32,
    /// Radius of the sphere about the same centre whose tangent cone it is: `d sin β`.
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

    /// Blocks where the sphere is in front of the light that it meets: before a plane along the mask in closed form, else runs of cell
    /// centres, their ends found between two centres by bisection.
    pub(crate) fn splat_in_front(&self, light: &Front, mask: &mut Mask) {
        let square = *mask.square();
        if let Front::Plane(normal, height) = *light
            && square.local(normal).truncate().length_squared() < ALONG
            && let Some(part) = PartBefore::new(square.local(self.to), self, height)
        {
            for j in 0..mask.side() {
                if let Some((from, to)) = part.row(mask.row_y(j)) {
                    mask.block_span(j, from, to);
                }
            }
            return;
        }
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

/// The part of a sphere before a plane, seen from in front of both: on the plane the disc that it cuts out of the sphere, and the ellipse
/// that the whole sphere hides, where rays pass their point nearest to the centre before they come to the plane.
///
/// Along a ray to a point q that is outside of the sphere, both hits are before q or both behind it: before it where `|q|² > c·q`, outside of
/// Thales' sphere over the centre c. On this sphere q is itself the point nearest to the centre, so that inside of the ellipse it is in the
/// sphere, too: where an end of the ellipse's row is inside of the sphere, the disc's end takes its place.
pub(crate) struct PartBefore {
    /// Centre and radius, in distances of the plane.
    center: Vec3,
    radius: f32,
    /// The ellipse: middle, shear, and half its span at a height t above the middle, `√(k₀ − k₂t²)`.
    middle: [f32; 2],
    shear: f32,
    k: [f32; 2],
}

impl PartBefore {
    /// None where the sphere is not wholly in front of the receiver, or blocks what it does not hold.
    pub(crate) fn new(to: Vec3, cone: &BlockedCone, height: f32) -> Option<Self> {
        let is_sphere = cone.cos > 0.0 && cone.tangent_radius == cone.radius && to.z > IN_FRONT * cone.radius;
        let (center, radius) = (to / height, cone.radius / height);
        // As `Ellipses`.
        let Vec3 { x, y, z } = center;
        let g = (z - radius) * (z + radius);
        let u = y * y + g;
        let w = x * x + u;
        let k = [radius * radius * w / (g * u), w * g / (u * u)];
        let part = Self { center, radius, middle: [x * z / g, y * z / g], shear: x * y / u, k };
        (is_sphere && k[0].is_finite() && k[1].is_finite()).then_some(part)
    }

    /// Its span at a height of the plane at distance 1.
    fn row(&self, y: f32) -> Option<(f32, f32)> {
        let t = y - self.middle[1];
        let square = self.k[0] - self.k[1] * t * t;
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        let (middle, half) = (self.middle[0] + self.shear * t, square.sqrt());
        let away = [y - self.center.y, 1.0 - self.center.z];
        let disc = (self.radius * self.radius - away[0] * away[0] - away[1] * away[1]).max(0.0).sqrt();
        let of_ellipse = [middle - half, middle + half];
        let is_before = of_ellipse.map(|x| x * (x - self.center.x) + y * away[0] + away[1] > 0.0);
        if disc <= 0.0 && !(is_before[0] || is_before[1]) {
            return None;
        }
        let [from, to] = [self.center.x - disc, self.center.x + disc];
        let end = |is_before: bool, ellipse: f32, disc: f32| if is_before { ellipse } else { disc };
        Some((end(is_before[0], of_ellipse[0], from), end(is_before[1], of_ellipse[1], to)))
    }
}

/// Where a light begins, seen from the receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Front {
    /// A sphere's centre and radius.
    Sphere(Vec3, f32),
    /// The normal of a plane, and how far that is.
    Plane(Vec3, f32),
    /// A tube, and how far along an axis its last visible part is.
    Body(Capsule, Vec3, f32),
}

impl Front {
    pub(crate) fn new(query: &VisibilityQuery<'_>) -> Self {
        match query.outline {
            None => Self::of_cone(query.cone),
            Some(light) => match light.body() {
                Some(body) => Self::Body(*body, light.axis(), light.depth_to(true)),
                None => Self::Plane(light.axis(), light.depth()),
            },
        }
    }

    pub(crate) fn of_cone(cone: &Cone) -> Self {
        Self::Sphere(cone.axis * cone.distance, cone.distance * cone.sin_sq().sqrt())
    }

    /// Whether, along the unit direction `v`, a sphere is entered before it.
    fn is_behind(&self, v: Vec3, sphere: &BlockedCone) -> bool {
        match self {
            Self::Sphere(center, radius) => order_by_ray(v, sphere, *center, *radius),
            Self::Plane(normal, height) => entry(v, sphere.to, sphere.radius) * normal.dot(v) < *height,
            Self::Body(body, axis, last) => {
                let end = body.entry(v).unwrap_or_else(|| last / axis.dot(v).max(f32::MIN_POSITIVE));
                entry(v, sphere.to, sphere.radius) < end
            }
        }
    }
}

/// Where a ray enters a sphere.
fn entry(v: Vec3, center: Vec3, radius: f32) -> f32 {
    let along = center.dot(v);
    // The distance of ray and centre directly: as a difference of squares it drowns a few hundred radii away.
    let half_sq = radius * radius - (center - v * along).length_squared();
    (along - half_sq.max(0.0).sqrt()).max(0.0)
}

/// Whether, along the unit direction `v`, the sphere is entered before the light (both seen from the origin). Inside the
/// sphere counts as entered at 0.
pub(crate) fn order_by_ray(v: Vec3, sphere: &BlockedCone, light: Vec3, light_radius: f32) -> bool {
    entry(v, sphere.to, sphere.radius) < entry(v, light, light_radius)
}
