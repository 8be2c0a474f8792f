//! The method of the paper as printed: least-squares lobes, tabulated products and integrals, shadow nodes as visibility lobes. The
//! baseline of every comparison.
//!
//! | here | paper |
//! |---|---|
//! | [`product_axis`] | axis of a product, Eq. 19, in closed form |
//! | [`fit_product`] | scale and exponent of a product, Eq. 20 |
//! | [`ProductTable`] | both tabulated and interpolated, §4.1; [`table_error`] measures it |
//! | [`integral`] | the tabulated integral of one lobe, §4.2 |
//! | [`CapTable`], [`fit_light`], [`fit_occluder`] | lobes of a light, Eq. 30–31, and of an occluder, Eq. 33–35 |
//! | [`PaperVisibility`] | shadow nodes of the quad-tree (Fig. 9) as lobes, §5.3, for any blockers |
//! | [`PaperWeights`] | their weights by level and distance, Eq. 38 |
//! | [`PaperIntegrator`] | the sum over reflectance and visibility lobes, §5.4 |
//! | [`wgsl`] | the same on a GPU |
//!
//! It stands beside the default method and behind the same contracts: [`PaperIntegrator`] is an
//! [`Integrator`](shading::Integrator), [`PaperVisibility`] a [`VisibilityLobes`](shading::VisibilityLobes). No other method
//! needs this crate.
//!
//! # Example
//! ```
//! use glam::Vec3;
//! use lobe_core::Lobe;
//! use paper::{ProductTable, Resolution};
//! // A coarse table, quick to build; `ProductTable::build()` makes the printed one in some seconds.
//! let table = ProductTable::build_with(Resolution { angles: 9, per_interval: 3 });
//! let lambert = Lobe::new(Vec3::Z, 1.0, Vec3::ONE);
//! let gloss = Lobe::new(Vec3::Z, 10.0, Vec3::ONE);
//! let product = table.product(&lambert, &gloss);
//! assert!((product.exponent - 11.0).abs() < 0.1 && (product.scale().x - 1.0).abs() < 0.01);
//! ```
//!
//! # References
//! S. Meunier, R. Perrot, L. Aveneau, D. Meneveaux, D. Ghazanfarpour, *Cosine lobes for interactive direct lighting in dynamic scenes*,
//! Computers & Graphics 34 (2010) 767–778. Equation numbers are its.

mod axis;
mod cap_table;
mod fit;
mod integral;
mod integrator;
mod meridian;
mod product_table;
mod profile;
mod resolution;
mod shadow_tree;
mod table_bytes;
mod table_error;
mod tables;
mod visibility;
mod weights;
pub mod wgsl;

pub use crate::axis::product_axis;
pub use crate::cap_table::{CapTable, LightLobe, fit_light, fit_occluder};
pub use crate::fit::{ProductFit, fit_product};
pub use crate::integral::integral;
pub use crate::integrator::PaperIntegrator;
pub use crate::product_table::{ProductTable, TableRow};
pub use crate::resolution::Resolution;
pub use crate::shadow_tree::ShadowNode;
pub use crate::table_bytes::TableFormatError;
pub use crate::table_error::{Population, TableError, table_error};
pub use crate::tables::Tables;
pub use crate::visibility::{PaperScratch, PaperVisibility};
pub use crate::weights::PaperWeights;
pub use glam;
