//! Sphere sets that stand for triangle meshes when shadows are cast: building, measuring, storing, drawing.

mod balance;
mod bind;
mod bits;
mod bound_file;
mod bound_set;
mod bounding;
mod build;
mod cover;
mod descent;
mod error;
mod exchange;
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
mod tolerance;
mod tree;
mod view;

#[cfg(test)]
mod bind_tests;
#[cfg(test)]
mod shapes;
#[cfg(test)]
mod tests;

pub use bind::Carriers;
pub use bound_set::BoundSet;
pub use error::{BindError, BuildError, MisfitError, SetFileError};
pub use options::{BuildOptions, Progress};
pub use preview::preview;
pub use quality::{SetQuality, Verdict};
pub use rig::{Rig, RigPart};
pub use sphere_set::SphereSet;
