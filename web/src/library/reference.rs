//! The Monte Carlo reference of a renderer's picture.

use crate::library::fault::Fault;
use crate::library::mail::Answer;
use crate::library::progress::Progress;
use bytemuck::cast_slice;
use core::sync::atomic::{AtomicU64, Ordering};
use glam::Vec3;
use ray_tracing::{GBuffer, World};
use reference::{Geometry, Reference, ReferenceJob};
use renderer::{RenderError, Renderer};
use scene::{BlockerSet, Cancel};

/// More camera rays than this, at 192 bytes each, are refused.
const MAX_RAYS: u64 = 1 << 23;
/// Reports of the whole work, at most.
const REPORTS: u64 = 200;

/// The picture by shadow rays on the true surfaces: radiance, the same without blockers, and the standard error of the first.
pub(crate) fn reference(
    renderer: &mut Renderer,
    samples: u32,
    seed: u64,
    progress: &Progress,
) -> Result<Answer, Fault> {
    let (size, rays) = ([renderer.scene().width, renderer.scene().height], renderer.settings().samples);
    let count = u64::from(size[0]) * u64::from(size[1]) * u64::from(rays.usual());
    if count > MAX_RAYS {
        return Err(Fault::range(format!("{count} camera rays are too many for a reference, at most {MAX_RAYS}")));
    }
    let sampled = renderer.with_world(|world| {
        let gbuffer = GBuffer::sampled(world, size, rays, [0..size[0], 0..size[1]], &Cancel::new())?;
        let blockers = BlockerSet::default();
        let job = ReferenceJob { world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed };
        let mut reference = Reference::new(job);
        let (all, done) = (reference.work(samples).max(1), AtomicU64::new(0));
        let report = |part: u64| {
            let before = done.fetch_add(part, Ordering::Relaxed);
            if REPORTS * (before + part) / all > REPORTS * before / all {
                // It stops the work by itself.
                let _ = progress.report("sampling", (before + part) as f64 / all as f64);
            }
        };
        reference.advance(samples, progress.is_over(), &report);
        Some(pictures(&reference, &gbuffer, world))
    });
    match sampled {
        Some(all) if !progress.is_over().load(Ordering::Relaxed) => {
            let named = ["beauty", "unshadowed", "stderr"].into_iter().zip(&all);
            Ok(Answer::named(named.map(|(name, picture)| (name.to_owned(), cast_slice(picture)))))
        }
        _ => Err(RenderError::Cancelled.into()),
    }
}

fn pictures(reference: &Reference<'_>, gbuffer: &GBuffer, world: &World<'_>) -> [Vec<Vec3>; 3] {
    let mut estimate = reference.estimate();
    gbuffer.add_emission(&mut estimate.radiance);
    gbuffer.add_emission(&mut estimate.unshadowed);
    let background = world.scene().background;
    [
        gbuffer.picture(&estimate.radiance, background),
        gbuffer.picture(&estimate.unshadowed, background),
        gbuffer.resolve_errors(&estimate.std_error),
    ]
}
