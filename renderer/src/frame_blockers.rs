use crate::cpu_shading::AnyCpuShader;
use crate::on_objects::OnObjects;
use crate::turn::at_once;
use crate::{Backend, CustomStrategy, Device, KeptSky, Method, Plan, RenderError, Settings, Shader, SkyFrame};
use paper::{PaperIntegrator, PaperVisibility, Tables};
use render_cpu::{CpuShader, SceneSilhouettes, SkyShader, SurfaceHits, World};
use scene::{Frame, Object, Shape, Strategy};
use shading::{Accuracy, Coverage, LightId, LobeIntegrator, Unshadowed, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, DynMixture, LookAgain, Mask, MaskVisibility, Mixture};
use visibility_rays::RayBlockers;
use visibility_shadowmap::{ShadowMap, ShadowMapBlockers};
use visibility_silhouettes::{SilhouetteBlockers, SilhouetteMesh};
use visibility_spheres::SphereBlockers;
#[cfg(feature = "gpu")]
use {
    crate::backend::GpuParts,
    glam::Vec3,
    lighting::Light,
    render_gpu::ShadowCasting,
    scene::{Bounds, Scene},
    shading::{LightExtent, LightLobes as _, gpu::GpuLight as _},
    visibility_silhouettes::{AroundLight, GpuSilhouettes, meets_plane},
};

/// A sky before these kinds.
type Sky<'a> = SkyShader<'a, (Option<&'a SphereBlockers>, Option<&'a SilhouetteBlockers<'a>>)>;

/// The blockers of one frame, by strategy.
#[derive(Debug)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "a GPU gathers what its rays meet from them"))]
pub struct FrameBlockers<'a> {
    world: &'a World<'a>,
    spheres: Option<&'a SphereBlockers>,
    maps: Option<ShadowMapBlockers>,
    /// Silhouettes of the objects that shadow maps draw, for receivers on these objects.
    drawn: Option<OnObjects<SilhouetteBlockers<'a>>>,
    silhouettes: Option<SilhouetteBlockers<'a>>,
    rays: Option<RayBlockers<'a>>,
    /// The environment, where it is summed at once.
    sky: Option<SkyFrame<'a>>,
    /// Custom strategies.
    custom: &'a [Box<dyn CustomStrategy>],
    /// The place in the scene of the frame's only light.
    alone: Option<usize>,
    /// See [`Settings::own_radiance`].
    of_own: bool,
    /// See [`Settings::interpolate`].
    is_interpolated: bool,
    /// The meshes by silhouettes for all receivers.
    meshes: Vec<&'a SilhouetteMesh>,
    /// Whether there are shared meshes beside them.
    has_instances: bool,
    /// For each object the receivers that it hides lights from by its true surface.
    hides: Vec<HidesFrom>,
}

/// The receivers that an object hides lights from by its true surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum HidesFrom {
    None,
    All,
    /// Receivers on objects that are `Drawn` too.
    Drawn,
}

impl<'a> FrameBlockers<'a> {
    /// Gathers the blockers of a plan for pictures of an accuracy, and leaves out those that are empty. `silhouettes` are [those of
    /// the plan](Plan::silhouettes).
    #[must_use]
    pub fn new(
        plan: &Plan,
        world: &'a World<'a>,
        spheres: Option<&'a SphereBlockers>,
        maps: Vec<ShadowMap>,
        silhouettes: &'a SceneSilhouettes,
        accuracy: Accuracy,
    ) -> Self {
        let mut maps: Vec<(LightId, ShadowMap)> = (0..).map(LightId).zip(maps).collect();
        maps.retain(|(_, map)| map.faces() > 0);
        let scene = world.scene();
        let casters = plan.casters(scene);
        let is_drawn = |(object, is_caster): (&Object, &bool)| match &object.shape {
            Shape::Mesh(mesh) => *is_caster && maps.iter().any(|(_, map)| map.draws(&mesh.positions, &mesh.triangles)),
            // Silhouettes stand for them.
            Shape::Instances(_) | Shape::Spheres(_) => false,
        };
        let drawn: Vec<bool> = scene.objects.iter().zip(&casters).map(is_drawn).collect();

        let traced: Vec<bool> = (0..drawn.len()).map(|o| plan.of(o) == Strategy::Rays).collect();
        let rays = traced.contains(&true).then(|| rays_to(world, &traced));
        let is_in_maps = |mesh: &&SilhouetteMesh| casters[mesh.object() as usize];
        let (own, meshes): (Vec<_>, Vec<_>) = silhouettes.meshes().iter().partition(is_in_maps);
        let mut has_outlines = vec![false; drawn.len()];
        silhouettes.meshes().iter().for_each(|mesh| has_outlines[mesh.object() as usize] = true);
        let instances = silhouettes.instances();
        instances.objects().for_each(|object| has_outlines[object as usize] = true);
        let outlines = |meshes: &[&'a SilhouetteMesh], in_maps: bool| {
            let has = |o: u32| has_outlines[o as usize] && casters[o as usize] == in_maps;
            let hits = SurfaceHits::new(world, has);
            let blockers = SilhouetteBlockers::new(meshes.iter().copied(), hits).with_tolerance(accuracy.tolerance);
            if in_maps { blockers } else { blockers.with_instances(instances) }
        };
        let hides = |o: usize| match (traced[o], drawn[o]) {
            (true, _) => HidesFrom::All,
            (_, true) => HidesFrom::Drawn,
            _ if has_outlines[o] && !casters[o] => HidesFrom::All,
            _ => HidesFrom::None,
        };
        let hides = (0..drawn.len()).map(hides).collect();
        let silhouettes = (!meshes.is_empty() || !instances.is_empty()).then(|| outlines(&meshes, false));
        let on_drawn = drawn.contains(&true).then(|| OnObjects::new(outlines(&own, true), drawn.clone()));
        let maps = (!maps.is_empty()).then(|| ShadowMapBlockers::of_lights(maps).with_casters(casters).leaving(drawn));
        Self {
            world,
            spheres,
            maps,
            drawn: on_drawn,
            silhouettes,
            rays,
            sky: None,
            custom: &[],
            alone: None,
            of_own: false,
            is_interpolated: false,
            meshes,
            has_instances: !instances.is_empty(),
            hides,
        }
    }

