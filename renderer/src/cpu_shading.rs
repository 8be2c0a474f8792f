//! Shaders of the CPU behind one type.

use crate::event::check;
use crate::{RenderError, Shader};
use brdf::Material;
use core::convert::Infallible;
use glam::Vec3;
use lighting::Light;
use render_cpu::{CpuShader, Layers as PointLayers, ShadeRequest, SkyLighting};
use scene::{Frame, Shade, ShadeStats, ShadingPoints};
use shading::{Integrator, Visibility};
#[cfg(feature = "gpu")]
use {
    crate::error::NO_GPU,
    render_gpu::{GpuPicture, PixelMeans},
};

/// The call that a task makes of a shader.
trait CpuShading {
    fn shade_with(
        &self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
        request: &ShadeRequest<'_>,
    ) -> (ShadeStats, PointLayers);
}

impl<V: Visibility, I: Integrator<V>, K: SkyLighting> CpuShading for CpuShader<V, I, K> {
    fn shade_with(
        &self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
        request: &ShadeRequest<'_>,
    ) -> (ShadeStats, PointLayers) {
        Self::shade_with(self, points, frame, out, request)
    }
}

/// A shader of the CPU for any visibility and method. Each shader is compiled once, in this crate, and not again for each task, nor in each crate
/// that has tasks. A call through it costs nothing beside the points that it shades.
pub(crate) struct AnyCpuShader<'a>(Box<dyn CpuShading + 'a>);

impl<'a> AnyCpuShader<'a> {
    pub(crate) fn new<V, I, K>(shader: CpuShader<V, I, K>) -> Self
    where
        V: Visibility + 'a,
        I: Integrator<V> + 'a,
        K: SkyLighting + 'a,
    {
        Self(Box::new(shader))
    }
}

impl Shade<Material, Light> for AnyCpuShader<'_> {
    type Error = Infallible;

    fn shade(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
    ) -> Result<ShadeStats, Self::Error> {
        Ok(self.0.shade_with(points, frame, out, &ShadeRequest::default()).0)
    }
}

impl Shader for AnyCpuShader<'_> {
    async fn shade_with(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
        request: &ShadeRequest<'_>,
    ) -> Result<(ShadeStats, PointLayers), RenderError> {
        let shaded = self.0.shade_with(points, frame, out, request);
        request.cancel.map_or(Ok(()), check)?;
        Ok(shaded)
    }

    #[cfg(feature = "gpu")]
    async fn shade_picture(
        &mut self,
        _: &ShadingPoints,
        _: &PixelMeans<'_>,
        _: &Frame<'_>,
        _: &GpuPicture,
        _: &ShadeRequest<'_>,
    ) -> Result<ShadeStats, RenderError> {
        Err(RenderError::NotOnGpu(NO_GPU))
    }
}
