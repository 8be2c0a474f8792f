//! The WGSL of outlines, and of integrals over them.

use super::{AROUND, DEPTH, Outline, TURNS, WIDEST, cells, cubature, image, integral, lambert, parts, rules};
use crate::wgsl::{GEOMETRY, LOBE, MICROFACETS, MICROFACETS_GRAIN, Piece, SPECIAL};
use crate::wgsl_numbers;

/// The polygon or disc of light that a point sees: `outline_new`, `outline_disc`, `light_is_flat`.
pub static OUTLINE: Piece = Piece::new(include_str!("outline.wgsl"))
    .numbers(wgsl_numbers![
        OUTLINE_ROOM = Outline::ROOM,
        OUTLINE_MOST = Outline::MOST,
        OUTLINE_DEPTH = DEPTH,
        OUTLINE_WIDEST = WIDEST,
        OUTLINE_AROUND = AROUND,
        OUTLINE_TURNS = TURNS[..6].iter().map(|[cos, sin]| (*cos, *sin)).collect::<Vec<_>>(),
    ])
    .needs(&[&GEOMETRY]);

/// In place of [`OUTLINE`] where all lights are seen as cones.
pub static NO_OUTLINE: Piece = Piece::new(include_str!("none.wgsl"));

/// Integrals over outlines. Needs one of [`OUTLINE_MICROFACETS`], [`OUTLINE_BRUSHED`] and [`OUTLINE_NO_MICROFACETS`], and one of [`OUTLINE_PLAIN`] and
/// [`OUTLINE_IMAGE`].
pub static OUTLINE_INTEGRAL: Piece = Piece::new(include_str!("integral.wgsl"))
    .numbers(wgsl_numbers![
        OUTLINE_RULES = cubature::half_rules(),
        OUTLINE_STEEP = integral::STEEP,
        OUTLINE_WIDE = integral::WIDE,
        OUTLINE_AS_LARGE = integral::AS_LARGE,
        OUTLINE_AT_CORNER = integral::AT_CORNER,
        OUTLINE_NOTHING = integral::NOTHING,
        OUTLINE_EQUAL = lambert::EQUAL,
        OUTLINE_SHORT = lambert::SHORT,
        OUTLINE_CUT = lambert::CUT,
        OUTLINE_SMALL = cubature::SMALL,
    ])
    .needs(&[&OUTLINE, &LOBE]);

/// `light_integral(at, lobe, cone) -> f32` for lights with or without outlines. Needs `cap_integral`: [`CAP`](crate::wgsl::CAP) or
/// [`CAP_LAMBERT`](crate::wgsl::CAP_LAMBERT).
pub static OUTLINE_PLAIN: Piece = Piece::new(concat!(include_str!("parts.wgsl"), include_str!("plain.wgsl")))
    .numbers(wgsl_numbers![
        OUTLINE_POLES = rules::POLES_OF_PARTS,
        OUTLINE_DEVIATIONS = rules::DEVIATIONS_OF_PARTS,
        OUTLINE_FEW = parts::FEW,
        OUTLINE_PARTS = parts::MOST,
        OUTLINE_PARTS_ROOM = parts::ROOM / 2,
    ])
    .needs(&[&OUTLINE_INTEGRAL]);

/// The image of a light: `image_at`, from `frame.image` on in `light_images`.
pub static IMAGE: Piece = Piece::new(include_str!("image.wgsl"))
    .numbers(wgsl_numbers![IMAGE_BORDER = image::BORDER])
    .needs(&[&OUTLINE, &SPECIAL]);

/// `light_integral` by channel for lights that show an image, in place of [`OUTLINE_PLAIN`].
pub static OUTLINE_IMAGE: Piece = Piece::new(include_str!("image_integral.wgsl"))
    .numbers(wgsl_numbers![
        OUTLINE_CELL_WIDE = cells::Cells::WIDE.0,
        OUTLINE_CELL_POWER = cells::Cells::POWER.0,
        OUTLINE_CELL_FACETS = cells::Cells::FACETS.0,
        OUTLINE_AT_HORIZON = cells::AT_HORIZON,
        OUTLINE_SHALLOWEST = cells::SHALLOWEST,
        OUTLINE_SMOOTH = cells::SMOOTH,
        OUTLINE_EVEN = cells::EVEN,
        OUTLINE_DEEPEST = cells::DEEPEST,
    ])
    .needs(&[&OUTLINE_INTEGRAL, &IMAGE]);

/// Needs a highlight.
static OUTLINE_FACETS: Piece = Piece::new(include_str!("microfacets.wgsl")).needs(&[&OUTLINE_INTEGRAL]);

/// [`OUTLINE_INTEGRAL`] with the integral of lobes of microfacets without a grain.
pub static OUTLINE_MICROFACETS: Piece =
    Piece::new(include_str!("highlight.wgsl")).needs(&[&OUTLINE_FACETS, &MICROFACETS]);

/// [`OUTLINE_INTEGRAL`] with the integral of lobes of microfacets that may have a grain.
pub static OUTLINE_BRUSHED: Piece =
    Piece::new(include_str!("brushed.wgsl")).needs(&[&OUTLINE_FACETS, &MICROFACETS_GRAIN]);

/// [`OUTLINE_INTEGRAL`] without microfacets.
pub static OUTLINE_NO_MICROFACETS: Piece = Piece::new(include_str!("no_microfacets.wgsl")).needs(&[&OUTLINE_INTEGRAL]);
