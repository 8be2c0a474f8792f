//! Pictures with fewer pixels.

use crate::{EditError, Image, ImageStats, LayerSet, LightHandle, Listener, RenderError, Renderer, Sink};
use pictures::Window;
#[cfg(feature = "gpu")]
use {
    crate::{Backend, GpuImage, Layers, error::NO_GPU},
    core::ops::ControlFlow,
};

impl Renderer {
    /// Renders the whole picture with fewer pixels: each side is divided by `divisor` and rounded up. The data that is kept for the
    /// whole picture stays, and the reduced one keeps its own: both can be rendered in turn.
    ///
    /// ```
    /// # use renderer::{Renderer, Settings};
    /// # let mut scene = scene::builtin();
    /// (scene.width, scene.height) = (70, 40);
    /// let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
    /// let coarse = renderer.render_reduced(4, &mut |_| core::ops::ControlFlow::Continue(()))?;
    /// assert_eq!((coarse.size, renderer.render()?.size), ([18, 10], [70, 40]));
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_reduced(&mut self, divisor: u32, listener: &mut Listener<'_>) -> Result<Image, RenderError> {
        let own = self.reduced(divisor);
        let window = Window::whole(own.renderer.scene.width as usize, own.renderer.scene.height as usize);
        own.renderer.render_window(&window, listener)
    }

    /// The part of one light in the picture of [`render_reduced`](Self::render_reduced): the parts of all lights, emission and the
    /// background are the picture, but for rounding and, under eight lights and more, within the tolerance. For programs that move one light
    /// and keep the sum of all else. The light of an environment in one of its patches is that of this patch.
    ///
    /// ```
    /// # use renderer::{Renderer, Settings};
    /// # let mut scene = scene::builtin();
    /// (scene.width, scene.height) = (64, 36);
    /// let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
    /// let whole = renderer.render()?.radiance;
    /// let lights: Vec<_> = renderer.lights().map(|(light, _)| light).collect();
    /// let mut go_on = |_: renderer::Event<'_>| core::ops::ControlFlow::Continue(());
    /// let [first, second] = [lights[0], lights[1]].map(|light| renderer.render_light(1, light, &mut go_on));
    /// let (first, second) = (first?.radiance, second?.radiance);
    /// let floor = 30 * 64 + 32;
    /// assert!((first[floor] + second[floor] - whole[floor]).abs().max_element() < 1e-5 * whole[floor].max_element());
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Cost
    /// That of a picture under this light alone.
    ///
    /// # Errors
    /// [`RenderError::Edit`] if the light is not in the scene; `RenderError::NotOnGpu` with a custom strategy on a GPU; those of
    /// [`render_reduced`](Self::render_reduced).
    pub fn render_light(
        &mut self,
        divisor: u32,
        light: LightHandle,
        listener: &mut Listener<'_>,
    ) -> Result<Image, RenderError> {
        let place = self.light_handles.place(light.0).ok_or(EditError::NoLight(light))?;
        // A strategy of the caller's may know lights by their numbers.
        let is_alone = self.custom.0.is_empty();
        let own = LayerSet { lights: !is_alone, ..LayerSet::NONE };
        let layers = core::mem::replace(&mut self.settings.layers, own);
        self.alone = is_alone.then_some(place);
        let made = self.render_reduced(divisor, listener);
        (self.alone, self.settings.layers) = (None, layers);
        made.map(|mut image| {
            let parts = core::mem::take(&mut image.layers).lights;
            if let Some(part) = parts.into_iter().nth(place) {
                image.radiance = part;
            }
            image
        })
    }

    /// As [`render_reduced`](Self::render_reduced), but the picture stays on the GPU: no pixel comes to the CPU, and visible points that are
    /// the last picture's are not uploaded again. The sums of pixels are rounded otherwise than on the CPU.
    ///
    /// The call returns once all points are shaded. Pixels are there for all that is submitted to the [GPU](Backend::gpu)'s queue later.
    ///
    /// # Errors
    /// [`RenderError`]; [`RenderError::NotOnGpu`] if the renderer's device is the CPU. [`GpuError::Limits`](render_gpu::GpuError::Limits) for
    /// more points than a buffer of the GPU holds, which [`render_reduced`](Self::render_reduced) shades in parts.
    #[cfg(feature = "gpu")]
    pub fn render_on_gpu(&mut self, divisor: u32, listener: &mut Listener<'_>) -> Result<GpuImage, RenderError> {
        let own = self.reduced(divisor);
        let renderer = &mut *own.renderer;
        let size = [renderer.scene.width, renderer.scene.height];
        let Backend::Gpu(gpu) = &mut renderer.backend else { return Err(RenderError::NotOnGpu(NO_GPU)) };
        renderer.canvas.target = Some(gpu.picture(size)?);
        let window = Window::whole(size[0] as usize, size[1] as usize);
        let mut layers = Layers::default();
        let done = renderer.render_bands(&window, listener, &mut |band| {
            layers.append(&band.layers);
            ControlFlow::Continue(())
        });
        let picture = renderer.canvas.target.take().ok_or(RenderError::NotOnGpu(NO_GPU))?;
        Ok(GpuImage { picture, layers, stats: done? })
    }

    /// Renders parts of the whole picture with fewer pixels, as [`render_parts`](Self::render_parts) does: windows of the picture of
    /// [`render_reduced`](Self::render_reduced).
    ///
    /// # Errors
    /// Those of [`render_parts`](Self::render_parts).
    pub fn render_reduced_parts(
        &mut self,
        divisor: u32,
        parts: &[Window],
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        self.reduced(divisor).renderer.render_parts(parts, listener, sink)
    }

    /// As [`render_reduced_parts`](Self::render_reduced_parts), as [`render_parts_async`](Self::render_parts_async).
    ///
    /// # Errors
    /// Those of [`render_parts`](Self::render_parts).
    pub async fn render_reduced_parts_async(
        &mut self,
        divisor: u32,
        parts: &[Window],
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        self.reduced(divisor).renderer.render_parts_async(parts, listener, sink).await
    }

    /// The renderer with fewer pixels; the data that is kept for the whole picture stays.
    fn reduced(&mut self, divisor: u32) -> Reduced<'_> {
        let whole = [self.scene.width, self.scene.height];
        if divisor > 1 {
            [self.scene.width, self.scene.height] = whole.map(|side| side.div_ceil(divisor));
            core::mem::swap(&mut self.kept, &mut self.reduced);
        }
        Reduced { renderer: self, whole: (divisor > 1).then_some(whole) }
    }
}

/// A renderer that has fewer pixels for a while.
struct Reduced<'a> {
    renderer: &'a mut Renderer,
    /// Width and height of the whole picture, if it has others now.
    whole: Option<[u32; 2]>,
}

impl Drop for Reduced<'_> {
    fn drop(&mut self) {
        let Some(whole) = self.whole else { return };
        core::mem::swap(&mut self.renderer.kept, &mut self.renderer.reduced);
        [self.renderer.scene.width, self.renderer.scene.height] = whole;
    }
}
