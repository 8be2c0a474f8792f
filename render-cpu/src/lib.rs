//! Shading on the CPU, what shadow rays and camera rays meet, and the Monte-Carlo reference.
//!
//! - [`CpuShader`]: shades points by lobe sums, with any visibility strategy, materials and lights.
//! - [`World`]: the geometry of a scene, ready for rays; [`GBuffer`]: the visible points of a picture.
//! - What blocks in a scene: [`SceneSpheres`] and [`blockers()`], [`SceneSilhouettes`] with [`SurfaceHits`], [`RayBlockers`].
//! - [`Reference`]: Monte Carlo of the same points, which reports its own error and can be kept and resumed; [`RayShader`]: shadow
//!   rays on the same points, what the lobes are measured against. Both share nothing with the lobes.
//!
//! ```
//! use glam::Vec3;
//! use lobe_core::{Accuracy, Unshadowed};
//! use render_cpu::{CpuShader, GBuffer, World};
//! use scene::{Frame, Shade};
//! let scene = scene::builtin();
//! let points = GBuffer::new(&World::new(&scene), 32, 18, 1);
//! let frame =
//!     Frame { materials: &points.materials, lights: &scene.lights, accuracy: Accuracy::default(), threshold: 0.0 };
//! let mut radiance = vec![Vec3::ZERO; points.len()];
//! CpuShader::new(Unshadowed).shade(&points.points, &frame, &mut radiance).unwrap();
//! let pixels = points.resolve(&radiance, scene.background);
//! assert_eq!(pixels.len(), 32 * 18);
//! ```

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
