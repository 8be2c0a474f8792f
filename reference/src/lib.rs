//! Monte Carlo of the same points that the lobes shade: no lobe, no mask, only rays. By design it has no code in common with the lobes.
//!
//! - [`Reference`]: direct light of a [`ReferenceJob`], progressive and resumable ([`Reference::save`]), with a standard error for
//!   each point ([`Estimate`]).
//! - [`RayShader`]: shadow rays at the best speed that they reach here, as a [`Shade`](scene::Shade), to compare the lobes with.
//!
//! ```
//! use core::sync::atomic::AtomicBool;
//! use ray_tracing::{GBuffer, World};
//! use reference::{Geometry, Reference, ReferenceJob};
//! use scene::BlockerSet;
//! let scene = scene::builtin();
//! let world = World::new(&scene);
//! let gbuffer = GBuffer::new(&world, 16, 9, 1);
//! let job = ReferenceJob {
//!     world: &world,
//!     gbuffer: &gbuffer,
//!     blockers: &BlockerSet::default(),
//!     geometry: Geometry::Mesh,
//!     seed: 1,
//! };
//! let mut reference = Reference::new(job);
//! reference.advance(64, &AtomicBool::new(false), &|_| {});
//! let estimate = reference.estimate();
//! assert_eq!((estimate.radiance.len(), estimate.std_error.len()), (gbuffer.len(), gbuffer.len()));
//! ```

mod area;
mod cone;
mod ray_shader;
mod reference;
mod sky;
mod sobol;
#[cfg(test)]
mod test_blockers;

pub use crate::ray_shader::RayShader;
pub use crate::reference::{CheckpointError, Estimate, Geometry, REPLICATES, Reference, ReferenceJob};
pub use glam;
