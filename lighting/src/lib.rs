//! Sphere lights, and what every visibility strategy shares: the unit square, the mask and the cut.
//!
//! A light is seen from a receiver as a cone ([`SphereLight`]). The [`UnitSquare`] faces it; blockers are rasterised on
//! the square into a [`Mask`], a complete quad-tree as bits. [`MaskVisibility`] turns any [`Blockers`] into lobes;
//! [`PaperVisibility`] does it as the paper does.
//!
//! Out of scope: what blocks (the `visibility-*` crates), scenes, images.

mod contour;
mod cut;
mod edges;
mod facet;
mod fineness;
#[doc(hidden)]
pub mod hooks;
mod lanes;
mod mask;
mod mixture;
mod node;
mod optional;
mod panes;
mod paper_visibility;
mod paper_weights;
mod raster;
mod row;
mod shadow_tree;
mod share;
mod sphere_light;
mod square;
#[cfg(test)]
mod square_tests;
#[cfg(test)]
mod tests;
mod visibility;
pub mod wgsl;

pub use crate::contour::Contour;
pub use crate::edges::Edges;
pub use crate::facet::facet_coverage;
pub use crate::fineness::Fineness;
pub use crate::mask::{MAX_DEPTH, Mask};
pub use crate::mixture::{Mixture, MixtureScratch};
pub use crate::paper_visibility::{PaperScratch, PaperVisibility};
pub use crate::paper_weights::PaperWeights;
pub use crate::raster::{LitBounds, Raster};
pub use crate::row::EightRows;
pub use crate::sphere_light::SphereLight;
pub use crate::square::UnitSquare;
pub use crate::visibility::{Blockers, MaskScratch, MaskVisibility};
