use crate::bands::seconds;
use crate::custom_strategy::CustomStrategies;
use crate::handles::Handles;
use crate::image::Canvas;
use crate::kept::Kept;
use crate::plan::map_sphere;
use crate::rows::Rows;
use crate::{Backend, Clocks, KeptSky, KeptSpheres, LightHandle, Method, Plan, RenderError, Settings, Stale, Upkeep};
use lighting::Light;
use paper::Tables;
use render_cpu::{Hierarchy, SceneSilhouettes, SceneSpheres};
#[cfg(feature = "gpu")]
use render_gpu::Gpu;
use scene::{Animation, BlockerSet, Bounds, Cancel, Scene};
use shading::Accuracy;
use std::sync::Arc;
use visibility_shadowmap::ShadowMap;

/// A scene, and everything that turns it into pictures: the strategy of each object, the spheres, hierarchies and maps that are
/// kept between frames, the device and the method.
///
/// Prints nothing, reads no arguments, and never exits. Long work reports to a [`Listener`](crate::Listener), which may stop it.
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
    pub(crate) sets: SceneSpheres,
    /// Seconds of work that is done once.
    pub(crate) clocks: Clocks,
    /// Seconds of the last [`seek`](Self::seek).
    pub(crate) pose: f64,
    /// The accuracy that a time budget has chosen.
    pub(crate) chosen: Option<Accuracy>,
    pub(crate) set: BlockerSet,
    pub(crate) spheres: KeptSpheres,
    pub(crate) hierarchy: Option<Arc<Hierarchy>>,
    /// Seconds spent on updating the hierarchy before the next picture.
    pub(crate) built: f64,
    pub(crate) silhouettes: SceneSilhouettes,
    pub(crate) custom: CustomStrategies,
    pub(crate) kept: Kept,
    /// Data of pictures with fewer pixels.
    pub(crate) reduced: Kept,
    pub(crate) canvas: Canvas,
    pub(crate) sky: KeptSky,
    pub(crate) rows: Rows,
    pub(crate) light_handles: Handles,
    pub(crate) material_handles: Handles,
    pub(crate) stale: Stale,
    pub(crate) upkeep: Upkeep,
    /// A box around all points of the caller's so far.
    pub(crate) points: Option<Bounds>,
    pub(crate) is_advised: bool,
    pub(crate) cancel: Cancel,
    /// The only light of the picture that is made, by its place.
    pub(crate) alone: Option<usize>,
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
            alone: None,
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

    /// Sets the GPU that [settings](Self::set_settings) with [`Device::Gpu`](crate::Device::Gpu) mean from now on: that of a window, which shows pictures of it
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
