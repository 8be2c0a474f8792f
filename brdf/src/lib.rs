//! Reflectance models as sums of cosine lobes.

mod material;
mod model;

pub use crate::material::Material;
pub use crate::model::{Brdf, BrdfSample};
