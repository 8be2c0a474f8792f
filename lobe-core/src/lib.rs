//! The algebra of cosine lobes `s·max(a·v, 0)^e`: what the whole workspace computes with.
//!
//! - [`Lobe`]; [`BrdfLobe`], which is one or a lobe of [`Microfacets`]; sums of lobes as structure-of-arrays views over the caller's storage ([`Lobes`], [`LobeWriter`],
//!   [`LobeBuffer`]);
//! - closed integrals: one lobe, the product of two ([`product_integral`]), a lobe over a uniform disc of light ([`cap_integral`]);
//! - the moment lobe of a cone, which keeps its total and mean vector exactly ([`cone_lobe`]);
//! - the outlines and images of lights, and lobes over them ([`Outline`], [`light_integral`]);
//! - all of it for tiles of receivers, in columns ([`Tile`], [`cap_integrals`]).
//!
//! The contracts of materials, lights and visibility, and the sum over them, are the crate `shading`.
//!
//! # Conventions
//! Right-handed world space, f32, linear RGB. Directions point *away* from the receiver and have length 1. Angles are in
//! radians, solid angles in steradians. `max(a·v, 0)` is what a lobe of exponent `e` is a power of, and a lobe is zero
//! on the far side of its axis.
//!
//! # Scope
//! Out of scope here: visibility, scenes, meshes, images, threads, files. Nothing in this crate allocates per shaded point.
//!
//! # References
//! S. Meunier, R. Perrot, L. Aveneau, D. Meneveaux, D. Ghazanfarpour, *Cosine lobes for interactive direct lighting in
//! dynamic scenes*, Computers & Graphics 34 (2010) 767–778: "the paper" in every comment here; equation numbers are its.

mod brdf_lobe;
mod cap;
mod compact;
mod geometry;
// For the workspace alone: its signatures are another crate's.
mod grain;
#[cfg(test)]
mod grain_tests;
#[doc(hidden)]
pub mod lanes;
mod lobe;
mod lobes;
mod microfacets;
mod moments;
#[cfg(any(test, feature = "oracle"))]
pub mod oracle;
mod outline;
mod packed_lobe;
mod product;
mod random;
mod seen;
mod seen_light;
pub mod special;
#[cfg(test)]
mod tests;
mod tile;
mod tile_lobes;
// For the workspace alone, too.
#[doc(hidden)]
pub mod vec3x8;
mod visibility_sum;
pub mod wgsl;

pub use crate::brdf_lobe::BrdfLobe;
pub use crate::cap::{cap_integral, cap_integrals, sphere_light_irradiance};
pub use crate::compact::compact_runs;
pub use crate::geometry::{Cone, NO_OBJECT, Receiver, SelfShadow, Sphere, orthonormal_basis, scales_evenly};
pub use crate::grain::{BrushedAt, Facets, Grain};
pub use crate::lobe::{Lobe, power};
pub use crate::lobes::{LobeBuffer, LobeWriter, Lobes};
pub use crate::microfacets::{Microfacets, MicrofacetsAt, Schlick};
pub use crate::moments::{cone_lobe, exponent_of_spread};
pub use crate::outline::{
    Capsule, FlatShape, LightImage, Outline, Places, distance_of_segments, fingerprint, image_integral,
    light_image_integral, light_integral, outline_integral,
};
pub use crate::packed_lobe::PackedLobe;
pub use crate::product::{is_lambert, product_integral, product_of_angle, products_of_angle};
pub use crate::random::Random;
pub use crate::seen_light::SeenLight;
pub use crate::tile::{Tile, TileLight, TileRadiance};
pub use crate::tile_lobes::TileLobes;
pub use crate::visibility_sum::{VisibilitySum, visible_fraction};
pub use glam;
