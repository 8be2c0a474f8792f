//! Area lights: the cone in which a receiver sees one, its radiance, and its lobes.
//!
//! A light is one type that implements [`LightLobes`](lobe_core::LightLobes); [`SphereLight`] is the built-in one. Add another kind
//! beside it, here or in a crate of your own.
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

mod sphere_light;

pub use crate::sphere_light::SphereLight;
