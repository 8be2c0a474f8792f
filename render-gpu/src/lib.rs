//! Shading on the GPU through wgpu: the same lobe sums in WGSL.
//!
//! - [`Gpu`]: a device, the caller's or the strongest adapter's; [`KernelLog`] lists the kernels that its driver compiles.
//! - [`GpuShader`]: shades points, as `CpuShader` does; materials, lights and custom blockers come by the parts of
//!   [`shading::gpu`].
//! - [`Occlusion`]: the blockers: spheres, shadow maps, and any [`GpuBlockers`](shading::gpu::GpuBlockers); [`GpuWorld`]: the
//!   scene that their rays meet.
//! - [`GpuGBuffer`]: visible points found on the GPU; [`GpuPose`]: spheres that follow bones; [`GpuTextureWriter`]: radiance to a
//!   texture.
//! - [`GpuPicture`]: a picture that stays on the device, [shaded](GpuShader::shade_picture) from points of the CPU; [`GpuDisplay`]: the
//!   same for a screen.
//!
//! ```no_run
//! use shading::Accuracy;
//! use render_gpu::{Gpu, GpuOptions, GpuShader, Occlusion};
//! use scene::{Frame, Shade, ShadingPoints};
//! let gpu = Gpu::blocking(&GpuOptions::default())?;
//! let frame: Frame<'_> = Frame::new(&[], &[], Accuracy::default());
//! GpuShader::new(&gpu, Occlusion::default())?.shade(&ShadingPoints::default(), &frame, &mut [])?;
//! # Ok::<(), render_gpu::GpuError>(())
//! ```

pub use wgpu;

mod binding;
mod bvh;
mod clock;
mod error;
mod gbuffer;
mod gpu;
mod images;
#[cfg(test)]
mod inlined;
mod kernel;
mod kernels;
mod layout;
mod log;
mod mail;
mod memory;
mod module;
mod occlusion;
mod paper;
mod picture;
mod pipeline;
mod pose;
mod resident;
mod scopes;
mod screen;
mod shader;
mod sky;
mod texture_writer;
#[cfg(test)]
mod validated;
pub mod wgsl;

pub use self::bvh::{GpuWorld, ShadowCasting};
pub use self::error::GpuError;
pub use self::gbuffer::{GpuGBuffer, GpuPoints, TILE};
pub use self::gpu::{Gpu, GpuOptions};
pub use self::layout::{GpuReceiver, NO_MATERIAL};
pub use self::log::{CompiledKernel, KernelLog};
pub use self::occlusion::Occlusion;
pub use self::picture::GpuPicture;
pub use self::pose::GpuPose;
pub use self::resident::PixelMeans;
pub use self::screen::GpuDisplay;
pub use self::shader::GpuShader;
pub use self::sky::GpuSky;
pub use self::texture_writer::GpuTextureWriter;
pub use glam;
