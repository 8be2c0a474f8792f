use crate::gpu::{CONES, INSIDE, PLANES};
use crate::{Area, Light, LightError, LightKind, SphereLight};
use glam::{Mat4, Vec3};
use lobe_core::{LightImage, Receiver, SeenLight, Sphere};
use shading::gpu::{GpuLight as _, GpuText};
use shading::{LightExtent, LightLobes};

/// A light inside an object whose surface it stands for: it does not light that object.
///
/// A sphere in place of a faceted mesh is above its surface here and below it there; what that surface got of it would be noise.
///
/// ```
/// use glam::Vec3;
/// use lighting::{EnclosedLight, SphereLight};
/// use lobe_core::{Receiver, Sphere};
/// use shading::LightLobes;
/// let sphere = SphereLight::new(Sphere { center: Vec3::ZERO, radius: 1.0 }, Vec3::ONE);
/// let light = EnclosedLight { light: Box::new(sphere.into()), object: 3 };
/// let at = Receiver::on_surface(Vec3::Z * 0.99, Vec3::Z, Vec3::Z).on_object(3);
/// assert_eq!(light.radiance(&at), Vec3::ZERO);
/// assert_eq!(light.radiance(&Receiver { object: 2, ..at }), Vec3::ONE);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EnclosedLight {
    /// The light.
    pub light: Box<Light>,
    /// The number of the object, as receivers have it.
    pub object: u32,
}

impl LightLobes for EnclosedLight {
    fn bounds(&self) -> Sphere {
        self.light.bounds()
    }

    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        self.light.bounds_from(receivers)
    }

    fn extent(&self) -> Option<LightExtent> {
        self.light.extent()
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        let seen = self.light.seen_from(at);
        if at.object == self.object { SeenLight { radiance: Vec3::ZERO, ..seen } } else { seen }
    }

    fn image(&self) -> Option<&LightImage> {
        self.light.image()
    }

    fn has_shadows(&self) -> bool {
        self.light.has_shadows()
    }
}

impl LightKind for EnclosedLight {
    fn name(&self) -> &'static str {
        self.light.kind().name()
    }

    fn validate(&self) -> Result<(), LightError> {
        self.light.kind().validate()
    }

    fn full_radiance(&self) -> Vec3 {
        self.light.full_radiance()
    }

    fn sphere(&self) -> Option<Sphere> {
        self.light.sphere()
    }

    fn moved(&self, placement: Mat4) -> Light {
        Self { light: Box::new(self.light.moved(placement)), ..*self }.into()
    }

    fn area(&self, from: Vec3) -> Option<Area<'_>> {
        self.light.kind().area(from)
    }

    fn world(&self) -> Option<Sphere> {
        self.light.world()
    }

    fn in_world(&self, world: Sphere) -> Option<Light> {
        let light = Box::new(self.light.kind().in_world(world)?);
        Some(Self { light, ..*self }.into())
    }

    fn distance_to(&self, point: Vec3) -> Option<f32> {
        self.light.distance_to(point)
    }

    fn roundness(&self) -> Option<f32> {
        self.light.kind().roundness()
    }

    /// Of spheres and of lights that are seen as outlines.
    fn wgsl(&self) -> Option<GpuText> {
        match self.light.kind().wgsl()? {
            flat if flat == PLANES => Some(PLANES),
            (SphereLight::NAME, _) => Some(CONES),
            _ => None,
        }
    }

    fn gpu_bounds(&self) -> Sphere {
        self.light.kind().gpu_bounds()
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        if self.roundness().is_none() {
            return vec![[self.object as f32, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, INSIDE]];
        }
        let mut shape = self.light.kind().gpu_shape();
        shape[1][2] = self.object as f32;
        shape
    }
}
