use crate::bands::{Bands, seconds};
use crate::budget::Budget;
use crate::event::tell;
use crate::image::Shading;
use crate::{
    Backend, Clocks, Event, FrameBlockers, FrameClocks, Image, ImageStats, KeptSpheres, Layers, Listener, Method, Plan,
    RenderError, Settings, Sink, paper_tables, scene_spheres,
};
use core::ops::ControlFlow;
use lobe_core::Accuracy;
use lobe_core::paper::Tables;
use pictures::Window;
use render_cpu::{Hierarchy, SceneSilhouettes, SceneSpheres, World};
use scene::{Animation, BlockerSet, Frame, Scene};
use visibility_shadowmap::ShadowMap;

/// A scene, and all that turns it into pictures: which strategy each object's shadow takes, spheres, hierarchies and maps kept
/// from frame to frame, the device and the method.
///
/// Nothing is printed, no argument is read, nothing exits; long work tells a [`Listener`], which may stop it.
///
/// # Cost
/// The first picture builds what the strategies need (hierarchies: about a microsecond a triangle; spheres: seconds, unless they
/// are in the cache). Later ones refit what has moved.
#[derive(Debug)]
pub struct Renderer {
    scene: Scene,
    animation: Animation,
    settings: Settings,
    plan: Plan,
    backend: Backend,
    /// Seconds of the animation.
    time: f32,
    prepared: Option<Prepared>,
    /// What is spent once.
    clocks: Clocks,
    /// Seconds of the last [`seek`](Self::seek).
    pose: f64,
    /// What a time budget has chosen.
    chosen: Option<Accuracy>,
    set: BlockerSet,
    spheres: KeptSpheres,
    hierarchy: Option<Hierarchy>,
    /// Seconds of making it before the next picture.
    built: f64,
    silhouettes: Option<SceneSilhouettes>,
    /// Whether anything has moved since what is kept was made.
    is_moved: bool,
    is_advised: bool,
}

/// What is made once.
#[derive(Debug)]
struct Prepared {
    spheres: SceneSpheres,
    tables: Option<Tables>,
}

impl Renderer {
    /// Takes a scene as it was loaded, at its first moment, with the animation that it came with, and opens the device.
    ///
    /// # Errors
    /// [`RenderError`] where there is no such device, or it lacks what the settings ask for.
    pub fn new(scene: Scene, animation: Animation, settings: Settings) -> Result<Self, RenderError> {
        // Refused before a device is opened, which takes a while.
        settings.check_device(settings.device)?;
        let backend = Backend::open(settings.device)?;
        Self::with_backend(scene, animation, settings, backend)
    }

    /// The same with a device that is open already; [`Settings::device`] has no say.
    ///
    /// # Errors
    /// [`RenderError::NotOnGpu`] where the device lacks what the settings ask for.
    pub fn with_backend(
        scene: Scene,
        animation: Animation,
        settings: Settings,
        backend: Backend,
    ) -> Result<Self, RenderError> {
        settings.check_device(backend.device())?;
        if let (Method::Paper, Some((i, light))) =
            (settings.method, scene.lights.iter().enumerate().find(|(_, light)| light.ball().is_none()))
        {
            // As scene files call them.
            let kind = match light.kind() {
                "flat" => "a rectangle, disc or polygon",
                "tube" => "a tube",
                "sun" => "a sun",
                "spot" => "a spot",
                "environment" => "an environment",
                kind => kind,
            };
            return Err(RenderError::PaperLight(i, kind));
        }
        let plan = Plan::new(settings.strategy, &scene);
        Ok(Self {
            scene,
            animation,
            settings,
            plan,
            backend,
            time: 0.0,
            prepared: None,
            clocks: Clocks::default(),
            pose: 0.0,
            chosen: None,
            set: BlockerSet::default(),
            spheres: KeptSpheres::default(),
            hierarchy: None,
            built: 0.0,
            silhouettes: None,
            is_moved: true,
            is_advised: false,
        })
    }

    /// The scene at its present moment.
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

    /// What it was asked for.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What shades.
    #[must_use]
    pub const fn backend(&self) -> &Backend {
        &self.backend
    }

    /// Seconds spent once so far.
    #[must_use]
    pub const fn clocks(&self) -> Clocks {
        self.clocks
    }