    /// The same for a frame of which the scene's light at a place is the only one.
    pub(crate) const fn before_light(mut self, place: usize) -> Self {
        self.alone = Some(place);
        self
    }

    /// The same with an environment that is summed at once where it can be: before spheres and silhouettes, by
    /// [`Method::Moments`]. Elsewhere its patches are lights. On a GPU patches also shine on lobes narrower than the first table's samples, and
    /// before rays that stand for silhouettes there. Its table is made only where it is used.
    pub(crate) fn under(self, kept: &'a mut KeptSky, frame: &Frame<'_>, backend: &Backend, method: Method) -> Self {
        let device = backend.device();
        let is_summed = self.sums_skies(method) && (device == Device::Cpu || !self.has_instances);
        let scene = self.world.scene();
        let sky = if is_summed { kept.follow(scene, frame, device) } else { None };
        let has_forms = sky.is_some() && device == Device::Cpu;
        let silhouettes = self.silhouettes.map(|own| if has_forms { own.under_sky() } else { own });
        Self { sky, silhouettes, ..self }
    }

    /// Whether a sky before these blockers is summed at once.
    fn sums_skies(&self, method: Method) -> bool {
        let are_drawn = self.maps.is_none() && self.rays.is_none() && self.custom.is_empty();
        are_drawn && method == Method::Moments
    }

    /// Adds the custom strategies, and sets [the kind of tolerance](Settings::own_radiance) and [interpolation](Settings::interpolate).
    pub(crate) fn with(self, custom: &'a [Box<dyn CustomStrategy>], settings: &Settings) -> Self {
        Self { custom, of_own: settings.own_radiance, is_interpolated: settings.interpolate, ..self }
    }

    /// The meshes by silhouettes, packed for a GPU. `None` if other objects are traced by rays anyway, if there are instances, or if a round light contains
    /// parts of triangles: rays then block for these meshes too, equally exactly.
    #[cfg(feature = "gpu")]
    fn gpu_silhouettes(&self) -> Option<GpuSilhouettes> {
        let by_rays = self.rays.is_some() || self.drawn.is_some() || self.has_instances;
        let silhouettes = self.silhouettes.as_ref().filter(|_| !by_rays)?;
        let mut cut = Vec::new();
        for light in &self.world.scene().lights {
            let mut triangles = Vec::new();
            if light.gpu_roundness().is_some() {
                // All blockers are in front of the sky, whose sphere may contain the scene.
                if !matches!(light, Light::Sky(_)) {
                    triangles = cut_by_plane(silhouettes, light, self.world.scene());
                }
            } else if let Some(sphere) = light.sphere().filter(|sphere| sphere.radius > 0.0) {
                let mut is_met = false;
                silhouettes.triangles_meeting(sphere, &mut |_| is_met = true);
                if is_met {
                    return None;
                }
            }
            cut.push(triangles);
        }
        if let Some(place) = self.alone {
            cut = cut.drain(place..=place).collect();
        }
        Some(GpuSilhouettes::new(self.meshes.iter().copied()).with_clipped(&cut))
    }

