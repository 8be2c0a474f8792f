//! Sphere lights, the light cone, the unit square and the visibility mask.

mod sphere_light;

pub use crate::sphere_light::SphereLight;
