//! The paper as printed: least-squares lobes, tabulated products, tabulated integrals. The baseline of every comparison.
//!
//! | here | paper |
//! |---|---|
//! | [`product_axis`] | axis of a product, Eq. 19, in closed form |
//! | [`fit_product`] | scale and exponent of a product, Eq. 20 |
//! | [`ProductTable`] | both tabulated and interpolated, §4.1; [`table_error`] measures it |
//! | [`integral`] | the tabulated integral of one lobe, §4.2 |
//! | [`PaperIntegrator`] | the sum over reflectance and visibility lobes, §5.4 |
//! | [`CapTable`], [`fit_light`], [`fit_occluder`] | lobes of a light, Eq. 30–31, and of an occluder, Eq. 33–35 |
//!
//! The `moments` method needs none of this at run time: see the crate's front page.
//!
//! # Example
//! ```
//! use glam::Vec3;
//! use lobe_core::{Lobe, paper::{ProductTable, Resolution}};
//! // A coarse table, quick to build; `ProductTable::build()` makes the printed one in some seconds.
//! let table = ProductTable::build_with(Resolution { angles: 9, per_interval: 3 });
//! let lambert = Lobe::new(Vec3::Z, 1.0, Vec3::ONE);
//! let gloss = Lobe::new(Vec3::Z, 10.0, Vec3::ONE);
//! let product = table.product(&lambert, &gloss);
//! assert!((product.exponent - 11.0).abs() < 0.1 && (product.scale().x - 1.0).abs() < 0.01);
//! ```

mod axis;
mod cap_table;
mod fit;
mod integral;
mod integrator;
mod meridian;
mod product_table;
mod profile;
mod resolution;
mod table_bytes;
mod table_error;
mod tables;

pub use self::axis::product_axis;
pub use self::cap_table::{CapTable, LightLobe, fit_light, fit_occluder};
pub use self::fit::{ProductFit, fit_product};
pub use self::integral::integral;
pub use self::integrator::PaperIntegrator;
pub use self::product_table::{ProductTable, TableRow};
pub use self::resolution::Resolution;
pub use self::table_bytes::TableFormatError;
pub use self::table_error::{Population, TableError, table_error};
pub use self::tables::Tables;
