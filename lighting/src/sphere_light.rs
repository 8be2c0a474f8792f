use crate::{Area, Light, LightError, LightKind};
use glam::{Mat4, Vec3};
use lobe_core::wgsl::{GEOMETRY, Piece};
use lobe_core::{Cone, Receiver, SeenLight, Sphere, Tile, TileLight};
use shading::LightLobes;
use shading::gpu::{GpuLight, GpuText};

/// A sphere that emits the same radiance in all directions from all of its surface.
///
/// Neither seen by the camera nor a blocker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    /// Where it is, how large.
    pub sphere: Sphere,
    /// Radiance, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec3,
}

impl SphereLight {
    /// A light of the given radiance `L`.
    #[must_use]
    pub const fn new(sphere: Sphere, radiance: Vec3) -> Self {
        Self { sphere, radiance }
    }

    /// A light that emits the total power `flux` (W per channel): `L = Φ/(4π²r²)`. The radius must be positive.
    #[must_use]
    pub fn with_flux(sphere: Sphere, flux: Vec3) -> Self {
        let pi = core::f32::consts::PI;
        Self { sphere, radiance: flux / (4.0 * pi * pi * sphere.radius * sphere.radius) }
    }

    /// A small light of the intensity `I` (W·sr⁻¹ per channel, from afar): `L = I/(πr²)`. The radius must be positive.
    #[must_use]
    pub fn with_intensity(sphere: Sphere, intensity: Vec3) -> Self {
        Self { sphere, radiance: intensity / (core::f32::consts::PI * sphere.radius * sphere.radius) }
    }
}

impl LightLobes for SphereLight {
    fn bounds(&self) -> Sphere {
        self.sphere
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        SeenLight::of_cone(Cone::of_sphere(at.position, self.sphere), self.radiance)
    }

    fn tile_light(&self, _: &[Receiver], tile: &Tile, out: &mut TileLight) {
        out.sphere(tile, self.sphere, self.radiance);
    }
}

impl LightKind for SphereLight {
    fn name(&self) -> &'static str {
        "sphere"
    }

    fn validate(&self) -> Result<(), LightError> {
        LightError::check_sphere(self.sphere)
    }

    fn full_radiance(&self) -> Vec3 {
        self.radiance
    }

    fn sphere(&self) -> Option<Sphere> {
        Some(self.sphere)
    }

    fn moved(&self, placement: Mat4) -> Light {
        Self { sphere: Sphere { center: placement.transform_point3(self.sphere.center), ..self.sphere }, ..*self }
            .into()
    }

    fn area(&self, _: Vec3) -> Option<Area<'_>> {
        Some(Area::sphere(self.sphere))
    }

    fn wgsl(&self) -> Option<GpuText> {
        Some((Self::NAME, Self::WGSL))
    }
}

static WGSL: Piece = Piece::new(include_str!("sphere_light.wgsl")).needs(&[&GEOMETRY]);

impl GpuLight for SphereLight {
    const NAME: &'static str = "sphere lights";
    const WGSL: &'static Piece = &WGSL;

    fn gpu_radiance(&self) -> [f32; 3] {
        self.radiance.to_array()
    }
}
