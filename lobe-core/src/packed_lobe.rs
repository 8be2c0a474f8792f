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

/// Declares the kinds as constants of [`PackedLobe`] and of WGSL, with WGSL's prefix `LOBE_`.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident = $number:literal;)*) => {
        impl PackedLobe {
            $($(#[$doc])* pub const $name: f32 = $number;)*
        }

        pub(crate) const WGSL: &str = concat!(
            $("const LOBE_", stringify!($name), " = ", stringify!($number), "f;\n",)*
            include_str!("lobe.wgsl")
        );
    };
}

kinds! {
    /// A cosine lobe.
    PLAIN = 0.0;
    /// A cosine lobe times the receiver's cosine.
    COSINE = 1.0;
    /// The part of microfacets' reflectance that `f0` multiplies. This number and above: microfacets.
    MICROFACETS_F0 = 2.0;
    /// The part that `f90` multiplies.
    MICROFACETS_F90 = 3.0;
}

impl PackedLobe {
    /// Whether it is of [`Microfacets`].
    #[inline(always)]
    #[must_use]
    pub const fn is_microfacets(&self) -> bool {
        self.kind >= Self::MICROFACETS_F0
    }

    /// Whether `f90` is the other half of microfacets that begin with this lobe.
    #[inline(always)]
    pub(crate) fn is_followed_by(&self, f90: &Self) -> bool {
        let is_pair = self.kind == Self::MICROFACETS_F0 && f90.kind == Self::MICROFACETS_F90;
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
    fn from(Microfacets { view, exponent, flux, part }: Microfacets) -> Self {
        let kind = match part {
            Schlick::F0 => Self::MICROFACETS_F0,
            Schlick::F90 => Self::MICROFACETS_F90,
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
    fn from(PackedLobe { axis, exponent, flux, kind }: PackedLobe) -> Self {
        if kind >= PackedLobe::MICROFACETS_F0 {
            let part = if kind == PackedLobe::MICROFACETS_F90 { Schlick::F90 } else { Schlick::F0 };
            Self::Microfacets(Microfacets { view: axis, exponent, flux, part })
        } else {
            Self::Cosine(Lobe { axis, exponent, flux, has_cosine: kind == PackedLobe::COSINE })
        }
    }
}
