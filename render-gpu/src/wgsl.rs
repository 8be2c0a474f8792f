//! Texts of this crate's own kernels: pieces to be joined.

/// The hierarchy and its primitives, and where rays meet them.
pub const BVH: &str = include_str!("kernels/bvh.wgsl");
/// The kernel of visible points. Needs [`BVH`], `lobe_core::wgsl::GEOMETRY` and a constant `STACK`.
pub const TRACE: &str = include_str!("kernels/trace.wgsl");
/// The `rays` strategy for one point a thread. Needs [`BVH`], `lobe_core::wgsl::GEOMETRY`, `visibility_mask::wgsl::FACET` and a
/// constant `STACK`.
pub const RAYS: &str = include_str!("kernels/rays.wgsl");
/// Answers other strategies' questions about rays. Needs [`RAYS`].
pub const ANY_HIT: &str = include_str!("kernels/any_hit.wgsl");
/// The masks of `rays`. Needs [`RAYS`], and of `visibility_mask::wgsl` `CONTOUR` and `EDGES`.
pub const RAYS_SPLAT: &str = include_str!("kernels/rays_splat.wgsl");

#[cfg(test)]
#[path = "wgsl_tests.rs"]
mod tests;
