use crate::{Area, Light, LightError, LightKind};
use glam::{Mat4, Vec3};
use lobe_core::gpu::GpuLight;
use lobe_core::{Cone, LightLobes, Receiver, SeenLight, Sphere, Tile, TileLight};

/// A ball that emits the same radiance in all directions from all of its surface.
///
/// Neither seen by the camera nor a blocker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    /// Where it is, how large.
    pub ball: Sphere,
    /// Radiance, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec3,
}

impl SphereLight {
    /// A light of the given radiance `L`.
    #[must_use]
    pub const fn new(ball: Sphere, radiance: Vec3) -> Self {
        Self { ball, radiance }
    }

    /// A light that emits the total power `flux` (W per channel): `L = Φ/(4π²r²)`. The radius must be positive.
    #[must_use]
    pub fn with_flux(ball: Sphere, flux: Vec3) -> Self {
        let pi = core::f32::consts::PI;
        Self { ball, radiance: flux / (4.0 * pi * pi * ball.radius * ball.radius) }
    }

    /// A small light of the intensity `I` (W·sr⁻¹ per channel, from afar): `L = I/(πr²)`. The radius must be positive.
    #[must_use]
    pub fn with_intensity(ball: Sphere, intensity: Vec3) -> Self {
        Self { ball, radiance: intensity / (core::f32::consts::PI * ball.radius * ball.radius) }
    }
}

impl LightLobes for SphereLight {
    fn bounds(&self) -> Sphere {
        self.ball
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        SeenLight::of_cone(Cone::of_sphere(at.position, self.ball), self.radiance)
    }

    fn tile_light(&self, _: &[Receiver], tile: &Tile, out: &mut TileLight) {
        out.ball(tile, self.ball, self.radiance);
    }
}

impl LightKind for SphereLight {
    fn name(&self) -> &'static str {
        "sphere"
    }

    fn validate(&self) -> Result<(), LightError> {
        LightError::check_sphere(self.ball)
    }

    fn full_radiance(&self) -> Vec3 {
        self.radiance
    }

    fn sphere(&self) -> Option<Sphere> {
        Some(self.ball)
    }

    fn moved(&self, placement: Mat4) -> Light {
        Self { ball: Sphere { center: placement.transform_point3(self.ball.center), ..self.ball }, ..*self }.into()
    }

    fn area(&self, _: Vec3) -> Option<Area<'_>> {
        Some(Area::sphere(self.ball))
    }

    fn wgsl(&self) -> Option<[&'static str; 2]> {
        Some([Self::NAME, Self::WGSL])
    }
}

impl GpuLight for SphereLight {
    const NAME: &'static str = "sphere lights";
    const WGSL: &'static str = include_str!("sphere_light.wgsl");

    fn gpu_radiance(&self) -> [f32; 3] {
        self.radiance.to_array()
    }
}
