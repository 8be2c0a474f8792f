//! Sphere sets that stand for triangle meshes when shadows are cast: fitting, measuring, storing, drawing, following bones.
//!
//! [`SphereSet::build`] fits spheres to a mesh; [`BoundSet`] lets them follow its bones; [`SphereSet::to_json`] and
//! [`SphereSet::from_json`] keep them. `visibility-spheres` casts their shadows, and needs nothing of this crate.
//!
//! ```
//! use glam::Vec3;
//! use sphere_sets::{BuildOptions, SphereSet};
//! let tetrahedron = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
//! let set = SphereSet::build(&tetrahedron, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], &BuildOptions::draft(6)).unwrap();
//! assert_eq!(set.spheres.len(), 6);
//! ```

mod bind;
mod bits;
mod blurred_difference;
mod bound_file;
mod bound_set;
mod bounding;
mod build;
mod cover;
mod descent;
mod error;
mod file;
mod goal;
mod options;
mod preview;
mod quality;
mod random;
mod rig;
mod self_shadow;
mod solid;
mod sphere_set;
mod surface;
mod swap;
mod tolerance;
mod tree;
mod view;
pub mod wgsl;

#[cfg(test)]
mod bind_tests;
#[cfg(test)]
mod shapes;
#[cfg(test)]
mod tests;

pub use bind::Carriers;
pub use bound_set::BoundSet;
pub use error::{BindError, BuildError, MisfitError, SetFileError};
pub use glam;
pub use options::{BuildOptions, Progress};
pub use preview::preview;
pub use quality::{SetQuality, Verdict};
pub use rig::{SphereRig, SphereRigPart};
pub use sphere_set::SphereSet;
