//! The same in WGSL: pieces that a shader's module is [joined](lobe_core::wgsl::join) of, in any order.

use crate::cap_table::VALUES;
use crate::product_table::LAST;
use crate::shadow_tree::ShadowTree;
use crate::tables::{CAPS, PRODUCTS};
use lobe_core::wgsl::{LOBE, Piece};
use lobe_core::wgsl_numbers;
use visibility_mask::Fineness;
use visibility_mask::wgsl::{MASK, TOTAL};

/// Lobes that come from the tables: `paper_product`, `paper_light_lobe`, `paper_occluder`, `paper_reflected`. Needs the buffer `paper_tables` (of
/// `vec2f`), which is that of [`Tables::pack`](crate::Tables::pack).
pub static TABLES: Piece = Piece::new(include_str!("tables.wgsl"))
    .numbers(wgsl_numbers![PAPER_CAPS = CAPS, PAPER_CAP_VALUES = VALUES, PAPER_PRODUCTS = PRODUCTS, PAPER_LAST = LAST,])
    .needs(&[&LOBE]);

/// Shadow nodes and their lobes, by [`TABLES`] with the pairs of [`PaperWeights::pack`](crate::PaperWeights::pack) after them. Needs
/// [`header`].
pub static VISIBILITY: Piece = Piece::new(include_str!("visibility.wgsl")).needs(&[&TABLES, &MASK, &TOTAL]);

/// [`header`](visibility_mask::wgsl::header) of the fine masks that a quad-tree of `depth` is read from, with `PAPER_DEPTH`.
///
/// # Panics
/// As [`header`](visibility_mask::wgsl::header).
#[must_use]
pub fn header(depth: u32) -> String {
    let mask = ShadowTree::uncovered(depth).mask_depth();
    format!("const PAPER_DEPTH = {depth}u;\n{}", visibility_mask::wgsl::header(mask, Fineness::FINE))
}