    /// The mask of a light in which all of these blockers are drawn.
    pub(crate) fn mask(self, query: &VisibilityQuery<'_>) -> (Coverage, Mask) {
        let maps = self.maps.map(|maps| Mixture::new(maps, self.drawn));
        let custom = DynMixture(self.custom.iter().map(|own| own.blockers()).collect());
        let triangles = Mixture::new(self.silhouettes, Mixture::new(maps, self.rays));
        MaskVisibility::new(Mixture::new(custom, Mixture::new(self.spheres, triangles))).mask(query)
    }

    /// Runs `work` with a shader for these blockers.
    ///
    /// Not for a browser's GPU, which no call can wait for: see [`shade_async`](Self::shade_async).
    ///
    /// # Errors
    /// Those of the work; [`RenderError::NotOnGpu`] for a method that a GPU does not support, `RenderError::Gpu` from the device.
    pub fn shade<W: ShaderTask>(
        self,
        backend: &mut Backend,
        method: Method,
        tables: Option<&Tables>,
        work: W,
    ) -> Result<W::Output, RenderError> {
        at_once(self.shade_async(backend, method, tables, work))?
    }

    /// As [`shade`](Self::shade). The future is ready at its first poll, except on a browser's GPU.
    ///
    /// # Errors
    /// Those of [`shade`](Self::shade).
    pub async fn shade_async<W: ShaderTask>(
        mut self,
        backend: &mut Backend,
        method: Method,
        tables: Option<&Tables>,
        work: W,
    ) -> Result<W::Output, RenderError> {
        let tables = tables.filter(|_| method == Method::Paper);
        #[cfg(feature = "gpu")]
        if let Backend::Gpu(gpu) = backend {
            return self.shade_on_gpu(gpu, method, tables, work).await;
        }
        #[cfg(not(feature = "gpu"))]
        let Backend::Cpu = backend;
        work.with(&mut self.on_cpu(method, tables)).await
    }

    /// The shader of the CPU. Takes blockers that are not borrowed. By the default method spheres alone and silhouettes alone have a shader of their own; all
    /// else shares one, in which absent kinds cost a branch a query: each shader takes seconds to compile.
    fn on_cpu<'s>(&'s mut self, method: Method, tables: Option<&'s Tables>) -> AnyCpuShader<'s> {
        let is_summed = self.sums_skies(method);
        let (spheres, silhouettes) = (self.spheres, self.silhouettes.as_ref());
        let sky = self.sky.take().filter(|_| is_summed);
        let sky = sky.map(|sky| SkyShader::new(sky.tables, sky.replaced, (spheres, silhouettes)));
        let (drawn, rays) = (self.drawn.take(), self.rays.take());
        let maps = self.maps.take().map(|maps| Mixture::new(maps, drawn));
        let (look_again, is_interpolated) = (look_again(self.of_own), self.is_interpolated);
        let is_built_in = self.custom.is_empty();
        match (method, spheres, maps, silhouettes, rays) {
            (_, None, None, None, None) if is_built_in => match tables {
                Some(tables) => AnyCpuShader::new(CpuShader::with_integrator(Unshadowed, PaperIntegrator { tables })),
                None => AnyCpuShader::new(CpuShader::new(Unshadowed).with_sky(sky)),
            },
            (Method::Moments, Some(spheres), None, None, None) if is_built_in => {
                fractions(masks(spheres, look_again), sky, is_interpolated)
            }
            (Method::Moments, None, None, Some(silhouettes), None) if is_built_in => {
                fractions(masks(silhouettes, look_again), sky, is_interpolated)
            }
            (method, spheres, maps, silhouettes, rays) => {
                let custom = || DynMixture(self.custom.iter().map(|own| own.blockers()).collect());
                let custom = (!is_built_in).then(custom);
                let triangles = Mixture::new(silhouettes, Mixture::new(maps, rays));
                let visibility = masks(Mixture::new(custom, Mixture::new(spheres, triangles)), look_again);
                match (method, tables) {
                    (Method::Lobes, _) => {
                        AnyCpuShader::new(CpuShader::with_integrator(visibility.with_lobes(), LobeIntegrator))
                    }
                    (Method::Paper, Some(tables)) => {
                        let visibility = PaperVisibility::new(visibility.into_blockers(), tables);
                        AnyCpuShader::new(CpuShader::with_integrator(visibility, PaperIntegrator { tables }))
                    }
                    _ => fractions(visibility, sky, is_interpolated),
                }
            }
        }
    }

