//! The same in WGSL: texts that are joined into a shader module, in any order.
//!
//! One workgroup of `LANES` threads draws the mask of one point and light, a row a thread. Functions are named after their Rust
//! equivalents, with the type's name first: `mask_row_y` is [`Mask::row_y`](crate::Mask::row_y).

use crate::row::{COARSE, WIDTH};
use crate::{Fineness, MAX_DEPTH};

/// The unit square; needs `geometry.wgsl` and `lobe.wgsl` of `lobe-core`, and one of [`ROUND`] and [`FLAT`].
pub const SQUARE: &str = include_str!("square.wgsl");
/// Lights that appear as discs. Needs [`SQUARE`] and `NO_OUTLINE` of `lobe-core`.
pub const ROUND: &str = include_str!("round.wgsl");
/// Lights that may have outlines, instead of [`ROUND`]. Needs [`SQUARE`] and `OUTLINE` of `lobe-core`.
pub const FLAT: &str = include_str!("flat.wgsl");
/// The thread's row of the mask; needs [`header`] and [`SQUARE`].
pub const MASK: &str = include_str!("mask.wgsl");
/// The contour of blockers, from tests of directions; needs [`MASK`] and `light_is_hidden`.
pub const CONTOUR: &str = concat!(
    include_str!("contour_bits.wgsl"),
    include_str!("contour_cells.wgsl"),
    include_str!("contour_spans.wgsl"),
    include_str!("contour.wgsl")
);
/// The sum of edges that turns a mask; needs `geometry.wgsl`.
pub const EDGES: &str = include_str!("edges.wgsl");

/// Coverage of a light by a receiver's own facet; needs `geometry.wgsl`.
pub const FACET: &str = include_str!("facet.wgsl");

/// Results that threads compute together; needs [`header`].
pub const TOTAL: &str = include_str!("total.wgsl");
/// The visible fraction of a lobe through masks; needs [`MASK`], [`TOTAL`] and one of [`LAMBERT`] and [`LOBES`].
pub const FRACTION: &str = include_str!("fraction.wgsl");
/// Masks of blockers; needs [`EDGES`], [`MASK`], [`TOTAL`], [`FRACTION`], `blockers_edges` and `blockers_splat`.
pub const VISIBILITY: &str = include_str!("visibility.wgsl");
/// The visible fraction of a lobe if all lobes are Lambert's; needs [`VISIBILITY`].
pub const LAMBERT: &str = concat!(
    include_str!("visibility_whole.wgsl"),
    include_str!("fraction_lambert.wgsl"),
    include_str!("fraction_lambert_only.wgsl")
);
/// The visible fraction of any lobe; needs [`VISIBILITY`], [`header_of_lobes`], `special.wgsl` of `lobe-core`, and one of [`ALIKE`] and
/// [`IMAGE`].
pub const LOBES: &str = concat!(
    include_str!("visibility_window.wgsl"),
    include_str!("fraction_lambert.wgsl"),
    include_str!("fraction_glossy.wgsl"),
    include_str!("fraction_both.wgsl")
);

/// The visible fraction of microfacet lobes, if [`header_of_lobes`] has them; needs [`LOBES`] and `MICROFACETS` of `lobe-core`.
pub const MICROFACETS: &str = include_str!("fraction_microfacets.wgsl");

/// The visible fraction if it is the same in all channels; needs [`LOBES`].
pub const ALIKE: &str = include_str!("fraction_alike.wgsl");
/// The same by channel, for a light that shows an image; needs [`FLAT`], [`LOBES`], `IMAGE` of `lobe-core`, and
/// [`IMAGE_MICROFACETS`] or [`IMAGE_NO_MICROFACETS`].
pub const IMAGE: &str = include_str!("fraction_image.wgsl");
/// Microfacet lobes for such a light; needs [`MICROFACETS`].
pub const IMAGE_MICROFACETS: &str = include_str!("fraction_image_microfacets.wgsl");
/// Replaces [`IMAGE_MICROFACETS`] if there are no microfacets.
pub const IMAGE_NO_MICROFACETS: &str = "fn image_alpha(lobe: Lobe) -> f32 { return 0.0; }
fn image_highlight(whole: UnitSquare, at: Receiver, tolerance: f32, lobe: Lobe) -> UnitSquare { return whole; }
fn image_facets_in(square: UnitSquare, at: Receiver, lobe: Lobe) {}
fn image_facets(v: vec3f) -> f32 { return 0.0; }
";

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
    fn edges_of_nothing_are_rusts() {
        assert!(EDGES.contains(&format!("EDGES_NOTHING = vec2f({:e}, 0.0)", crate::edges::NOTHING)));
    }

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