    /// Another accuracy from the next picture on; a time budget has no say any more.
    pub fn set_accuracy(&mut self, accuracy: Accuracy) {
        self.settings.accuracy = accuracy;
        self.settings.time_budget = None;
        self.chosen = None;
    }

    /// Changes the camera, lights, materials or the size of the picture. Objects are to stay: they follow the animation.
    pub fn edit(&mut self, change: impl FnOnce(&mut Scene)) {
        change(&mut self.scene);
        self.is_moved = true;
    }

    /// Makes what is made once, spheres and tables, unless it is there. Pictures do it themselves.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn prepare(&mut self, listener: &mut Listener<'_>) -> Result<(), RenderError> {
        if self.prepared.is_some() {
            return Ok(());
        }
        // Spheres are fitted at the first moment.
        if self.time != 0.0 {
            self.animation.seek(0.0, &mut self.scene);
        }
        let (scene, cache) = (&mut self.scene, self.settings.cache.as_deref());
        let spheres =
            seconds(&mut self.clocks.spheres, || scene_spheres(scene, &self.animation, &self.plan, cache, listener));
        if self.time != 0.0 {
            self.animation.seek(self.time, &mut self.scene);
        }
        let tables = match self.settings.method {
            Method::Paper => Some(seconds(&mut self.clocks.tables, || paper_tables(cache, listener))?),
            Method::Moments | Method::Lobes => None,
        };
        self.prepared = Some(Prepared { spheres: spheres?, tables });
        Ok(())
    }

    /// The [exposure](crate::exposure) of the scene at the first moment of its animation, whatever the present one: the same for all its
    /// frames.
    pub fn exposure(&mut self) -> f32 {
        let time = self.time;
        self.seek(0.0);
        let hierarchy = self.hierarchy.take();
        let world = seconds(&mut self.built, || match hierarchy {
            Some(hierarchy) => World::refit(&self.scene, hierarchy),
            None => World::new(&self.scene),
        });
        let stops = crate::exposure(&world);
        self.hierarchy = Some(world.into_hierarchy());
        self.is_moved = true;
        self.seek(time);
        stops
    }

    /// Goes to a moment of the animation, in seconds.
    pub fn seek(&mut self, time: f32) {
        self.pose = 0.0;
        seconds(&mut self.pose, || self.animation.seek(time, &mut self.scene));
        self.is_moved |= time != self.time || self.hierarchy.is_none();
        self.time = time;
    }

    /// The whole picture.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render(&mut self) -> Result<Image, RenderError> {
        let window = Window::whole(self.scene.width as usize, self.scene.height as usize);
        self.render_window(&window, &mut |_| ControlFlow::Continue(()))
    }

    /// A window of the picture: its pixels are those of the whole one, bit for bit.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_window(&mut self, window: &Window, listener: &mut Listener<'_>) -> Result<Image, RenderError> {
        let mut image = Image { size: window.size(), ..Image::default() };
        // At once: a picture that finds no room is refused here, and growing would take twice the memory.
        image.radiance.try_reserve_exact(window.columns.len() * window.rows.len())?;
        image.layers = self.settings.layers.then(Layers::default);
        image.stats = self.render_bands(window, listener, &mut |band| {
            image.radiance.extend(band.radiance);
            if let (Some(all), Some(next)) = (&mut image.layers, band.layers) {
                all.append(next);
            }
            ControlFlow::Continue(())
        })?;
        Ok(image)
    }

    /// The same in bands of rows, which go to `sink` as they are done: pictures of any size in bounded memory. Ends early where the
    /// sink has had enough.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render_bands(
        &mut self,
        window: &Window,
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        self.prepare(listener)?;
        let (pose, hierarchy) = (core::mem::take(&mut self.pose), core::mem::take(&mut self.built));
        let mut clocks = FrameClocks { pose, hierarchy, ..FrameClocks::default() };
        self.follow(&mut clocks)?;
        let hierarchy = self.hierarchy.take();
        let world = seconds(&mut clocks.hierarchy, || match hierarchy {
            Some(hierarchy) if self.is_moved => World::refit(&self.scene, hierarchy),
            Some(hierarchy) => World::kept(&self.scene, hierarchy),
            None => World::new(&self.scene),
        });
        let none = SceneSilhouettes::default();
        let tables = self.prepared.as_ref().and_then(|prepared| prepared.tables.as_ref());
        let job = Job {
            settings: &self.settings,
            window,
            plan: &self.plan,
            spheres: &self.spheres,
            silhouettes: self.silhouettes.as_ref().unwrap_or(&none),
            tables,
        };
        let made =
            job.picture(&world, &mut self.backend, &mut self.chosen, &mut self.is_advised, clocks, listener, sink);
        self.hierarchy = Some(world.into_hierarchy());
        self.is_moved = false;
        made
    }

    /// Spheres and silhouettes of the present moment.
    fn follow(&mut self, clocks: &mut FrameClocks) -> Result<(), RenderError> {
        if !self.is_moved {
            return Ok(());
        }
        let (scene, plan) = (&self.scene, &self.plan);
        if let Some(prepared) = &self.prepared {
            seconds(&mut clocks.spheres, || {
                prepared.spheres.pose(scene, Some((&self.animation, self.time)), &mut self.set)?;
                self.spheres.update(&self.set);
                Ok::<(), RenderError>(())
            })?;
        }
        seconds(&mut clocks.silhouettes, || match &mut self.silhouettes {
            Some(kept) => kept.update(scene),
            None => self.silhouettes = Some(plan.silhouettes(scene)),
        });
        Ok(())
    }
}

