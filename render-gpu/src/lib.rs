//! Shading on the GPU through wgpu: the same lobe sums in WGSL.

mod error;
mod gpu;
mod layout;

pub use self::error::GpuError;
pub use self::gpu::{Gpu, GpuOptions};
pub use self::layout::{GpuReceiver, NO_MATERIAL};
