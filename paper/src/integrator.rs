use crate::Tables;
use glam::Vec3;
use lobe_core::{BrdfLobe, Lobe, Receiver, Tile, TileLobes, VisibilitySum};
use shading::{
    BrdfLobes, Contribution, Integrator, Interaction, LightCoverage, LightVisibility, Observer, Stage,
    TileContributions, TileInteraction, VisibilityLobes,
};

/// The paper's integrator (§5.4): least-squares lobes and tabulated products, `f̃·L` first, then the threshold, then V.
///
/// For strategies whose lobes are the paper's, as [`PaperVisibility`](crate::PaperVisibility) writes them.
#[derive(Clone, Copy, Debug)]
pub struct PaperIntegrator<'t> {
    /// The paper's tables.
    pub tables: &'t Tables,
}

impl<V: VisibilityLobes + ?Sized> Integrator<V> for PaperIntegrator<'_> {
    type Scratch = VisibilitySum;
    const TAKES_INTEGRALS: bool = false;

    fn reflectance<B: BrdfLobes>(materials: &[B], of: &[u32], at: &[Receiver], tile: &Tile, out: &mut TileLobes) {
        B::tile_cosine_lobes(materials, of, at, tile, out);
    }

    fn radiance(
        &self,
        point: &Interaction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
    ) -> Contribution {
        let light_lobe = self.tables.light_lobe(&point.light.cone, point.light.radiance);
        let mut total = Contribution::default();
        let mut coverage = None;
        // A lobe without flux is not there.
        for lobe in point.brdf.iter().filter(|lobe| lobe.flux() != Vec3::ZERO) {
            let lobe = self.times_cosine(lobe, point.at.normal);
            let product = self.tables.product(&lobe, &light_lobe);
            let unshadowed = product.flux;
            observer.count(0, 1);
            observer.end(Stage::Lighting);
            total.unshadowed += unshadowed;
            if unshadowed.max_element() <= point.threshold {
                observer.prune();
                continue;
            }
            total.radiance += match coverage
                .get_or_insert_with(|| visibility.observed(point.at, &point.light.cone, None, observer))
            {
                LightCoverage::Lit => unshadowed,
                LightCoverage::Dark => continue,
                LightCoverage::Partial(penumbra) => {
                    visibility.lobes(penumbra, &lobe, unshadowed.max_element(), sum);
                    observer.end(Stage::VisibilityLobes);
                    self.visible_part(&product, sum, point.threshold, observer)
                }
            };
        }
        total
    }

    fn tile(
        &self,
        tile: &TileInteraction<'_>,
        visibility: &mut LightVisibility<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) {
        tile.one_by_one(|point, observer| self.radiance(point, visibility, sum, observer), observer, out);
    }
}

impl PaperIntegrator<'_> {
    /// c_a of Eq. 12: a receiver's cosine is one more lobe.
    fn times_cosine(&self, lobe: &BrdfLobe, normal: Vec3) -> Lobe {
        let lobe = lobe.cosine_lobe(normal);
        if lobe.has_cosine {
            let cosine = Lobe::new(normal, 1.0, Vec3::ONE);
            self.tables.product(&Lobe { has_cosine: false, ..lobe }, &cosine)
        } else {
            lobe
        }
    }

    /// The product `f̃·L` times the sum of visibility lobes (Eq. 38).
    fn visible_part(&self, product: &Lobe, sum: &VisibilitySum, threshold: f32, observer: &mut impl Observer) -> Vec3 {
        let lobes = sum.lobes.lobes();
        let mut shadow = Vec3::ZERO;
        for lobe in lobes.iter() {
            let taken = self.tables.product(product, &lobe).flux;
            if taken.abs().max_element() < threshold {
                observer.prune();
            } else {
                shadow += taken;
            }
        }
        observer.count(lobes.len(), lobes.len());
        observer.end(Stage::Integration);
        (product.flux * sum.base + shadow).max(Vec3::ZERO)
    }
}