/// The parts of a picture, made and kept.
struct Job<'a> {
    settings: &'a Settings,
    window: &'a Window,
    plan: &'a Plan,
    spheres: &'a KeptSpheres,
    silhouettes: &'a SceneSilhouettes,
    tables: Option<&'a Tables>,
}

impl Job<'_> {
    /// One picture of a world, as far as the sink takes it.
    #[expect(clippy::too_many_arguments, reason = "what it changes, whom it tells, where it goes")]
    fn picture(
        &self,
        world: &World<'_>,
        backend: &mut Backend,
        chosen: &mut Option<Accuracy>,
        is_advised: &mut bool,
        mut clocks: FrameClocks,
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        let Self { settings, window, plan, silhouettes, tables, .. } = *self;
        let (scene, spheres) = (world.scene(), self.spheres.get());
        let mut bands = Bands::new(world, settings.samples, window.clone());
        let mut maps = Vec::new();
        if let Some(receivers) = plan.wants_maps(scene).then(|| bands.bounds()).flatten() {
            let (resolution, room) = (settings.map_resolution, backend.room_for_maps());
            let coarser;
            (maps, coarser) = seconds(&mut clocks.maps, || plan.maps(scene, receivers, resolution, room))?;
            if !core::mem::replace(is_advised, true) {
                if let Some(coarser) = coarser {
                    tell(listener, Event::CoarserMaps(coarser))?;
                }
                for (light, map) in maps.iter().enumerate() {
                    tell(listener, Event::Map { light, advice: map.advice(&receivers) })?;
                }
            }
        }
        let (materials, lights) = (&scene.materials, &scene.lights);
        let mut frame = Frame { materials, lights, accuracy: settings.accuracy, threshold: settings.threshold };
        match (*chosen, settings.time_budget) {
            (Some(accuracy), _) => frame.accuracy = accuracy,
            (None, Some(budget)) => {
                let choice = Budget {
                    world,
                    plan,
                    spheres,
                    maps: &maps,
                    silhouettes,
                    method: settings.method,
                    tables,
                    fixed: clocks.maps,
                };
                frame.accuracy = choice.choose(backend, budget, &bands, &frame, listener)?;
                *chosen = Some(frame.accuracy);
            }
            (None, None) => {}
        }
        let map_resolutions = maps.iter().map(ShadowMap::resolution).collect();
        let map_bytes = maps.iter().map(ShadowMap::bytes).sum();
        let blockers = FrameBlockers::new(plan, world, spheres, maps, silhouettes, frame.accuracy);
        let (repeat, layers) = (settings.repeat, settings.layers);
        let shading = Shading { frame: &frame, bands: &mut bands, repeat, layers, listener, sink };
        let mut stats = blockers.shade(backend, settings.method, tables, shading)?;
        clocks.gbuffer = bands.seconds;
        stats.clocks = clocks;
        stats.accuracy = frame.accuracy;
        stats.spheres = spheres.map_or(0, |s| s.spheres().len());
        stats.triangles = world.triangle_count();
        (stats.map_resolutions, stats.map_bytes) = (map_resolutions, map_bytes);
        Ok(stats)
    }
}
