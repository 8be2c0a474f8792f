use crate::bands::seconds;
use crate::custom_strategy::CustomStrategies;
use crate::event::check;
use crate::handles::Handles;
use crate::image::Canvas;
use crate::job::{Job, State};
use crate::kept::Kept;
use crate::plan::map_sphere;
use crate::rows::Rows;
use crate::sphere_cache::{Scope, follow_spheres};
use crate::turn::at_once;
use crate::{
    Backend, Clocks, Device, FrameClocks, Image, ImageStats, KeptSky, KeptSpheres, LayerSet, LightHandle, Listener,
    Method, Plan, RenderError, Settings, Sink, Stale, Upkeep, paper_tables,
};
use core::ops::ControlFlow;
use glam::Vec3;
use lighting::Light;
use paper::Tables;
use pictures::Window;
use render_cpu::{Hierarchy, Looks, SceneSilhouettes, SceneSpheres, Update, World};
use scene::{Animation, BlockerSet, Bounds, Cancel, Scene};
use shading::Accuracy;
use std::sync::Arc;
use visibility_shadowmap::ShadowMap;
#[cfg(feature = "gpu")]
use {
    crate::{GpuImage, Layers, error::NO_GPU},
    render_gpu::Gpu,
};

/// A scene, and everything that turns it into pictures: the strategy of each object, the spheres, hierarchies and maps that are
/// kept between frames, the device and the method.
///
/// Prints nothing, reads no arguments, and never exits. Long work reports to a [`Listener`], which may stop it.
///
/// # Cost
/// The first picture builds the strategies' data (hierarchies: about a microsecond a triangle; spheres: seconds, unless they are in
/// the cache). Later pictures refit the objects that have moved.
#[derive(Debug)]
pub struct Renderer {
    pub(crate) scene: Scene,
    pub(crate) animation: Animation,
    pub(crate) settings: Settings,
    pub(crate) plan: Plan,
    pub(crate) backend: Backend,
    /// The GPU of settings that request one; none: the strongest adapter.
    #[cfg(feature = "gpu")]
    pub(crate) gpu: Option<Gpu>,
    /// Time of the animation in seconds.
    pub(crate) time: f32,
    pub(crate) tables: Option<Tables>,
    sets: SceneSpheres,
    /// Seconds of work that is done once.
    clocks: Clocks,
    /// Seconds of the last [`seek`](Self::seek).
    pose: f64,
    /// The accuracy that a time budget has chosen.
    pub(crate) chosen: Option<Accuracy>,
    set: BlockerSet,
    pub(crate) spheres: KeptSpheres,
    hierarchy: Option<Arc<Hierarchy>>,
    /// Seconds spent on updating the hierarchy before the next picture.
    built: f64,
    pub(crate) silhouettes: SceneSilhouettes,
    pub(crate) custom: CustomStrategies,
    pub(crate) kept: Kept,
    /// Data of pictures with fewer pixels.
    pub(crate) reduced: Kept,
    canvas: Canvas,
    pub(crate) sky: KeptSky,
    pub(crate) rows: Rows,
    pub(crate) light_handles: Handles,
    pub(crate) material_handles: Handles,
    pub(crate) stale: Stale,
    pub(crate) upkeep: Upkeep,
    /// A box around all points of the caller's so far.
    points: Option<Bounds>,
    is_advised: bool,
    pub(crate) cancel: Cancel,
}

impl Renderer {
    /// Takes a scene as loaded, at its first moment, with its animation, and opens the device.
    ///
    /// # Errors
    /// [`RenderError`] if there is no such device, or it does not support the settings; if the scene or the animation is not valid.
    pub fn new(scene: Scene, animation: Animation, settings: Settings) -> Result<Self, RenderError> {
        // Checked before opening a device, which is slow.
        settings.check_device(settings.device)?;
        let backend = Backend::open(settings.device)?;
        Self::with_backend(scene, animation, settings, backend)
    }

