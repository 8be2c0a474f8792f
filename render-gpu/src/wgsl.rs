//! Texts of this crate's own kernels: pieces to be joined.

/// The hierarchy, its primitives, and their intersections with rays.
pub const BVH: &str = include_str!("kernels/bvh.wgsl");
/// The kernel of visible points. Needs [`BVH`], `lobe_core::wgsl::GEOMETRY` and a constant `STACK`.
pub const TRACE: &str = include_str!("kernels/trace.wgsl");
/// Answers the strategies' ray queries. Needs [`BVH`], `lobe_core::wgsl::GEOMETRY` and a constant `STACK`.
pub const ANY_HIT: &str = include_str!("kernels/any_hit.wgsl");
