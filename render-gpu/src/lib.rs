//! Shading on the GPU through wgpu: the same lobe sums in WGSL.

mod bvh;
mod canvas;
mod clock;
mod error;
mod gbuffer;
mod gpu;
mod kernel;
mod kernels;
mod layout;
mod log;
mod memory;
mod module;
mod occlusion;
mod paper;
mod pose;
mod shader;
pub mod wgsl;

pub use self::bvh::GpuWorld;
pub use self::canvas::GpuCanvas;
pub use self::error::GpuError;
pub use self::gbuffer::{GpuGBuffer, GpuPoints, TILE};
pub use self::gpu::{Gpu, GpuOptions};
pub use self::layout::{GpuReceiver, NO_MATERIAL};
pub use self::log::{CompiledKernel, KernelLog};
pub use self::occlusion::Occlusion;
pub use self::pose::GpuPose;
pub use self::shader::GpuShader;
