//! Spheres before a whole sky.

use crate::SphereBlockers;
use fearless_simd::{Level, dispatch};
use glam::Vec3;
use lobe_core::{Receiver, SelfShadow, Sphere};
use visibility_mask::sky::{SkyBlockers, SkyBuffer, SkyTile};

/// Working memory of [`SphereBlockers`] before a sky.
#[derive(Clone, Debug, Default)]
pub struct SkySphereScratch {
    /// Spheres that are above the horizon of any receiver of the tile.
    candidates: Vec<u32>,
    /// The directions that they hide from the last receiver, and whether one hides all.
    cones: Vec<BlockedDirections>,
    is_dark: bool,
}

/// All directions `v` with `axis·v ≥ cos`.
#[derive(Clone, Copy, Debug)]
struct BlockedDirections {
    axis: Vec3,
    cos: f32,
}

impl BlockedDirections {
    /// The directions that a sphere hides if rays are blocked only where they leave it farther than τ away: the tangent cone if the power `k = d² − r²` is not
    /// below τ², else `cos β = (τ² + k)/2τd`. None where that is nothing.
    fn of(sphere: Sphere, tau: f32, from: Vec3) -> Option<Self> {
        let to = sphere.center - from;
        let distance = to.length();
        let power = (distance - sphere.radius) * (distance + sphere.radius);
        let cos = if power > 0.0 && tau * tau <= power {
            power.sqrt() / distance
        } else if tau > 0.0 && distance > 0.0 {
            (tau * tau + power) / (2.0 * tau * distance)
        } else if power <= 0.0 && tau < sphere.radius + distance {
            -1.0
        } else {
            1.0
        };
        let axis = if distance > 0.0 { to / distance } else { Vec3::Z };
        (cos < 1.0).then_some(Self { axis, cos: cos.max(-1.0) })
    }
}

impl SphereBlockers {
    /// A sphere as a receiver sees it, and its τ.
    fn seen_by(&self, index: usize, at: &Receiver) -> (Sphere, f32) {
        let sphere = self.spheres()[index];
        if self.objects()[index] != at.object {
            return (sphere, 0.0);
        }
        let (near, tau) = self.own(index);
        (SelfShadow::seen(sphere, near, at.position), tau)
    }
}

impl SkyBlockers for SphereBlockers {
    type Scratch = SkySphereScratch;

    fn scratch(&self) -> SkySphereScratch {
        SkySphereScratch::default()
    }

    fn has_facet(&self, at: &Receiver) -> bool {
        self.casters().binary_search(&at.object).is_ok()
    }

    fn enter(&self, tile: &SkyTile<'_>, scratch: &mut SkySphereScratch) -> bool {
        let spheres = self.spheres();
        let is_above = |i: &u32| {
            let Sphere { center, radius } = spheres[*i as usize];
            let mut all = tile.receivers.iter().zip(tile.horizons);
            all.any(|(at, horizon)| horizon.normal().dot(center - at.position) > -radius)
        };
        scratch.candidates.clear();
        scratch.candidates.extend(self.order().iter().copied().filter(is_above));
        true
    }

    fn draw(&self, tile: &SkyTile<'_>, number: usize, buffer: &mut SkyBuffer, scratch: &mut SkySphereScratch) -> bool {
        let (at, horizon) = (&tile.receivers[number], &tile.horizons[number]);
        scratch.cones.clear();
        scratch.is_dark = false;
        for index in &scratch.candidates {
            let (sphere, tau) = self.seen_by(*index as usize, at);
            if horizon.normal().dot(sphere.center - at.position) <= -sphere.radius {
                continue;
            }
            let Some(cone) = BlockedDirections::of(sphere, tau, at.position) else { continue };
            scratch.is_dark |= cone.cos <= -1.0;
            scratch.cones.push(cone);
        }
        if !scratch.is_dark {
            dispatch!(Level::new(), simd => {
                for cone in &scratch.cones {
                    buffer.draw_cone(simd, tile.meridians, horizon, cone.axis, cone.cos);
                }
            });
        }
        false
    }

    fn hides(&self, _: &SkyTile<'_>, _: usize, direction: Vec3, scratch: &mut SkySphereScratch) -> bool {
        scratch.is_dark || scratch.cones.iter().any(|cone| cone.axis.dot(direction) >= cone.cos)
    }
}
