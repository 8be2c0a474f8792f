//! The WGSL of integrals over cones.

use super::{albedo, chord, ellipse, form, lambert, microfacets, slab};
use crate::wgsl::{LOBE, MICROFACETS, MICROFACETS_GRAIN, Piece};
use crate::wgsl_numbers;

static LAMBERT: Piece =
    Piece::new(include_str!("lambert.wgsl")).numbers(wgsl_numbers![ARC = lambert::G]).needs(&[&LOBE]);

/// `cap_integral(at, lobe, cone)` where every lobe is Lambert's.
pub static CAP_LAMBERT: Piece = Piece::new(include_str!("lambert_only.wgsl")).needs(&[&LAMBERT]);

static PAIR: Piece = Piece::new(include_str!("pair.wgsl")).needs(&[&LOBE]);

static SLAB: Piece = Piece::new(include_str!("slab.wgsl"))
    .numbers(wgsl_numbers![SLAB_EXPONENT = slab::EXPONENT, SLAB_WIDTH = slab::WIDTH])
    .needs(&[&PAIR]);

static CHORD: Piece = Piece::new(include_str!("chord.wgsl"))
    .numbers(wgsl_numbers![
        FEW = chord::FEW,
        MANY = chord::MANY,
        PIECE = chord::PIECE,
        EDGE = chord::EDGE,
        KAPPA = chord::KAPPA,
        ENDS = chord::ENDS,
        NODES = chord::half_rules(),
    ])
    .needs(&[&PAIR]);

/// `cap_integral(at, lobe, cone)` for all lobes, instead of [`CAP_LAMBERT`]. Needs one of [`CAP_MICROFACETS`] and [`CAP_NO_MICROFACETS`].
pub static CAP: Piece = Piece::new(include_str!("cap.wgsl"))
    .numbers(wgsl_numbers![MIRROR = form::MIRROR])
    .needs(&[&LAMBERT, &SLAB, &CHORD]);

/// Needs one of [`ALBEDO_FACETS`] and [`BRUSHED_FACETS`].
static ALBEDO: Piece = Piece::new(include_str!("albedo.wgsl"))
    .numbers(wgsl_numbers![ALBEDO_PLACES = albedo::PLACES, ALBEDO_HALVINGS = albedo::HALVINGS]);

static ALBEDO_FACETS: Piece = Piece::new(include_str!("albedo_facets.wgsl"))
    .numbers(wgsl_numbers![ALBEDO_TURNS = albedo::TURNS, ALBEDO_AROUND = albedo::TURNS.len()])
    .needs(&[&MICROFACETS]);

static BRUSHED_FACETS: Piece = Piece::new(include_str!("brushed_facets.wgsl"))
    .numbers(wgsl_numbers![
        ALBEDO_TURNS = albedo::all_turns().collect::<Vec<_>>(),
        ALBEDO_AROUND = albedo::all_turns().count(),
    ])
    .needs(&[&MICROFACETS_GRAIN]);

/// Needs an ellipse.
static ELLIPSE_CHORDS: Piece = Piece::new(include_str!("microfacets.wgsl"))
    .numbers(wgsl_numbers![
        ELLIPSE_FAR = microfacets::FAR,
        ELLIPSE_STEPS = ellipse::STEPS as u32,
        NODES_WHOLE = microfacets::TEN,
        NODES_CUT = microfacets::THIRTY_TWO,
    ])
    .needs(&[&CAP, &ALBEDO]);

/// [`CAP`] with the integral of lobes of microfacets without a grain.
pub static CAP_MICROFACETS: Piece =
    Piece::new(include_str!("ellipse.wgsl")).needs(&[&ELLIPSE_CHORDS, &ALBEDO_FACETS, &MICROFACETS]);

/// [`CAP`] with the integral of lobes of microfacets that may have a grain.
pub static CAP_BRUSHED: Piece =
    Piece::new(include_str!("brushed.wgsl")).needs(&[&ELLIPSE_CHORDS, &BRUSHED_FACETS, &MICROFACETS_GRAIN]);

/// [`CAP`] without microfacets.
pub static CAP_NO_MICROFACETS: Piece = Piece::new(include_str!("microfacets_none.wgsl")).needs(&[&CAP]);
