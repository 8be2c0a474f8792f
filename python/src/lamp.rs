//! Lamps as programs for modelling have them.

use cosine_lobes::lighting::{Area, Light, LightKind, SphereLight};
use cosine_lobes::lobe_core::{Cone, Receiver, SeenLight, Sphere};
use cosine_lobes::shading::LightLobes;
use glam::{Mat4, Vec3};
use std::sync::Arc;

/// A small light to all sides or into a cone, on the CPU alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    /// Radius and radiance.
    pub(crate) light: SphereLight,
    /// Whether it is a disc that faces each receiver instead of a sphere: seen under the angle whose tangent, not whose sine, is radius over
    /// distance.
    pub(crate) facing: bool,
    /// The cone, if it has one.
    pub(crate) beam: Option<Beam>,
}

/// The cone of a spot: a part of the radiance of `3x² − 2x³`, `x = (cos ψ − cos)/((1 − cos)·blend)` in [0, 1], leaves the light in directions at
/// the angle ψ from the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    /// Unit direction.
    pub(crate) axis: Vec3,
    /// Cosine of its half angle.
    pub(crate) cos: f32,
    /// The part of the cone in which it becomes dark.
    pub(crate) blend: f32,
}

/// Points across the light at which a beam is looked at.
const POINTS: i32 = 32;

impl Beam {
    fn part(&self, cos: f32) -> f32 {
        let x = ((cos - self.cos) / ((1.0 - self.cos) * self.blend).max(1e-6)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// The mean over a small disc, of the rays that reach one point from all of the light. Gauss's rule for `∫√(1 − x²) f(x) dx`.
    fn mean(&self, toward: Vec3, half: f32) -> f32 {
        let psi = self.axis.angle_between(toward);
        // The mean over a chord of the disc, beside the plane of axis and ray, turns rays by a third of its square.
        let at = |x: f32| self.part((psi + half * x).cos() * (1.0 - half * half * (1.0 - x * x) / 6.0));
        // Wholly in the bright part, or wholly outside.
        let brightest = if psi > half { at(-1.0) } else { self.part(1.0) };
        if brightest == 0.0 || at(1.0) == 1.0 {
            return brightest;
        }
        let step = core::f32::consts::PI / (POINTS + 1) as f32;
        let points = (1..=POINTS).map(|k| (k as f32 * step).sin_cos());
        let (sum, weight) = points.fold((0.0, 0.0), |(sum, weight), (sin, cos)| {
            let w = sin * sin;
            (sum + w * at(cos), weight + w)
        });
        sum / weight
    }
}

impl Lamp {
    pub(crate) fn light(self) -> Light {
        Light::Custom(Arc::new(self))
    }

    /// The sphere that looks like it from a point.
    fn seen(&self, from: Vec3) -> Sphere {
        let Sphere { center, radius } = self.light.sphere;
        if !self.facing {
            return self.light.sphere;
        }
        let distance = center.distance(from);
        Sphere { center, radius: radius * distance / distance.hypot(radius).max(f32::MIN_POSITIVE) }
    }
}

impl LightLobes for Lamp {
    fn bounds(&self) -> Sphere {
        self.light.sphere
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        let sphere = self.seen(at.position);
        let away = at.position - sphere.center;
        let part = self.beam.map_or(1.0, |beam| {
            let half = (sphere.radius / away.length().max(f32::MIN_POSITIVE)).min(1.0).asin();
            beam.mean(away.normalize_or(beam.axis), half)
        });
        SeenLight::of_cone(Cone::of_sphere(at.position, sphere), self.light.radiance * part)
    }
}

impl LightKind for Lamp {
    fn name(&self) -> &'static str {
        "lamp"
    }

    fn full_radiance(&self) -> Vec3 {
        self.light.radiance
    }

    fn sphere(&self) -> Option<Sphere> {
        Some(self.light.sphere)
    }

    fn moved(&self, placement: Mat4) -> Light {
        let sphere = Sphere { center: placement.transform_point3(self.light.sphere.center), ..self.light.sphere };
        let beam =
            self.beam.map(|beam| Beam { axis: placement.transform_vector3(beam.axis).normalize_or(beam.axis), ..beam });
        Self { light: SphereLight { sphere, ..self.light }, beam, ..*self }.light()
    }

    fn area(&self, from: Vec3) -> Option<Area<'_>> {
        Some(Area::sphere(self.seen(from)))
    }
}
