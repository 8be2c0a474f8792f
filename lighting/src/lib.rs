//! Area lights: the cone in which a receiver sees one, its radiance, and its lobes.
//!
//! A light is one type that implements [`LightLobes`](lobe_core::LightLobes): [`SphereLight`], [`FlatLight`] (rectangles, discs, convex polygons),
//! [`TubeLight`], [`SunLight`], [`SpotLight`], [`AmbientLight`], [`InsideLight`]; [`Light`] is any of these. An [`Environment`] is a set of them, [`faces`] and [`emissive_mesh`] are those of a mesh
//! that emits. Add another kind beside them, here or in a crate of your own.
//!
//! Out of scope: what hides a light (the `visibility-*` crates), scenes, images.
//!
//! ```
//! use glam::Vec3;
//! use lighting::SphereLight;
//! use lobe_core::{LightLobes, OWN_NONE, Receiver, Sphere};
//! let lamp = SphereLight::new(Sphere { center: Vec3::new(0.0, 4.0, 0.0), radius: 0.5 }, Vec3::splat(10.0));
//! let at = Receiver { position: Vec3::ZERO, normal: Vec3::Y, face: Vec3::Y, view: Vec3::Y, object: OWN_NONE };
//! assert_eq!((lamp.cone(&at).axis, lamp.cone(&at).distance), (Vec3::Y, 4.0));
//! ```

mod ambient_light;
mod emissive_mesh;
mod environment;
mod faces;
mod flat_light;
mod gpu;
mod light;
mod sky_light;
mod sphere_light;
mod spot_light;
mod sun_light;
mod surface;
mod tube_light;
mod world;

pub use crate::ambient_light::AmbientLight;
pub use crate::emissive_mesh::{EmissiveMesh, EmissiveMeshError, emissive_mesh};
pub use crate::environment::{Environment, EnvironmentError, EnvironmentMap};
pub use crate::faces::{FacesError, faces};
pub use crate::flat_light::{FlatLight, FlatLightError};
pub use crate::light::{InsideLight, Light};
pub use crate::sky_light::{SkyLight, SkyPatch};
pub use crate::sphere_light::SphereLight;
pub use crate::spot_light::SpotLight;
pub use crate::sun_light::SunLight;
pub use crate::tube_light::TubeLight;
pub use glam;
