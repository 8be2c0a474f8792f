//! A lamp: a sphere or a tube that stands for triangles.

use crate::{Light, SphereLight, TubeLight};
use glam::{DVec3, Vec3};
use lobe_core::Sphere;

/// A sphere, or a tube where its ends are not the same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    pub(super) ends: [DVec3; 2],
    pub(super) radius: f64,
}

impl Lamp {
    /// Whether a line meets it.
    pub(super) fn is_met(&self, from: DVec3, v: DVec3) -> bool {
        let across = |p: DVec3| p - v * v.dot(p);
        let (to, along) = (across(self.ends[0] - from), across(self.ends[1] - self.ends[0]));
        let square = along.length_squared();
        let t = if square > 0.0 { (-to.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        (to + along * t).length_squared() <= self.radius * self.radius
    }

    pub(super) fn light(&self, center: DVec3, scale: f64, radiance: Vec3) -> Light {
        let ends = self.ends.map(|p| (center + p * scale).as_vec3());
        let radius = (self.radius * scale) as f32;
        if ends[0] == ends[1] {
            SphereLight::new(Sphere { center: ends[0], radius }, radiance).into()
        } else {
            TubeLight { ends, radius, radiance }.into()
        }
    }

    /// A tube between two places, or a sphere where they are next to each other.
    pub(super) fn tube(middle: DVec3, axis: DVec3, length: f64, radius: f64) -> Self {
        Self { ends: [middle - axis * (0.5 * length), middle + axis * (0.5 * length)], radius }
    }
}
