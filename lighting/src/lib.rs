//! Sphere lights, and what every visibility strategy shares: the unit square, the mask and the cut.
//!
//! A light is seen from a receiver as a cone ([`SphereLight`]). The [`UnitSquare`] faces it; blockers are rasterised on
//! the square into a [`Mask`], a complete quad-tree as bits. [`MaskVisibility`] turns any [`Blockers`] into lobes.
//!
//! Out of scope: what blocks (the `visibility-*` crates), scenes, images.

mod cut;
mod mask;
mod node;
mod sphere_light;
mod square;
mod visibility;

pub use crate::mask::{MAX_DEPTH, Mask};
pub use crate::sphere_light::SphereLight;
pub use crate::square::UnitSquare;
pub use crate::visibility::{Blockers, MaskScratch, MaskVisibility, depth_for};
