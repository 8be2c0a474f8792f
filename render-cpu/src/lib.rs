//! Shading on the CPU and the Monte-Carlo reference.

mod blockers;
mod gbuffer;
mod ray_shader;
mod rays;
mod reference;
mod scene_silhouettes;
mod scene_spheres;
mod shade;
mod surface_hits;
#[cfg(test)]
mod test_scenes;
mod wide;
mod world;

pub use crate::blockers::{BlockersError, BlockersProgress, blockers};
pub use crate::gbuffer::{GBuffer, TILE};
pub use crate::ray_shader::RayShader;
pub use crate::rays::{RayBlockers, RayScratch};
pub use crate::reference::{CheckpointError, Estimate, Geometry, REPLICATES, Reference, ReferenceJob};
pub use crate::scene_silhouettes::SceneSilhouettes;
pub use crate::scene_spheres::{SceneSpheres, SphereSource, read_set};
pub use crate::shade::{CpuShader, Layers};
pub use crate::surface_hits::{HitScratch, SurfaceHits};
pub use crate::world::{Hierarchy, World};
