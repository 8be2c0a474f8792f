//! Visibility from sphere sets: building, culling and splatting.

mod blockers;
mod set;

pub use crate::set::{
    BindError, BoundSet, BuildError, BuildOptions, Carriers, MisfitError, Progress, SetFileError, SetQuality,
    SphereSet, preview,
};
mod splat;
#[cfg(test)]
mod tests;

pub use crate::blockers::{SphereBlockers, SphereScratch};
