//! The same in WGSL: pieces that a shader's module is [joined](lobe_core::wgsl::join) of, in any order.
//!
//! One workgroup of `LANES` threads draws the mask of one point and light, a row a thread. Functions are named after their Rust
//! equivalents, with the type's name first: `mask_row_y` is [`Mask::row_y`](crate::Mask::row_y). All but [`SQUARE`], [`ROUND`], [`FLAT`], [`EDGES`] and
//! [`FACET`] need a [`header`].

use crate::row::{COARSE, WIDTH};
use crate::sky::{SkyResolution, buffer, crowd, meridians, pole, spread, view};
use crate::{
    Fineness, MAX_DEPTH, accuracy, contour, edges, fineness, near_masks, places, square, visibility, visible_fraction,
};
use lobe_core::wgsl::{self as lobes, Piece};
use lobe_core::wgsl_numbers;
use shading::Accuracy;

/// The unit square. Needs one of [`ROUND`] and [`FLAT`].
pub static SQUARE: Piece = Piece::new(include_str!("square.wgsl"))
    .numbers(wgsl_numbers![
        WIDEST_TAN = square::WIDEST_TAN,
        NARROWEST = square::NARROWEST,
        FARTHEST = square::FARTHEST,
        THINNEST = square::THINNEST,
    ])
    .needs(&[&lobes::LOBE]);
/// Lights that appear as discs.
pub static ROUND: Piece = Piece::new(include_str!("round.wgsl")).needs(&[&SQUARE, &EDGES, &lobes::NO_OUTLINE]);
/// Lights that may have outlines, instead of [`ROUND`].
pub static FLAT: Piece = Piece::new(include_str!("flat.wgsl"))
    .numbers(wgsl_numbers![FLAT_WIDE = visibility::WIDE])
    .needs(&[&SQUARE, &EDGES, &lobes::OUTLINE]);
/// The thread's row of the mask.
pub static MASK: Piece = Piece::new(include_str!("mask.wgsl")).needs(&[&SQUARE]);

static CONTOUR_BITS: Piece = Piece::new(include_str!("contour_bits.wgsl"));
static CONTOUR_CELLS: Piece = Piece::new(include_str!("contour_cells.wgsl")).needs(&[&CONTOUR_BITS, &MASK]);
static CONTOUR_SPANS: Piece = Piece::new(include_str!("contour_spans.wgsl")).needs(&[&CONTOUR_CELLS]);
/// The contour of blockers, from tests of directions. Needs `light_is_hidden`.
pub static CONTOUR: Piece = Piece::new(include_str!("contour.wgsl"))
    .numbers(wgsl_numbers![
        CONTOUR_START = contour::START,
        CONTOUR_BISECTIONS = contour::BISECTIONS,
        CONTOUR_LONG = contour::LONG,
        CONTOUR_MANY = contour::MANY,
        CONTOUR_WHOLE = f32::from(contour::WHOLE),
        CONTOUR_WIDE = contour::WIDE,
        CONTOUR_RIM = contour::rim()[..contour::RIM / 4].iter().map(|(sin, cos)| (*cos, *sin)).collect::<Vec<_>>(),
    ])
    .needs(&[&CONTOUR_SPANS]);
/// The sum of edges that turns a mask.
pub static EDGES: Piece = Piece::new(include_str!("edges.wgsl"))
    .numbers(wgsl_numbers![
        EDGES_NOTHING = (edges::NOTHING, 0.0),
        EDGES_PLANE = edges::PLANE,
        EDGES_STEPS = edges::STEP.recip(),
    ])
    .needs(&[&lobes::GEOMETRY]);

/// Coverage of a light by a receiver's own facet.
pub static FACET: Piece = Piece::new(include_str!("facet.wgsl")).needs(&[&lobes::GEOMETRY]);

