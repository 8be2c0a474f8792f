use crate::term::Term;
use crate::tile::tile_lobes;
use crate::{
    Brdf, BrdfSample, HalfVector, Lafortune, Lambert, MaterialError, MetallicRoughness, ModifiedPhong, Neumann, Phong,
};
use glam::Vec3;
use lobe_core::{BrdfLobes, LobesFull, LobesMut, Receiver, Tile, TileLobes};

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

    /// The most lobes that it has, with those of microfacets, as the default method takes them, or without.
    #[must_use]
    pub fn lobe_count(&self, takes_microfacets: bool) -> usize {
        match self {
            Self::MetallicRoughness(_) if takes_microfacets => MetallicRoughness::MICROFACET_LOBES,
            Self::HalfVector(m) if takes_microfacets => m.microfacet_lobes(),
            material => material.max_lobes(),
        }
    }

    /// What the lobe at a place is made of; none beyond the last, and of models whose lobes have no such constants.
    pub(crate) fn term(&self, place: usize) -> Option<Term<'_>> {
        match self {
            Self::Lambert(m) => m.term(place),
            Self::Phong(m) => m.term(place),
            Self::ModifiedPhong(m) => m.term(place),
            Self::Lafortune(m) => m.term(place),
            Self::MetallicRoughness(_) | Self::Neumann(_) | Self::HalfVector(_) => None,
        }
    }
}

impl BrdfLobes for Material {
    fn max_lobes(&self) -> usize {
        each!(self, m => m.max_lobes())
    }

    fn brdf_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
        each!(self, m => m.brdf_lobes(at, out))
    }

    /// Sixteen receivers at a time.
    fn tile_lobes(
        materials: &[Self],
        of: &[u32],
        _: &[Receiver],
        tile: &Tile,
        out: &mut TileLobes,
    ) -> Result<(), LobesFull> {
        tile_lobes(materials, of, tile, out);
        Ok(())
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
