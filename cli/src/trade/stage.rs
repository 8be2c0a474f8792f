use super::setting::{Setting, Technique};
use super::truth::Truth;
use crate::args::{TradeArgs, TradeDevice, TradeGeometry, Visibility};
use crate::console::STOP;
use crate::failure::Failure;
use crate::teller::Teller;
use cosine_lobes::Picture;
use cosine_lobes::brdf::Material;
use cosine_lobes::lighting::Light;
use cosine_lobes::paper::Tables;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::RayShader;
use cosine_lobes::render_cpu::SceneSilhouettes;
use cosine_lobes::renderer::{
    Backend, Event, FrameBlockers, KeptSpheres, Plan, RenderError, Shader, ShaderTask, exposure, seconds,
};
use cosine_lobes::scene::{BlockerSet, Frame, Shade, ShadingPoints};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::visibility_shadowmap::{ReceiverBounds, ShadowMap};
use glam::Vec3;
use std::time::{Duration, Instant};

/// No setting is repeated for longer, once it was shaded three times.
const LONGEST: Duration = Duration::from_secs(3);

/// The tolerance that methods without one are given; they do not look at it.
const ANY_TOLERANCE: f32 = 0.005;

/// One setting, shaded again and again.
pub(super) struct Shot {
    /// Ascending.
    pub(super) seconds: Vec<f64>,
    pub(super) radiance: Vec<Vec3>,
    /// Of drawing the shadow maps, once a frame.
    pub(super) map_seconds: f64,
}

impl Shot {
    /// The quantile of the times of the repetitions, `share` in [0, 1].
    pub(super) fn at(&self, share: f64) -> f64 {
        let index = (self.seconds.len() - 1) as f64 * share;
        let (low, high) = (self.seconds[index.floor() as usize], self.seconds[index.ceil() as usize]);
        low + (high - low) * index.fract()
    }
}

/// The scene at its moment, with the data that all settings share.
pub(super) struct Stage<'a> {
    args: &'a TradeArgs,
    world: &'a World<'a>,
    gbuffer: &'a GBuffer,
    blockers: &'a BlockerSet,
    /// The spheres of each strategy.
    spheres: Vec<(Visibility, KeptSpheres)>,
    /// The meshes by their silhouettes, of the last plan.
    silhouettes: Option<(Visibility, SceneSilhouettes)>,
    gbuffer_seconds: f64,
    /// The maps of the last strategy that has some.
    maps: Option<(Visibility, Vec<ShadowMap>, f64)>,
    /// Of pictures that are looked at.
    exposure: f32,
    /// The requested GPU; the CPU by default.
    gpu: Backend,
    /// Made where the paper's method is swept.
    pub(super) tables: Option<Tables>,
}

