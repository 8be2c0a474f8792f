use crate::{
    Brdf, BrdfSample, Factors, HalfVector, Lafortune, LafortuneLobe, Lambert, MaterialError, MetallicRoughness,
    ModifiedPhong, Neumann, Phong,
};
use glam::Vec3;
use lobe_core::Receiver;

/// Any of the built-in models: the closed set that scene files name. The open set is the [`Brdf`](crate::Brdf) trait.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Material {
    /// Ideally diffuse.
    Lambert(Lambert),
    /// The paper's Phong model, without cosine on the specular term.
    Phong(Phong),
    /// Normalised Phong.
    ModifiedPhong(ModifiedPhong),
    /// Lafortune.
    Lafortune(Lafortune),
    /// glTF's metallic–roughness model.
    MetallicRoughness(MetallicRoughness),
    /// Neumann et al.'s metals.
    Neumann(Neumann),
    /// Lobes about the half vector.
    HalfVector(HalfVector),
}

/// The same call on whichever model it is.
macro_rules! each {
    ($material:expr, $model:ident => $call:expr) => {
        match $material {
            Material::Lambert($model) => $call,
            Material::Phong($model) => $call,
            Material::ModifiedPhong($model) => $call,
            Material::Lafortune($model) => $call,
            Material::MetallicRoughness($model) => $call,
            Material::Neumann($model) => $call,
            Material::HalfVector($model) => $call,
        }
    };
}
pub(crate) use each;

impl Material {
    /// A diffuse material.
    #[must_use]
    pub const fn lambert(albedo: Vec3) -> Self {
        Self::Lambert(Lambert { albedo })
    }

    /// Checks the model's parameters.
    ///
    /// # Errors
    /// [`MaterialError`] that names what is wrong.
    pub fn validate(&self) -> Result<(), MaterialError> {
        match self {
            Self::Lambert(m) => m.validate(),
            Self::Phong(m) => m.validate(),
            Self::ModifiedPhong(m) => m.validate(),
            Self::Lafortune(m) => m.validate(),
            // Was checked when it was made.
            Self::MetallicRoughness(_) => Ok(()),
            Self::Neumann(m) => m.validate(),
            Self::HalfVector(m) => m.validate(),
        }
    }

    /// The model's name as scene files spell it.
    #[must_use]
    pub const fn model_name(&self) -> &'static str {
        match self {
            Self::Lambert(_) => "lambert",
            Self::Phong(_) => "phong",
            Self::ModifiedPhong(_) => "modified-phong",
            Self::Lafortune(_) => "lafortune",
            Self::MetallicRoughness(_) => "metallic-roughness",
            Self::Neumann(_) => "neumann",
            Self::HalfVector(_) => "half-vector",
        }
    }

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

impl Brdf for Material {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        each!(self, m => m.eval(at, v))
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        each!(self, m => m.sample(at, u))
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        each!(self, m => m.pdf(at, v))
    }
}

impl From<Lambert> for Material {
    fn from(model: Lambert) -> Self {
        Self::Lambert(model)
    }
}

impl From<Phong> for Material {
    fn from(model: Phong) -> Self {
        Self::Phong(model)
    }
}

impl From<ModifiedPhong> for Material {
    fn from(model: ModifiedPhong) -> Self {
        Self::ModifiedPhong(model)
    }
}

impl From<Lafortune> for Material {
    fn from(model: Lafortune) -> Self {
        Self::Lafortune(model)
    }
}

impl From<MetallicRoughness> for Material {
    fn from(model: MetallicRoughness) -> Self {
        Self::MetallicRoughness(model)
    }
}

impl From<Neumann> for Material {
    fn from(model: Neumann) -> Self {
        Self::Neumann(model)
    }
}

impl From<HalfVector> for Material {
    fn from(model: HalfVector) -> Self {
        Self::HalfVector(model)
    }
}