    /// As [`new`](Self::new), but with an open device; ignores [`Settings::device`].
    ///
    /// # Errors
    /// [`RenderError::NotOnGpu`] if the device does not support the settings.
    pub fn with_backend(
        scene: Scene,
        animation: Animation,
        settings: Settings,
        backend: Backend,
    ) -> Result<Self, RenderError> {
        settings.check_device(backend.device())?;
        settings.validate()?;
        scene.validate()?;
        animation.validate()?;
        check_method(settings.method, &scene.lights)?;
        let plan = Plan::new(settings.strategy, &scene);
        let settings = Settings { device: backend.device(), ..settings };
        Ok(Self {
            rows: Rows::new(scene.objects.len()),
            light_handles: Handles::new(scene.lights.len()),
            material_handles: Handles::new(scene.materials.len()),
            scene,
            animation,
            settings,
            plan,
            backend,
            #[cfg(feature = "gpu")]
            gpu: None,
            time: 0.0,
            tables: None,
            sets: SceneSpheres::default(),
            clocks: Clocks::default(),
            pose: 0.0,
            chosen: None,
            set: BlockerSet::default(),
            spheres: KeptSpheres::default(),
            hierarchy: None,
            built: 0.0,
            silhouettes: SceneSilhouettes::default(),
            custom: CustomStrategies::default(),
            kept: Kept::default(),
            reduced: Kept::default(),
            canvas: Canvas::default(),
            sky: KeptSky::default(),
            stale: Stale::ALL,
            upkeep: Upkeep::default(),
            points: None,
            is_advised: false,
            cancel: Cancel::new(),
        })
    }

    /// The scene at the present time.
    #[must_use]
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The animation.
    #[must_use]
    pub const fn animation(&self) -> &Animation {
        &self.animation
    }

    /// The strategy of each object.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The device that shades.
    #[must_use]
    pub const fn backend(&self) -> &Backend {
        &self.backend
    }

    /// Sets the GPU that [settings](Self::set_settings) with [`Device::Gpu`] mean from now on: that of a window, which shows pictures of it
    /// without a copy. None: the strongest adapter, opened for this renderer alone.
    #[cfg(feature = "gpu")]
    pub fn use_gpu(&mut self, gpu: Option<Gpu>) {
        self.gpu = gpu;
    }

    /// Seconds of work that is done once, so far.
    #[must_use]
    pub const fn clocks(&self) -> Clocks {
        self.clocks
    }

    /// The union of everything that edits have made stale since the last picture.
    #[must_use]
    pub const fn stale(&self) -> Stale {
        self.stale
    }

    /// How often the data that is kept between pictures was built or updated so far.
    #[must_use]
    pub const fn upkeep(&self) -> Upkeep {
        let ray_worlds = self.upkeep.ray_worlds + self.backend.worlds_followed();
        Upkeep {
            point_bands: self.kept.points.found,
            maps: self.kept.maps.drawn,
            sky_tables: self.sky.made(),
            ray_worlds,
            ..self.upkeep
        }
    }

    /// The spheres that block light for the objects that block by spheres, where the last picture had them; none before the first one.
    /// Objects are their places in [`objects`](Self::objects).
    #[must_use]
    pub const fn blocker_spheres(&self) -> &BlockerSet {
        self.spheres.set()
    }

    /// The shadow map that the last whole picture had for a light; none if it had none, if no surface was drawn into it, and after the light
    /// has moved. A clone costs nothing.
    #[must_use]
    pub fn shadow_map(&self, light: LightHandle) -> Option<&ShadowMap> {
        let place = self.light_handles.place(light.0)?;
        // Places change where lights are removed.
        let sphere = map_sphere(self.scene.lights.get(place)?);
        self.kept.maps.of(place).filter(|map| map.faces() > 0 && map.light() == sphere)
    }

    /// Sets the request, which any thread may make, that stops pictures and their preparation with [`RenderError::Cancelled`].
    ///
    /// The renderer keeps all work done so far: once it has another request, the next picture has the same bits as if nothing had
    /// been stopped.
    ///
    /// # Cost
    /// The request is checked for each tile of pixels and each light. After it each thread computes 0.5 ms in the median and 2.4 ms
    /// at most (1280 × 720, seven wide sphere lights, four strategies; `tests/cancel.rs`). Some steps always finish: one hierarchy
    /// over the triangles (0.6 µs a triangle to build, 0.1 to refit), the silhouettes of one mesh, one shadow map, a step of
    /// fitting spheres, and on a GPU one slice of 2²⁰ points and the compilation of one kernel.
    ///
    /// ```
    /// # use renderer::{RenderError, Renderer, Settings};
    /// # let mut scene = scene::builtin();
    /// # (scene.width, scene.height) = (32, 18);
    /// let mut renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
    /// let cancel = scene::Cancel::new();
    /// renderer.set_cancel(cancel.clone());
    /// cancel.cancel();
    /// assert!(matches!(renderer.render(), Err(RenderError::Cancelled)));
    /// renderer.set_cancel(scene::Cancel::new());
    /// assert!(renderer.render().is_ok());
    /// # Ok::<(), RenderError>(())
    /// ```
    pub fn set_cancel(&mut self, cancel: Cancel) {
        self.cancel = cancel;
    }

