//! The device that shades: the cores of the CPU, or a GPU.

use crate::{Device, RenderError};
use brdf::Material;
use core::error::Error;
use glam::Vec3;
use lighting::Light;
use render_cpu::{Layers as PointLayers, ShadeRequest};
use scene::{Frame, Shade, ShadeStats, ShadingPoints};

#[cfg(feature = "gpu")]
use {
    crate::error::LAYERS,
    paper::Tables,
    ray_tracing::World,
    render_gpu::{Gpu, GpuError, GpuOptions, GpuPicture, GpuShader, GpuWorld, Occlusion, PixelMeans, ShadowCasting},
    shading::gpu::GpuBlockers,
    visibility_rays::GpuRays,
    visibility_shadowmap::{PackedMaps, ShadowMapBlockers},
    visibility_silhouettes::GpuSilhouettes,
    visibility_spheres::SphereBlockers,
};

/// Bytes of the shadow maps of all lights on a CPU.
const MAPS: u64 = 1 << 30;

/// The device that shades the frames of a [`Renderer`](crate::Renderer).
#[derive(Debug)]
pub enum Backend {
    /// The cores of the CPU.
    Cpu,
    /// A GPU.
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuBackend>),
}

#[cfg(not(feature = "gpu"))]
const NOT_BUILT: &str = "this program was built without its GPU part (feature `gpu`)";

impl Backend {
    /// Opens a device. Not for a browser's GPU, which no call can wait for: see `Backend::on`.
    ///
    /// # Errors
    /// [`RenderError`] if there is none.
    pub fn open(device: Device) -> Result<Self, RenderError> {
        match device {
            Device::Cpu => Ok(Self::Cpu),
            #[cfg(feature = "gpu")]
            Device::Gpu => Self::on(&Gpu::blocking(&GpuOptions::default())?),
            #[cfg(not(feature = "gpu"))]
            Device::Gpu => Err(RenderError::NotOnGpu(NOT_BUILT)),
        }
    }

    /// Shades on an open GPU: one that several renderers use, a window's own, or a browser's, which is opened by
    /// [`Gpu::new`](render_gpu::Gpu::new).
    ///
    /// # Errors
    /// [`RenderError`] if its limits are too small.
    #[cfg(feature = "gpu")]
    pub fn on(gpu: &Gpu) -> Result<Self, RenderError> {
        let shader = GpuShader::new(gpu, Occlusion::default())?;
        Ok(Self::Gpu(Box::new(GpuBackend { shader, world: None, maps: None, followed: 0 })))
    }

    /// The kind of device.
    #[must_use]
    pub const fn device(&self) -> Device {
        match self {
            Self::Cpu => Device::Cpu,
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => Device::Gpu,
        }
    }

    /// The GPU, if it is one.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn gpu(&self) -> Option<&Gpu> {
        match self {
            Self::Cpu => None,
            Self::Gpu(gpu) => Some(gpu.shader.gpu()),
        }
    }

    /// The most bytes of shadow maps of all lights: a gigabyte, or what the device can use.
    #[must_use]
    pub fn room_for_maps(&self) -> u64 {
        match self {
            Self::Cpu => MAPS,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.shader.gpu().room_for_pages(),
        }
    }

    /// How often the hierarchy of the GPU's rays was built or updated.
    pub(crate) const fn worlds_followed(&self) -> u64 {
        match self {
            Self::Cpu => 0,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.followed,
        }
    }

    /// `cpu`, or the GPU's own name.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Cpu => "cpu".to_owned(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.shader.gpu().name(),
        }
    }
}

/// A GPU's shader, and the scene that its rays meet.
#[cfg(feature = "gpu")]
#[derive(Debug)]
pub struct GpuBackend {
    shader: GpuShader,
    world: Option<RayWorld>,
    /// The shadow maps that are on the GPU.
    maps: Option<PackedMaps>,
    /// How often `world` was built or updated.
    followed: u64,
}

/// The scene that the GPU's rays meet.
#[cfg(feature = "gpu")]
#[derive(Debug)]
struct RayWorld {
    world: GpuWorld,
    /// For each object the rays that it stops.
    casting: Vec<ShadowCasting>,
    /// Revision of the hierarchy of the CPU that `world` follows.
    revision: u64,
}

/// The built-in strategies that block, except rays.
#[cfg(feature = "gpu")]
pub(crate) struct GpuParts<'a> {
    pub(crate) spheres: Option<&'a SphereBlockers>,
    pub(crate) maps: Option<&'a ShadowMapBlockers>,
    pub(crate) silhouettes: Option<&'a GpuSilhouettes>,
}

#[cfg(feature = "gpu")]
impl GpuBackend {
    /// A picture of this size that stays on the device.
    pub(crate) fn picture(&mut self, size: [u32; 2]) -> Result<GpuPicture, GpuError> {
        self.shader.picture(size)
    }

