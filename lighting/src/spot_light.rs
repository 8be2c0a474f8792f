use crate::SphereLight;
use glam::{Mat4, Vec3};
use lobe_core::{LightLobes, Receiver, SeenLight, Sphere};

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

    /// The same light somewhere else. Turns and shifts only.
    #[must_use]
    pub fn moved(&self, placement: Mat4) -> Self {
        let axis = placement.transform_vector3(self.axis).normalize_or(self.axis);
        Self { light: self.light.moved(placement), axis, ..*self }
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
