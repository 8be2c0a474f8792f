use crate::Material;

/// The models that occur among some materials: what a shader needs the code of.
///
/// ```
/// use brdf::{Material, Models};
/// let models = Models::of(&[Material::lambert(glam::Vec3::ONE)]);
/// assert_eq!(models.names().collect::<Vec<_>>(), ["lambert"]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Models(u16);

impl Models {
    /// All of them.
    pub const ALL: Self = Self(0x1ff);

    /// Names by number, as [`Material::model_name`] spells them; some a second time, by microfacets instead of cosine lobes.
    const NAMES: [&'static str; 9] = [
        "lambert",
        "phong",
        "modified-phong",
        "lafortune",
        "metallic-roughness",
        "metallic-microfacets",
        "neumann",
        "half-vector",
        "half-vector-microfacets",
    ];

    /// The models of these materials.
    #[must_use]
    pub fn of(materials: &[Material]) -> Self {
        Self::numbered(materials, number)
    }

    /// The models of their [cosine lobes](lobe_core::BrdfLobes::cosine_lobes).
    #[must_use]
    pub fn of_cosine_lobes(materials: &[Material]) -> Self {
        Self::numbered(materials, cosine_number)
    }

    fn numbered(materials: &[Material], number: impl Fn(&Material) -> u32) -> Self {
        Self(materials.iter().fold(0, |all, material| all | 1 << number(material)))
    }

    /// The models whose bits are set, in the order of the table in the crate's documentation.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits & Self::ALL.0)
    }

    /// Their names, as [`Material::model_name`] spells them.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        self.numbers().map(|number| Self::NAMES[number as usize])
    }

    /// Their numbers, ascending.
    pub(crate) fn numbers(self) -> impl Iterator<Item = u32> {
        (0..Self::NAMES.len() as u32).filter(move |number| self.0 >> number & 1 == 1)
    }
}

/// Number of a material's model.
pub(crate) const fn number(material: &Material) -> u32 {
    match material {
        Material::Lambert(_) => 0,
        Material::Phong(_) => 1,
        Material::ModifiedPhong(_) => 2,
        Material::Lafortune(_) => 3,
        Material::MetallicRoughness(_) => 5,
        Material::Neumann(_) => 6,
        Material::HalfVector(_) => 8,
    }
}

/// Number of the model of its cosine lobes.
pub(crate) const fn cosine_number(material: &Material) -> u32 {
    match material {
        Material::MetallicRoughness(_) => 4,
        Material::HalfVector(_) => 7,
        _ => number(material),
    }
}