    /// The shader with these blockers. `traced` is the scene and, for each object, the rays that it stops; `None` if no object
    /// stops rays. These objects block by `parts.silhouettes`, or else by rays.
    pub(crate) fn occluded(
        &mut self,
        tables: Option<&Tables>,
        parts: &GpuParts<'_>,
        traced: Option<(&World<'_>, Vec<ShadowCasting>)>,
        custom: &[&dyn GpuBlockers],
    ) -> Result<&mut GpuShader, GpuError> {
        let GpuParts { spheres, maps, silhouettes } = *parts;
        match traced {
            Some((world, casting)) => self.follow(world, casting)?,
            None => self.world = None,
        }
        self.shader.set_paper(tables);
        let any_hit = self.world.as_ref().map(|of| &of.world);
        let silhouettes = silhouettes.map(|silhouettes| silhouettes as &dyn GpuBlockers);
        let traced = silhouettes.or_else(|| any_hit.map(|_| &GpuRays as &dyn GpuBlockers));
        if let Some(maps) = maps {
            // Packs and uploads only maps that have changed.
            self.maps.get_or_insert_default().update(maps);
        } else {
            self.maps = None;
        }
        let spheres = spheres.map(|spheres| spheres as &dyn GpuBlockers);
        let maps = self.maps.as_ref().map(|maps| maps as &dyn GpuBlockers);
        let blockers: Vec<&dyn GpuBlockers> =
            [spheres, maps, traced].into_iter().flatten().chain(custom.iter().copied()).collect();
        self.shader.occlude(Occlusion { blockers: &blockers, any_hit })?;
        Ok(&mut self.shader)
    }

    /// Updates the scene that rays meet, if anything has moved.
    fn follow(&mut self, world: &World<'_>, casting: Vec<ShadowCasting>) -> Result<(), GpuError> {
        let revision = world.revision();
        match &mut self.world {
            // The list changes as lights move, since it depends on which objects the maps draw.
            Some(kept) if kept.casting == casting => {
                if kept.revision == revision {
                    return Ok(());
                }
                kept.world.update(world.scene())?;
                kept.revision = revision;
            }
            kept => {
                let made = GpuWorld::with_casting(self.shader.gpu(), world.scene(), |o| casting[o as usize])?;
                *kept = Some(RayWorld { world: made, casting, revision });
            }
        }
        self.followed += 1;
        Ok(())
    }
}

/// A shader for any device.
pub trait Shader: Shade<Material, Light, Error: Error + Into<RenderError>> {
    /// Shades with the requested layers until a stop is requested. The future is ready at its first poll, except on a browser's GPU.
    ///
    /// # Errors
    /// As [`Shade::shade`]; [`RenderError::NotOnGpu`] for layers on a GPU; [`RenderError::Cancelled`].
    fn shade_with(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
        request: &ShadeRequest<'_>,
    ) -> impl Future<Output = Result<(ShadeStats, PointLayers), RenderError>>;

    /// Shades points into the pixels of a picture that stays on the GPU, until a stop is requested.
    ///
    /// # Errors
    /// As [`shade_with`](Self::shade_with); [`RenderError::NotOnGpu`] on the CPU.
    #[cfg(feature = "gpu")]
    fn shade_picture(
        &mut self,
        points: &ShadingPoints,
        means: &PixelMeans<'_>,
        frame: &Frame<'_>,
        picture: &GpuPicture,
        request: &ShadeRequest<'_>,
    ) -> impl Future<Output = Result<ShadeStats, RenderError>>;
}

/// Refuses layers, which a GPU does not have.
#[cfg(feature = "gpu")]
const fn has_no_layers(request: &ShadeRequest<'_>) -> Result<(), RenderError> {
    if request.unshadowed || request.lights || request.counts {
        return Err(RenderError::NotOnGpu(LAYERS));
    }
    Ok(())
}

#[cfg(feature = "gpu")]
impl Shader for GpuShader {
    async fn shade_with(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
        request: &ShadeRequest<'_>,
    ) -> Result<(ShadeStats, PointLayers), RenderError> {
        has_no_layers(request)?;
        let stats = self.shade_async(points, frame, out, request.cancel).await?.ok_or(RenderError::Cancelled)?;
        Ok((stats, PointLayers::default()))
    }

    async fn shade_picture(
        &mut self,
        points: &ShadingPoints,
        means: &PixelMeans<'_>,
        frame: &Frame<'_>,
        picture: &GpuPicture,
        request: &ShadeRequest<'_>,
    ) -> Result<ShadeStats, RenderError> {
        has_no_layers(request)?;
        let stats = GpuShader::shade_picture(self, points, means, frame, picture, request.cancel).await?;
        stats.ok_or(RenderError::Cancelled)
    }
}
