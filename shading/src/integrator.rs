//! The rendering equation of this project: radiance as a sum over lights and reflectance lobes.

use crate::{
    BrdfLobes, Coverage, LightCoverage, LightVisibility, Penumbra, TileContributions, TileInteraction, Visibility,
    VisibilityLobes,
};
use glam::Vec3;
use lobe_core::{
    BrdfLobe, Receiver, SeenLight, Tile, TileLobes, VisibilitySum, light_image_integral, light_integral,
    visible_fraction,
};

/// A stage of the paper's Table 1, told to an [`Observer`] when it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// (b) Light lobes and unshadowed integrals.
    Lighting,
    /// (c) The visibility mask.
    Mask,
    /// (d) Visibility lobes.
    VisibilityLobes,
    /// (e) Products and their integrals.
    Integration,
}

/// Listens to the integrators: counters and clocks. `()` listens to nothing and costs nothing.
pub trait Observer {
    /// A stage has ended.
    fn end(&mut self, stage: Stage) {
        let _ = stage;
    }
    /// `lobes` visibility lobes were made and `integrals` evaluated.
    fn count(&mut self, lobes: usize, integrals: usize) {
        let _ = (lobes, integrals);
    }
    /// A product was dropped below the threshold: reflectance and light, or (paper) that and a visibility lobe.
    fn prune(&mut self) {}
    /// The receiver sees this much of the light.
    fn coverage(&mut self, coverage: Coverage) {
        let _ = coverage;
    }
}

impl Observer for () {}

/// The part of a receiver's radiance that one light contributes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contribution {
    /// With visibility.
    pub radiance: Vec3,
    /// Without.
    pub unshadowed: Vec3,
}

/// One receiver and one light: a term of the sum over lights.
#[derive(Clone, Copy, Debug)]
pub struct Interaction<'a> {
    /// The receiver.
    pub at: &'a Receiver,
    /// Reflectance lobes at the receiver.
    pub brdf: &'a [BrdfLobe],
    /// The light as the receiver sees it.
    pub light: &'a SeenLight,
    /// Products of reflectance and light whose radiance (largest channel) is at most this are dropped (t_i of §4.3); by the
    /// paper's method also each visibility lobe's product with them, which leaves shadows ragged when it is high (Fig. 5).
    pub threshold: f32,
}

/// A way to integrate reflectance × light × visibility (Eq. 21) over one light.
///
/// [`FractionIntegrator`] is the default; [`LobeIntegrator`] writes visibility as lobes;
/// `PaperIntegrator` of the crate `paper` is the paper's. Each has a form for one receiver and one for a
/// tile of receivers, with the same results to the bit.
pub trait Integrator<V: Visibility + ?Sized>: Sync {
    /// Working memory, one a thread.
    type Scratch: Default + Send;

    /// Whether tiles come with the [integrals](lobe_core::cap_integrals) of their lobes over the light.
    const TAKES_INTEGRALS: bool;

    /// The reflectance of a tile's receivers as this method takes it. Provided: [`BrdfLobes::tile_lobes`].
    ///
    /// # Panics
    /// As [`BrdfLobes::tile_lobes`].
    fn reflectance<B: BrdfLobes>(materials: &[B], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes) {
        B::tile_lobes(materials, of, at, tile, out);
    }

    /// The contribution of one light to one receiver.
    fn radiance(
        &self,
        point: &Interaction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        scratch: &mut Self::Scratch,
        observer: &mut impl Observer,
    ) -> Contribution;

    /// The contributions of one light to all receivers of a tile: [`radiance`](Self::radiance) of each, bit for bit, for less.
    ///
    /// # Panics
    /// When the parts of `tile` are not of one tile.
    fn tile(
        &self,
        tile: &TileInteraction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        scratch: &mut Self::Scratch,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    );
}

/// The default method: the closed integral of each reflectance lobe over the light, times the visible fraction of that lobe.
///
/// ```text
/// radiance = Σ lights Σ reflectance lobes  flux · light's radiance · ∫ lobe over the light · visible fraction
/// ```
///
/// (Eq. 21, with visibility not as lobes but as [`Visibility::fraction`].) A lit receiver costs one integral per reflectance lobe, a
/// dark one no fraction either.
#[derive(Clone, Copy, Debug, Default)]
pub struct FractionIntegrator;

impl<V: Visibility + ?Sized> Integrator<V> for FractionIntegrator {
    type Scratch = ();
    const TAKES_INTEGRALS: bool = true;

    fn radiance(
        &self,
        point: &Interaction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        (): &mut (),
        observer: &mut impl Observer,
    ) -> Contribution {
        radiance(point, visibility, &mut Fractions, observer)
    }

    fn tile(
        &self,
        tile: &TileInteraction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        (): &mut (),
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) {
        tile.radiance(visibility, &mut Fractions, observer, out);
    }
}

