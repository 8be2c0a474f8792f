//! Deterministic, noise-free direct lighting from area lights, as sums of cosine lobes.
//!
//! One crate that re-exports all of them, each as a module:
//!
//! - [`renderer`]: a scene to a picture, the whole of it as one type; start here.
//! - [`scene`]: meshes, materials, camera, animation and their files; [`pictures`]: OpenEXR, PNG, comparison.
//! - [`lobe_core`], [`brdf`], [`lighting`], [`visibility_mask`]: lobes, and the three sources of them: reflectance, light, visibility.
//! - [`visibility_silhouettes`], [`visibility_spheres`] with [`sphere_sets`], [`visibility_shadowmap`], [`visibility_rays`]: what blocks light.
//! - [`ray_tracing`]: what rays meet, and the visible points of a picture.
//! - [`render_cpu`], `render_gpu`: points to radiance; [`reference`](mod@reference): the same by Monte Carlo, to measure them by.
//!
//! ```
//! use cosine_lobes::renderer::{Renderer, Settings};
//! use cosine_lobes::scene::{Animation, builtin};
//! let mut scene = builtin();
//! (scene.width, scene.height) = (32, 18);
//! let image = Renderer::new(scene, Animation::default(), Settings::default())?.render()?;
//! assert_eq!(image.size, [32, 18]);
//! # Ok::<(), cosine_lobes::renderer::RenderError>(())
//! ```
//!
//! # Features
//! `gpu` (default): `render_gpu`, through wgpu. `oracle`: the f64 oracle, and the suites that strategies, lights and materials are
//! tried with ([`lobe_core`]'s `conformance`, [`brdf`]'s `conformance`). The command `lobes` is a package of its own,
//! `cosine-lobes-cli`.

pub use brdf;
pub use glam;
pub use lighting;
pub use lobe_core;
pub use pictures;
pub use ray_tracing;
pub use reference;
pub use render_cpu;
#[cfg(feature = "gpu")]
pub use render_gpu;
pub use renderer;
pub use scene;
pub use sphere_sets;
pub use visibility_mask;
pub use visibility_rays;
pub use visibility_shadowmap;
pub use visibility_silhouettes;
pub use visibility_spheres;

pub use pictures::{
    Comparison, ExrLayer, ExrPart, FlipMap, ImageFileError, MergeError, Output, Picture, PictureStream, RegionError,
    ShadowErrors, SizesDiffer, Window, checksum, luminance, merge_exr, read_exr, read_exr_layer, read_stamp,
    remove_unfinished, signed_difference, srgb_bytes, write_exr, write_png,
};
