//! Ray tracing of a scene, and the visible points of a picture.
//!
//! - [`World`]: the triangles and spheres of a scene in two hierarchies (obvhs). It answers single shadow rays ([`World::occluded`]), and
//!   queries that save rays: the [`Primitive`]s between points and a light ([`World::in_shaft`]), whether any ray of a
//!   [`Region`] meets something. A [`Hierarchy`] is kept and refitted as things move.
//! - [`GBuffer`]: the visible points of a picture, found by packets of camera rays.
//! - [`mapped_normal`]: the normal of a point by a normal map.
//! - [`SphereHierarchy`]: the same for spheres that carry data.
//!
//! ```
//! use glam::Vec3;
//! use ray_tracing::{GBuffer, World};
//! let scene = scene::builtin();
//! let world = World::new(&scene);
//! let points = GBuffer::new(&world, 32, 18, 1);
//! let at = &points.points.receivers[0];
//! let light = scene.lights[0].sphere().expect("a sphere").center - at.position;
//! let hidden = world.occluded(world.leave(at.position, at.face), light.normalize(), light.length());
//! assert!(!hidden && !points.is_empty());
//! ```

mod gbuffer;
mod sphere_hierarchy;
mod world;

pub use crate::gbuffer::{GBuffer, PixelSamples, TILE};
pub use crate::sphere_hierarchy::SphereHierarchy;
#[doc(hidden)]
pub use crate::world::binary_hierarchy;
pub use crate::world::{Hierarchy, Primitive, Region, TriangleList, Update, World, mapped_normal, vertex_tangents};
pub use glam;
