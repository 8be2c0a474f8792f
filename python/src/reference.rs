//! The Monte Carlo reference of a scene.

use crate::errors::OrRaise;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::values;
use crate::work::{Reporter, run};
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Estimate, Geometry, Reference, ReferenceJob};
use cosine_lobes::render_cpu::PixelSamples;
use cosine_lobes::renderer::{self, Plan, RenderError, scene_spheres};
use cosine_lobes::scene::{self, Animation, BlockerSet, Cancel, Strategy};
use glam::Vec3;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};

/// More camera rays than this, at 192 bytes each, are refused.
const MAX_POINTS: u64 = 1 << 25;
/// The most samples a point.
const MAX_SAMPLES: u32 = 1 << 24;

/// The geometry that casts shadows.
#[derive(Clone, Copy, PartialEq)]
enum Shadows {
    Scene,
    Spheres,
    Mesh,
    None,
}

/// Everything that a reference is computed from.
struct Job {
    scene: scene::Scene,
    animation: Animation,
    settings: renderer::Settings,
    shadows: Shadows,
    time: f32,
    spp: u32,
    seed: u64,
}

/// Its pictures.
struct Pictures {
    radiance: Vec<Vec3>,
    unshadowed: Vec<Vec3>,
    errors: Vec<Vec3>,
}

/// The same picture by Monte Carlo, as `lobes reference` computes it: a dictionary of "beauty", "unshadowed" and "stderr", the standard
/// error of each pixel.
///
/// `geometry` casts the shadows: "scene" as pictures have it, "spheres", "mesh" the true triangles, or "none".
#[pyfunction]
#[pyo3(signature = (scene, *, spp = 1024, geometry = "scene", seed = 0, samples = None, time = 0.0, progress = None))]
#[expect(clippy::too_many_arguments, reason = "each is a keyword")]
pub(crate) fn reference<'py>(
    py: Python<'py>,
    scene: PyRef<'py, Scene>,
    spp: u32,
    geometry: &str,
    seed: u64,
    samples: Option<u32>,
    time: f32,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let shadows = match geometry {
        "scene" => Shadows::Scene,
        "spheres" => Shadows::Spheres,
        "mesh" => Shadows::Mesh,
        "none" => Shadows::None,
        _ => {
            let fault = format!("geometry is \"{geometry}\": expected one of scene, spheres, mesh, none");
            return Err(PyValueError::new_err(fault));
        }
    };
    if !(1..=MAX_SAMPLES).contains(&spp) {
        return Err(PyValueError::new_err(format!("spp is {spp}: expected 1 to {MAX_SAMPLES}")));
    }
    if !(time >= 0.0 && time.is_finite()) {
        return Err(PyValueError::new_err(format!("time is {time}: expected seconds of at least 0")));
    }
    let changes = PyDict::new(py);
    changes.set_item("samples", samples)?;
    let settings = Settings::changed(py, None, Some(&changes))?.settings()?;
    let (PixelSamples::Uniform(_) | PixelSamples::Edges(_)) = settings.samples;
    let (own, animation) = (scene.scene.clone(), scene.animation.clone());
    drop(scene);
    own.validate().or_raise()?;
    let size = [own.width as usize, own.height as usize];
    let rays = u64::from(own.width) * u64::from(own.height) * u64::from(settings.samples.usual());
    if rays > MAX_POINTS {
        let fault = format!("{rays} camera rays are too many for a reference, at most {MAX_POINTS}");
        return Err(PyValueError::new_err(fault));
    }
    let job = Job { scene: own, animation, settings, shadows, time, spp, seed };
    let done = run(py, progress, |cancel, reporter| job.run(cancel, reporter))?.or_raise()?;
    let all = PyDict::new(py);
    all.set_item("beauty", values::layer(py, size, &done.radiance)?)?;
    all.set_item("unshadowed", values::layer(py, size, &done.unshadowed)?)?;
    all.set_item("stderr", values::layer(py, size, &done.errors)?)?;
    Ok(all)
}

impl Job {
    fn run(self, cancel: &Cancel, reporter: &Reporter) -> Result<Pictures, RenderError> {
        let Self { mut scene, animation, settings, shadows, time, spp, seed } = self;
        let plan = Plan::with_backdrops((shadows != Shadows::Scene).then_some(Strategy::Spheres), &scene);
        let solid = plan.by_surfaces(&scene);
        let geometry = match shadows {
            Shadows::None => Geometry::None,
            Shadows::Mesh => Geometry::Mesh,
            Shadows::Scene if solid.contains(&true) => Geometry::Mixed(&solid),
            Shadows::Scene | Shadows::Spheres => Geometry::Spheres,
        };
        let mut blockers = BlockerSet::default();
        let spheres = match geometry {
            Geometry::Spheres | Geometry::Mixed(_) => {
                let cache = settings.cache.as_deref();
                Some(scene_spheres(&mut scene, &animation, &plan, cache, &mut |event| {
                    if cancel.is_cancelled() {
                        return core::ops::ControlFlow::Break(());
                    }
                    reporter.hear(event)
                })?)
            }
            Geometry::Mesh | Geometry::None => None,
        };
        animation.seek(time, &mut scene);
        if let Some(spheres) = spheres {
            spheres.pose(&scene, Some((&animation, time)), &mut blockers)?;
        }
        let world = World::new(&scene);
        let whole = [0..scene.width, 0..scene.height];
        let gbuffer = GBuffer::sampled(&world, [scene.width, scene.height], settings.samples, whole, cancel);
        let gbuffer = gbuffer.ok_or(RenderError::Cancelled)?;
        let job = ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry, seed };
        let mut reference = Reference::new(job);
        let (all, done) = (reference.work(spp), Mutex::new(0));
        reference.advance(spp, cancel.flag(), &|part| {
            // Held over the report, so that reports come in order from all threads.
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            let before = *done;
            *done += part;
            // A thousand reports are enough.
            let thousandths = |work: u64| 1000 * work / all.max(1);
            if thousandths(*done) > thousandths(before) {
                reporter.progress("sampling", *done as f32 / all.max(1) as f32);
            }
        });
        if cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        Ok(pictures(reference.estimate(), &gbuffer, scene.background))
    }
}

fn pictures(mut estimate: Estimate, gbuffer: &GBuffer, background: Vec3) -> Pictures {
    gbuffer.add_emission(&mut estimate.radiance);
    gbuffer.add_emission(&mut estimate.unshadowed);
    Pictures {
        radiance: gbuffer.picture(&estimate.radiance, background),
        unshadowed: gbuffer.picture(&estimate.unshadowed, background),
        errors: gbuffer.resolve_errors(&estimate.std_error),
    }
}
