//! The same in WGSL: pieces that a shader's module is [joined](lobe_core::wgsl::join) of. They need `SILHOUETTES_DEPTH`, the functions
//! `any_hit…` of [`GpuBlockers`](shading::gpu::GpuBlockers), and one of `ROUND` and `FLAT` of `visibility-mask`.

use crate::blockers::trapezoids;
use crate::{beside, blockers, count, gpu, hull, project, select};
use lobe_core::wgsl::{GEOMETRY, Piece};
use lobe_core::wgsl_numbers;
use visibility_mask::wgsl::{AREA, EDGES, FACET, MASK, SKY_BUFFER, TOTAL};

/// Corners, and sides of triangles.
static SIDES: Piece = Piece::new(include_str!("silhouettes_sides.wgsl"))
    .numbers(wgsl_numbers![SILHOUETTES_UNSURE = hull::UNSURE, SILHOUETTES_NONE = gpu::NONE])
    .needs(&[&GEOMETRY]);

/// Edges of meshes, and which of them are silhouettes before a receiver's light.
static SILHOUETTES: Piece = Piece::new(include_str!("silhouettes.wgsl"))
    .numbers(wgsl_numbers![
        SILHOUETTES_AROUND = select::AROUND,
        SILHOUETTES_AROUND_SQ = select::AROUND_SQ,
        SILHOUETTES_MARGIN = beside::MARGIN,
        SILHOUETTES_SHORTEST = beside::SHORTEST,
        SILHOUETTES_CORNERS = beside::MOST,
    ])
    .needs(&[&SIDES, &FACET]);

/// The search of the hierarchy. Needs `SILHOUETTES_NODES` and `SILHOUETTES_DEPTH`.
static WALK: Piece = Piece::new(include_str!("silhouettes_walk.wgsl")).needs(&[&SIDES]);

/// `silhouettes_coverage`.
pub(crate) static COVERAGE: Piece = Piece::new(include_str!("silhouettes_coverage.wgsl")).needs(&[&SILHOUETTES]);

/// Sums of the directions of edges.
static SUM: Piece = Piece::new(include_str!("silhouettes_sum.wgsl"))
    .numbers(wgsl_numbers![SILHOUETTES_BESIDE = select::BESIDE])
    .needs(&[&SILHOUETTES, &EDGES]);

/// The number of surfaces before each sample.
static COUNT: Piece = Piece::new(include_str!("silhouettes_count.wgsl"))
    .numbers(wgsl_numbers![SILHOUETTES_NEAR = project::NEAR, SILHOUETTES_FAR_OUTSIDE = project::FAR_OUTSIDE])
    .needs(&[&SILHOUETTES, &MASK]);

/// The parts of outlines before a light.
static PIECES: Piece = Piece::new(include_str!("silhouettes_pieces.wgsl")).needs(&[&COUNT]);

/// The silhouettes of a receiver, which are summed or counted.
static LIST: Piece = Piece::new(include_str!("silhouettes_list.wgsl")).needs(&[&WALK, &SUM, &COUNT]);

/// The area of the lit part.
static LIT: Piece = Piece::new(include_str!("silhouettes_area.wgsl"))
    .numbers(wgsl_numbers![
        SILHOUETTES_GAUSS = trapezoids::GAUSS,
        SILHOUETTES_SLIVER = trapezoids::SLIVER,
        SILHOUETTES_SLAB = 1e-4_f32,
        SILHOUETTES_THICK = 0.25_f32,
    ])
    .needs(&[&LIST, &PIECES, &AREA]);

/// `silhouettes_splat` and `silhouettes_edges`.
pub(crate) static SPLAT: Piece = Piece::new(include_str!("silhouettes_splat.wgsl"))
    .numbers(wgsl_numbers![SILHOUETTES_WIDEST = blockers::WIDEST_DISC, SILHOUETTES_FEW = count::FEW])
    .needs(&[&LIT, &TOTAL]);

/// `silhouettes_sky`, `silhouettes_sky_hides` and `silhouettes_sky_has_facet`.
pub(crate) static SKY: Piece = Piece::new(include_str!("silhouettes_sky.wgsl"))
    .numbers(wgsl_numbers![SILHOUETTES_SKY_FAR = f32::MAX])
    .needs(&[&WALK, &SKY_BUFFER]);
