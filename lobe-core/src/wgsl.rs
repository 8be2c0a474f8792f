//! The WGSL of this crate: what a shader joins, as text, to what else it needs. The order of the pieces does not matter.
//!
//! Functions have the names that they have in Rust, and the same polynomials in the same order of operations (`exp` and
//! `atan2` are `exp_f32` and `atan2_f32`, because WGSL has functions of those names). No entry points and no bindings.

/// Special functions and constants. Needs nothing.
pub const SPECIAL: &str = include_str!("special.wgsl");

/// `Receiver`, `Cone`, coverage and bases. Needs nothing.
pub const GEOMETRY: &str = include_str!("geometry.wgsl");

/// `Lobe` ([`PackedLobe`](crate::PackedLobe) in Rust), its kinds and its value in a direction. Needs [`SPECIAL`] and [`GEOMETRY`].
pub const LOBE: &str = crate::packed_lobe::WGSL;

/// `cap_integral(at, lobe, cone)` where every lobe is Lambert's. Needs [`SPECIAL`], [`GEOMETRY`] and [`LOBE`].
pub const CAP_LAMBERT: &str = concat!(include_str!("cap/lambert.wgsl"), include_str!("cap/lambert_only.wgsl"));

/// Lobes of microfacets in a direction: `microfacets_of`, `microfacets_both`. Needs [`SPECIAL`], [`GEOMETRY`] and [`LOBE`].
pub const MICROFACETS: &str = include_str!("microfacets.wgsl");

/// `cap_integral(at, lobe, cone)` for all lobes, instead of [`CAP_LAMBERT`]. Needs [`SPECIAL`], [`GEOMETRY`], [`LOBE`], and
/// [`CAP_MICROFACETS`] or [`CAP_NO_MICROFACETS`].
pub const CAP: &str = concat!(
    include_str!("cap/lambert.wgsl"),
    include_str!("cap/pair.wgsl"),
    include_str!("cap/slab.wgsl"),
    include_str!("cap/chord.wgsl"),
    include_str!("cap/cap.wgsl"),
);

/// The integral of lobes of microfacets. Needs [`CAP`] and [`MICROFACETS`].
pub const CAP_MICROFACETS: &str = concat!(include_str!("cap/microfacets.wgsl"), include_str!("cap/albedo.wgsl"));

/// In place of [`CAP_MICROFACETS`] where there are none.
pub const CAP_NO_MICROFACETS: &str = include_str!("cap/microfacets_none.wgsl");

/// The polygon or disc of light that a point sees: `outline_new`, `outline_disc`, `light_is_flat`. Needs [`GEOMETRY`].
pub const OUTLINE: &str = include_str!("outline/outline.wgsl");

/// In place of [`OUTLINE`] where all lights are seen as cones.
pub const NO_OUTLINE: &str = include_str!("outline/none.wgsl");

/// Integrals over outlines. Needs [`OUTLINE`], [`SPECIAL`], [`LOBE`], one of [`OUTLINE_MICROFACETS`] and [`OUTLINE_NO_MICROFACETS`], and one
/// of [`OUTLINE_PLAIN`] and [`OUTLINE_IMAGE`].
pub const OUTLINE_INTEGRAL: &str = include_str!("outline/integral.wgsl");

/// `light_integral(at, lobe, cone) -> Integral` for lights with or without outlines. Needs [`OUTLINE_INTEGRAL`] and [`CAP`] or
/// [`CAP_LAMBERT`].
pub const OUTLINE_PLAIN: &str = include_str!("outline/plain.wgsl");

/// The image of a light: `image_at`, from `frame.image` on in `light_images`. Needs [`OUTLINE`] and [`SPECIAL`].
pub const IMAGE: &str = include_str!("outline/image.wgsl");

/// `light_integral` by channel for lights that show an image, in place of [`OUTLINE_PLAIN`]. Needs [`OUTLINE_INTEGRAL`] and [`IMAGE`].
pub const OUTLINE_IMAGE: &str = include_str!("outline/image_integral.wgsl");

/// The integral of lobes of microfacets. Needs [`OUTLINE_INTEGRAL`] and [`MICROFACETS`].
pub const OUTLINE_MICROFACETS: &str = include_str!("outline/microfacets.wgsl");

/// In place of [`OUTLINE_MICROFACETS`] where there are none.
pub const OUTLINE_NO_MICROFACETS: &str = include_str!("outline/no_microfacets.wgsl");
