//! The same in WGSL: texts that are joined into a shader module, in any order.
//!
//! All need: `maps_word`, which reads one of [`PackedMaps::words`](crate::PackedMaps::words)
//! ([`GpuPages::wgsl`](shading::gpu::GpuPages::wgsl)); a variable `frame` with `light: vec4f` (centre and radius),
//! `tolerance: f32` and `number: u32`, the light's number in its frame; `geometry.wgsl` and `lobe.wgsl` of `lobe-core`;
//! `square.wgsl` and `facet.wgsl` of `visibility-mask`; and [`COMMON`].
//!
//! # Accuracy
//! Rust computes in f64, this WGSL in f32, with texels and depths counted from the receiver's own place: the error is 1e-7 of the
//! distance to the light, magnified for a blocker much nearer to the receiver than the light. The visible fraction of a mask
//! differs from Rust's by 1e-5 in the mean for lights of a half-angle of 1° and more (3e-4 at most for 5°, a sample of a row), 6e-5
//! for 0.5° (2e-3 at most), 2e-4 for 0.1° (3e-3 at most). This includes penumbrae of bodies on themselves; moving scenes by 1e4
//! loses nothing more.

/// Layers, views and own faces.
pub const COMMON: &str =
    concat!(include_str!("layer.wgsl"), "\n", include_str!("face_view.wgsl"), "\n", include_str!("own_face.wgsl"));

/// `fn maps_coverage(tile: u32, at: Receiver, cone: Cone) -> u32`, one thread a receiver: the coverage of a light by texels. As
/// [`Blockers::select`](visibility_mask::Blockers::select) of [`ShadowMapBlockers`](crate::ShadowMapBlockers).
pub const COVERAGE: &str = include_str!("coverage.wgsl");

/// `fn maps_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask)`, one thread a row of the mask: clears the same bits
/// of the row `lit` as [`Blockers::splat`](visibility_mask::Blockers::splat). Has no barriers. Needs `mask.wgsl` and the header of
/// `visibility-mask`.
///
/// A thread keeps four lines of `16 · 2^depth` samples: 256 bytes at depth 5, 512 at depth 6.
pub const SPLAT: &str = concat!(include_str!("polygon_union.wgsl"), "\n", include_str!("splat.wgsl"));
