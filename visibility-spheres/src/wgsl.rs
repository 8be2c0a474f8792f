//! The same in WGSL, to be joined as text with what each needs.
//!
//! All of it wants lobe-core's geometry, [`PACKED`], and the buffers `spheres`, an `array<BlockerSphere>`, `spheres_bounds`, an
//! `array<vec4f>`, and `spheres_lists`, an `array<u32>`, each bound with just what it holds.

/// The struct of a blocker, the layout of a tile's list.
pub const PACKED: &str = include_str!("packed.wgsl");
/// The kernel of the bounds of blocks.
pub const BOUNDS: &str = include_str!("bounds.wgsl");
/// The kernel of the lists of tiles: with [`SHAFT_TEST`].
pub const CULL: &str = include_str!("cull.wgsl");
/// Which spheres meet a shaft: for culling.
pub const SHAFT_TEST: &str = include_str!("shaft.wgsl");
/// Which spheres a light's cone may meet.
pub const CONE_TEST: &str = include_str!("cone_test.wgsl");
/// The cone that a sphere blocks.
pub const BLOCKED_CONE: &str = include_str!("blocked_cone.wgsl");
/// `spheres_coverage`: with [`CONE_TEST`], [`BLOCKED_CONE`] and visibility-mask's facet.
pub const SPHERES: &str = include_str!("spheres.wgsl");
/// A sphere on a mask: with visibility-mask's mask.
pub const ELLIPSE: &str = include_str!("ellipse.wgsl");
/// Other cones on a mask: with [`BLOCKED_CONE`], [`ELLIPSE`] and visibility-mask's mask and edges.
pub const SPLAT: &str = concat!(include_str!("splat.wgsl"), "\n", include_str!("wide_cone.wgsl"));
/// `spheres_edges` and `spheres_splat`: with all of these but [`SHAFT_TEST`].
pub const SPHERES_SPLAT: &str = include_str!("spheres_splat.wgsl");
