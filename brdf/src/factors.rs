use glam::Vec3;

/// Factors on a material's parameters, as textures give them for a point: a surface whose material varies has one material a point.
///
/// ```
/// use brdf::{Factors, Material};
/// use glam::Vec3;
/// let white = Material::lambert(Vec3::ONE);
/// let red = white.scaled(&Factors { color: Vec3::new(0.8, 0.1, 0.1), ..Factors::ONE });
/// assert_eq!(red, Material::lambert(Vec3::new(0.8, 0.1, 0.1)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// Of the diffuse part, or a metallic–roughness material's base.
    pub color: Vec3,
    /// Of Phong's and Neumann's `ks`, the scales of Lafortune's and half-vector lobes, and what a metallic–roughness material's coat
    /// reflects at normal incidence.
    pub specular: Vec3,
    /// Of all that this coat reflects.
    pub coat: f32,
    /// Of the exponents.
    pub exponent: f32,
    /// Of metalness.
    pub metallic: f32,
    /// Of roughness.
    pub roughness: f32,
    /// Of the strength of anisotropy.
    pub anisotropy: f32,
    /// Of a clear coat's weight.
    pub clearcoat: f32,
    /// Of its roughness.
    pub clearcoat_roughness: f32,
}

impl Factors {
    /// Nothing changes.
    pub const ONE: Self = Self {
        color: Vec3::ONE,
        specular: Vec3::ONE,
        coat: 1.0,
        exponent: 1.0,
        metallic: 1.0,
        roughness: 1.0,
        anisotropy: 1.0,
        clearcoat: 1.0,
        clearcoat_roughness: 1.0,
    };

    /// The same within [0, 1]; 0 for NaN.
    pub(crate) fn clamped(self) -> Self {
        let unit = |x: f32| if x > 0.0 { x.min(1.0) } else { 0.0 };
        let color = |c: Vec3| Vec3::from_array(c.to_array().map(unit));
        Self {
            color: color(self.color),
            specular: color(self.specular),
            coat: unit(self.coat),
            exponent: unit(self.exponent),
            metallic: unit(self.metallic),
            roughness: unit(self.roughness),
            anisotropy: unit(self.anisotropy),
            clearcoat: unit(self.clearcoat),
            clearcoat_roughness: unit(self.clearcoat_roughness),
        }
    }
}

impl Default for Factors {
    fn default() -> Self {
        Self::ONE
    }
}
