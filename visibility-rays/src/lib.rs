//! Visibility from shadow rays on the true triangles and spheres.
//!
//! - [`RayBlockers`]: the strategy `rays` on the CPU, in a [`World`](ray_tracing::World).
//! - [`GpuRays`]: the same for a GPU.
//!
//! ```
//! use ray_tracing::World;
//! use visibility_mask::MaskVisibility;
//! use visibility_rays::RayBlockers;
//! let scene = scene::builtin();
//! let world = World::new(&scene);
//! let visibility = MaskVisibility::new(RayBlockers::new(&world));
//! ```

mod gpu_rays;
mod rays;

pub use crate::gpu_rays::GpuRays;
pub use crate::rays::{RayBlockers, RayScratch};
pub use glam;
