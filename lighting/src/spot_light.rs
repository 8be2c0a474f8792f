use crate::gpu::{CONES, SPOT};
use crate::{Area, Light, LightError, LightKind, SphereLight};
use glam::{Mat4, Vec3};
use lobe_core::{Receiver, SeenLight, Sphere};
use shading::LightLobes;
use shading::gpu::GpuText;

/// A sphere of light that shines into a cone with a soft edge: `L(ψ) = L·clamp((cos ψ − cos ψ_o)/(cos ψ_i − cos ψ_o), 0, 1)²`, ψ the angle
/// between the spot's axis and the direction from the light's middle to the receiver (as KHR_lights_punctual has it), times
/// `max(1 − (d/range)⁴, 0)` where it has a range, `d` the distance from the light's middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    /// The light along its axis.
    pub light: SphereLight,
    /// Unit direction in which it shines.
    pub axis: Vec3,
    /// Cosines of the angles at which it begins to fall and has fallen to nothing: the first is the larger.
    pub cos: [f32; 2],
    /// Distance from which on it lights nothing, above 0; infinite if there is none.
    pub range: f32,
}

/// Cosines that all directions are above.
const EVERYWHERE: [f32; 2] = [-2.0, -3.0];

impl SpotLight {
    /// A light that shines to all sides, as far as its range.
    #[must_use]
    pub const fn everywhere(light: SphereLight, range: f32) -> Self {
        Self { light, axis: Vec3::NEG_Y, cos: [-1.0; 2], range }
    }

    /// The falloff by angle and distance: the part of the radiance that reaches a point.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lighting::{SphereLight, SpotLight};
    /// use lobe_core::Sphere;
    /// let light = SphereLight::new(Sphere { center: Vec3::ZERO, radius: 0.1 }, Vec3::ONE);
    /// let lamp = SpotLight::everywhere(light, 4.0);
    /// assert_eq!(lamp.falloff(Vec3::Y * 2.0), 1.0 - 0.5_f32.powi(4));
    /// assert_eq!(lamp.falloff(Vec3::X * 5.0), 0.0);
    /// ```
    #[must_use]
    pub fn falloff(&self, position: Vec3) -> f32 {
        let to = position - self.light.sphere.center;
        let cos = self.axis.dot(to.normalize_or_zero());
        let [inner, outer] = self.cosines();
        let part = ((cos - outer) / (inner - outer).max(1e-4)).clamp(0.0, 1.0);
        let reach = (to.length() / self.range).powi(2);
        part * part * (1.0 - reach * reach).max(0.0)
    }

    /// Cosines with which the formula holds on the far side of the axis as well.
    const fn cosines(&self) -> [f32; 2] {
        if self.cos[0] <= -1.0 { EVERYWHERE } else { self.cos }
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
        let range = self.range;
        if range.is_nan() || range <= 0.0 {
            return Err(LightError::new(format!("the range is {range}: expected a number above 0")));
        }
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

    fn wgsl(&self) -> Option<GpuText> {
        Some(CONES)
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        let [inner, outer] = self.cosines();
        vec![self.axis.extend(0.0).to_array(), [inner, outer, 1.0 / self.range, SPOT]]
    }
}
