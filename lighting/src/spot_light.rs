use crate::gpu::{CONES, SPOT};
use crate::{Area, Light, LightError, LightKind, SphereLight};
use glam::{Mat4, Vec3};
use lobe_core::{Receiver, SeenLight, Sphere};
use shading::LightLobes;

/// A sphere of light that shines into a cone with a soft edge: `L(ψ) = L·clamp((cos ψ − cos ψ_o)/(cos ψ_i − cos ψ_o), 0, 1)²`, ψ the angle
/// between the spot's axis and the direction from the light's middle to the receiver (as KHR_lights_punctual has it).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    /// The light along its axis.
    pub light: SphereLight,
    /// Unit direction in which it shines.
    pub axis: Vec3,
    /// Cosines of the angles at which it begins to fall and has fallen to nothing: the first is the larger.
    pub cos: [f32; 2],
}

impl SpotLight {
    /// The angular falloff: the part of the radiance that reaches a point.
    #[must_use]
    pub fn falloff(&self, position: Vec3) -> f32 {
        let cos = self.axis.dot((position - self.light.sphere.center).normalize_or_zero());
        let [inner, outer] = self.cos;
        let part = ((cos - outer) / (inner - outer).max(1e-4)).clamp(0.0, 1.0);
        part * part
    }
}

impl LightLobes for SpotLight {
    fn bounds(&self) -> Sphere {
        self.light.sphere
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        SeenLight { radiance: self.light.radiance * self.falloff(at.position), ..self.light.seen_from(at) }
    }
}

impl LightKind for SpotLight {
    fn name(&self) -> &'static str {
        "spot"
    }

    fn validate(&self) -> Result<(), LightError> {
        LightError::check_sphere(self.light.sphere)?;
        LightError::check_direction("axis", self.axis)?;
        let [inner, outer] = self.cos;
        if (-1.0..=1.0).contains(&outer) && (outer..=1.0).contains(&inner) {
            return Ok(());
        }
        Err(LightError::new(format!("cosines are {inner} and {outer}: expected 1 ≥ first ≥ second ≥ -1")))
    }

    fn full_radiance(&self) -> Vec3 {
        self.light.radiance
    }

    fn sphere(&self) -> Option<Sphere> {
        Some(self.light.sphere)
    }

    fn moved(&self, placement: Mat4) -> Light {
        let axis = placement.transform_vector3(self.axis).normalize_or(self.axis);
        let sphere = Sphere { center: placement.transform_point3(self.light.sphere.center), ..self.light.sphere };
        Self { light: SphereLight { sphere, ..self.light }, axis, ..*self }.into()
    }

    fn area(&self, _: Vec3) -> Option<Area<'_>> {
        Some(Area::sphere(self.light.sphere))
    }

    fn wgsl(&self) -> Option<[&'static str; 2]> {
        Some(CONES)
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        vec![self.axis.extend(0.0).to_array(), [self.cos[0], self.cos[1], 0.0, SPOT]]
    }
}
