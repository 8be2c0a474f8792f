//! Shading on the CPU by lobe sums, and what blocks light in a scene.
//!
//! - [`CpuShader`]: shades points, with any visibility strategy, materials and lights.
//! - Blockers: [`SceneSpheres`] and [`blockers()`], [`SceneSilhouettes`] with [`SurfaceHits`].
//! - [`World`] and [`GBuffer`], which they ask and shade, are [`ray_tracing`]'s.
//!
//! ```
//! use glam::Vec3;
//! use shading::{Accuracy, Unshadowed};
//! use render_cpu::{CpuShader, GBuffer, World};
//! use scene::{Frame, Shade};
//! let scene = scene::builtin();
//! let points = GBuffer::new(&World::new(&scene), 32, 18, 1);
//! let frame =
//!     Frame::new(&points.materials, &scene.lights, Accuracy::default());
//! let mut radiance = vec![Vec3::ZERO; points.len()];
//! CpuShader::new(Unshadowed).shade(&points.points, &frame, &mut radiance).unwrap();
//! let pixels = points.resolve(&radiance, scene.background);
//! assert_eq!(pixels.len(), 32 * 18);
//! ```

mod blockers;
mod blockers_error;
mod faint;
mod group;
mod layers;
mod lent;
mod revision;
mod scene_silhouettes;
mod scene_spheres;
mod shade;
mod sky;
mod surface_hits;

pub use crate::blockers::blockers;
pub use crate::blockers_error::{BlockersError, BlockersProgress};
pub use crate::layers::{Layers, ShadeRequest};
pub use crate::revision::Revision;
pub use crate::scene_silhouettes::{Looks, SceneSilhouettes};
pub use crate::scene_spheres::{SceneSpheres, SphereSource, read_set};
pub use crate::shade::CpuShader;
pub use crate::sky::{SkyLighting, SkyScratch, SkyShader};
pub use crate::surface_hits::{HitScratch, SurfaceHits};
pub use glam;
pub use ray_tracing::{GBuffer, Hierarchy, PixelSamples, TILE, Update, World};
