//! Area lights: the cone in which a receiver sees one, its radiance, and its lobes.
//!
//! A light is one type that implements [`LightLobes`](shading::LightLobes): [`SphereLight`], [`FlatLight`] (rectangles, discs, convex polygons),
//! [`TubeLight`], [`SunLight`], [`SpotLight`], [`AmbientLight`], [`EnclosedLight`]; [`Light`] is any of these, or a [`LightKind`] of your own. An [`Environment`]
//! is a set of them, [`faces`] and [`emissive_mesh`] are those of a mesh that emits.
//!
//! Out of scope: what hides a light (the `visibility-*` crates), scenes, images.
//!
//! ```
//! use glam::Vec3;
//! use lighting::SphereLight;
//! use lobe_core::{Receiver, Sphere};
//! use shading::LightLobes;
//! let lamp = SphereLight::new(Sphere { center: Vec3::new(0.0, 4.0, 0.0), radius: 0.5 }, Vec3::splat(10.0));
//! let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
//! assert_eq!((lamp.cone(&at).axis, lamp.cone(&at).distance), (Vec3::Y, 4.0));
//! ```

mod ambient_light;
mod area;
mod emissive_mesh;
mod enclosed_light;
mod environment;
mod error;
mod faces;
mod flat_light;
mod gpu;
mod kind;
mod light;
mod sky_light;
mod sphere_light;
mod spot_light;
mod sun_light;
mod tube_light;

pub use crate::ambient_light::AmbientLight;
pub use crate::area::{Area, AreaPoint, AreaShape, SampledArea, ShownImage};
pub use crate::emissive_mesh::{EmissiveMesh, EmissiveMeshError, emissive_mesh};
pub use crate::enclosed_light::EnclosedLight;
pub use crate::environment::{Environment, EnvironmentError, EnvironmentMap};
pub use crate::error::LightError;
pub use crate::faces::{FacesError, faces};
pub use crate::flat_light::{FlatLight, FlatLightError};
pub use crate::kind::LightKind;
pub use crate::light::Light;
pub use crate::sky_light::{SkyLight, SkyPatch};
pub use crate::sphere_light::SphereLight;
pub use crate::spot_light::SpotLight;
pub use crate::sun_light::SunLight;
pub use crate::tube_light::TubeLight;
pub use glam;
