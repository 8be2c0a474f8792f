//! The WGSL of this crate: pieces that a shader's module is [joined](join) of. Their order does not matter.
//!
//! Functions have the names that they have in Rust, and the same polynomials in the same order of operations (`exp` and
//! `atan2` are `exp_f32` and `atan2_f32`, because WGSL has functions of those names). No entry points and no bindings.
//!
//! A piece says by itself [what it calls](Piece::needs). Where it is said that a piece needs one of several, the choice is the caller's.

mod piece;

pub use crate::cap::wgsl::{CAP, CAP_BRUSHED, CAP_LAMBERT, CAP_MICROFACETS, CAP_NO_MICROFACETS};
pub use crate::outline::wgsl::{
    IMAGE, NO_OUTLINE, OUTLINE, OUTLINE_BRUSHED, OUTLINE_IMAGE, OUTLINE_INTEGRAL, OUTLINE_MICROFACETS,
    OUTLINE_NO_MICROFACETS, OUTLINE_PLAIN,
};
pub use piece::{Number, Piece, constant, join};

use crate::{Cone, Microfacets, NO_OBJECT, PackedLobe, grain, packed_lobe, special, wgsl_numbers};
use core::f32::consts;

/// Special functions and constants.
pub static SPECIAL: Piece = Piece::new(include_str!("../special.wgsl")).numbers(wgsl_numbers![
    PI = consts::PI,
    TAU = consts::TAU,
    FRAC_PI_2 = consts::FRAC_PI_2,
    FRAC_PI_4 = consts::FRAC_PI_4,
    FRAC_1_PI = consts::FRAC_1_PI,
    FRAC_1_TAU = 0.5 * consts::FRAC_1_PI,
    FRAC_1_SQRT_2 = consts::FRAC_1_SQRT_2,
    FRAC_2_SQRT_PI = consts::FRAC_2_SQRT_PI,
    LN_2 = consts::LN_2,
    LOG2_E = consts::LOG2_E,
    MIN_POSITIVE = f32::MIN_POSITIVE,
    MAX_FLOAT = f32::MAX,
    ERF_END = special::ERF_END,
]);

/// The number of the material of a place without a receiver: kernels skip it.
pub const NO_MATERIAL: u32 = u32::MAX;

/// `Receiver`, `Cone`, coverage and bases.
pub static GEOMETRY: Piece = Piece::new(include_str!("../geometry.wgsl")).numbers(wgsl_numbers![
    NO_OBJECT = NO_OBJECT,
    NO_MATERIAL = NO_MATERIAL,
    CONE_INSIDE = Cone::INSIDE
]);

/// `Lobe` ([`PackedLobe`] in Rust), its kinds and its value in a direction.
pub static LOBE: Piece = Piece::new(include_str!("../lobe.wgsl"))
    .numbers(wgsl_numbers![
        LOBE_PLAIN = PackedLobe::PLAIN,
        LOBE_COSINE = PackedLobe::COSINE,
        LOBE_MICROFACETS_F0 = PackedLobe::MICROFACETS_F0,
        LOBE_MICROFACETS_F90 = PackedLobe::MICROFACETS_F90,
        LOBE_MICROFACETS_GRAIN = PackedLobe::MICROFACETS_GRAIN,
    ])
    .needs(&[&SPECIAL, &GEOMETRY]);

/// `cos_sin(angle)`, as exact on all devices.
pub static COS_SIN: Piece = Piece::new(include_str!("../cos_sin.wgsl")).needs(&[&SPECIAL]);

static SURFACE: Piece = Piece::new(include_str!("../microfacets.wgsl"))
    .numbers(wgsl_numbers![MICROFACETS_GRAZING = Microfacets::GRAZING])
    .needs(&[&LOBE]);

/// Lobes of microfacets without a grain in a direction: `microfacets_of`, `microfacets_both`.
pub static MICROFACETS: Piece = Piece::new(include_str!("../facets.wgsl")).needs(&[&SURFACE]);

/// In place of [`MICROFACETS`] where lobes may have a [grain](crate::Grain); `grain_kind` gives them one. A module has one of both.
pub static MICROFACETS_GRAIN: Piece = Piece::new(include_str!("../grain.wgsl"))
    .numbers(wgsl_numbers![GRAIN_STEPS = grain::STEPS, GRAIN_HALF = packed_lobe::HALF])
    .needs(&[&SURFACE, &COS_SIN]);
