//! Visibility from sphere sets: building, culling and splatting.

mod set;

pub use crate::set::{BuildError, BuildOptions, Progress, SetFileError, SetQuality, SphereSet, preview};
