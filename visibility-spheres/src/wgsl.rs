//! The same in WGSL: pieces that a shader's module is [joined](lobe_core::wgsl::join) of.
//!
//! All of it reads the buffers `spheres`, an `array<BlockerSphere>`, `spheres_bounds`, an `array<vec4f>`, and `spheres_lists`, an
//! `array<u32>`, each bound with just what it holds.

use crate::packed::{LIST_ROOM, LIST_WORDS, SPHERE_BLOCK};
use crate::{blocked_cones, blockers, ellipse, shaft, wide_cone};
use lobe_core::wgsl::{GEOMETRY, Piece, SPECIAL};
use lobe_core::wgsl_numbers;
use visibility_mask::wgsl::{EDGES, FACET, MASK, SKY_BUFFER, TOTAL};

/// The struct of a blocker, the layout of a tile's list.
pub static PACKED: Piece = Piece::new(include_str!("packed.wgsl")).numbers(wgsl_numbers![
    SPHERE_BLOCK = SPHERE_BLOCK,
    LIST_ROOM = LIST_ROOM,
    LIST_WORDS = LIST_WORDS
]);
/// The kernel of the bounds of blocks.
pub static BOUNDS: Piece = Piece::new(include_str!("bounds.wgsl")).needs(&[&PACKED]);
/// Which spheres meet a shaft.
static SHAFT_TEST: Piece =
    Piece::new(include_str!("shaft.wgsl")).numbers(wgsl_numbers![SHAFT_MARGIN = shaft::MARGIN]).needs(&[&GEOMETRY]);
/// The kernel of the lists of tiles.
pub static CULL: Piece = Piece::new(include_str!("cull.wgsl"))
    .numbers(wgsl_numbers![SHOWS = blockers::SHOWS])
    .needs(&[&PACKED, &SHAFT_TEST]);
/// Which spheres a light's cone may meet.
static CONE_TEST: Piece = Piece::new(include_str!("cone_test.wgsl"))
    .numbers(wgsl_numbers![CONE_SLACK = blocked_cones::SLACK])
    .needs(&[&GEOMETRY]);
/// The cone that a sphere blocks.
static BLOCKED_CONE: Piece = Piece::new(include_str!("blocked_cone.wgsl")).needs(&[&GEOMETRY]);
/// Spheres as receivers see them.
static SEEN: Piece = Piece::new(include_str!("seen.wgsl")).needs(&[&PACKED, &BLOCKED_CONE]);
/// `spheres_sky`, `spheres_sky_hides` and `spheres_sky_has_facet`.
pub static SPHERES_SKY: Piece = Piece::new(include_str!("spheres_sky.wgsl")).needs(&[&SEEN, &SKY_BUFFER]);
/// `spheres_coverage`. Needs `OUTLINE` or `NO_OUTLINE` of `lobe-core`.
pub static SPHERES: Piece = Piece::new(include_str!("spheres.wgsl")).needs(&[&SEEN, &CONE_TEST, &FACET]);
/// A sphere on a mask.
static ELLIPSE: Piece =
    Piece::new(include_str!("ellipse.wgsl")).numbers(wgsl_numbers![FLAT = ellipse::FLAT]).needs(&[&MASK]);
static SPLAT: Piece = Piece::new(include_str!("splat.wgsl")).needs(&[&BLOCKED_CONE, &MASK, &EDGES]);
/// Other cones on a mask.
static WIDE_CONE: Piece = Piece::new(include_str!("wide_cone.wgsl"))
    .numbers(wgsl_numbers![WIDE_LIMIT = wide_cone::LIMIT])
    .needs(&[&SPLAT, &ELLIPSE, &SPECIAL]);
/// `spheres_edges` and `spheres_splat`. Needs the header of `visibility-mask`, and its `ROUND` or `FLAT`.
pub static SPHERES_SPLAT: Piece = Piece::new(include_str!("spheres_splat.wgsl")).needs(&[&SPHERES, &WIDE_CONE, &TOTAL]);
