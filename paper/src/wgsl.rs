//! The same in WGSL: texts that are joined into a shader module, in any order.

use crate::shadow_tree::ShadowTree;
use visibility_mask::Fineness;

/// The tables, storage buffer of binding 9, and the lobes that come from them: `paper_product`, `paper_light_lobe`, `paper_occluder`,
/// `paper_reflected`. The buffer is that of [`Tables::pack`](crate::Tables::pack). Needs `SPECIAL`, `GEOMETRY` and `LOBE` of `lobe-core`.
pub const TABLES: &str = include_str!("tables.wgsl");

/// Shadow nodes and their lobes; needs [`header`], [`TABLES`] with the pairs of [`PaperWeights::pack`](crate::PaperWeights::pack) after
/// them, and `SQUARE`, `MASK` and `TOTAL` of `visibility-mask`.
pub const VISIBILITY: &str = include_str!("visibility.wgsl");

/// [`header`](visibility_mask::wgsl::header) of the fine masks that a quad-tree of `depth` is read from, with `PAPER_DEPTH`.
///
/// # Panics
/// As [`header`](visibility_mask::wgsl::header).
#[must_use]
pub fn header(depth: u32) -> String {
    let mask = ShadowTree::uncovered(depth).mask_depth();
    format!("const PAPER_DEPTH = {depth}u;\n{}", visibility_mask::wgsl::header(mask, Fineness::FINE))
}
