use crate::{HalfVector, Lafortune, LafortuneLobe, Lambert, Material, ModifiedPhong, Neumann, Phong};
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
}

impl Factors {
    /// Nothing changes.
    pub const ONE: Self =
        Self { color: Vec3::ONE, specular: Vec3::ONE, coat: 1.0, exponent: 1.0, metallic: 1.0, roughness: 1.0 };

    /// The same within [0, 1]; 0 for NaN.
    fn clamped(self) -> Self {
        let unit = |x: f32| if x > 0.0 { x.min(1.0) } else { 0.0 };
        let color = |c: Vec3| Vec3::from_array(c.to_array().map(unit));
        Self {
            color: color(self.color),
            specular: color(self.specular),
            coat: unit(self.coat),
            exponent: unit(self.exponent),
            metallic: unit(self.metallic),
            roughness: unit(self.roughness),
        }
    }
}

impl Default for Factors {
    fn default() -> Self {
        Self::ONE
    }
}

impl Material {
    /// The material as it is at a point of this normal with this tangent: [`Lafortune::turned`]; none if the tangent has no say.
    #[must_use]
    pub fn turned(&self, normal: Vec3, tangent: Vec3) -> Option<Self> {
        match self {
            Self::Lafortune(m) if m.is_anisotropic() => Some(m.turned(normal, tangent).into()),
            _ => None,
        }
    }

    /// The material with its parameters times factors, which are taken within [0, 1]: [valid](Self::validate) if this one is.
    ///
    /// Of metallic–roughness and half-vector lobes, the lobes of directions are those of the nearest of 256 roughnesses and four reflectances; their
    /// microfacets are exact.
    ///
    /// # Cost
    /// Some nanoseconds, and an allocation for Lafortune's.
    #[must_use]
    pub fn scaled(&self, by: &Factors) -> Self {
        let by = by.clamped();
        let Factors { color, specular, exponent, roughness, .. } = by;
        match self {
            Self::Lambert(m) => Lambert { albedo: m.albedo * color }.into(),
            Self::Phong(m) => Phong { kd: m.kd * color, ks: m.ks * specular, exponent: m.exponent * exponent }.into(),
            Self::ModifiedPhong(m) => {
                ModifiedPhong { kd: m.kd * color, ks: m.ks * specular, exponent: m.exponent * exponent }.into()
            }
            Self::Neumann(m) => {
                let exponent = (m.exponent * exponent).max(1.0);
                Neumann { kd: m.kd * color, ks: m.ks * specular, exponent }.into()
            }
            Self::Lafortune(m) => {
                let scaled =
                    |l: &LafortuneLobe| LafortuneLobe::new(l.matrix(), l.exponent() * exponent, l.scale() * specular);
                Lafortune { diffuse: m.diffuse * color, lobes: m.lobes.iter().map(scaled).collect() }.into()
            }
            Self::MetallicRoughness(m) => m.scaled(&by).into(),
            Self::HalfVector(m) => {
                let lobes = m.lobes.iter().map(|lobe| lobe.scaled(roughness, specular)).collect();
                HalfVector { diffuse: m.diffuse * color, lobes }.into()
            }
        }
    }
}
