//! Pictures: whole, in windows, in parts.

use crate::job::{Job, State};
use crate::turn::at_once;
use crate::{
    Backend, Device, FrameClocks, Image, ImageStats, LayerSet, Listener, RenderError, Renderer, Settings, Sink,
};
use core::ops::ControlFlow;
use glam::Vec3;
use pictures::Window;
use render_cpu::World;
use scene::Scene;

impl Renderer {
    /// Renders the whole picture.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render(&mut self) -> Result<Image, RenderError> {
        let window = Window::whole(self.scene.width as usize, self.scene.height as usize);
        self.render_window(&window, &mut |_| ControlFlow::Continue(()))
    }

    /// Prepares everything for the next picture except its points: sphere sets, tables, hierarchies, silhouettes, maps, the
    /// accuracy of a time budget, and on a GPU the compiled kernels. An interactive program calls it before its first picture, and
    /// after edits of settings.
    ///
    /// ```
    /// # let mut scene = scene::builtin();
    /// # (scene.width, scene.height) = (32, 18);
    /// # let mut renderer = renderer::Renderer::new(scene, scene::Animation::default(), renderer::Settings::default())?;
    /// let clocks = renderer.warm_up(&mut |_| core::ops::ControlFlow::Continue(()))?.clocks;
    /// assert!(clocks.hierarchy >= 0.0 && renderer.upkeep().hierarchy_builds == 1);
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn warm_up(&mut self, listener: &mut Listener<'_>) -> Result<ImageStats, RenderError> {
        self.render_parts(&[], listener, &mut |_| ControlFlow::Continue(()))
    }

    /// Renders a window of the picture: its pixels equal those of the whole picture, bit for bit.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_window(&mut self, window: &Window, listener: &mut Listener<'_>) -> Result<Image, RenderError> {
        let mut image = Image { size: window.size(), ..Image::default() };
        // Reserves all memory first: a picture that does not fit is refused here, and growing would take twice the memory.
        image.radiance.try_reserve_exact(window.pixels())?;
        image.stats = self.render_bands(window, listener, &mut |band| {
            image.radiance.extend_from_slice(&band.radiance);
            image.layers.append(&band.layers);
            ControlFlow::Continue(())
        })?;
        Ok(image)
    }

    /// Renders the radiance of a window into the caller's memory, one value a pixel, row by row. Allocates no picture, and from the
    /// second call on no memory of a picture's size.
    ///
    /// # Errors
    /// [`RenderError`]; [`RenderError::Setting`] if `out` has not one value a pixel.
    pub fn render_into(
        &mut self,
        window: &Window,
        listener: &mut Listener<'_>,
        pixels: &mut [Vec3],
    ) -> Result<ImageStats, RenderError> {
        if pixels.len() != window.pixels() {
            let (value, expected) = (format!("of {} pixels", pixels.len()), "one value for each pixel of the window");
            return Err(RenderError::Setting { name: "memory", value, expected });
        }
        self.render_bands(window, listener, &mut |band| {
            band.copy_to(window, pixels);
            ControlFlow::Continue(())
        })
    }

    /// Renders a window in bands of rows, and passes each to `sink` as it is done: pictures of any size in bounded memory. Ends
    /// early if the sink stops it.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_bands(
        &mut self,
        window: &Window,
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        self.render_parts(core::slice::from_ref(window), listener, sink)
    }

    /// Renders parts of the picture, of any size and in any order: their pixels equal those of the whole picture, bit for bit. A
    /// part of more than [`BAND_RAYS`](crate::BAND_RAYS) camera rays comes in several bands of rows.
    ///
    /// Sides that are multiples of 8 cost least, since pixels are found and shaded in tiles of 8 × 8. [`Window::parts`] cuts a
    /// window.
    ///
    /// ```
    /// use core::ops::ControlFlow;
    /// use renderer::{Renderer, Settings, Window, glam::Vec3};
    /// let mut scene = scene::builtin();
    /// (scene.width, scene.height) = (64, 36);
    /// let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
    /// let whole = Window::whole(64, 36);
    /// let mut parts: Vec<Window> = whole.parts([16, 16]).collect();
    /// // From the middle outward.
    /// parts.sort_by_key(|part| part.columns.start.abs_diff(24) + part.rows.start.abs_diff(16));
    /// let mut picture = vec![Vec3::ZERO; 64 * 36];
    /// renderer.render_parts(&parts, &mut |_| ControlFlow::Continue(()), &mut |band| {
    ///     band.copy_to(&whole, &mut picture);
    ///     ControlFlow::Continue(())
    /// })?;
    /// assert_eq!(picture, renderer.render()?.radiance);
    /// # Ok::<(), renderer::RenderError>(())
    /// ```
    ///
    /// # Errors
    /// [`RenderError`]; [`RenderError::Setting`] for a window that is not a part of this picture.
    pub fn render_parts(
        &mut self,
        parts: &[Window],
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        at_once(self.render_parts_async(parts, listener, sink))?
    }

    /// As [`render_parts`](Self::render_parts). On a browser's GPU, which no call can wait for, the future is ready in a later turn;
    /// everywhere else its first poll does all the work. A future that is dropped leaves the renderer as a cancelled picture does.
    ///
    /// # Errors
    /// Those of [`render_parts`](Self::render_parts).
    pub async fn render_parts_async(
        &mut self,
        parts: &[Window],
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        parts.iter().try_for_each(|part| check_window(part, &self.scene))?;
        self.prepare(listener)?;
        let (pose, hierarchy) = (core::mem::take(&mut self.pose), core::mem::take(&mut self.built));
        let mut clocks = FrameClocks { pose, hierarchy, ..FrameClocks::default() };
        let hierarchy = self.follow(&mut clocks)?;
        let world = World::with_hierarchy(&self.scene, hierarchy);
        let job = Job {
            settings: &self.settings,
            parts,
            plan: &self.plan,
            cancel: &self.cancel,
            spheres: &self.spheres,
            silhouettes: &self.silhouettes,
            custom: &self.custom.0,
            tables: self.tables.as_ref(),
            alone: self.alone,
        };
        let state = State {
            backend: &mut self.backend,
            chosen: &mut self.chosen,
            is_advised: &mut self.is_advised,
            points: &mut self.kept.points,
            canvas: &mut self.canvas,
            maps: &mut self.kept.maps,
            sky: &mut self.sky,
        };
        let done = job.picture(&world, state, clocks, listener, sink).await;
        if !self.settings.keep_points {
            self.kept.points.clear_parts();
        }
        done
    }

    /// Renders a window on the CPU with other layers and another number of camera rays. All data that is kept for pictures stays.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_apart(&mut self, window: &Window, layers: LayerSet, samples: u32) -> Result<Image, RenderError> {
        // Updates plan and hierarchy first, so that stale data is dropped before it is put aside.
        let _ = self.follow_hierarchy();
        let accuracy = self.chosen.unwrap_or(self.settings.accuracy);
        let own = Settings {
            device: Device::Cpu,
            accuracy,
            layers,
            samples: samples.into(),
            repeat: 1,
            ..self.settings.clone()
        };
        own.validate()?;
        let settings = core::mem::replace(&mut self.settings, own);
        let backend = core::mem::replace(&mut self.backend, Backend::Cpu);
        let kept = core::mem::take(&mut self.kept);
        let image = self.render_window(window, &mut |_| ControlFlow::Continue(()));
        (self.settings, self.backend, self.kept) = (settings, backend, kept);
        image
    }
}

/// Checks that a window is a part of a scene's picture.
pub(crate) fn check_window(window: &Window, scene: &Scene) -> Result<(), RenderError> {
    let image = [scene.width as usize, scene.height as usize];
    if window.image == image && window.is_inside() {
        return Ok(());
    }
    let Window { image: [width, height], columns, rows } = window;
    let value = format!("columns {columns:?} and rows {rows:?} of {width} x {height}");
    Err(RenderError::Setting { name: "window", value, expected: "a part of the picture" })
}
