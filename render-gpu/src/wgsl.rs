//! Pieces of this crate's own kernels. A kernel declares its buffers beside them.

use crate::bvh::{BLOCKS, BLOCKS_ALIKE, FLAT, SPHERE, VISIBLE};
use crate::gbuffer::view;
use crate::kernels::queue;
use crate::resident::{LAST, NO_PLACE, RAYS};
use crate::screen::{AGX, LINEAR, NEUTRAL};
use lobe_core::wgsl::{GEOMETRY, LOBE, Piece, SPECIAL};
use lobe_core::wgsl_numbers;
use scene::rounding;
use visibility_mask::wgsl as masks;

/// The hierarchy, its primitives, and their intersections with rays. Needs a constant `STACK`, and the buffers `nodes` and `primitives`.
pub static BVH: Piece = Piece::new(include_str!("kernels/bvh.wgsl"))
    .numbers(wgsl_numbers![
        SPHERE = SPHERE,
        VISIBLE = VISIBLE,
        BLOCKS = BLOCKS,
        BLOCKS_ALIKE = BLOCKS_ALIKE,
        OBJECT = BLOCKS_ALIKE - 1,
        NO_CORNERS = FLAT,
        BVH_EDGE = rounding::EDGE,
        WIDEST = rounding::WIDEST,
        CLOSE = rounding::CLOSE,
        CLOSE_TO_SPHERE = rounding::CLOSE_TO_SPHERE,
    ])
    .needs(&[&GEOMETRY]);
/// The kernel of visible points.
pub static TRACE: Piece = Piece::new(include_str!("kernels/trace.wgsl"))
    .numbers(wgsl_numbers![PARALLEL = view::PARALLEL, PANORAMIC = view::PANORAMIC])
    .needs(&[&BVH, &SPECIAL]);
/// Answers the strategies' ray queries.
pub static ANY_HIT: Piece =
    Piece::new(include_str!("kernels/any_hit.wgsl")).numbers(wgsl_numbers![BLUR = rounding::BLUR]).needs(&[&BVH]);
/// Writes radiance to a texture. Needs a binding `target_texture`.
pub static TEXTURE_WRITER: Piece = Piece::new(include_str!("kernels/texture_writer.wgsl")).needs(&[&GEOMETRY]);

/// Pixels as the means of their points. Needs a binding `target_texture`.
pub static RESOLVE: Piece = Piece::new(include_str!("kernels/resolve.wgsl")).numbers(wgsl_numbers![
    NO_PLACE = NO_PLACE,
    LAST = LAST,
    RAYS = RAYS,
]);
/// Pictures as screens show them.
pub static DISPLAY: Piece = Piece::new(include_str!("kernels/display.wgsl")).numbers(wgsl_numbers![
    LINEAR = LINEAR,
    NEUTRAL = NEUTRAL,
    AGX = AGX,
]);

/// One light of one frame: the struct `Frame` of the uniform `frame`.
pub static FRAME: Piece = Piece::new(include_str!("kernels/frame.wgsl"));
/// The queue of points in penumbra, and the counters of a frame.
pub static QUEUE: Piece = Piece::new(include_str!("kernels/queue.wgsl"))
    .numbers(wgsl_numbers![
        QUEUE_COUNTERS = queue::QUEUE_HEADER - 1,
        LIT_POINTS = queue::LIT_POINTS,
        DARK_POINTS = queue::DARK_POINTS,
        PENUMBRA_POINTS = queue::PENUMBRA_POINTS,
        INTEGRALS = queue::INTEGRALS,
        PRUNED = queue::PRUNED,
        CUT = queue::CUT,
        SKY_LEFT = queue::SKY_LEFT,
    ])
    .needs(&[&FRAME]);
/// Integrals in the queue, for lights with the same radiance everywhere.
pub static INTEGRALS: Piece = Piece::new(include_str!("kernels/integrals.wgsl")).needs(&[&QUEUE]);
/// The same for lights that show an image.
pub static INTEGRALS_BY_CHANNEL: Piece = Piece::new(include_str!("kernels/integrals_by_channel.wgsl")).needs(&[&QUEUE]);
/// The parts that both kernels of classification share.
pub static TILES: Piece = Piece::new(include_str!("kernels/tiles.wgsl")).needs(&[&QUEUE, &GEOMETRY]);
/// Classifies each point for one light. Needs `light_integral`, `blockers_coverage`, the light and `brdf_lobe`.
pub static CLASSIFY: Piece = Piece::new(include_str!("kernels/classify.wgsl")).needs(&[&TILES, &LOBE]);
/// Shades one queued point with one workgroup. Needs the same, the hooks of masks and the visible fraction of lobes.
pub static PENUMBRA: Piece =
    Piece::new(include_str!("kernels/penumbra.wgsl")).needs(&[&QUEUE, &GEOMETRY, &masks::VISIBILITY]);
/// [`CLASSIFY`] by the paper's method.
pub static PAPER_CLASSIFY: Piece =
    Piece::new(include_str!("kernels/paper_classify.wgsl")).needs(&[&TILES, &paper::wgsl::TABLES]);
/// [`PENUMBRA`] by the paper's method.
pub static PAPER_PENUMBRA: Piece =
    Piece::new(include_str!("kernels/paper_penumbra.wgsl")).needs(&[&QUEUE, &GEOMETRY, &paper::wgsl::VISIBILITY]);
/// The size of the penumbra kernel's dispatch.
pub static ARGS: Piece = Piece::new(include_str!("kernels/args.wgsl")).needs(&[&QUEUE]);
/// Where a sky leaves lobes to its patches.
static SKY_LEFT: Piece = Piece::new(include_str!("kernels/sky_left.wgsl")).needs(&[&QUEUE]);
/// The lobes that a light shines on: all.
pub static ALL_LOBES: Piece = Piece::new("fn lobes_left(point: u32) -> u32 { return 0xffffffffu; }\n");
/// Those that a sky leaves to its patches.
pub static LOBES_LEFT: Piece =
    Piece::new("fn lobes_left(point: u32) -> u32 { return queue.items[sky_left_place(point)]; }\n").needs(&[&SKY_LEFT]);
/// Sums a sky at once. Needs the functions `blockers_sky…` and `brdf_lobe`, a header of a sky, and one of `SKY_MICROFACETS` and `SKY_NO_MICROFACETS`.
pub static SKY: Piece = Piece::new(include_str!("kernels/sky.wgsl")).needs(&[&SKY_LEFT, &GEOMETRY, &masks::SKY_VIEW]);
/// The size of the dispatches of a sky's patches.
pub static SKY_ARGS: Piece = Piece::new(include_str!("kernels/sky_args.wgsl")).needs(&[&QUEUE]);
