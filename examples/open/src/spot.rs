//! A light: a sphere in a shade, so that it shines into a cone with a smooth edge.

use cosine_lobes::glam::{Mat4, Vec3};
use cosine_lobes::lighting::{Area, Light, LightKind};
use cosine_lobes::lobe_core::wgsl::{GEOMETRY, Piece};
use cosine_lobes::lobe_core::{Cone, Receiver, SeenLight, Sphere};
use cosine_lobes::shading::LightLobes;
use cosine_lobes::shading::gpu::GpuText;
use std::sync::Arc;

/// Full radiance within an angle of `direction`, none beyond another, smooth between.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pub sphere: Sphere,
    pub radiance: Vec3,
    /// Unit.
    pub direction: Vec3,
    /// Cosines of the angles to which it shines fully, and at all.
    pub inner: f32,
    pub outer: f32,
}

impl LightLobes for Spot {
    fn bounds(&self) -> Sphere {
        self.sphere
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        let cone = Cone::of_sphere(at.position, self.sphere);
        let cos = -cone.axis.dot(self.direction);
        let x = ((cos - self.outer) / (self.inner - self.outer)).clamp(0.0, 1.0);
        SeenLight::of_cone(cone, self.radiance * (x * x * (3.0 - 2.0 * x)))
    }
}

static WGSL: Piece = Piece::new(
    "
    fn light_cone(at: Receiver) -> Cone { return cone_of_sphere(at.position, frame.light); }

    fn light_radiance(at: Receiver) -> vec3f {
        let cos = -dot(light_cone(at).axis, frame.shape[0].xyz);
        let x = clamp((cos - frame.shape[1].y) / (frame.shape[1].x - frame.shape[1].y), 0.0, 1.0);
        return frame.radiance * (x * x * (3.0 - 2.0 * x));
    }",
)
.needs(&[&GEOMETRY]);

/// For renderers, the reference and GPUs.
impl LightKind for Spot {
    fn name(&self) -> &'static str {
        "shaded spot"
    }

    fn full_radiance(&self) -> Vec3 {
        self.radiance
    }

    fn sphere(&self) -> Option<Sphere> {
        Some(self.sphere)
    }

    fn moved(&self, placement: Mat4) -> Light {
        let sphere = Sphere { center: placement.transform_point3(self.sphere.center), ..self.sphere };
        let direction = placement.transform_vector3(self.direction).normalize();
        Light::Custom(Arc::new(Self { sphere, direction, ..*self }))
    }

    fn area(&self, _: Vec3) -> Option<Area<'_>> {
        Some(Area::sphere(self.sphere))
    }

    fn wgsl(&self) -> Option<GpuText> {
        Some(("shaded spot", &WGSL))
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        vec![self.direction.extend(0.0).to_array(), [self.inner, self.outer, 0.0, 0.0]]
    }
}
