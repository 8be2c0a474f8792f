//! The contracts of reflectance, light and visibility, and the integrators that put them together. No files, no pictures, no graphics
//! library: all that it takes to shade one point or a tile of points. Scenes stand above.
//!
//! | contract | gives |
//! |---|---|
//! | [`BrdfLobes`] | the reflectance lobes of a receiver |
//! | [`LightLobes`] | the light as a receiver sees it |
//! | [`Visibility`] | coverage, and the visible fraction of one lobe |
//! | [`VisibilityLobes`] | visibility as a sum of lobes |
//! | [`Integrator`] | a method: [`FractionIntegrator`] (default), [`LobeIntegrator`], or one of your own |
//! | [`gpu`] | the parts that each of them brings to a GPU |
//! | [`Shade`] | the radiance of many points ([`ShadingPoints`]) for the materials and lights of a [`Frame`], on either device |
//!
//! # The sum
//! [`FractionIntegrator`] computes
//!
//! ```text
//! radiance = Σ lights Σ reflectance lobes  flux · light's radiance · ∫ lobe over the light · visible fraction
//! ```
//!
//! for one receiver, and for a tile of receivers in columns, with the same results to the bit.
//!
//! # Conventions
//! Those of [`lobe_core`]: right-handed world space, f32, linear RGB, unit directions away from the receiver. Nothing in this crate allocates
//! per shaded point.
//!
//! # Example
//! ```
//! use glam::Vec3;
//! use lobe_core::{Cone, Lobe, Receiver, SeenLight, Sphere};
//! use shading::{Accuracy, FractionIntegrator, Integrator, Interaction, LightId, LightVisibility, Unshadowed};
//!
//! let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
//! let cone = Cone::of_sphere(at.position, Sphere { center: Vec3::new(0.0, 0.0, 5.0), radius: 1.0 });
//! let light = SeenLight::of_cone(cone, Vec3::splat(3.0));
//! let brdf = [Lobe::new(at.normal, 1.0, Vec3::ONE).into()];
//! let mut scratch = ();
//! let mut visibility = LightVisibility::alone(&Unshadowed, LightId(0), Accuracy::default(), &mut scratch);
//! let point = Interaction { at: &at, brdf: &brdf, light: &light, threshold: 0.0 };
//! let radiance = FractionIntegrator.radiance(&point, &mut visibility, &mut (), &mut ()).radiance;
//! // π · radiance · sin²θ of a disc straight above.
//! assert!((radiance.x - 3.0 * core::f32::consts::PI / 25.0).abs() < 1e-4);
//! ```

mod accuracy;
mod brdf_lobes;
mod coherence;
mod dyn_visibility;
pub mod gpu;
mod gpu_pages;
mod integrator;
mod light_lobes;
mod shade;
mod shaft;
#[cfg(test)]
mod shaft_tests;
mod tile_blocks;
mod tile_integrator;
mod visibility;

pub use crate::accuracy::Accuracy;
pub use crate::brdf_lobes::BrdfLobes;
pub use crate::coherence::GROUP;
pub use crate::dyn_visibility::{DynScratch, DynVisibility};
pub use crate::integrator::{
    Contribution, FractionIntegrator, Integrator, Interaction, LobeIntegrator, Observer, Stage,
};
pub use crate::light_lobes::LightLobes;
pub use crate::shade::{BlockerSet, Counts, Frame, Shade, ShadeStats, ShadingPoints, StageSeconds};
pub use crate::shaft::{LightExtent, LightId, Shaft};
pub use crate::tile_integrator::{Counted, TileContributions, TileInteraction};
pub use crate::visibility::{
    Coverage, LightCoverage, LightVisibility, Penumbra, Unshadowed, Visibility, VisibilityLobes, VisibilityQuery,
};
pub use glam;
