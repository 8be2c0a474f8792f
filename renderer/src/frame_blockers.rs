use crate::{Backend, Method, Plan, RenderError, Shader};
use lobe_core::paper::Tables;
use lobe_core::{Accuracy, LightId, Method as Products, Unshadowed};
use render_cpu::{CpuShader, RayBlockers, SceneSilhouettes, SurfaceHits, World};
use visibility_mask::{Blockers, MaskVisibility, Mixture, PaperVisibility};
use visibility_shadowmap::{ShadowMap, ShadowMapBlockers};
use visibility_silhouettes::{SilhouetteBlockers, SilhouetteMesh};
use visibility_spheres::SphereBlockers;
#[cfg(feature = "gpu")]
use {
    glam::Vec3,
    lighting::Light,
    lobe_core::gpu::GpuLight as _,
    lobe_core::{LightLobes as _, Sphere},
    visibility_silhouettes::AnyHit,
};

/// In which form visibility meets reflectance, ready to be used.
#[derive(Clone, Copy, Debug)]
pub enum Form<'t> {
    /// Visible fractions of lobes.
    Fractions,
    /// Lobes of visibility.
    Lobes,
    /// The paper's lobes, by its tables.
    Paper(&'t Tables),
}

/// What blocks light in one frame, by strategy.
#[derive(Debug)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "a GPU gathers what its rays meet from them"))]
pub struct FrameBlockers<'a> {
    world: &'a World<'a>,
    spheres: Option<&'a SphereBlockers>,
    maps: Option<ShadowMapBlockers>,
    silhouettes: Option<SilhouetteBlockers<'a, SurfaceHits<'a>>>,
    rays: Option<RayBlockers<'a>>,
    meshes: &'a [SilhouetteMesh],
    /// For each object whether it is by rays or by silhouettes.
    traced: Vec<bool>,
}

impl<'a> FrameBlockers<'a> {
    /// Gathers what the plan asks for, for pictures of an accuracy, and leaves out what turned out empty.
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
        let mut traced = plan.traced(scene, &casters);
        let rays = traced.contains(&true).then(|| match traced.iter().all(|traced| *traced) {
            true => RayBlockers::new(world),
            false => RayBlockers::new(world).only(|o| traced[o as usize]),
        });
        let maps = (!maps.is_empty()).then(|| ShadowMapBlockers::of_lights(maps).with_casters(casters));
        let meshes = silhouettes.meshes();
        let silhouettes = (!meshes.is_empty()).then(|| {
            let hits = SurfaceHits::new(world, |o| plan.by_silhouettes(scene, o));
            SilhouetteBlockers::new(meshes, hits).with_tolerance(accuracy.tolerance)
        });
        (0..).zip(&mut traced).for_each(|(o, traced)| *traced |= plan.by_silhouettes(scene, o));
        Self { world, spheres, maps, silhouettes, rays, meshes, traced }
    }

    /// The meshes that a GPU can have by silhouettes; what is exact by these is exact by rays, too: where others are by rays anyway, or
    /// where a light holds parts of triangles, or the plane of a flat one cuts them next to it.
    #[cfg(feature = "gpu")]
    fn outlines(&self) -> &'a [SilhouetteMesh] {
        let Some(silhouettes) = self.silhouettes.as_ref().filter(|_| self.rays.is_none()) else { return &[] };
        let hits = silhouettes.any_hit();
        let holds = |light: &Light| {
            let mut is_met = false;
            let around = match light {
                _ if light.gpu_roundness().is_some() => light.bounds_from(&Sphere { center: Vec3::ZERO, radius: 0.0 }),
                _ => light.ball().unwrap_or(Sphere { center: Vec3::ZERO, radius: 0.0 }),
            };
            if around.radius > 0.0 {
                hits.triangles_meeting(around, &mut |corners| is_met |= cuts(light, corners));
            }
            is_met
        };
        if self.world.scene().lights.iter().any(holds) { &[] } else { self.meshes }
    }

    /// Does the work with the shader that these blockers make. What is not there is not in the shader; mixtures of any kinds
    /// share one.
    ///
    /// # Errors
    /// Those of the work; [`RenderError::NotOnGpu`] for a form that a GPU does not have, `RenderError::Gpu` of the device.
    pub fn shade<W: Work>(self, backend: &mut Backend, form: Form<'_>, work: W) -> Result<W::Output, RenderError> {
        #[cfg(feature = "gpu")]
        if let Backend::Gpu(gpu) = backend {
            let outlines = self.outlines();
            let traced = self.traced.contains(&true).then(|| (self.world.scene(), self.traced));
            let method = match form {
                Form::Fractions => Products::Moments,
                Form::Lobes => return Err(RenderError::NotOnGpu(crate::backend::LOBES)),
                Form::Paper(tables) => Products::Paper(tables),
            };
            return work.with(gpu.occluded(method, self.spheres, self.maps.as_ref(), traced, outlines)?);
        }
        #[cfg(not(feature = "gpu"))]
        let Backend::Cpu = backend;
        match (self.spheres, self.maps, self.silhouettes, self.rays) {
            (None, None, None, None) => work.with(&mut CpuShader::with_method(Unshadowed, form.products())),
            (Some(spheres), None, None, None) => masked(spheres, form, work),
            (None, None, Some(silhouettes), None) => masked(silhouettes, form, work),
            (spheres, maps, silhouettes, rays) => {
                let triangles = Mixture::new(silhouettes, Mixture::new(maps, rays));
                masked(Mixture::new(spheres, triangles), form, work)
            }
        }
    }
}

