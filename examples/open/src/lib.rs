//! An own material, an own light and own blockers, each on CPU and GPU, in a crate that has nothing but the public interface.
//!
//! `cargo run --release --manifest-path examples/open/Cargo.toml` draws them together, on both devices where there is a GPU.

pub mod capsules;
pub mod scene;
pub mod spot;
pub mod velvet;

pub use crate::capsules::{Capsule, Capsules};
pub use crate::spot::Spot;
pub use crate::velvet::Velvet;
