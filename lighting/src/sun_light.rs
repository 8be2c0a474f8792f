use crate::gpu::{CONES, SUN};
use crate::{Area, Light, LightError, LightKind};
use core::f32::consts::PI;
use glam::{Mat4, Vec3};
use lobe_core::{Cone, Receiver, SeenLight, Sphere};
use shading::LightLobes;
use shading::gpu::GpuText;

/// A light so far away that all receivers see it in the same directions: the sun, a window to a plain sky.
///
/// As a sphere it is one at a distance that all blockers are nearer than, another one for each receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunLight {
    /// Unit direction toward the light.
    pub toward: Vec3,
    /// Sine of half the angle under which it is seen, above 0.
    pub sin: f32,
    /// Radiance, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec3,
    /// A sphere around all that blocks and all that is lit.
    pub world: Sphere,
}

impl SunLight {
    /// Half-angle of the sun, in degrees.
    pub const HALF_ANGLE: f32 = 0.265;

    /// A light toward a unit direction with half-angle `degrees` that gives the irradiance `E` (W·m⁻² per channel) to a surface that faces
    /// it: `L = E/(π sin²θ)`. `world` is a sphere around all that blocks and all that is lit.
    #[must_use]
    pub fn new(toward: Vec3, degrees: f32, irradiance: Vec3, world: Sphere) -> Self {
        let sin = degrees.to_radians().sin();
        Self { toward, sin, radiance: irradiance / (PI * sin * sin), world }
    }

    fn distance(&self) -> f32 {
        4.0 * self.world.radius.max(f32::MIN_POSITIVE)
    }

    /// The cone in which all receivers see it.
    #[must_use]
    pub fn seen(&self) -> Cone {
        let sin_sq = self.sin * self.sin;
        let one_minus_cos = sin_sq / (1.0 + (1.0 - sin_sq).sqrt());
        Cone { axis: self.toward, one_minus_cos, distance: self.distance() }
    }

    /// The sphere that a receiver sees.
    #[must_use]
    pub fn sphere_from(&self, position: Vec3) -> Sphere {
        Sphere { center: position + self.toward * self.distance(), radius: self.distance() * self.sin }
    }
}

impl LightLobes for SunLight {
    /// Around the spheres of all receivers in the world.
    fn bounds(&self) -> Sphere {
        self.bounds_from(&self.world)
    }

    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        let sphere = self.sphere_from(receivers.center);
        Sphere { radius: sphere.radius + receivers.radius, ..sphere }
    }

    fn seen_from(&self, _: &Receiver) -> SeenLight {
        SeenLight::of_cone(self.seen(), self.radiance)
    }
}

impl LightKind for SunLight {
    fn name(&self) -> &'static str {
        "sun"
    }

    fn validate(&self) -> Result<(), LightError> {
        LightError::check_direction("direction", self.toward)?;
        let sin = self.sin;
        if !(sin > 0.0 && sin <= 1.0) {
            return Err(LightError::new(format!("sine of its half-angle is {sin}: expected more than 0, 1 at most")));
        }
        LightError::check_bounds(self.world)
    }

    fn full_radiance(&self) -> Vec3 {
        self.radiance
    }

    fn moved(&self, placement: Mat4) -> Light {
        Self { toward: placement.transform_vector3(self.toward).normalize_or(self.toward), ..*self }.into()
    }

    fn area(&self, from: Vec3) -> Option<Area<'_>> {
        Some(Area::sphere(self.sphere_from(from)))
    }

    fn world(&self) -> Option<Sphere> {
        Some(self.world)
    }

    fn in_world(&self, world: Sphere) -> Option<Light> {
        Some(Self { world, ..*self }.into())
    }

    fn wgsl(&self) -> Option<GpuText> {
        Some(CONES)
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        let cone = self.seen();
        vec![self.toward.extend(0.0).to_array(), [cone.one_minus_cos, cone.distance, 0.0, SUN]]
    }
}
