use crate::args::{TradeArgs, TradeGeometry};
use crate::checkpoint;
use crate::console::{self, STOP};
use crate::failure::Failure;
use crate::files::Files;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Geometry, Reference, ReferenceJob};
use cosine_lobes::scene::BlockerSet;
use cosine_lobes::{Comparison, Display, ExrLayer, FlipMap, Picture, RegionError, ShadowErrors, luminance};
use glam::Vec3;

/// The reference that all rows are compared with.
pub(super) struct Truth {
    pub(super) picture: Picture,
    unshadowed: Picture,
    /// Its own standard error, mean over penumbra points, as a fraction of the unshadowed radiance.
    pub(super) std_error: f64,
    pub(super) samples: u32,
}

impl Truth {
    /// Samples, or resumes from the checkpoint in the folder; leaves checkpoint and picture there.
    pub(super) fn find(
        args: &TradeArgs,
        world: &World<'_>,
        gbuffer: &GBuffer,
        blockers: &BlockerSet,
    ) -> Result<Self, Failure> {
        let scene = world.scene();
        let geometry = match args.geometry {
            TradeGeometry::Spheres => Geometry::Spheres,
            TradeGeometry::Mesh => Geometry::Mesh,
        };
        let mut reference = Reference::new(ReferenceJob { world, gbuffer, blockers, geometry, seed: 0 });
        let path = args.output.join("reference.checkpoint");
        checkpoint::resume(&mut reference, &path, args.view.console.quiet)?;
        let samples = args.reference_spp;
        if reference.samples() < samples {
            console::stoppable(|| -> Result<(), Failure> {
                checkpoint::advance(&mut reference, samples, &path, "reference", args.view.console.quiet)?;
                checkpoint::save(&reference, &path)
            })?;
            if STOP.is_cancelled() {
                return Err(Failure::interrupted(format_args!(
                    "the reference so far is kept in {}; the same command goes on from there",
                    path.display()
                )));
            }
        }
        let estimate = reference.estimate();
        let picture = |values: &[Vec3], background| {
            Picture::new(scene.width as usize, scene.height as usize, gbuffer.picture(values, background))
        };
        let truth = Self {
            picture: picture(&estimate.radiance, scene.background),
            unshadowed: picture(&estimate.unshadowed, scene.background),
            std_error: penumbra_error(&estimate.radiance, &estimate.unshadowed, &estimate.std_error),
            samples: reference.samples(),
        };
        let layer = ExrLayer::color("unshadowed", truth.unshadowed.pixels());
        Files::create(&[args.output.join("reference.exr")], None)?.write(
            &truth.picture,
            &Display::default(),
            &[layer],
        )?;
        Ok(truth)
    }

    /// Error of each pixel's own radiance, of the unshadowed radiance in penumbra, and FLIP of the whole.
    pub(super) fn compare(&self, picture: &Picture, exposure: f32) -> Result<([RegionError; 2], f64), Failure> {
        let own = Comparison::of(picture, &self.picture)?.own;
        let errors = ShadowErrors::of(picture, &self.picture, &self.unshadowed)?;
        Ok(([own, errors.penumbra], FlipMap::of(picture, &self.picture, exposure)?.mean()))
    }
}

fn penumbra_error(radiance: &[Vec3], unshadowed: &[Vec3], std_error: &[Vec3]) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    for ((r, u), e) in radiance.iter().zip(unshadowed).zip(std_error) {
        let whole = luminance(*u);
        if whole > 0.0 && (0.01..0.99).contains(&(luminance(*r) / whole)) {
            sum += luminance(*e) / whole;
            count += 1;
        }
    }
    sum / count.max(1) as f64
}
