use crate::splat::BlockedCone;
use glam::Vec3;
use lighting::{Blockers, Mask};
use lobe_core::{Coverage, Shaft, Sphere, VisibilityQuery};

/// Spheres that block light, as the `spheres` strategy sees them: wrap it in
/// [`MaskVisibility`](lighting::MaskVisibility).
///
/// # Self-shadowing
/// A sphere set stands for a mesh that lies partly inside, partly outside of it, so a receiver on the mesh is often
/// inside a sphere of its own object. The rule: *a sphere of the receiver's own object blocks a direction only if the
/// ray leaves it farther than τ from the receiver*. The blocked directions are again a cone about the sphere's centre,
/// with `d` the distance of the centre and `k = d² − r²`: the tangent cone if `k > 0` and `τ² ≤ k`, else
/// `cos β = (τ² + k)/(2τd)`, and it is continuous as the receiver moves through the sphere's surface. Spheres of other
/// objects have τ = 0: what contains the receiver hides everything from it.
///
/// # Order
/// A sphere blocks where it is in front of the light. For a sphere that does not meet the light this is the same for
/// all directions (the one with the smaller power `d² − r²` is in front); where blocker and light intersect it is
/// decided direction by direction.
#[derive(Clone, Debug, Default)]
pub struct SphereBlockers {
    spheres: Vec<Sphere>,
    objects: Vec<u32>,
    self_distances: Vec<f32>,
}

impl SphereBlockers {
    /// Blockers of several objects: `objects[i]` is the object of `spheres[i]`, `self_distances[object]` its τ (0 where
    /// missing). Spheres of radius zero or less block nothing and are dropped.
    ///
    /// # Panics
    /// When `spheres` and `objects` differ in length.
    #[must_use]
    pub fn new(spheres: &[Sphere], objects: &[u32], self_distances: &[f32]) -> Self {
        assert_eq!(spheres.len(), objects.len(), "each sphere belongs to an object");
        let solid = |s: &Sphere| s.radius > 0.0 && s.radius.is_finite() && s.center.is_finite();
        let (spheres, objects) = spheres.iter().zip(objects).filter(|(s, _)| solid(s)).map(|(s, o)| (*s, *o)).unzip();
        Self { spheres, objects, self_distances: self_distances.to_vec() }
    }

    /// The spheres that block.
    #[must_use]
    pub fn spheres(&self) -> &[Sphere] {
        &self.spheres
    }
}

/// Working memory of [`SphereBlockers`].
#[derive(Clone, Debug, Default)]
pub struct SphereScratch {
    /// Spheres in the current shaft.
    candidates: Vec<u32>,
    /// What meets the current receiver's light cone.
    hits: Vec<BlockedCone>,
}

#[cfg(test)]
impl SphereScratch {
    pub(crate) fn candidates(&self) -> usize {
        self.candidates.len()
    }
}

impl Blockers for SphereBlockers {
    type Scratch = SphereScratch;

    fn scratch(&self) -> SphereScratch {
        SphereScratch { candidates: (0..self.spheres.len() as u32).collect(), hits: Vec::new() }
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut SphereScratch) {
        scratch.candidates.clear();
        scratch
            .candidates
            .extend(self.spheres.iter().enumerate().filter(|(_, sphere)| meets(shaft, sphere)).map(|(i, _)| i as u32));
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut SphereScratch) -> Coverage {
        scratch.hits.clear();
        let cone = query.cone;
        let sin_sq = cone.sin_sq();
        let (sin, cos) = (sin_sq.sqrt(), cone.cos());
        // Power of the receiver with respect to the light.
        let light_power = cone.distance * cone.distance * (cos * cos);
        let light_radius = cone.distance * sin;
        for &index in &scratch.candidates {
            let sphere = &self.spheres[index as usize];
            let object = self.objects[index as usize];
            let to = sphere.center - query.at.position;
            let tau = if object == query.at.object {
                self.self_distances.get(object as usize).copied().unwrap_or(0.0)
            } else {
                0.0
            };
            let Some(mut blocked) = BlockedCone::new(to, sphere.radius, tau) else { continue };
            if cone.distance.is_finite() {
                let apart = (to - cone.axis * cone.distance).length();
                if apart >= sphere.radius + light_radius {
                    if to.length_squared() - sphere.radius * sphere.radius >= light_power {
                        continue;
                    }
                } else {
                    blocked.meets_light = Some((cone.axis * cone.distance, light_radius));
                }
            }
            match blocked.cover(cone.axis, sin, cos) {
                Coverage::Lit => {}
                Coverage::Dark => return Coverage::Dark,
                Coverage::Partial => scratch.hits.push(blocked),
            }
        }
        if scratch.hits.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    /// Toward the centre of the sphere that looks largest: its rim is the straightest edge on the square.
    fn across(&self, _: &VisibilityQuery<'_>, scratch: &SphereScratch) -> Vec3 {
        let size = |b: &&BlockedCone| b.one_minus_cos();
        scratch.hits.iter().max_by(|a, b| size(a).total_cmp(&size(b))).map_or(Vec3::ZERO, |b| b.to)
    }

    fn splat(&self, _: &VisibilityQuery<'_>, scratch: &mut SphereScratch, mask: &mut Mask) {
        for blocked in &scratch.hits {
            match blocked.meets_light {
                None => blocked.splat(mask),
                Some((center, radius)) => blocked.splat_in_front(center, radius, mask),
            }
        }
    }
}

/// Whether a sphere meets the convex hull of the shaft's two balls; conservative.
fn meets(shaft: &Shaft, sphere: &Sphere) -> bool {
    let (from, to) = (shaft.receivers, shaft.light);
    let axis = to.center - from.center;
    let length_sq = axis.length_squared();
    if length_sq <= 0.0 || !length_sq.is_finite() {
        return true;
    }
    let length = length_sq.sqrt();
    let w: Vec3 = sphere.center - from.center;
    let t = w.dot(axis) / length_sq;
    let reach = sphere.radius / length;
    if t + reach < -from.radius / length || t - reach > 1.0 + to.radius / length {
        return false;
    }
    let grow = to.radius - from.radius;
    let slope = grow / length;
    if slope.abs() >= 1.0 {
        return true;
    }
    let secant = 1.0 / (1.0 - slope * slope).sqrt();
    let distance = (w - axis * t).length();
    // A ball beyond either end is measured against the widest part.
    let width = (from.radius + grow * t).max(0.0).max(if t < 0.0 { from.radius } else { 0.0 }).max(if t > 1.0 {
        to.radius
    } else {
        0.0
    });
    distance * 0.999_9 <= width * secant + sphere.radius * secant
}
