use glam::{Mat4, Vec3};
use lobe_core::{Cone, LightLobes, Receiver, SeenLight, Sphere, Tile, TileLight};

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

    /// The same light somewhere else. Turns and shifts only.
    #[must_use]
    pub fn moved(&self, placement: Mat4) -> Self {
        Self { sphere: Sphere { center: placement.transform_point3(self.sphere.center), ..self.sphere }, ..*self }
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
