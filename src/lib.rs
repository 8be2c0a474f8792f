//! Deterministic, noise-free direct lighting from area lights, as sums of cosine lobes.
//!
//! This package is the composition: it re-exports the crates that do the work, each as a module, and adds what its
//! command `lobes` needs to read, write and compare pictures. The feature `oracle` adds the f64 oracle and the suite
//! that visibility strategies are tried with, `lobe_core::conformance`.
//!
//! ```
//! use cosine_lobes::{Comparison, Picture};
//! use glam::Vec3;
//! let reference = Picture::new(2, 1, vec![Vec3::ONE, Vec3::splat(2.0)]);
//! let test = Picture::new(2, 1, vec![Vec3::ONE, Vec3::splat(2.5)]);
//! let error = Comparison::of(&test, &reference).unwrap();
//! assert_eq!((error.mae, error.bias, error.max), (0.25, 0.25, 0.5));
//! ```

pub use brdf;
pub use glam;
pub use lighting;
pub use lobe_core;
pub use pictures;
pub use render_cpu;
#[cfg(feature = "gpu")]
pub use render_gpu;
pub use renderer;
pub use scene;
pub use sphere_sets;
pub use visibility_mask;
pub use visibility_shadowmap;
pub use visibility_silhouettes;
pub use visibility_spheres;

pub use pictures::{
    Comparison, ExrLayer, ExrPart, FlipMap, ImageFileError, MergeError, Output, Picture, PictureStream, RegionError,
    ShadowErrors, SizesDiffer, Window, checksum, luminance, merge_exr, read_exr, read_exr_layer, read_stamp,
    remove_unfinished, signed_difference, srgb_bytes, write_exr, write_png,
};
