//! Makes one picture: maps, the accuracy that a time budget chooses, blockers, shading.

use crate::bands::{Bands, seconds};
use crate::budget::Budget;
use crate::event::tell;
use crate::image::{Canvas, Shading};
use crate::kept_maps::{KeptMaps, MapRequest};
use crate::kept_points::KeptPoints;
use crate::{
    Backend, CustomStrategy, Event, FrameBlockers, FrameClocks, ImageStats, KeptSky, KeptSpheres, Listener,
    MapReduction, Plan, RenderError, Settings, Sink,
};
use paper::Tables;
use pictures::Window;
use render_cpu::{SceneSilhouettes, World};
use scene::{Cancel, Frame, Scene};
use shading::Accuracy;
use visibility_shadowmap::{ReceiverBounds, ShadowMap};

/// The state that a picture uses and leaves for the next one.
pub(crate) struct State<'a> {
    pub(crate) backend: &'a mut Backend,
    pub(crate) chosen: &'a mut Option<Accuracy>,
    pub(crate) is_advised: &'a mut bool,
    pub(crate) points: &'a mut KeptPoints,
    pub(crate) canvas: &'a mut Canvas,
    pub(crate) maps: &'a mut KeptMaps,
    pub(crate) sky: &'a mut KeptSky,
}

/// The parts of a picture to be shaded.
pub(crate) struct Job<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) parts: &'a [Window],
    pub(crate) plan: &'a Plan,
    pub(crate) cancel: &'a Cancel,
    pub(crate) spheres: &'a KeptSpheres,
    pub(crate) silhouettes: &'a SceneSilhouettes,
    pub(crate) custom: &'a [Box<dyn CustomStrategy>],
    pub(crate) tables: Option<&'a Tables>,
    /// The only light, by its place: pictures have neither emission nor background then.
    pub(crate) alone: Option<usize>,
}

impl Job<'_> {
    /// Makes one picture of a world; ends early if the sink stops it.
    pub(crate) async fn picture(
        &self,
        world: &World<'_>,
        state: State<'_>,
        mut clocks: FrameClocks,
        listener: &mut Listener<'_>,
        sink: &mut Sink<'_>,
    ) -> Result<ImageStats, RenderError> {
        let Self { settings, parts, plan, cancel, silhouettes, custom, tables, .. } = *self;
        let State { backend, chosen, is_advised, points, canvas, maps: kept_maps, sky } = state;
        let (scene, spheres) = (world.scene(), self.spheres.get());
        let mut bands = Bands::new(world, settings, parts, points, cancel);
        let room = backend.room_for_maps();
        let maps = self.maps(scene, &mut bands, (kept_maps, is_advised), room, (&mut clocks.maps, listener))?;
        let materials = &scene.materials;
        let lights = self.alone.map_or(&scene.lights[..], |place| &scene.lights[place..=place]);
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
                    custom,
                    settings,
                    tables,
                    cancel,
                    fixed: clocks.maps,
                };
                frame.accuracy = choice.choose(backend, sky, budget, (&bands, &frame), listener).await?;
                *chosen = Some(frame.accuracy);
            }
            (None, None) => {}
        }
        let map_resolutions = maps.iter().map(ShadowMap::resolution).collect();
        let map_bytes = maps.iter().map(ShadowMap::bytes).sum();
        let blockers = FrameBlockers::new(plan, world, spheres, maps, silhouettes, frame.accuracy);
        let blockers = blockers.with(custom, settings);
        let blockers = match self.alone {
            Some(place) => blockers.before_light(place),
            None => blockers.under(sky, &frame, backend, settings.method),
        };
        let (repeat, layers) = (settings.repeat, settings.layers);
        let is_part = self.alone.is_some();
        let shading = Shading { frame: &frame, bands: &mut bands, canvas, repeat, layers, is_part, listener, sink };
        let mut stats = blockers.shade_async(backend, settings.method, tables, shading).await?;
        clocks.gbuffer = bands.seconds;
        stats.clocks = clocks;
        stats.accuracy = frame.accuracy;
        stats.spheres = spheres.map_or(0, |s| s.spheres().len());
        stats.triangles = world.triangle_count();
        (stats.map_resolutions, stats.map_bytes) = (map_resolutions, map_bytes);
        Ok(stats)
    }

    /// The maps of the picture's lights; none where nothing blocks through maps, or no receiver is seen.
    fn maps(
        &self,
        scene: &Scene,
        bands: &mut Bands<'_>,
        (kept, is_advised): (&mut KeptMaps, &mut bool),
        room: u64,
        (time, listener): (&mut f64, &mut Listener<'_>),
    ) -> Result<Vec<ShadowMap>, RenderError> {
        if !self.plan.wants_maps(scene) {
            return Ok(Vec::new());
        }
        let Some(receivers) = bands.bounds()? else { return Ok(Vec::new()) };
        let request = MapRequest { receivers, resolution: self.settings.map_resolution, room };
        let (mut maps, coarser) = seconds(time, || kept.update(self.plan, scene, request, self.cancel))?;
        if !core::mem::replace(is_advised, true) {
            advise(&maps, coarser, &receivers, listener)?;
        }
        if let Some(place) = self.alone.filter(|place| *place < maps.len()) {
            maps = maps.drain(place..=place).collect();
        }
        Ok(maps)
    }
}

/// Reports how well the maps suit the receivers.
fn advise(
    maps: &[ShadowMap],
    coarser: Option<MapReduction>,
    receivers: &ReceiverBounds,
    listener: &mut Listener<'_>,
) -> Result<(), RenderError> {
    if let Some(coarser) = coarser {
        tell(listener, Event::MapsReduced(coarser))?;
    }
    let mut maps = maps.iter().enumerate();
    maps.try_for_each(|(light, map)| tell(listener, Event::Map { light, advice: map.advice(receivers) }))
}
