//! The same in WGSL: pieces that a shader's module is [joined](lobe_core::wgsl::join) of, in any order.
//!
//! All need: `maps_word`, which reads one of [`PackedMaps::words`](crate::PackedMaps::words)
//! ([`GpuPages::wgsl`](shading::gpu::GpuPages::wgsl)); a variable `frame` with `light: vec4f` (centre and radius),
//! `cells: f32`, the cells a side of a mask, and `number: u32`, the light's number in its frame; and one of `ROUND` and `FLAT` of
//! `visibility-mask`.
//!
//! # Accuracy
//! Rust computes in f64, this WGSL in f32, with texels and depths counted from the receiver's own place: the error is 1e-7 of the
//! distance to the light, magnified for a blocker much nearer to the receiver than the light. The visible fraction of a mask
//! differs from Rust's by 1e-5 in the mean for lights of a half-angle of 1° and more (3e-4 at most for 5°, a sample of a row), 6e-5
//! for 0.5° (2e-3 at most), 2e-4 for 0.1° (3e-3 at most). This includes penumbrae of bodies on themselves; moving scenes by 1e4
//! loses nothing more.

use crate::{face_view, packed, polygon_union};
use lobe_core::wgsl::{Piece, SPECIAL};
use lobe_core::wgsl_numbers;
use visibility_mask::wgsl::{FACET, MASK, SQUARE};

static LAYER: Piece = Piece::new(include_str!("layer.wgsl")).numbers(wgsl_numbers![MAP_FACE = packed::FACE]);
static FACE_VIEW: Piece = Piece::new(include_str!("face_view.wgsl"))
    .numbers(wgsl_numbers![
        MAP_BIAS = face_view::BIAS as f32,
        MAP_TILT = face_view::TILT as f32,
        MAP_ROUNDING = face_view::ROUNDING as f32,
        MAP_SHIFT = face_view::SHIFT as f32,
        MAP_SMALL = face_view::SMALL as f32,
        MAP_PART_SHIFT = face_view::PART_SHIFT as f32,
        MAP_NEAR = face_view::NEAR,
    ])
    .needs(&[&LAYER, &SQUARE]);
static OWN_FACE: Piece = Piece::new(include_str!("own_face.wgsl")).needs(&[&FACE_VIEW, &FACET]);

/// `fn maps_coverage(tile: u32, at: Receiver, cone: Cone) -> u32`, one thread a receiver: the coverage of a light by texels. As
/// [`Blockers::select`](visibility_mask::Blockers::select) of [`ShadowMapBlockers`](crate::ShadowMapBlockers).
pub static COVERAGE: Piece = Piece::new(include_str!("coverage.wgsl")).needs(&[&OWN_FACE, &SPECIAL]);

static UNION: Piece = Piece::new(include_str!("polygon_union.wgsl"))
    .numbers(wgsl_numbers![UNION_ACROSS = polygon_union::ACROSS, UNION_LINES = polygon_union::LINES])
    .needs(&[&MASK]);
/// `fn maps_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask)`, one thread a row of the mask: clears the same bits
/// of the row `lit` as [`Blockers::splat`](visibility_mask::Blockers::splat). Has no barriers. Needs the header of
/// `visibility-mask`.
///
/// A thread keeps four lines of `16 · 2^depth` samples: 256 bytes at depth 5, 512 at depth 6.
pub static SPLAT: Piece = Piece::new(include_str!("splat.wgsl")).needs(&[&OWN_FACE, &UNION]);
