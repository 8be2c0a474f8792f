use crate::bands::{Bands, seconds};
use crate::event::tell;
use crate::{Event, FrameClocks, LayerSet, Layers, Listener, RenderError, Shader, ShaderTask};
use core::ops::ControlFlow;
use glam::Vec3;
use pictures::Window;
use render_cpu::GBuffer;
#[cfg(feature = "gpu")]
use render_cpu::Layers as PointLayers;
use scene::{Frame, ShadeStats, ShadingPoints};
use shading::Accuracy;
#[cfg(feature = "gpu")]
use {
    crate::kept_points::Found,
    render_gpu::{GpuPicture, PixelMeans},
};

/// A picture, or a window of one, row by row from the top, with its statistics.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear radiance toward the eye, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec<Vec3>,
    /// The requested layers.
    pub layers: Layers,
    /// Statistics of the rendering.
    pub stats: ImageStats,
}

/// Statistics of the rendering of a picture.
#[derive(Clone, Debug, Default)]
pub struct ImageStats {
    /// Requested error and depth of masks.
    pub accuracy: Accuracy,
    /// Visible points.
    pub points: usize,
    /// Statistics of each repetition of the shading.
    pub shading: Vec<ShadeStats>,
    /// Seconds of the frame outside shading.
    pub clocks: FrameClocks,
    /// Seconds of compiling kernels.
    pub kernels: f64,
    /// Blocker spheres.
    pub spheres: usize,
    /// Triangles.
    pub triangles: usize,
    /// Resolution of each light's shadow map.
    pub map_resolutions: Vec<u32>,
    /// Bytes of all shadow maps.
    pub map_bytes: usize,
}

/// A finished part of a picture.
#[derive(Clone, Debug, Default)]
pub struct Band {
    /// The part's window.
    pub window: Window,
    /// As [`Image::radiance`].
    pub radiance: Vec<Vec3>,
    /// As [`Image::layers`].
    pub layers: Layers,
}

/// Receives parts of a picture as they are done, and may stop the work. Their memory is used again for the next part.
pub type Sink<'a> = dyn FnMut(&Band) -> ControlFlow<()> + 'a;

impl Band {
    /// Copies the radiance to its place in the pixels of a larger window.
    ///
    /// # Panics
    /// If that window does not contain this part, or `pixels` has not one value a pixel.
    pub fn copy_to(&self, window: &Window, pixels: &mut [Vec3]) {
        assert_eq!(pixels.len(), window.pixels(), "one value a pixel");
        let width = self.window.columns.len();
        let left = self.window.columns.start - window.columns.start;
        for (row, line) in self.window.rows.clone().zip(self.radiance.chunks_exact(width.max(1))) {
            let first = (row - window.rows.start) * window.columns.len() + left;
            pixels[first..first + width].copy_from_slice(line);
        }
    }
}

/// A picture that stays on the GPU which made it.
#[cfg(feature = "gpu")]
#[derive(Debug)]
pub struct GpuImage {
    /// Its pixels: as [`Image::radiance`], to rounding.
    pub picture: GpuPicture,
    /// The requested layers, on the CPU.
    pub layers: Layers,
    /// Statistics of the rendering.
    pub stats: ImageStats,
}

/// Memory of a part of a picture, used again for the next part.
#[derive(Debug, Default)]
pub(crate) struct Canvas {
    band: Band,
    /// Radiance of its points.
    radiance: Vec<Vec3>,
    /// The picture on the GPU, where it is to stay there: bands have no radiance then.
    #[cfg(feature = "gpu")]
    pub(crate) target: Option<GpuPicture>,
}

/// Shades a picture band by band with the chosen strategy.
pub(crate) struct Shading<'a, 'w, 'l, 's> {
    pub(crate) frame: &'a Frame<'a>,
    pub(crate) bands: &'a mut Bands<'w>,
    pub(crate) canvas: &'a mut Canvas,
    pub(crate) repeat: u32,
    pub(crate) layers: LayerSet,
    /// Whether emission and background are left out.
    pub(crate) is_part: bool,
    pub(crate) listener: &'a mut Listener<'l>,
    pub(crate) sink: &'a mut Sink<'s>,
}

impl ShaderTask for Shading<'_, '_, '_, '_> {
    type Output = ImageStats;

