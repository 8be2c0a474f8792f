//! Visibility from sphere sets: building, culling and splatting.

mod block;
mod blockers;
mod ellipse;
mod hits;
mod looks;
mod packed;
mod set;
mod shaft_test;
mod sphere_tree;
mod splat;
pub mod wgsl;
mod wide;

pub use crate::blockers::{SphereBlockers, SphereScratch};
pub use crate::packed::{BlockerSphere, LIST_WORDS, SPHERE_BLOCK};
pub use crate::set::{
    BindError, BoundSet, BuildError, BuildOptions, Carriers, MisfitError, Progress, Rig, RigPart, SetFileError,
    SetQuality, SphereSet, Verdict, preview,
};

#[cfg(test)]
mod culling_tests;
#[cfg(test)]
mod splat_tests;
#[cfg(test)]
mod tests;
