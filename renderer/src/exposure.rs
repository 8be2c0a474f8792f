use crate::points::Shading;
use crate::{Backend, FrameBlockers, KeptSky, KeptSpheres, Method, Plan, RenderError};
use core::ops::ControlFlow;
use core::sync::atomic::AtomicBool;
use glam::Vec3;
use pictures::luminance;
use ray_tracing::{GBuffer, World};
use reference::{Estimate, Geometry, Reference, ReferenceJob};
use render_cpu::{SceneSpheres, ShadeRequest};
use scene::{BlockerSet, Frame, Strategy};
use shading::Accuracy;

/// Pixels along the longer side of the picture that is metered.
const SIDE: f32 = 64.0;
/// Shadow rays for each pixel and light.
const RAYS: u32 = 16;
/// The fraction of lit pixels that are darker than the metered luminance.
const BRIGHT: f32 = 0.9;
/// The metered luminance after exposure.
const TARGET: f64 = 0.5;

/// The largest exposure, in stops.
const MOST: f64 = 32.0;

/// A pixel is noisy whose standard error is more than this part of its luminance.
const NOISY: f64 = 0.35;
/// The part of the lit pixels that may be noisy.
const MOST_NOISY: f64 = 0.25;

/// The exposure, in stops, that suits a scene at its present time: `E = log₂(0.5/Y)`, rounded to a tenth, within ±32. `Y` is the
/// luminance that nine of ten lit pixels stay below. 0 if no pixel is lit.
///
/// A picture of at most 64 × 64 pixels is metered, of its own: the exposure does not depend on method, strategy, device, threads or window.
/// The Monte-Carlo sampler renders it. Where its few rays leave open how bright the pixels are, as in rooms that are lit through small openings,
/// silhouettes render it again. Background and surfaces that emit do not count.
///
/// # Cost
/// 16 shadow rays for each light and metered pixel: about 10 ms of two cores. With silhouettes as much as that number of pixels of a picture, and
/// their preparation.
///
/// ```
/// use ray_tracing::World;
/// let mut scene = scene::builtin();
/// let before = renderer::exposure(&World::new(&scene));
/// scene.lights.clear();
/// assert_eq!(renderer::exposure(&World::new(&scene)), 0.0);
/// assert!((0.5..1.5).contains(&before));
/// ```
#[must_use]
pub fn exposure(world: &World<'_>) -> f32 {
    let scene = world.scene();
    let scale = (SIDE / scene.width.max(scene.height) as f32).min(1.0);
    let [width, height] = [scene.width, scene.height].map(|side| ((side as f32 * scale).round() as u32).max(1));
    let gbuffer = GBuffer::new(world, width, height, 1);
    let sampled = sampled(world, &gbuffer);
    let masked = is_doubtful(&sampled).then(|| masked(world, &gbuffer).ok()).flatten();
    exposure_of(masked.unwrap_or(sampled.radiance))
}

/// The light at points by a few rays.
fn sampled(world: &World<'_>, gbuffer: &GBuffer) -> Estimate {
    let blockers = BlockerSet::default();
    let job = ReferenceJob { world, gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 0 };
    let mut reference = Reference::new(job);
    reference.advance(RAYS, &AtomicBool::new(false), &|_| {});
    reference.estimate()
}

/// Whether rays leave open how bright the pixels are: many lit ones are noisy, or more are dark, which a few rays may be by chance.
fn is_doubtful(sampled: &Estimate) -> bool {
    let Estimate { radiance, unshadowed, std_error } = sampled;
    let (mut lit, mut noisy, mut dark) = (0, 0, 0);
    for ((seen, unshadowed), error) in radiance.iter().zip(unshadowed).zip(std_error) {
        let seen = luminance(*seen);
        if seen > 0.0 {
            lit += 1;
            noisy += u32::from(luminance(*error) > NOISY * seen);
        } else {
            dark += u32::from(luminance(*unshadowed) > 0.0);
        }
    }
    f64::from(noisy) > MOST_NOISY * f64::from(lit) || dark > lit
}

/// The light at points by the silhouettes of all meshes.
fn masked(world: &World<'_>, gbuffer: &GBuffer) -> Result<Vec<Vec3>, RenderError> {
    let scene = world.scene();
    let plan = Plan::new(Some(Strategy::Silhouettes), scene);
    let (mut set, mut spheres) = (BlockerSet::default(), KeptSpheres::default());
    let source = |object| plan.spheres(scene, object);
    SceneSpheres::new(scene, None, source, &mut |_, _| ControlFlow::Continue(()))?.pose(scene, None, &mut set)?;
    spheres.update(&set);
    let silhouettes = plan.silhouettes(scene);
    let frame = Frame::new(&gbuffer.materials, &scene.lights, Accuracy::default());
    let (mut backend, mut sky) = (Backend::Cpu, KeptSky::default());
    let blockers = FrameBlockers::new(&plan, world, spheres.get(), Vec::new(), &silhouettes, frame.accuracy);
    let blockers = blockers.under(&mut sky, &frame, &backend, Method::Moments);
    let shading = Shading { points: &gbuffer.points, frame, request: ShadeRequest::default() };
    Ok(blockers.shade(&mut backend, Method::Moments, None, shading)?.0)
}

/// The [`exposure`] that suits these pixels: that of a scene is metered without its method and its window.
///
/// ```
/// use glam::Vec3;
/// assert_eq!(renderer::exposure_of([Vec3::ZERO, Vec3::splat(0.25)]), 1.0);
/// ```
#[must_use]
pub fn exposure_of(radiance: impl IntoIterator<Item = Vec3>) -> f32 {
    let luminances = radiance.into_iter().map(luminance);
    let mut lit: Vec<f64> = luminances.filter(|y| *y > 0.0 && y.is_finite()).collect();
    lit.sort_unstable_by(f64::total_cmp);
    let Some(last) = lit.len().checked_sub(1) else { return 0.0 };
    let bright = lit[(BRIGHT * last as f32).round() as usize];
    // Adding zero makes −0 equal to 0.
    ((10.0 * (TARGET / bright).log2().clamp(-MOST, MOST)).round() / 10.0 + 0.0) as f32
}
