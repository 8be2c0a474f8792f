use crate::{Lobe, Microfacets};
use glam::Vec3;

/// One lobe of a reflectance `f̃ = f_r·(n·v)`: a cosine lobe of directions, or half of the light that microfacets reflect.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{BrdfLobe, Lobe};
/// let diffuse = BrdfLobe::from(Lobe::new(Vec3::Z, 1.0, Vec3::ONE));
/// assert_eq!(diffuse.eval_at(Vec3::Z, Vec3::Z), Vec3::ONE);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BrdfLobe {
    /// A cosine lobe.
    Cosine(Lobe),
    /// A lobe of half vectors.
    Microfacets(Microfacets),
}

impl BrdfLobe {
    /// The factor of its integral over a light, which [`cap_integral`](crate::cap_integral) takes for a flux of 1.
    #[inline]
    #[must_use]
    pub const fn flux(&self) -> Vec3 {
        match self {
            Self::Cosine(lobe) => lobe.flux,
            Self::Microfacets(facets) => facets.flux,
        }
    }

    /// Value in the unit direction `v` at a receiver of this normal.
    #[must_use]
    pub fn eval_at(&self, normal: Vec3, v: Vec3) -> Vec3 {
        match self {
            Self::Cosine(lobe) => lobe.eval_at(normal, v),
            Self::Microfacets(facets) => facets.flux * facets.value(normal, v),
        }
    }

    /// Value of a sum in the unit direction `v` at a receiver of this normal.
    #[must_use]
    pub fn sum_at(lobes: &[Self], normal: Vec3, v: Vec3) -> Vec3 {
        lobes.iter().map(|lobe| lobe.eval_at(normal, v)).sum()
    }

    /// The cosine lobe, or the one that stands for microfacets at a receiver of this normal ([`Microfacets::mirror_lobe`]).
    #[must_use]
    pub fn cosine_lobe(&self, normal: Vec3) -> Lobe {
        match self {
            Self::Cosine(lobe) => *lobe,
            Self::Microfacets(facets) => facets.mirror_lobe(normal),
        }
    }
}

impl From<Lobe> for BrdfLobe {
    fn from(lobe: Lobe) -> Self {
        Self::Cosine(lobe)
    }
}

impl From<&Lobe> for BrdfLobe {
    fn from(lobe: &Lobe) -> Self {
        Self::Cosine(*lobe)
    }
}

impl From<Microfacets> for BrdfLobe {
    fn from(facets: Microfacets) -> Self {
        Self::Microfacets(facets)
    }
}
