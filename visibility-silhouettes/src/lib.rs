//! Exact visibility of triangle meshes from their silhouette edges.
//!
//! A [`SilhouetteMesh`] is prepared once and refitted as it moves. [`SilhouetteBlockers`] fills a receiver's mask from the outlines
//! of all meshes, the same mask that every strategy fills. Its samples are the ones that shadow rays would find lit, but a mask
//! takes one shadow ray. [`AnyHit`] traces that ray: any ray tracer can implement it.
//!
//! ```
//! use glam::Vec3;
//! use visibility_mask::MaskVisibility;
//! use lobe_core::{Cone, Receiver, Sphere};
//! use shading::{LightId, Accuracy, Coverage, Visibility, VisibilityQuery};
//! use visibility_silhouettes::{AnyHit, SilhouetteBlockers, SilhouetteMesh};
//!
//! /// One square, one unit above the origin.
//! struct Square;
//!
//! impl AnyHit for Square {
//!     type Scratch = ();
//!     fn scratch(&self) {}
//!     fn leave(&self, position: Vec3, face: Vec3) -> Vec3 {
//!         position + 1e-6 * face
//!     }
//!     fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, _: &mut ()) -> bool {
//!         let t = (1.0 - origin.y) / direction.y;
//!         let met = origin + direction * t;
//!         (0.0..distance).contains(&t) && met.x.abs() < 1.0 && met.z.abs() < 1.0
//!     }
//!     fn triangles_meeting(&self, _: Sphere, _: &mut dyn FnMut([Vec3; 3])) {}
//!     fn has(&self, object: u32) -> bool {
//!         object == 1
//!     }
//! }
//!
//! let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x, 1.0, z));
//! let meshes = [SilhouetteMesh::new(1, &corners, &[[0, 1, 2], [0, 2, 3]])];
//! let visibility = MaskVisibility::new(SilhouetteBlockers::new(&meshes, Square));
//! let mut scratch = visibility.scratch();
//! let light = Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 0.5 };
//! let mut coverage = |position: Vec3| {
//!     let at = Receiver { position, normal: Vec3::Y, face: Vec3::Y, view: Vec3::Y, object: 0 };
//!     let cone = Cone::of_sphere(position, light);
//!     visibility.coverage(&VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003)), &mut scratch)
//! };
//! assert_eq!(coverage(Vec3::ZERO), Coverage::Dark);
//! assert_eq!(coverage(Vec3::new(1.25, 0.0, 0.0)), Coverage::Partial);
//! assert_eq!(coverage(Vec3::new(3.0, 0.0, 0.0)), Coverage::Lit);
//! ```
//!
//! # Limits
//! A surface that reaches into the light blocks up to the circle in which the cone touches the light, not up to the light's own
//! surface. Needles as thin as the rounding of their corners may be wrong by a sample. Meshes of many triangles have edges finer
//! than the mask and take correspondingly long, unless [simplified forms](SilhouetteMesh::with_coarse) are allowed.
//!
//! Out of scope: tracing rays, and choosing the objects that cast shadows.

mod any_hit;
mod beside;
mod blockers;
mod clip;
mod coarse;
mod count;
mod draft;
mod edge_list;
mod fit;
mod gpu;
mod halving;
mod hidden;
mod hull;
mod hull_placed;
mod lanes;
mod levels;
mod lists;
mod look;
mod look_placed;
mod mesh;
mod near_light;
mod penumbra;
mod placed;
mod project;
mod select;
mod sift;
mod sky;
mod topology;
mod tree;
mod wgsl;

pub use crate::any_hit::AnyHit;
pub use crate::blockers::{SilhouetteBlockers, SilhouetteScratch};
pub use crate::gpu::GpuSilhouettes;
pub use crate::mesh::SilhouetteMesh;
pub use crate::near_light::{AroundLight, meets_plane};
pub use crate::placed::{SharedMesh, SilhouetteInstances};
pub use crate::sky::SkySilhouetteScratch;
pub use glam;