    async fn with<S: Shader>(mut self, shader: &mut S) -> Result<ImageStats, RenderError> {
        let shading = vec![ShadeStats::default(); self.repeat as usize];
        let mut stats = ImageStats { shading, ..ImageStats::default() };
        // Compiles the kernels that are missing.
        seconds(&mut stats.kernels, || shader.shade(&ShadingPoints::default(), self.frame, &mut []))
            .map_err(|error: S::Error| -> RenderError { error.into() })?;
        let windows = self.bands.windows();
        let of = windows.iter().map(|window| window.pixels() as u64).sum();
        let mut done = 0;
        for window in windows {
            tell(self.listener, Event::Pixels { done, of })?;
            let g = self.bands.points(&window)?;
            #[cfg(feature = "gpu")]
            let shaded = match self.canvas.target.is_some() {
                true => self.shade_on_gpu(shader, &g, &window, &mut stats).await,
                false => self.shade(shader, &g.points, &mut stats).await,
            };
            #[cfg(not(feature = "gpu"))]
            let shaded = self.shade(shader, &g.points, &mut stats).await;
            stats.points += g.points.len();
            // Keeps the points of a cancelled band too: they are right, and likely to be needed again.
            self.bands.keep(&window, g);
            shaded?;
            done += window.pixels() as u64;
            self.canvas.band.window = window;
            if (self.sink)(&self.canvas.band).is_break() {
                break;
            }
        }
        Ok(stats)
    }
}

impl Shading<'_, '_, '_, '_> {
    /// Shades the points of a band into its memory.
    async fn shade<S: Shader>(
        &mut self,
        shader: &mut S,
        g: &GBuffer,
        stats: &mut ImageStats,
    ) -> Result<(), RenderError> {
        let background = self.bands.world.scene().background;
        let frame = &Frame { materials: &g.materials, ..*self.frame };
        let Canvas { band, radiance, .. } = &mut *self.canvas;
        radiance.clear();
        radiance.resize(g.len(), Vec3::ZERO);
        let request = self.layers.request(self.bands.cancel);
        for (repetition, total) in stats.shading.iter_mut().enumerate() {
            let (once, points) = shader.shade_with(&g.points, frame, radiance, &request).await?;
            *total += once;
            if repetition == 0 {
                band.layers = Layers::new(g, points, &self.layers, frame.lights.len(), background);
            }
        }
        band.radiance.resize(g.width as usize * g.height as usize, Vec3::ZERO);
        if self.is_part {
            g.resolve_into(radiance, Vec3::ZERO, &mut band.radiance);
        } else {
            g.add_emission(radiance);
            g.picture_into(radiance, background, &mut band.radiance);
        }
        Ok(())
    }

    /// Shades the points of a band into its place in the picture on the GPU.
    #[cfg(feature = "gpu")]
    async fn shade_on_gpu<S: Shader>(
        &mut self,
        shader: &mut S,
        found: &Found,
        window: &Window,
        stats: &mut ImageStats,
    ) -> Result<(), RenderError> {
        let background = self.bands.world.scene().background;
        let g = &found.points;
        let frame = &Frame { materials: &g.materials, ..*self.frame };
        let Canvas { band, target: Some(picture), .. } = &mut *self.canvas else { return Ok(()) };
        let rest = rest_of(g, background);
        let means = PixelMeans {
            stamp: found.stamp,
            corner: [window.columns.start, window.rows.start].map(|side| side as u32),
            size: [g.width, g.height],
            pixels: &g.pixels,
            rays: &g.rays,
            samples: g.samples,
            rest: &rest,
        };
        let request = self.layers.request(self.bands.cancel);
        for total in &mut stats.shading {
            *total += shader.shade_picture(&g.points, &means, frame, picture, &request).await?;
        }
        band.radiance.clear();
        band.layers = Layers::new(g, PointLayers::default(), &self.layers, frame.lights.len(), background);
        Ok(())
    }
}

/// The radiance of each pixel besides that of lit points; empty where there is none.
#[cfg(feature = "gpu")]
fn rest_of(g: &GBuffer, background: Vec3) -> Vec<Vec3> {
    let mut emission = Vec::new();
    if g.emission.is_empty() {
        if g.sky.is_empty() && background == Vec3::ZERO {
            return Vec::new();
        }
        emission = vec![Vec3::ZERO; g.len()];
    }
    g.picture(if emission.is_empty() { &g.emission } else { &emission }, background)
}
