//! The same in WGSL, to be joined as text with its dependencies.

/// Bindings 6, 12 and 13, and the entry point `pose_spheres`, one sphere a thread, 64 a workgroup: a kernel of its own that
/// wants no `frame`, with lobe-core's special functions.
pub const POSE: &str = include_str!("pose.wgsl");