    /// [`shade_async`](Self::shade_async) on a GPU.
    #[cfg(feature = "gpu")]
    async fn shade_on_gpu<W: ShaderTask>(
        self,
        gpu: &mut crate::backend::GpuBackend,
        method: Method,
        tables: Option<&Tables>,
        work: W,
    ) -> Result<W::Output, RenderError> {
        let silhouettes = self.gpu_silhouettes();
        let casting = self.hides.iter().map(|hides| match hides {
            HidesFrom::None => ShadowCasting::None,
            HidesFrom::All => ShadowCasting::All,
            HidesFrom::Drawn => ShadowCasting::Alike,
        });
        let casting: Vec<ShadowCasting> = casting.collect();
        let traced = casting.iter().any(|casting| *casting != ShadowCasting::None);
        let traced = traced.then_some((self.world, casting));
        if method == Method::Lobes {
            return Err(RenderError::NotOnGpu(crate::error::LOBES));
        }
        let mut blockers = Vec::with_capacity(self.custom.len());
        for own in self.custom {
            let fault = || RenderError::Strategy { name: own.name(), fault: crate::error::NO_WGSL.to_owned() };
            blockers.push(own.gpu_blockers().ok_or_else(fault)?);
        }
        let parts = GpuParts { spheres: self.spheres, maps: self.maps.as_ref(), silhouettes: silhouettes.as_ref() };
        let shader = gpu.occluded(tables, &parts, traced, &blockers)?;
        let sky = self.sky.as_ref().and_then(|sky| Some((sky.packed.as_ref()?, sky.replaced.clone())));
        shader.set_sky(sky);
        // Software drivers would end the many loops over a map's texels.
        let is_short = shader.gpu().is_software() && parts.maps.is_some();
        shader.set_look_again(if is_short { LookAgain::Never } else { look_again(self.of_own) });
        work.with(shader).await
    }
}

/// A task for a shader of any device and visibility.
pub trait ShaderTask {
    /// The result of the task.
    type Output;

    /// Runs the task.
    ///
    /// # Errors
    /// Those of the task.
    fn with<S: Shader>(self, shader: &mut S) -> impl Future<Output = Result<Self::Output, RenderError>>;
}

/// The triangles that the plane of a flat light or of a tube may cut: as on a CPU, which leaves out most of them for each receiver.
#[cfg(feature = "gpu")]
fn cut_by_plane(silhouettes: &SilhouetteBlockers<'_>, light: &Light, scene: &Scene) -> Vec<[Vec3; 3]> {
    let bounds = light.gpu_bounds();
    let around = AroundLight::new(bounds, &light.extent().unwrap_or(LightExtent::of_sphere(bounds.radius)));
    let mut triangles = Vec::new();
    silhouettes.triangles_meeting(around.sphere(), &mut |corners| {
        if around.may_have(&corners) {
            triangles.push(corners);
        }
    });
    if let Light::Flat(flat) = light
        && triangles.len() > FEW_TRIANGLES
    {
        let Bounds { min, max } = scene.bounds();
        let margin = f64::from(PLANE_MARGIN * (max - min).length());
        triangles.retain(|corners| meets_plane(corners, flat.normal(), flat.as_disc().0, margin));
    }
    triangles
}

/// Near a flat light so many triangles are not worth a search for those that its plane cuts.
#[cfg(feature = "gpu")]
const FEW_TRIANGLES: usize = 16;
/// The planes up to which surfaces block are as far from a light's own plane as this part of the receiver's height, and less.
#[cfg(feature = "gpu")]
const PLANE_MARGIN: f32 = 1e-3;

/// Where masks are drawn again, with the tolerance relative to [own radiance](Settings::own_radiance) or not.
const fn look_again(of_own: bool) -> LookAgain {
    if of_own { LookAgain::Everywhere } else { LookAgain::Openings }
}

fn masks<B: Blockers>(blockers: B, look_again: LookAgain) -> MaskVisibility<B> {
    MaskVisibility::new(blockers).look_again(look_again)
}

/// A shader by visible fractions, with [interpolation](Settings::interpolate) or without.
fn fractions<'s, V: Visibility + 's>(visibility: V, sky: Option<Sky<'s>>, is_interpolated: bool) -> AnyCpuShader<'s> {
    AnyCpuShader::new(CpuShader::new(visibility).interpolating(is_interpolated).with_sky(sky))
}

/// Rays to the surfaces of some objects.
fn rays_to<'a>(world: &'a World<'a>, traced: &[bool]) -> RayBlockers<'a> {
    let rays = RayBlockers::new(world);
    if traced.iter().all(|traced| *traced) { rays } else { rays.only(|o| traced[o as usize]) }
}
