use crate::gpu::{AMBIENT, CONES};
use crate::{Area, Light, LightError, LightKind};
use glam::{Mat4, Vec3};
use lobe_core::{Cone, Receiver, SeenLight, Sphere};
use shading::LightLobes;
use shading::gpu::GpuText;

/// The same radiance from everywhere, which nothing hides: what a scene without walls reflects, as a guess.
///
/// A receiver is inside of a sphere of light, as large as you like; one sphere for all receivers is `world`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientLight {
    /// Radiance, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec3,
    /// A sphere around all that is lit.
    pub world: Sphere,
}

impl LightLobes for AmbientLight {
    fn bounds(&self) -> Sphere {
        self.world
    }

    /// Nothing between receivers and this sphere hides the light.
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        *receivers
    }

    fn has_shadows(&self) -> bool {
        false
    }

    /// All directions.
    fn seen_from(&self, at: &Receiver) -> SeenLight {
        let cone = Cone { axis: at.normal, one_minus_cos: 2.0, distance: f32::MIN_POSITIVE };
        SeenLight::of_cone(cone, self.radiance)
    }
}

impl LightKind for AmbientLight {
    fn name(&self) -> &'static str {
        "ambient"
    }

    fn validate(&self) -> Result<(), LightError> {
        LightError::check_bounds(self.world)
    }

    fn full_radiance(&self) -> Vec3 {
        self.radiance
    }

    /// It is everywhere.
    fn moved(&self, _: Mat4) -> Light {
        (*self).into()
    }

    fn area(&self, from: Vec3) -> Option<Area<'_>> {
        Some(Area::sphere(Sphere { center: from, radius: 1.0 }))
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
        vec![[0.0; 4], [0.0, 0.0, 0.0, AMBIENT]]
    }
}
