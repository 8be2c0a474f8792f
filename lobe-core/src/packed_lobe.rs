use crate::grain::Grain;
use crate::{BrdfLobe, Lobe, Microfacets, Schlick};
use glam::Vec3;

/// A [`BrdfLobe`] as eight numbers: a row of [`TileLobes`](crate::TileLobes), and the struct `Lobe` of WGSL.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PackedLobe {
    /// The lobe's axis; of microfacets the direction to the eye.
    pub axis: Vec3,
    /// The exponent.
    pub exponent: f32,
    /// The factor of the integral.
    pub flux: Vec3,
    /// One of the constants of this type.
    pub kind: f32,
}

impl PackedLobe {
    /// A cosine lobe.
    pub const PLAIN: f32 = 0.0;
    /// A cosine lobe times the receiver's cosine.
    pub const COSINE: f32 = 1.0;
    /// The part of microfacets' reflectance that `f0` multiplies. This number and above: microfacets.
    pub const MICROFACETS_F0: f32 = 2.0;
    /// The part that `f90` multiplies.
    pub const MICROFACETS_F90: f32 = 3.0;
    /// This number and above: microfacets with a [grain](crate::Grain), whose bits are those behind; from 6 on those of `f90`.
    pub const MICROFACETS_GRAIN: f32 = 4.0;
}

/// The lowest bit of the second half of numbers from [`PackedLobe::MICROFACETS_GRAIN`] on.
pub(crate) const HALF: u32 = 1 << 22;

impl PackedLobe {
    /// Whether it is of [`Microfacets`].
    #[inline(always)]
    #[must_use]
    pub const fn is_microfacets(&self) -> bool {
        self.kind >= Self::MICROFACETS_F0
    }

    /// Whether it is Lambert's at a receiver of this normal.
    #[inline(always)]
    pub(crate) fn is_lambert(&self, normal: Vec3) -> bool {
        self.exponent == 1.0 && self.kind == Self::PLAIN && self.axis == normal
    }

    /// Whether it is the part of microfacets that `f90` multiplies.
    #[inline(always)]
    #[must_use]
    pub fn is_edge(&self) -> bool {
        self.kind == Self::MICROFACETS_F90 || self.kind >= 1.5 * Self::MICROFACETS_GRAIN
    }

    /// The grain of microfacets of this kind.
    #[inline(always)]
    pub(crate) fn grain(kind: f32) -> Option<Grain> {
        (kind >= Self::MICROFACETS_GRAIN).then(|| Grain::from_bits(kind.to_bits() % HALF))
    }

    /// Whether `f90` is the other half of microfacets that begin with this lobe.
    #[inline(always)]
    pub(crate) fn is_followed_by(&self, f90: &Self) -> bool {
        let is_brushed = self.kind >= Self::MICROFACETS_GRAIN && self.kind.to_bits() + HALF == f90.kind.to_bits();
        let is_pair = self.kind == Self::MICROFACETS_F0 && f90.kind == Self::MICROFACETS_F90 || is_brushed;
        let reflects = self.flux != Vec3::ZERO && f90.flux != Vec3::ZERO;
        is_pair && reflects && self.exponent == f90.exponent && self.axis == f90.axis
    }
}

impl From<Lobe> for PackedLobe {
    #[inline(always)]
    fn from(Lobe { axis, exponent, flux, has_cosine }: Lobe) -> Self {
        Self { axis, exponent, flux, kind: if has_cosine { Self::COSINE } else { Self::PLAIN } }
    }
}

impl From<Microfacets> for PackedLobe {
    #[inline(always)]
    fn from(Microfacets { view, exponent, flux, part, grain }: Microfacets) -> Self {
        let kind = match (part, grain) {
            (Schlick::F0, None) => Self::MICROFACETS_F0,
            (Schlick::F90, None) => Self::MICROFACETS_F90,
            (part, Some(grain)) => {
                let half = if part == Schlick::F90 { HALF } else { 0 };
                f32::from_bits(Self::MICROFACETS_GRAIN.to_bits() + half + grain.bits())
            }
        };
        Self { axis: view, exponent, flux, kind }
    }
}

impl From<BrdfLobe> for PackedLobe {
    #[inline(always)]
    fn from(lobe: BrdfLobe) -> Self {
        match lobe {
            BrdfLobe::Cosine(lobe) => lobe.into(),
            BrdfLobe::Microfacets(facets) => facets.into(),
        }
    }
}

impl From<PackedLobe> for BrdfLobe {
    #[inline(always)]
    fn from(lobe: PackedLobe) -> Self {
        let PackedLobe { axis, exponent, flux, kind } = lobe;
        if lobe.is_microfacets() {
            let part = if lobe.is_edge() { Schlick::F90 } else { Schlick::F0 };
            Self::Microfacets(Microfacets { view: axis, exponent, flux, part, grain: PackedLobe::grain(kind) })
        } else {
            Self::Cosine(Lobe { axis, exponent, flux, has_cosine: kind == PackedLobe::COSINE })
        }
    }
}