impl<'a> Stage<'a> {
    pub(super) fn new(
        args: &'a TradeArgs,
        world: &'a World<'a>,
        (gbuffer, gbuffer_seconds): (&'a GBuffer, f64),
        blockers: &'a BlockerSet,
        sets: &[(Visibility, BlockerSet)],
        gpu: Backend,
    ) -> Self {
        let kept = |(visibility, set): &(Visibility, BlockerSet)| {
            let mut kept = KeptSpheres::default();
            kept.update(set);
            (*visibility, kept)
        };
        let spheres = sets.iter().map(kept).collect();
        let (silhouettes, maps, tables) = (None, None, None);
        let exposure = args.view.exposure.unwrap_or_else(|| exposure(world));
        Self { args, world, gbuffer, blockers, spheres, silhouettes, gbuffer_seconds, maps, exposure, gpu, tables }
    }

    pub(super) const fn gbuffer_seconds(&self) -> f64 {
        self.gbuffer_seconds
    }

    pub(super) fn points(&self) -> usize {
        self.gbuffer.len()
    }

    pub(super) const fn exposure(&self) -> f32 {
        self.exposure
    }

    pub(super) fn picture(&self, radiance: &[Vec3]) -> Picture {
        let scene = self.world.scene();
        let pixels = self.gbuffer.picture(radiance, scene.background);
        Picture::new(scene.width as usize, scene.height as usize, pixels)
    }

    /// A paragraph about the scene.
    pub(super) fn about(&self, title: &str, truth: &Truth) -> String {
        let scene = self.world.scene();
        let geometry = match self.args.geometry {
            TradeGeometry::Spheres => "the same blocker spheres",
            TradeGeometry::Mesh => "the true geometry",
        };
        let gpu = match &self.gpu {
            Backend::Cpu => String::new(),
            gpu => format!(", GPU {}", gpu.name()),
        };
        format!(
            "{title}: {} x {} pixels, {} points, {} blocker spheres, {} triangles, {} lights, {} threads{gpu}. Reference: Monte Carlo of \
             {geometry}, {} samples, own standard error in penumbra {:.4} %. Time: shading of one frame with visible points \
             given, median of repeated frames (quartiles); `frame` adds finding the points ({:.2} ms) and drawing shadow maps. \
             Errors: fractions of the unshadowed radiance over pixels between 1 % and 99 % lit.",
            scene.width,
            scene.height,
            self.gbuffer.len(),
            self.blockers.spheres.len(),
            self.world.triangle_count(),
            scene.lights.len(),
            rayon::current_num_threads(),
            truth.samples,
            100.0 * truth.std_error,
            1e3 * self.gbuffer_seconds,
        )
    }

    /// Shades once to warm up, then as often as requested.
    pub(super) fn shoot(&mut self, setting: &Setting) -> Result<Shot, Failure> {
        let scene = self.world.scene();
        let any = Accuracy::new(setting.tolerance.unwrap_or(ANY_TOLERANCE));
        let accuracy = setting.depth.map_or(any, |depth| any.with_depth(depth));
        let frame = Frame::new(&self.gbuffer.materials, &scene.lights, accuracy);
        let timed = Timed { points: &self.gbuffer.points, frame: &frame, repeats: self.args.repeat as usize };
        match setting.technique {
            Technique::Samples { culled } => {
                let spp = setting.spp.unwrap_or(1);
                let shader = match self.args.geometry {
                    TradeGeometry::Spheres => RayShader::spheres(self.blockers, spp),
                    TradeGeometry::Mesh => RayShader::surfaces(self.world, spp),
                };
                Ok(timed.run(&mut shader.culled(culled))?)
            }
            Technique::Lobes(method, visibility) => {
                let plan = Plan::new(visibility.strategy(), scene);
                let (maps, map_seconds) = match plan.wants_maps(scene) {
                    true => self.maps(visibility, &plan)?,
                    false => (Vec::new(), 0.0),
                };
                let spheres = self.spheres.iter().find(|(of, _)| *of == visibility).and_then(|(_, kept)| kept.get());
                let silhouettes = match self.silhouettes.take() {
                    Some((of, kept)) if of == visibility => kept,
                    _ => plan.silhouettes(scene),
                };
                let (_, silhouettes) = &*self.silhouettes.insert((visibility, silhouettes));
                let (method, tables) = (method.into(), self.tables.as_ref());
                let backend = match setting.device {
                    TradeDevice::Cpu => &mut Backend::Cpu,
                    TradeDevice::Gpu => &mut self.gpu,
                };
                let blockers = FrameBlockers::new(&plan, self.world, spheres, maps, silhouettes, frame.accuracy);
                let shot = blockers.shade(backend, method, tables, timed)?;
                Ok(Shot { map_seconds, ..shot })
            }
        }
    }

    /// The lights' shadow maps, drawn once, and how long that took.
    fn maps(&mut self, visibility: Visibility, plan: &Plan) -> Result<(Vec<ShadowMap>, f64), Failure> {
        if self.maps.as_ref().is_none_or(|(of, ..)| *of != visibility) {
            let receivers = ReceiverBounds::of(self.gbuffer.points.receivers.iter().map(|r| r.position));
            let mut time = 0.0;
            let (maps, coarser) = match receivers {
                // The same maps for all devices.
                Some(receivers) => {
                    let (scene, resolution) = (self.world.scene(), self.args.map_resolution);
                    seconds(&mut time, || plan.maps(scene, receivers, resolution, self.gpu.room_for_maps()))?
                }
                None => (Vec::new(), None),
            };
            if let Some(coarser) = coarser {
                let _ = Teller::new(self.args.view.console.quiet).hear(Event::MapsReduced(coarser));
            }
            self.maps = Some((visibility, maps, time));
        }
        Ok(self.maps.clone().map(|(_, maps, time)| (maps, time)).unwrap_or_default())
    }
}

/// Shading, timed.
struct Timed<'a> {
    points: &'a ShadingPoints,
    frame: &'a Frame<'a>,
    repeats: usize,
}

impl Timed<'_> {
    fn run<S: Shade<Material, Light>>(&self, shader: &mut S) -> Result<Shot, S::Error> {
        let mut radiance = vec![Vec3::ZERO; self.points.receivers.len()];
        shader.shade(self.points, self.frame, &mut radiance)?;
        let (start, mut times) = (Instant::now(), Vec::with_capacity(self.repeats));
        let goes_on = |done: usize| done < self.repeats && (done < 3 || start.elapsed() < LONGEST);
        while times.is_empty() || (goes_on(times.len()) && !STOP.is_cancelled()) {
            times.push(shader.shade(self.points, self.frame, &mut radiance)?.seconds);
        }
        times.sort_by(f64::total_cmp);
        Ok(Shot { seconds: times, radiance, map_seconds: 0.0 })
    }
}

impl ShaderTask for Timed<'_> {
    type Output = Shot;

    async fn with<S: Shader>(self, shader: &mut S) -> Result<Shot, RenderError> {
        self.run(shader).map_err(Into::into)
    }
}
