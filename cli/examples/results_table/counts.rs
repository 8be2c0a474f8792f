//! Cost and error of more or fewer spheres of the same object.

use crate::measure::{How, Timing, frames};
use crate::models::Models;
use crate::scenes::close_up;
use core::sync::atomic::AtomicBool;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Geometry, Reference, ReferenceJob};
use cosine_lobes::{Picture, RegionError, ShadowErrors};
use glam::Vec3;

/// A set of this number of spheres.
pub(crate) struct Count {
    pub(crate) spheres: usize,
    pub(crate) timing: Timing,
    /// Against the mesh.
    pub(crate) penumbra: RegionError,
}

/// Samples of the reference: it errs by some 0.1 %.
const SAMPLES: u32 = 256;

pub(crate) fn measure(models: &mut Models, repeats: usize) -> Result<Vec<Count>, String> {
    eprintln!("Sets by count");
    let of = |spheres: usize| {
        let (scene, blockers) = close_up(models.of(spheres)?, 1.0);
        let world = World::new(&scene);
        let gbuffer = GBuffer::new(&world, 360, 240, 1);
        let job =
            ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 1 };
        let mut reference = Reference::new(job);
        reference.advance(SAMPLES, &AtomicBool::new(false), &|_| {});
        let (timing, radiance) = frames(&scene, &blockers, &gbuffer.points, How::default(), repeats)?;
        let truth = reference.estimate();
        let picture = |values: &[Vec3]| Picture::new(360, 240, gbuffer.resolve(values, Vec3::ZERO));
        let [test, truth, unshadowed] = [&radiance, &truth.radiance, &truth.unshadowed].map(|values| picture(values));
        let errors = ShadowErrors::of(&test, &truth, &unshadowed).map_err(|e| e.to_string())?;
        Ok(Count { spheres, timing, penumbra: errors.penumbra })
    };
    [64, 128, 256, 484].into_iter().map(of).collect()
}