/// The sky before one receiver: the horizon, meridians, and counts of surfaces along them. Needs a [`sky_header`], a binding `sky_table` of
/// [these numbers](crate::sky::SkyTable::packed), and blockers that call `sky_draw_arc` or `sky_cross`.
pub static SKY_BUFFER: Piece =
    Piece::new(concat!(include_str!("sky/buffer.wgsl"), "\n", include_str!("sky/crowd.wgsl")))
        .numbers(wgsl_numbers![
            SKY_PLACES = buffer::HALF as u32,
            SKY_CUTS = buffer::CUTS,
            SKY_RUN = buffer::RUN as u32,
            SKY_FINER = crowd::FINER as u32,
            SKY_SPARSE = crowd::SPARSE as u32,
            SKY_AXES = pole::AXES,
            SKY_SURE = 1.0 + buffer::MARGIN,
            SKY_AROUND = meridians::AROUND,
            SKY_DIAGONAL = meridians::DIAGONAL,
            SKY_SPREAD = meridians::SPREAD,
        ])
        .needs(&[&lobes::SPECIAL, &lobes::GEOMETRY]);
/// Sums of lobes over what is seen. Needs one of [`SKY_MICROFACETS`] and [`SKY_NO_MICROFACETS`].
pub static SKY_VIEW: Piece = Piece::new(include_str!("sky/view.wgsl"))
    .numbers(wgsl_numbers![
        SKY_STEEP = view::STEEP,
        SKY_LITTLE = view::LITTLE,
        SKY_CROWD_LITTLE = view::CROWD_LITTLE,
        SKY_MUCH = crate::sky::SkyView::MUCH
    ])
    .needs(&[&SKY_BUFFER, &TOTAL, &lobes::LOBE]);
/// [`SKY_VIEW`] with microfacet lobes. Needs one of [`lobes::MICROFACETS`] and [`lobes::MICROFACETS_GRAIN`].
pub static SKY_MICROFACETS: Piece = Piece::new(include_str!("sky/facets.wgsl")).needs(&[&SKY_VIEW]);
/// [`SKY_VIEW`] without microfacets.
pub static SKY_NO_MICROFACETS: Piece = Piece::new(
    "fn sky_set_facets(at: Receiver, lobe: Lobe) {}
fn sky_facets(lobe: Lobe, v: vec3f) -> f32 { return 0.0; }
",
)
.needs(&[&SKY_VIEW]);

/// Threads of a workgroup that sums a sky.
pub const SKY_LANES: u32 = 64;
/// The most lobes of a material that a workgroup sums over a sky.
pub const SKY_MOST_LOBES: u32 = 16;

/// The constants of [`SKY_BUFFER`] and [`SKY_VIEW`] for the samples of a table and a number of lobes a material. None for samples or lobes that
/// kernels have no room for.
#[must_use]
pub fn sky_header(samples: SkyResolution, most_lobes: u32) -> Option<String> {
    let (rows, along) = (samples.rows(), samples.samples());
    let has_room = rows <= 256 && rows.is_multiple_of(32) && along < 256 && along.is_multiple_of(16);
    let step = view::STEPS * samples.pitch();
    (has_room && most_lobes <= SKY_MOST_LOBES).then(|| {
        lobes::constant("LANES", &SKY_LANES)
            + &lobes::constant("SKY_ROWS", &rows)
            + &lobes::constant("SKY_SAMPLES", &along)
            + &lobes::constant("SKY_LOBES", &most_lobes.max(1))
            + &lobes::constant("SKY_STEP_SQ", &(step * step))
            + &lobes::constant("SKY_ACROSS", &(spread::ACROSS * samples.pitch()))
    })
}

/// Results that threads compute together.
pub static TOTAL: Piece = Piece::new(include_str!("total.wgsl"));
/// The lit part of a window with its exact area, which blockers may find.
pub static AREA: Piece = Piece::new(include_str!("area.wgsl"))
    .numbers(wgsl_numbers![AREA_NARROWEST = 0.5 * visibility::NARROWEST_OPENING])
    .needs(&[&MASK]);
/// The visible fraction of a lobe through masks. Needs one of [`LAMBERT`] and [`LOBES`].
pub static FRACTION: Piece = Piece::new(include_str!("fraction.wgsl")).needs(&[&AREA, &TOTAL]);
/// Boxes around the lit parts of a light.
static PLACES: Piece = Piece::new(include_str!("near_places.wgsl"))
    .numbers(wgsl_numbers![PLACES_STEPS = 16_777_216.0_f32])
    .needs(&[&SQUARE]);
