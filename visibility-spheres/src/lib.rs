//! Visibility from spheres: culling, and splatting on the mask.
//!
//! [`SphereBlockers`] holds the spheres of a frame under a hierarchy and is one [`Blockers`](visibility_mask::Blockers): exact for
//! spheres, and for the sets that `sphere-sets` fits to meshes.
//!
//! ```
//! use glam::Vec3;
//! use lobe_core::Sphere;
//! use visibility_mask::MaskVisibility;
//! use visibility_spheres::SphereBlockers;
//! let sphere = Sphere { center: Vec3::Y, radius: 0.5 };
//! let strategy = MaskVisibility::new(SphereBlockers::new(&[sphere], &[0], &[])); // a shading::Visibility
//! # let _ = strategy;
//! ```

mod block;
mod blocked_cones;
mod blockers;
mod cone_list;
mod ellipse;
mod gpu;
mod packed;
mod rim;
mod shaft;
mod sky;
mod sphere_tree;
mod splat;
pub mod wgsl;
mod wide_cone;

pub use crate::blockers::{SphereBlockers, SphereScratch};
pub use crate::packed::{BlockerSphere, LIST_WORDS, SPHERE_BLOCK};
pub use crate::sky::SkySphereScratch;
pub use glam;

#[cfg(test)]
mod culling_tests;
#[cfg(test)]
mod splat_tests;
#[cfg(test)]
mod tests;
