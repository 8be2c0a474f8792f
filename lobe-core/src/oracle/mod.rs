//! Truth in f64 by quadrature: what the closed forms of this workspace are tested against (feature `oracle`).
//!
//! - [`lobe_integral`], [`product`] and [`ln_product`]: one lobe and two lobes over the sphere;
//! - [`cap`]: a lobe over a uniform disc of light that the receiver's horizon may cut; [`sphere_light_irradiance`]: its
//!   closed Lambert case;
//! - [`CapMicrofacets`]: microfacets of the GGX distribution over a disc of light;
//! - [`brute_force`]: any function over the sphere or a zone of it, slowly and simply, to check the others;
//! - [`Random`]: axes, nearly parallel axes and log-uniform exponents for property tests, from a seed.
//!
//! Nothing here shares code with the kernels that it judges. Not for production use: a value costs microseconds.
//!
//! ```
//! use lobe_core::oracle;
//! // Two Lambert lobes about the same axis: ∫ cos² = 2π/3.
//! let p = oracle::product(1.0, 1.0, 0.0);
//! assert!((p - core::f64::consts::TAU / 3.0).abs() < 1e-12);
//! ```

mod brute_force;
mod cap;
mod gauss;
mod microfacets;
mod product;
mod tanh_sinh;

pub use self::brute_force::{Zone, brute_force};
pub use self::cap::{CapLobe, cap, sphere_light_irradiance};
pub use self::microfacets::CapMicrofacets;
pub use self::product::{ln_product, lobe_integral, meridian, product};
pub use crate::random::Random;