/// Masks around a small lit part of a light: one, which is tried up to `NEAR_MOST` times, or one in each of a few cells.
static NEAR: Piece = Piece::new(include_str!("near.wgsl"))
    .numbers(wgsl_numbers![
        NEAR_LITTLE = near_masks::LITTLE as f32,
        NEAR_LEAST = near_masks::LEAST as f32,
        NEAR_FEW = near_masks::FEW as f32,
        NEAR_OF = near_masks::OF as f32,
        NEAR_NARROW = near_masks::NARROW as f32,
        NEAR_FILLED = near_masks::FILLED as f32,
        NEAR_ENDS = near_masks::ENDS as f32,
        NEAR_SLIGHT = near_masks::SLIGHT as f32,
        NEAR_ROOM = (places::ROOM_SAMPLES, places::ROOM_ROWS),
        NEAR_MOST = 8_u32,
        NEAR_SMALLER = near_masks::SMALLER,
        NEAR_WIDE = contour::WIDE,
        NEAR_ASKS = (visibility::NARROW, visibility::WIDE_ANYWAY),
    ])
    .needs(&[&MASK, &TOTAL, &PLACES]);
/// Masks of blockers. Needs `blockers_edges` and `blockers_splat`, and what [`FRACTION`] needs.
pub static VISIBILITY: Piece = Piece::new(include_str!("visibility.wgsl"))
    .numbers(wgsl_numbers![CROWDED = accuracy::CROWDED, COARSE = fineness::COARSE, FINEST = Accuracy::FINEST,])
    .needs(&[&EDGES, &FRACTION, &NEAR]);

static LAMBERT_WEIGHTS: Piece = Piece::new(include_str!("fraction_lambert.wgsl"))
    .numbers(wgsl_numbers![CORNER = visible_fraction::CORNER])
    .needs(&[&SQUARE]);
static WHOLE: Piece = Piece::new(include_str!("visibility_whole.wgsl")).needs(&[&VISIBILITY]);
/// The visible fraction of a lobe if all lobes are Lambert's.
pub static LAMBERT: Piece = Piece::new(include_str!("fraction_lambert_only.wgsl")).needs(&[&WHOLE, &LAMBERT_WEIGHTS]);

static WINDOW: Piece = Piece::new(include_str!("visibility_window.wgsl"))
    .numbers(wgsl_numbers![STEEP = visibility::STEEP])
    .needs(&[&VISIBILITY, &lobes::SPECIAL]);
static GLOSSY_WEIGHTS: Piece = Piece::new(include_str!("fraction_glossy.wgsl"))
    .numbers(wgsl_numbers![LEFT_OUT = visible_fraction::LEFT_OUT, MIRROR_EXPONENT = visible_fraction::MIRROR])
    .needs(&[&MASK, &lobes::SPECIAL]);
/// The visible fraction of any lobe. Needs [`header_of_lobes`], and one of [`ALIKE`] and [`IMAGE`].
pub static LOBES: Piece =
    Piece::new(include_str!("fraction_both.wgsl")).needs(&[&WINDOW, &LAMBERT_WEIGHTS, &GLOSSY_WEIGHTS]);

/// The visible fraction of microfacet lobes, if [`header_of_lobes`] has them. Needs one of [`lobes::MICROFACETS`] and
/// [`lobes::MICROFACETS_GRAIN`].
pub static MICROFACETS: Piece = Piece::new(include_str!("fraction_microfacets.wgsl"))
    .numbers(wgsl_numbers![HIGHLIGHT = square::HIGHLIGHT])
    .needs(&[&LOBES]);

/// The visible fraction if it is the same in all channels.
pub static ALIKE: Piece = Piece::new(include_str!("fraction_alike.wgsl")).needs(&[&LOBES]);
/// The same by channel, for a light that shows an image. Needs one of [`IMAGE_MICROFACETS`] and [`IMAGE_NO_MICROFACETS`].
pub static IMAGE: Piece = Piece::new(include_str!("fraction_image.wgsl")).needs(&[&FLAT, &LOBES, &lobes::IMAGE]);
/// [`IMAGE`] with microfacet lobes.
pub static IMAGE_MICROFACETS: Piece =
    Piece::new(include_str!("fraction_image_microfacets.wgsl")).needs(&[&IMAGE, &MICROFACETS]);
/// [`IMAGE`] without microfacets.
pub static IMAGE_NO_MICROFACETS: Piece = Piece::new(
    "fn image_alpha(lobe: Lobe) -> f32 { return 0.0; }
fn image_highlight(whole: UnitSquare, at: Receiver, tolerance: f32, lobe: Lobe) -> UnitSquare { return whole; }
fn image_facets_in(square: UnitSquare, at: Receiver, lobe: Lobe) {}
fn image_facets(v: vec3f) -> f32 { return 0.0; }
",
)
.needs(&[&IMAGE]);

