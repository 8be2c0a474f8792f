//! Shading on the CPU and the Monte-Carlo reference.

mod gbuffer;
mod reference;
#[cfg(test)]
mod test_scenes;
mod world;

pub use crate::gbuffer::{GBuffer, TILE};
pub use crate::reference::{CheckpointError, Estimate, Geometry, REPLICATES, Reference, ReferenceJob};
pub use crate::world::{Hit, World};