/// The same sum with visibility as lobes: the visible fraction is the closed integral of the reflectance lobe times the lobes of
/// visibility, divided by that over the whole light ([`visible_fraction`]).
#[derive(Clone, Copy, Debug, Default)]
pub struct LobeIntegrator;

impl<V: VisibilityLobes + ?Sized> Integrator<V> for LobeIntegrator {
    type Scratch = VisibilitySum;
    const TAKES_INTEGRALS: bool = true;

    fn reflectance<B: BrdfLobes>(materials: &[B], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes) {
        B::tile_cosine_lobes(materials, of, at, tile, out);
    }

    fn radiance(
        &self,
        point: &Interaction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        scratch: &mut VisibilitySum,
        observer: &mut impl Observer,
    ) -> Contribution {
        radiance(point, visibility, scratch, observer)
    }

    fn tile(
        &self,
        tile: &TileInteraction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        scratch: &mut VisibilitySum,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) {
        tile.radiance(visibility, scratch, observer, out);
    }
}

/// Where the visible fraction of a reflectance lobe comes from: the strategy, or the lobes that it writes.
pub(crate) trait FractionSource<V: Visibility + ?Sized> {
    /// The visible fraction, and how many visibility lobes and integrals it took.
    fn fraction(
        &mut self,
        visibility: &mut LightVisibility<'_, V>,
        penumbra: &Penumbra<'_>,
        brdf: &BrdfLobe,
        unshadowed: f32,
        observer: &mut impl Observer,
    ) -> (Vec3, [usize; 2]);
}

struct Fractions;

impl<V: Visibility + ?Sized> FractionSource<V> for Fractions {
    fn fraction(
        &mut self,
        visibility: &mut LightVisibility<'_, V>,
        penumbra: &Penumbra<'_>,
        brdf: &BrdfLobe,
        unshadowed: f32,
        observer: &mut impl Observer,
    ) -> (Vec3, [usize; 2]) {
        let fraction = visibility.fraction(penumbra, *brdf, unshadowed);
        observer.end(Stage::VisibilityLobes);
        (fraction, [0, 0])
    }
}

impl<V: VisibilityLobes + ?Sized> FractionSource<V> for VisibilitySum {
    fn fraction(
        &mut self,
        visibility: &mut LightVisibility<'_, V>,
        penumbra: &Penumbra<'_>,
        brdf: &BrdfLobe,
        unshadowed: f32,
        observer: &mut impl Observer,
    ) -> (Vec3, [usize; 2]) {
        let (lobe, unshadowed) = penumbra.cosine_lobe(brdf, unshadowed);
        visibility.lobes(penumbra, &lobe, unshadowed, self);
        observer.end(Stage::VisibilityLobes);
        let fraction = visible_fraction(penumbra.at, &lobe, unshadowed, self);
        let counts @ [lobes, integrals] = self.counts();
        observer.count(lobes, integrals);
        observer.end(Stage::Integration);
        (Vec3::splat(fraction), counts)
    }
}

/// The contribution of one light to one receiver:
///
/// ```text
/// Σ reflectance lobes  flux · light's radiance · ∫ lobe over the light · visible fraction
/// ```
///
/// The strategy is called only if some lobe's unshadowed radiance is above the threshold, and for fractions only where the
/// receiver sees a part of the light. [`TileInteraction`] has the twin for tiles.
pub(crate) fn radiance<V: Visibility + ?Sized>(
    point: &Interaction<'_>,
    visibility: &mut LightVisibility<'_, V>,
    source: &mut impl FractionSource<V>,
    observer: &mut impl Observer,
) -> Contribution {
    let mut sum = Contribution::default();
    let mut coverage = None;
    let light = point.light.above(point.at.normal);
    for lobe in point.brdf {
        let integral = match visibility.image().zip(light.outline.as_ref()) {
            None => Vec3::splat(light_integral(point.at, lobe, &light.cone, light.outline.as_ref())),
            Some((image, outline)) => light_image_integral(point.at, lobe, outline, image),
        };
        let unshadowed = lobe.flux() * light.radiance * integral;
        observer.count(0, 1);
        observer.end(Stage::Lighting);
        sum.unshadowed += unshadowed;
        if unshadowed.max_element() <= point.threshold {
            if unshadowed.max_element() > 0.0 {
                observer.prune();
            }
            continue;
        }
        let fraction = match coverage
            .get_or_insert_with(|| visibility.observed(point.at, &light.cone, light.outline.as_ref(), observer))
        {
            LightCoverage::Lit => Vec3::ONE,
            LightCoverage::Dark => Vec3::ZERO,
            LightCoverage::Partial(penumbra) => {
                source.fraction(visibility, penumbra, lobe, integral.max_element(), observer).0
            }
        };
        sum.radiance += unshadowed * fraction;
    }
    sum
}
