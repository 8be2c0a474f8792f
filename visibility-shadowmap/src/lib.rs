//! Visibility from depth maps around the light: texels as micro-blockers.
//!
//! A [`ShadowMap`] is drawn from the centre of a light, on the CPU, from any triangles: without proxies or preparation of the mesh.
//! [`ShadowMapBlockers`] fills a receiver's mask from it, the same mask that every strategy fills.
//!
//! ```
//! use glam::{Vec2, Vec3};
//! use visibility_mask::MaskVisibility;
//! use lobe_core::{Cone, Receiver, Sphere};
//! use shading::{LightId, Accuracy, Coverage, Shaft, Visibility, VisibilityQuery};
//! use visibility_shadowmap::{MapOptions, ShadowMap, ShadowMapBlockers};
//!
//! // A square one unit above the origin, and a light above it.
//! let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| Vec3::new(x, 1.0, z));
//! let light = Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 0.5 };
//! let map = ShadowMap::build(&corners, &[[0, 1, 2], [0, 2, 3]], light, &MapOptions::default())?;
//!
//! let visibility = MaskVisibility::new(ShadowMapBlockers::new(vec![map]));
//! let mut scratch = visibility.scratch();
//! let mut coverage = |position: Vec3| {
//!     let at = Receiver::on_surface(position, Vec3::Y, Vec3::Y).on_object(0);
//!     let cone = Cone::of_sphere(position, light);
//!     visibility.coverage(&VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003)), &mut scratch)
//! };
//! assert_eq!(coverage(Vec3::ZERO), Coverage::Dark);
//! assert_eq!(coverage(Vec3::new(1.25, 0.0, 0.0)), Coverage::Partial);
//! assert_eq!(coverage(Vec3::new(3.0, 0.0, 0.0)), Coverage::Lit);
//! # Ok::<(), visibility_shadowmap::MapError>(())
//! ```
//!
//! # Limits
//! The map may miss objects thinner than a texel. More than four surfaces behind each other, seen from the light's centre, can
//! leak: the map has the two nearest surfaces that face the light, and the two nearest that face away. At a contact, surfaces
//! within half a texel of the receiver's tangent plane do not block. Walls that the light's centre sees edge-on, and objects that
//! touch the light, need another strategy: test them with [`ShadowMap::shows`]. So do receivers on [drawn](ShadowMap::draws)
//! objects, see [`ShadowMapBlockers::leaving`]. [`ShadowMap::advice`] reports whether a map is fine enough; [`ShadowMap::fitted`]
//! chooses its resolution.
//!
//! Out of scope: fitting proxies, and choosing the objects that cast shadows.

mod blockers;
mod clip;
mod contacts;
mod face;
mod face_view;
mod fit;
mod images;
mod layer;
mod map;
mod options;
mod packed;
mod polygon_union;
mod raster;
mod suits;
#[cfg(test)]
mod tests;
pub mod wgsl;

pub use crate::blockers::{ShadowMapBlockers, ShadowMapScratch};
pub use crate::images::MapImage;
pub use crate::map::{MapAdvice, MapFineness, ShadowMap};
pub use crate::options::{MapError, MapOptions, ReceiverBounds};
pub use crate::packed::PackedMaps;
pub use glam;
