use core::sync::atomic::AtomicBool;
use glam::Vec3;
use pictures::luminance;
use ray_tracing::{GBuffer, World};
use reference::{Geometry, Reference, ReferenceJob};
use scene::BlockerSet;

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

/// The exposure, in stops, that suits a scene at its present time: `E = log₂(0.5/Y)`, rounded to a tenth, within ±32. `Y` is the
/// luminance that nine of ten lit pixels stay below. 0 if no pixel is lit.
///
/// The Monte-Carlo sampler renders a picture of at most 64 × 64 pixels for metering, so that the exposure does not depend on
/// method, strategy, device or window. Background and surfaces that emit do not count.
///
/// # Cost
/// 16 shadow rays for each light and metered pixel: about 10 ms of two cores.
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
    let blockers = BlockerSet::default();
    let job = ReferenceJob { world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 0 };
    let mut reference = Reference::new(job);
    reference.advance(RAYS, &AtomicBool::new(false), &|_| {});
    exposure_of(reference.estimate().radiance)
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
