//! The parts that all visibility strategies share: the unit square in front of a light, the mask on it, and visible fractions of
//! lobes.
//!
//! The [`UnitSquare`] faces the light's cone; blockers are rasterised on it into a [`Mask`], a complete quad-tree as bits.
//! [`MaskVisibility`] turns any [`Blockers`] into visible fractions of lobes, [`MaskLobes`] into lobes. [`Mixture`] draws two kinds of blockers into one mask; [`Contour`] fills a mask by testing whether directions are
//! blocked.
//!
//! Functions for eight rows or edges at once are meant for this workspace's strategies: they are hidden, since their signatures
//! have types of another crate.
//!
//! Out of scope: the blockers themselves (the other `visibility-*` crates), lights, scenes, images.
//!
//! ```
//! use glam::Vec3;
//! use lobe_core::*;
//! use shading::*;
//! use visibility_mask::{Blockers, Mask, MaskVisibility};
//!
//! /// Hides everything to the left of the light's middle.
//! struct Curtain;
//!
//! impl Blockers for Curtain {
//!     type Scratch = ();
//!     fn scratch(&self) {}
//!     fn select(&self, _: &VisibilityQuery<'_>, _: &mut ()) -> Coverage {
//!         Coverage::Partial
//!     }
//!     fn splat(&self, _: &VisibilityQuery<'_>, _: &mut (), mask: &mut Mask) {
//!         for row in 0..mask.side() {
//!             mask.block_span(row, f32::NEG_INFINITY, 0.0);
//!         }
//!     }
//! }
//!
//! let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
//! let cone = Cone { axis: Vec3::Z, one_minus_cos: 0.01, distance: 5.0 };
//! let lambert = Lobe::new(at.normal, 1.0, Vec3::ONE);
//! let strategy = MaskVisibility::new(Curtain);
//! let mut scratch = strategy.scratch();
//! let mut visit = LightVisibility::alone(&strategy, LightId(0), Accuracy::default(), &mut scratch);
//! let unshadowed = cap_integral(&at, lambert, &cone);
//! let fraction = visit.visible_fraction(&at, &cone, &lambert, unshadowed).x;
//! assert!((fraction - 0.5).abs() < 0.01);
//! ```

mod accuracy;
mod bits;
mod blockers;
mod contour;
mod counts;
mod dyn_blockers;
mod edges;
mod facet;
mod fineness;
#[doc(hidden)]
pub mod hooks;
mod lanes;
mod lit_area;
mod lit_sums;
mod mask;
mod mask_lobes;
mod mixture;
mod moments;
mod near_masks;
mod optional;
mod places;
mod quadtree_cut;
mod raster;
mod row;
pub mod sky;
mod spread;
mod square;
#[cfg(test)]
mod square_tests;
#[cfg(test)]
mod tests;
mod visibility;
mod visible_fraction;
pub mod wgsl;
mod window_masks;

pub use crate::accuracy::{fill_factor, mask_depth};
pub use crate::blockers::Blockers;
pub use crate::contour::Contour;
pub use crate::dyn_blockers::{DynBlockers, DynMixture};
pub use crate::edges::Edges;
pub use crate::facet::facet_coverage;
pub use crate::fineness::Fineness;
pub use crate::lit_area::LitArea;
pub use crate::mask::Mask;
pub use crate::mask_lobes::{MaskLobes, MaskLobesScratch};
pub use crate::mixture::{Mixture, MixtureScratch};
pub use crate::raster::{LitBounds, Raster};
pub use crate::row::{EightRows, MAX_DEPTH};
pub use crate::square::UnitSquare;
pub use crate::visibility::{LookAgain, MaskScratch, MaskVisibility, asks_for_openings};
pub use glam;