    /// The request that [`set_cancel`](Self::set_cancel) has set.
    #[must_use]
    pub const fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    pub(crate) fn mark(&mut self, stale: Stale) -> Stale {
        self.stale |= stale;
        stale
    }

    /// Computes spheres and tables, unless they are there. Pictures do so themselves.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn prepare(&mut self, listener: &mut Listener<'_>) -> Result<(), RenderError> {
        let cancel = self.cancel.clone();
        check(&cancel)?;
        let listener: &mut Listener<'_> = &mut |event| match cancel.is_cancelled() {
            true => ControlFlow::Break(()),
            false => listener(event),
        };
        self.follow_plan();
        if self.stale.has(Stale::SETS) {
            // Sets are fitted to objects at their initial places.
            self.rows.swap_rest(&mut self.scene);
            if self.time != 0.0 {
                self.animation.seek(0.0, &mut self.scene);
            }
            let (animation, plan, cache) = (&self.animation, &self.plan, self.settings.cache.as_deref());
            let scope = Scope { animation, plan, cache, revisions: self.rows.revisions() };
            let (sets, scene) = (&mut self.sets, &mut self.scene);
            let made = seconds(&mut self.clocks.spheres, || follow_spheres(sets, scene, &scope, listener));
            if self.time != 0.0 {
                self.animation.seek(self.time, &mut self.scene);
            }
            self.rows.swap_rest(&mut self.scene);
            self.rows.follow_proxies(&mut self.scene);
            self.upkeep.sphere_sets += made? as u64;
            self.stale = self.stale.without(Stale::SETS);
        }
        if self.settings.method == Method::Paper && self.tables.is_none() {
            let cache = self.settings.cache.as_deref();
            self.tables = Some(seconds(&mut self.clocks.tables, || paper_tables(cache, listener))?);
        }
        Ok(())
    }

    /// Lets floors block that such points of the caller's are behind.
    pub(crate) fn lights_points(&mut self, points: &[Vec3]) {
        let known = self.points;
        self.points = points.iter().fold(known, |bounds, p| Some(bounds.unwrap_or(Bounds::EMPTY).with_point(*p)));
        if self.points != known {
            self.plan_again();
        }
    }

    /// Updates the plan: strategies may have changed, and things that move go behind floors and come from there.
    fn follow_plan(&mut self) {
        if !self.stale.has(Stale::PLAN | Stale::HIERARCHY | Stale::LIGHTS) {
            return;
        }
        if self.scene.fit_lights() {
            self.mark(Stale::LIGHTS | Stale::MAPS);
        }
        self.plan_again();
        self.stale = self.stale.without(Stale::PLAN);
    }

    /// Makes the plan, and marks what followed another one.
    fn plan_again(&mut self) {
        let plan = Plan::with_points(self.settings.strategy, &self.scene, self.points);
        let is_new = core::mem::replace(&mut self.plan, plan) != self.plan;
        if is_new || self.stale.has(Stale::PLAN) {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.maps.clear());
            self.mark(Stale::SHADING | Stale::SPHERES | Stale::SILHOUETTES);
        }
    }

    /// The [exposure](crate::exposure) of the scene at the first moment of its animation, whatever the present time: the same for
    /// all frames.
    pub fn exposure(&mut self) -> f32 {
        let time = self.time;
        self.seek(0.0);
        let mut built = core::mem::take(&mut self.built);
        let hierarchy = seconds(&mut built, || self.follow_hierarchy());
        self.built = built;
        let stops = crate::exposure(&World::with_hierarchy(&self.scene, hierarchy));
        self.seek(time);
        stops
    }

    /// The present time of the animation, in seconds.
    #[must_use]
    pub const fn time(&self) -> f32 {
        self.time
    }

    /// Moves the animation to a time in seconds.
    pub fn seek(&mut self, time: f32) {
        self.pose = 0.0;
        seconds(&mut self.pose, || self.animation.seek(time, &mut self.scene));
        if time != self.time && !self.animation.is_still() {
            self.rows.bump_places(|object| self.animation.moves_object(object));
            self.mark(Stale::MOVED | Stale::LIGHTS);
        }
        self.time = time;
    }

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

    /// Renders a window on the CPU with other layers and another number of camera rays. All data that is kept for pictures stays.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_apart(&mut self, window: &Window, layers: LayerSet, samples: u32) -> Result<Image, RenderError> {
        // Updates the hierarchy first, so that stale data is dropped before it is put aside.
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

    /// Runs a query against the scene at the present time.
    pub fn with_world<R>(&mut self, ask: impl FnOnce(&World<'_>) -> R) -> R {
        let hierarchy = self.follow_hierarchy();
        ask(&World::with_hierarchy(&self.scene, hierarchy))
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

    /// The hierarchy at the present time.
    pub(crate) fn follow_hierarchy(&mut self) -> Arc<Hierarchy> {
        if self.stale.has(Stale::HIERARCHY | Stale::LIGHTS) && self.scene.fit_lights() {
            self.mark(Stale::LIGHTS | Stale::MAPS);
        }
        let scene = &self.scene;
        let mut done = Update::Kept;
        match self.hierarchy.as_mut().and_then(Arc::get_mut) {
            Some(kept) => {
                if self.stale.has(Stale::HIERARCHY) {
                    done = kept.update(scene);
                } else {
                    if self.stale.has(Stale::LIGHTS) {
                        kept.update_lights(scene);
                    }
                    if self.stale.has(Stale::SURFACES) {
                        kept.update_surfaces(scene);
                    }
                }
            }
            None => {
                self.hierarchy = Some(Arc::new(Hierarchy::new(scene)));
                done = Update::Built;
            }
        }
        self.upkeep.hierarchy_builds += u64::from(done == Update::Built);
        self.upkeep.hierarchy_refits += u64::from(done == Update::Refitted);
        if done != Update::Kept {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.maps.clear());
        }
        if done != Update::Kept || self.stale.has(Stale::POINTS) {
            [&mut self.kept, &mut self.reduced].into_iter().for_each(|kept| kept.points.clear());
        }
        self.stale = self.stale.without(Stale::HIERARCHY | Stale::SURFACES | Stale::POINTS);
        Arc::clone(self.hierarchy.get_or_insert_with(|| Arc::new(Hierarchy::new(scene))))
    }

    /// Updates spheres, silhouettes and hierarchy to the present time.
    pub(crate) fn follow(&mut self, clocks: &mut FrameClocks) -> Result<Arc<Hierarchy>, RenderError> {
        let hierarchy = seconds(&mut clocks.hierarchy, || self.follow_hierarchy());
        check(&self.cancel)?;
        let (scene, plan, revisions) = (&self.scene, &self.plan, self.rows.revisions());
        if self.stale.has(Stale::SPHERES | Stale::LIGHTS) {
            seconds(&mut clocks.spheres, || {
                self.sets.place(scene, revisions);
                self.sets.pose(scene, Some((&self.animation, self.time)), &mut self.set)?;
                self.upkeep.sphere_updates += u64::from(self.spheres.update(&self.set));
                Ok::<(), RenderError>(())
            })?;
        }
        check(&self.cancel)?;
        // A change of lights or size may make simplified forms worth their time, or no longer.
        let looks = match self.settings.keep_points || !self.animation.is_still() || self.points.is_some() {
            true => Looks::MANY,
            false => crate::looks::of_picture(scene),
        };
        if self.stale.has(Stale::SILHOUETTES) || looks != self.silhouettes.looks() {
            self.custom.update(scene, plan)?;
            let (kept, cancel) = (&mut self.silhouettes, &self.cancel);
            let [made, refitted] =
                seconds(&mut clocks.silhouettes, || plan.follow_silhouettes(scene, (revisions, looks), kept, cancel));
            self.upkeep.silhouette_builds += made as u64;
            self.upkeep.silhouette_refits += refitted as u64;
        }
        check(&self.cancel)?;
        self.stale = Stale::NOTHING;
        Ok(hierarchy)
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

/// Checks that a window is a part of a scene's picture.
fn check_window(window: &Window, scene: &Scene) -> Result<(), RenderError> {
    let image = [scene.width as usize, scene.height as usize];
    if window.image == image && window.is_inside() {
        return Ok(());
    }
    let Window { image: [width, height], columns, rows } = window;
    let value = format!("columns {columns:?} and rows {rows:?} of {width} x {height}");
    Err(RenderError::Setting { name: "window", value, expected: "a part of the picture" })
}

/// Checks that a method supports the lights.
pub(crate) fn check_method(method: Method, lights: &[Light]) -> Result<(), RenderError> {
    let other = lights.iter().enumerate().find(|(_, light)| light.sphere().is_none());
    let (Method::Paper, Some((i, light))) = (method, other) else { return Ok(()) };
    // The names of scene files.
    let kind = match light.name() {
        "flat" => "a rectangle, disc or polygon",
        "tube" => "a tube",
        "sun" => "a sun",
        "spot" => "a spot",
        "environment" => "an environment",
        kind => kind,
    };
    Err(RenderError::PaperLight(i, kind))
}
