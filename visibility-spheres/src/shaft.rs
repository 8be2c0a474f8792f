use crate::block::{Block, LANES, bits};
use glam::Vec3;
use lobe_core::Sphere;
use shading::Shaft;

/// Which spheres meet a shaft, the convex hull of its two spheres.
///
/// Exact up to a slack for rounding, on the side of keeping: a sphere is compared with the sphere of the shaft that is
/// nearest to it, which is one of the two ends or, beside the cone between them, one in between. Only products and
/// comparisons, for eight spheres at once.
pub(crate) struct ShaftTest {
    shaft: Shaft,
    /// From the receivers to the light, unit, and how far.
    axis: Vec3,
    length: f32,
    /// Sine of the angle by which the cone opens, its tangent, and the cosine's reciprocal.
    sin: f32,
    tan: f32,
    secant: f32,
    /// One of the spheres holds the other.
    nested: Option<Sphere>,
}

/// Relative to distances; f32 rounds the terms of a test by some 1e-7.
const SLACK: f32 = 4e-6;

/// A box is narrow that is thinner than this part of the sphere.
const NARROW: f32 = 0.6;
/// A sphere smaller by this part must hide all of the light from a tile before the tile counts as dark.
pub(crate) const MARGIN: f32 = 1e-3;

impl ShaftTest {
    pub(crate) fn new(shaft: &Shaft) -> Self {
        let (from, to) = (shaft.receivers, shaft.light);
        let axis = to.center.as_dvec3() - from.center.as_dvec3();
        let length = axis.length();
        let grow = f64::from(to.radius) - f64::from(from.radius);
        // NaN counts as nested, in a sphere that keeps everything.
        let beside = grow.abs() < length * (1.0 - 1e-6);
        let nested = (!beside).then_some(if to.radius > from.radius { to } else { from });
        let sin = if beside { grow / length } else { 0.0 };
        let secant = ((1.0 - sin) * (1.0 + sin)).sqrt().recip();
        Self {
            shaft: *shaft,
            axis: if beside { (axis / length).as_vec3() } else { Vec3::Z },
            length: length as f32,
            sin: sin as f32,
            tan: (sin * secant) as f32,
            secant: secant as f32,
            nested: nested
                .map(|sphere| Sphere { radius: sphere.radius * (1.0 + 1e-5) + (2e-6 * length) as f32, ..sphere }),
        }
    }

    /// The spheres of a block that meet the shaft, as bits; lanes without a sphere are anything.
    pub(crate) fn meets(&self, block: &Block) -> u32 {
        if let Some(sphere) = self.nested {
            return !bits(core::array::from_fn(|i| {
                let (dx, dy, dz) =
                    (block.x[i] - sphere.center.x, block.y[i] - sphere.center.y, block.z[i] - sphere.center.z);
                let reach = (sphere.radius + block.radius[i]) * (1.0 + SLACK);
                dx * dx + dy * dy + dz * dz > reach * reach
            }));
        }
        let (from, to) = (self.shaft.receivers, self.shaft.light);
        let (o, u) = (from.center, self.axis);
        let mut apart = [false; LANES];
        for (i, apart) in apart.iter_mut().enumerate() {
            let (x, y, z) = (block.x[i] - o.x, block.y[i] - o.y, block.z[i] - o.z);
            let along = x * u.x + y * u.y + z * u.z;
            let (x, y, z) = (x - u.x * along, y - u.y * along, z - u.z * along);
            let aside_sq = x * x + y * y + z * z;
            let past = along - self.length;
            // Where along + aside·tan lies, the foot on the axis of the nearest sphere: by squares with sign.
            let shift = aside_sq * self.tan * self.tan.abs();
            let before = along * along.abs() + shift < 0.0;
            let after = past * past.abs() + shift > 0.0;
            let r = block.radius[i];
            let beside = (from.radius + self.sin * along + r) * self.secant;
            let (offset, reach) = if before {
                (along, from.radius + r)
            } else if after {
                (past, to.radius + r)
            } else {
                (0.0, beside)
            };
            let reach = reach + SLACK * (along.abs() + reach.abs());
            *apart = (aside_sq + offset * offset > reach * reach) | (reach < 0.0);
        }
        !bits(apart)
    }

    /// Leaves out spheres beside the box of the receivers and the way from it to the light, where there is enough to gain.
    pub(crate) fn narrow(&self, spheres: &[Sphere], candidates: &mut Vec<u32>) {
        let Shaft { receivers, half_extent, light, .. } = self.shaft;
        let is_narrow = half_extent.min_element() < NARROW * receivers.radius;
        if candidates.len() <= LANES || !is_narrow || self.nested.is_some() {
            return;
        }
        let rounding = SLACK * (self.length + light.radius);
        let planes = self.shaft.normals().map(|n| (n, self.shaft.reach(n)));
        candidates.retain(|i| {
            let Sphere { center, radius } = spheres[*i as usize];
            let w = center - receivers.center;
            let near = radius + SLACK * (radius + w.abs().element_sum()) + rounding;
            planes.iter().all(|(n, reach)| n.dot(w) - near <= *reach)
        });
    }

    /// Whether a sphere hides all of the light from all receivers, each at least `clear` away from it along the tangent.
    /// Not always when it does.
    pub(crate) fn darkens(&self, sphere: &Sphere, clear: f32) -> bool {
        let (from, to) = (self.shaft.receivers, self.shaft.light);
        let r = sphere.radius * (1.0 - MARGIN);
        if self.nested.is_some() || r <= from.radius.min(to.radius) {
            return false;
        }
        let w = sphere.center - from.center;
        let along = w.dot(self.axis);
        // The shaft's cut through the sphere's middle is inside the sphere, between the two spheres.
        let cut = (from.radius + self.sin * along) * self.secant;
        let aside = (w - self.axis * along).length();
        let near = w.length() - from.radius;
        let outer = sphere.radius * (1.0 + MARGIN);
        aside + cut + SLACK * along.abs() < r
            && along > from.radius
            && along < self.length - to.radius
            && near > outer
            && (near - outer) * (near + outer) > clear * clear
            && sphere.center.distance(to.center) > (outer + to.radius) * (1.0 + MARGIN)
    }
}
