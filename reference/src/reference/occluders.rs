//! The blockers of a tile and of a point, and whether a ray meets one.

use super::meridian::Cap;
use crate::cone::LightCone;
use glam::{DVec3, Vec3};
use lobe_core::{NO_OBJECT, Receiver, Sphere};
use scene::BlockerSet;

/// A blocker sphere as one receiver sees it.
#[derive(Clone, Copy, Debug)]
struct Occluder {
    /// From the receiver to the centre.
    to_center: DVec3,
    radius_sq: f64,
    /// It blocks only where the ray leaves it farther than this.
    min_exit: f64,
}

/// The blockers between one receiver and one light.
#[derive(Debug, Default)]
pub(crate) struct Occluders {
    /// All of them, those that are caps first.
    list: Vec<Occluder>,
    caps: Vec<Cap>,
    all: bool,
    /// The normal of the receiver's facet where its object has spheres: they replace a mesh, which hides the directions below the facet.
    facet: Option<DVec3>,
}

/// Collects the numbers of the spheres that may lie between any of the receivers and the light: those that touch the
/// capsule around the line between their centres.
pub(crate) fn tile_candidates(receivers: &[Receiver], light: Sphere, blockers: &BlockerSet, out: &mut Vec<u32>) {
    out.clear();
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for r in receivers {
        (low, high) = (low.min(r.position), high.max(r.position));
    }
    let start = (0.5 * (low.as_dvec3() + high.as_dvec3()), 0.5 * (high - low).as_dvec3().length());
    let along = light.center.as_dvec3() - start.0;
    let capsule = start.1.max(f64::from(light.radius));
    let inverse = 1.0 / along.length_squared().max(f64::MIN_POSITIVE);
    for (i, s) in blockers.spheres.iter().enumerate() {
        let to = s.center.as_dvec3() - start.0;
        let t = (to.dot(along) * inverse).clamp(0.0, 1.0);
        // The margin is far above rounding and costs nothing but a useless candidate.
        let reach = (f64::from(s.radius) + capsule) * (1.0 + 1e-9);
        if (to - along * t).length_squared() <= reach * reach {
            out.push(i as u32);
        }
    }
}

impl Occluders {
    /// Keeps of the candidates those that block some ray of the cone nearer than `farthest`.
    pub(crate) fn select(
        &mut self,
        at: &Receiver,
        cone: &LightCone,
        farthest: f64,
        candidates: &[u32],
        blockers: &BlockerSet,
    ) {
        self.none();
        let has_own = at.object != NO_OBJECT && blockers.objects.contains(&at.object);
        self.facet = (has_own && at.face != at.normal).then(|| at.face.as_dvec3());
        let (nearest, _) = cone.surface_range();
        let half_angle = cone.half_angle();
        for &i in candidates {
            let own = blockers.objects[i as usize] == at.object;
            let (s, tau) = blockers.seen_from(i as usize, at);
            let min_exit = f64::from(tau);
            let to_center = s.center.as_dvec3() - at.position.as_dvec3();
            let (d, r) = (to_center.length(), f64::from(s.radius));
            if d + r <= min_exit || d - r >= farthest {
                continue;
            }
            let occluder = Occluder { to_center, radius_sq: r * r, min_exit };
            if d <= r {
                // Inside: a stranger's sphere is left at a positive distance in every direction.
                self.all |= !own && d < r;
            } else {
                let off_axis = angle(to_center / d, cone.axis());
                let half = (r / d).asin();
                if off_axis > half_angle + half + 1e-9 {
                    continue;
                }
                let tangent = ((d - r) * (d + r)).sqrt();
                // All rays that meet it enter before the tangent's length, and leave after it.
                if tangent < nearest && tangent > min_exit {
                    self.all |= off_axis + half_angle < half - 1e-9;
                    let last = self.caps.len();
                    self.caps.push(Cap::new(cone, to_center / d, tangent / d));
                    self.list.push(occluder);
                    let end = self.list.len() - 1;
                    self.list.swap(last, end);
                    continue;
                }
            }
            self.list.push(occluder);
        }
    }

    pub(crate) fn none(&mut self) {
        self.list.clear();
        self.caps.clear();
        self.all = false;
        self.facet = None;
    }

