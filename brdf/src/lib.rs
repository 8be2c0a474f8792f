//! Reflectance models as sums of cosine lobes: each definition gives lobes of `f̃ = f_r·(n·v)` to the integrators and
//! `eval`, `sample`, `pdf` to a Monte-Carlo reference.
//!
//! | model | `f̃(v)` for `n·v > 0` | lobes |
//! |---|---|---|
//! | [`Lambert`] | `ρ/π·(n·v)` | 1 |
//! | [`Phong`], as the paper prints it (Eq. 23) | `kd·(n·v) + ks·max(r·v, 0)^e` | ≤ 2 |
//! | [`ModifiedPhong`], normalised | `(kd/π + ks·(e+2)/2π·max(r·v, 0)^e)·(n·v)` | ≤ 2 |
//! | [`Lafortune`] (Eqs. 27–29) | `(ρ/π + Σ k·max(v·Mω_o, 0)^e)·(n·v)` | ≤ 1 + number of lobes |
//! | [`MetallicRoughness`] (GGX) | diffuse + `F·D·W` | 3, or ≤ 9 cosine lobes; with a clear coat 5, or ≤ 17 |
//! | [`HalfVector`] | `diffuse/π·(n·v) + Σ F·D·W` | ≤ 1 + 2 a lobe, or 1 + 8 cosine lobes |
//! | [`Neumann`], metals | `(kd/π + ks·(e+2)/2π·max(r·v, 0)^e/max(n·v, n·ω_o))·(n·v)` | ≤ 4 |
//!
//! [`Material`] is one of these, or a [`Model`] of your own. Lobes that reflect nothing are not written.
//!
//! ```
//! use brdf::{Brdf, ModifiedPhong};
//! use glam::Vec3;
//! use lobe_core::{BrdfLobe, Receiver};
//! use shading::BrdfLobes;
//!
//! let gloss = ModifiedPhong { kd: Vec3::splat(0.5), ks: Vec3::splat(0.3), exponent: 60.0 };
//! let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
//! let mut lobes = Vec::new();
//! gloss.brdf_lobes(&at, &mut lobes);
//!
//! let v = Vec3::new(-0.6, 0.0, 0.8); // where a mirror would reflect to
//! let (sum, direct) = (BrdfLobe::sum_at(&lobes, at.normal, v), gloss.eval(&at, v));
//! assert!((sum - direct).length() < 1e-4 * direct.length());
//! ```
//!
//! # Conventions
//! Directions are unit vectors that point away from the surface; `n` and `ω_o` are the receiver's `normal` and `view`,
//! `r = 2(n·ω_o)n − ω_o` mirrors the view. Values are linear RGB, sr⁻¹. All models are zero where `n·v ≤ 0`. Parameters
//! that pass `validate` never give NaN or infinity.
//!
//! # On the GPU
//! [`PackedMaterials`] are materials as words, [`wgsl`] is the code that makes the same lobes of them.
//!
//! # Scope
//! Out of scope here: where textures come from ([`Factors`] are what they do), transmission, emission, interreflection.

mod anisotropy;
#[cfg(test)]
mod anisotropy_tests;
mod clearcoat;
#[cfg(test)]
mod clearcoat_tests;
mod coat;
mod error;
mod factors;
mod fit;
#[cfg(test)]
mod fit_tests;
mod ggx;
#[cfg(test)]
mod ggx_tests;
mod half_vector;
mod lafortune;
mod lafortune_term;
mod lambert;
mod material;
mod material_lobes;
mod merl;
mod metallic_roughness;
mod model;
mod modified_phong;
mod neumann;
mod packed;
mod phong;
mod residual;
mod rows;
mod sampling;
mod shape;
#[cfg(test)]
mod suite;
mod symmetric;
mod term;
mod visible_normals;
pub mod wgsl;

pub use crate::error::MaterialError;
pub use crate::factors::Factors;
pub use crate::fit::{Fitted, MAX_FITTED, fit, fit_half_vector, fit_lafortune};
pub use crate::half_vector::{HalfVector, HalfVectorLobe};
pub use crate::lafortune::{Lafortune, LafortuneLobe};
pub use crate::lambert::Lambert;
pub use crate::material::Material;
pub use crate::merl::Merl;
pub use crate::metallic_roughness::MetallicRoughness;
pub use crate::model::{Brdf, BrdfSample, Model};
pub use crate::modified_phong::ModifiedPhong;
pub use crate::neumann::Neumann;
pub use crate::packed::{PackedMaterials, Packer};
pub use crate::phong::Phong;
pub use crate::residual::{residual, residual_of_cosine_lobes};
pub use glam;
