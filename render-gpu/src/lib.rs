//! Shading on the GPU through wgpu: the same lobe sums in WGSL.

mod error;
mod gpu;

pub use self::error::GpuError;
pub use self::gpu::{Gpu, GpuOptions};
