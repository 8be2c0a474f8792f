use glam::{Mat4, Vec3};
use lobe_core::{Cone, LightLobes, Receiver, SeenLight, Sphere};

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

impl AmbientLight {
    /// The same light: it is everywhere.
    #[must_use]
    pub const fn moved(&self, _: Mat4) -> Self {
        *self
    }
}

impl LightLobes for AmbientLight {
    fn bounds(&self) -> Sphere {
        self.world
    }

    /// Nothing between receivers and this sphere hides the light.
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        *receivers
    }

    /// All directions: strategies are not queried from inside a light.
    fn seen_from(&self, at: &Receiver) -> SeenLight {
        let cone = Cone { axis: at.normal, one_minus_cos: 2.0, distance: f32::MIN_POSITIVE };
        SeenLight::of_cone(cone, self.radiance)
    }
}