/// Half the golden section, in units of 2⁻³²: shifts of rows are fractions of its odd multiples.
const GOLDEN: u32 = 0x4f1b_bcdd;

/// The constants `DEPTH`, `SIDE` (rows), `WIDTH` (the most samples in a row), `LANES` (threads), `COLUMNS` (the most groups of
/// samples with one weight), `BROAD_GRID` and `MOST_BANDS` (the most bands of a deeper mask), and the type `Row` with its functions
/// and `row_width`, the samples in a row.
///
/// # Panics
/// When `depth` is not in 1…[`MAX_DEPTH`].
#[must_use]
pub fn header(depth: u32, fineness: Fineness) -> String {
    let fine = concat!(include_str!("row.wgsl"), include_str!("row_fine.wgsl"));
    let (width, row) = if fineness.coarse { (COARSE, include_str!("row_coarse.wgsl")) } else { (WIDTH, fine) };
    header_of(depth, width, fineness, row)
}

/// The same for broad and narrow lobes, whose masks are fine, with `NARROW_GRID`, `IS_NARROW_FINER` and `HAS_MICROFACETS`: if that
/// is true, it needs [`MICROFACETS`].
///
/// # Panics
/// As [`header`].
#[must_use]
pub fn header_of_lobes(depth: u32, broad: Fineness, narrow: Fineness, has_microfacets: bool) -> String {
    let both = concat!(include_str!("row.wgsl"), include_str!("row_both.wgsl"));
    let header = if broad.coarse { header_of(depth, WIDTH, broad, both) } else { header(depth, broad) };
    let [across, upward] = narrow.grid;
    let is_finer = narrow != broad;
    let microfacets = if has_microfacets { "const HAS_MICROFACETS = true;\n" } else { NO_MICROFACETS };
    format!(
        "const NARROW_GRID = vec2u({across}u, {upward}u);\nconst IS_NARROW_FINER = {is_finer};\n{microfacets}{header}"
    )
}

/// Replaces [`MICROFACETS`]; a part of [`header_of_lobes`] without microfacets.
pub const NO_MICROFACETS: &str = "const HAS_MICROFACETS = false;\n\
    fn masks_of_microfacets(at: Receiver, tolerance: f32, lobe: Lobe, is_narrow_finer: bool) -> Masks { return Masks(); }\n\
    fn microfacet_sums(lane: u32, mask: Mask, at: Receiver, lobe: Lobe, masks: Masks, is_own: bool) -> vec4f { return vec4f(); }\n\
    fn microfacet_fraction(sums: vec4f, lobe: Lobe) -> f32 { return 0.0; }\n";

fn header_of(depth: u32, width: usize, fineness: Fineness, row: &str) -> String {
    assert!((1..=MAX_DEPTH).contains(&depth), "mask depth {depth} is not in 1..={MAX_DEPTH}");
    let side = 1_u32 << depth;
    let lanes = side.max(32);
    let columns = if width == COARSE { 16 } else { 32 };
    let [across, upward] = fineness.grid;
    let bands = 1 << (MAX_DEPTH - depth);
    format!(
        "const DEPTH = {depth}u;\nconst SIDE = {side}u;\nconst WIDTH = {width}u;\nconst LANES = {lanes}u;\nconst COLUMNS = \
         {columns}u;\nconst BROAD_GRID = vec2u({across}u, {upward}u);\nconst MOST_BANDS = {bands}u;\nconst GOLDEN = {GOLDEN}u;\n{row}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::PHASE;

    #[test]
    fn shifts_of_rows_by_integers() {
        for (j, phase) in PHASE[..1 << MAX_DEPTH].iter().enumerate() {
            let bits = (2 * j as u32 + 1).wrapping_mul(GOLDEN) ^ 0x8000_0000;
            let got = bits as i32 as f32 * 2.0_f32.powi(-32);
            // The factor is rounded to 2⁻³³, its multiples go up to 127, results have 2⁻²⁵; positions of samples 2⁻¹⁷.
            assert!((got - phase).abs() < 6e-8, "row {j}: {got} {phase}");
        }
    }
}