    /// Those that hide a cap of directions.
    pub(crate) fn caps(&self) -> &[Cap] {
        &self.caps
    }

    /// True when some occluder lies on the ray before `limit`.
    #[inline]
    pub(crate) fn block(&self, v: DVec3, limit: f64) -> bool {
        self.is_hidden(v) || self.list.iter().any(|o| o.blocks(v, limit))
    }

    /// The same for the occluders that are no caps.
    #[inline]
    pub(crate) fn block_beside_caps(&self, v: DVec3, limit: f64) -> bool {
        self.is_hidden(v) || self.list[self.caps.len()..].iter().any(|o| o.blocks(v, limit))
    }

    fn is_hidden(&self, v: DVec3) -> bool {
        self.all || self.facet.is_some_and(|face| face.dot(v) <= 0.0)
    }
}

impl Occluder {
    #[inline]
    fn blocks(&self, v: DVec3, limit: f64) -> bool {
        let along = self.to_center.dot(v);
        let half_sq = self.radius_sq - (self.to_center - v * along).length_squared();
        if half_sq <= 0.0 {
            return false;
        }
        let half = half_sq.sqrt();
        along + half > self.min_exit && (along - half).max(0.0) < limit
    }
}

/// Angle between unit vectors, good at both ends.
fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::SelfShadow;

    fn rng(state: &mut u64) -> f32 {
        *state = crate::sobol::mix(*state, 1);
        (*state >> 40) as f32 / (1 << 24) as f32
    }

    /// Culling per tile and per point never changes the hits of a ray: against a search through all spheres, with
    /// receivers inside spheres, own spheres, spheres in and behind the light.
    #[test]
    fn culling_is_exact() {
        let mut seed = 11;
        let mut r = || rng(&mut seed);
        let (mut blocked, mut free) = (0, 0);
        for case in 0..600 {
            let mut p = || Vec3::new(r(), r(), r()) * 2.0 - 1.0;
            let tile = p();
            let receivers: Vec<Receiver> =
                (0..4).map(|i| Receiver::on_surface(tile + p() * 0.05, Vec3::Y, Vec3::Y).on_object(i % 2)).collect();
            let centers: Vec<Vec3> = (0..12).map(|_| p()).collect();
            let light_center = p() * 1.5;
            let light = Sphere { center: light_center, radius: 0.02 + 0.5 * r() };
            let spheres: Vec<Sphere> =
                centers.into_iter().map(|center| Sphere { center, radius: 0.5 * r() * r() }).collect();
            let objects = (0..12).map(|i| i % 3).collect();
            let self_distances = vec![0.0, 0.3, 0.1];
            let mut blockers = BlockerSet { spheres, objects, self_distances, ..BlockerSet::default() };
            if case % 2 == 1 {
                let own = |_| {
                    let offset = Vec3::new(r(), r(), r()) - 0.5;
                    SelfShadow { offset, radius: 0.5 + 0.5 * r(), distance: 2.0 * r() }.sound()
                };
                blockers.self_shadows = (0..12).map(own).collect();
            }
            let mut candidates = Vec::new();
            tile_candidates(&receivers, light, &blockers, &mut candidates);
            let mut some = Occluders::default();
            for at in &receivers {
                let cone = LightCone::new(at.position, light);
                some.select(at, &cone, cone.surface_range().1, &candidates, &blockers);
                for _ in 0..50 {
                    let v = cone.sample(f64::from(r()), f64::from(r()));
                    let limit = cone.surface(v);
                    let naive = (0..12).any(|i| {
                        let (s, tau) = blockers.seen_from(i, at);
                        let to = s.center.as_dvec3() - at.position.as_dvec3();
                        let b = to.dot(v);
                        let h = b * b - to.length_squared() + f64::from(s.radius).powi(2);
                        h > 0.0 && b + h.sqrt() > f64::from(tau) && (b - h.sqrt()).max(0.0) < limit
                    });
                    assert_eq!(some.block(v, limit), naive);
                    if naive { blocked += 1 } else { free += 1 }
                }
            }
        }
        assert!(blocked > 10_000 && free > 10_000, "{blocked} {free}");
    }
}