impl<'t> Form<'t> {
    /// That of a method; [`Fractions`](Self::Fractions) where the paper's has no tables yet.
    #[must_use]
    pub const fn of(method: Method, tables: Option<&'t Tables>) -> Self {
        match (method, tables) {
            (Method::Paper, Some(tables)) => Self::Paper(tables),
            (Method::Lobes, _) => Self::Lobes,
            _ => Self::Fractions,
        }
    }

    /// How products of lobes are taken.
    const fn products(self) -> Products<'t> {
        match self {
            Self::Fractions | Self::Lobes => Products::Moments,
            Self::Paper(tables) => Products::Paper(tables),
        }
    }
}

/// Whether a triangle that meets a light, or what is next to a flat one, ends there for some receiver: on its lit side it reaches to its
/// plane. What lies in the plane, as a lamp's face, does not.
#[cfg(feature = "gpu")]
fn cuts(light: &Light, corners: [Vec3; 3]) -> bool {
    match light {
        Light::Inside(inside) => cuts(&inside.light, corners),
        Light::Flat(light) => {
            let (middle, _) = light.as_disc();
            let heights = corners.map(|p| light.normal().dot(p - middle));
            let [low, high] = [heights.into_iter().reduce(f32::min), heights.into_iter().reduce(f32::max)]
                .map(Option::unwrap_or_default);
            let slack = IN_THE_PLANE * light.area().sqrt();
            let reaches = |low: f32, high: f32| high > slack && low < slack;
            reaches(low, high) || light.two_sided && reaches(-high, -low)
        }
        _ => true,
    }
}

/// Heights above a light's plane, in its size, that are rounding.
#[cfg(feature = "gpu")]
const IN_THE_PLANE: f32 = 1e-5;

/// Something to be done with a shader of whatever device and visibility.
pub trait Work {
    /// What comes of it.
    type Output;

    /// Does it.
    ///
    /// # Errors
    /// Its own.
    fn with<S: Shader>(self, shader: &mut S) -> Result<Self::Output, RenderError>;
}

fn masked<B: Blockers, W: Work>(blockers: B, form: Form<'_>, work: W) -> Result<W::Output, RenderError> {
    match form {
        Form::Fractions => work.with(&mut CpuShader::new(MaskVisibility::new(blockers))),
        Form::Lobes => work.with(&mut CpuShader::new(MaskVisibility::new(blockers).with_lobes())),
        Form::Paper(tables) => {
            let visibility = PaperVisibility::new(blockers, tables);
            work.with(&mut CpuShader::with_method(visibility, form.products()))
        }
    }
}
