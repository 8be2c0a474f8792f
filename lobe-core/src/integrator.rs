//! The integrator: the light, the reflectance and the visibility of one receiver, put together.

use crate::{
    Cone, Coverage, LightTerm, Lobe, Lobes, LobesFull, Look, Outline, PartlySeen, Receiver, VisibilityLobes,
    VisibilitySum, Visit, outline, paper, visible_fraction,
};
use glam::Vec3;

/// Which lobes stand for light and visibility, and how products are taken.
#[derive(Clone, Copy, Debug, Default)]
pub enum Method<'a> {
    /// Moment lobes and closed integrals: what matters is conserved, no table.
    #[default]
    Moments,
    /// The paper as printed: least-squares lobes, tabulated products, `f̃·L` first, then the threshold, then V (§5.4).
    Paper(&'a paper::Tables),
}

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

/// Listens to what the integrator does: counters and clocks. `()` listens to nothing and costs nothing.
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

/// What one light adds to the radiance toward the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lit {
    /// With visibility.
    pub radiance: Vec3,
    /// Without.
    pub unshadowed: Vec3,
}

/// One receiver and one light, to be integrated; what hides the light is asked through a [`Visit`].
#[derive(Clone, Copy, Debug)]
pub struct Call<'a> {
    /// The receiver.
    pub at: &'a Receiver,
    /// Reflectance lobes at the receiver.
    pub brdf: Lobes<'a>,
    /// The light.
    pub light: &'a LightTerm,
}

/// Puts the three lobe sums together: the rendering equation for one receiver and one light (Eq. 21).
#[derive(Clone, Copy, Debug, Default)]
pub struct Integrator<'a> {
    /// How.
    pub method: Method<'a>,
    /// Reflectance–light products whose radiance (largest channel) is below this are dropped (t_i of §4.3); by the paper's
    /// method also each visibility lobe's product with them, which leaves shadows ragged when it is high (Fig. 5).
    pub threshold: f32,
}

impl Integrator<'_> {
    /// Radiance toward the eye that one light adds.
    ///
    /// For each reflectance lobe the unshadowed integral comes first; if any is above the threshold the strategy is
    /// asked how much of the light is seen, and only where that is a part, for lobes. A lit point costs one integral
    /// per reflectance lobe, a dark one no lobe either.
    ///
    /// `sum` is working memory, one a thread.
    ///
    /// # Errors
    /// [`LobesFull`] when `sum` is smaller than the strategy's `max_lobes`.
    pub fn radiance<V: VisibilityLobes + ?Sized>(
        &self,
        call: &Call<'_>,
        visit: &mut Visit<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
    ) -> Result<Lit, LobesFull> {
        match self.method {
            Method::Moments => self.by_moments(call, visit, sum, observer),
            Method::Paper(tables) => self.by_paper(tables, call, visit, sum, observer),
        }
    }

    fn by_moments<V: VisibilityLobes + ?Sized>(
        &self,
        call: &Call<'_>,
        visit: &mut Visit<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
    ) -> Result<Lit, LobesFull> {
        let mut lit = Lit::default();
        let mut seen = None;
        let light = call.light.above(call.at.normal);
        for f in call.brdf.iter() {
            let shown = visit.image().zip(light.outline.as_ref());
            let integral = match shown {
                None => Vec3::splat(outline::light_integral(call.at, &f, &light.cone, light.outline.as_ref())),
                Some((image, outline)) => outline::of_image(call.at, &f, outline, image),
            };
            let unshadowed = f.flux * call.light.radiance * integral;
            observer.count(0, 1);
            observer.end(Stage::Lighting);
            lit.unshadowed += unshadowed;
            if unshadowed.max_element() <= self.threshold {
                if unshadowed.max_element() > 0.0 {
                    observer.prune();
                }
                continue;
            }
            let fraction =
                match seen.get_or_insert_with(|| look(visit, call.at, &light.cone, light.outline.as_ref(), observer)) {
                    Look::Lit => Vec3::ONE,
                    Look::Dark => Vec3::ZERO,
                    Look::Partial(seen) => {
                        let part = partly_seen(visit, seen, &f, integral.max_element(), sum, observer)?;
                        sum.by_channel.unwrap_or(Vec3::splat(part))
                    }
                };
            lit.radiance += unshadowed * fraction;
        }
        Ok(lit)
    }

    fn by_paper<V: VisibilityLobes + ?Sized>(
        &self,
        tables: &paper::Tables,
        call: &Call<'_>,
        visit: &mut Visit<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
    ) -> Result<Lit, LobesFull> {
        let light_lobe = tables.light_lobe(&call.light.cone, call.light.radiance);
        let mut lit = Lit::default();
        let mut seen = None;
        for f in call.brdf.iter() {
            // A lobe without flux is not there.
            if f.flux == Vec3::ZERO {
                continue;
            }
            // c_a of Eq. 12; a receiver's cosine is one more lobe.
            let f = if f.factor > 0.0 {
                let cosine = Lobe::new(call.at.normal, 1.0, Vec3::ONE);
                tables.product(&Lobe { factor: 0.0, ..f }, &cosine)
            } else {
                f
            };
            let product = tables.product(&f, &light_lobe);
            let unshadowed = product.flux;
            observer.count(0, 1);
            observer.end(Stage::Lighting);
            lit.unshadowed += unshadowed;
            if unshadowed.max_element() <= self.threshold {
                observer.prune();
                continue;
            }
            match seen.get_or_insert_with(|| look(visit, call.at, &call.light.cone, None, observer)) {
                Look::Lit => {
                    lit.radiance += unshadowed;
                    continue;
                }
                Look::Dark => continue,
                Look::Partial(seen) => visit.lobes(seen, &f, unshadowed.max_element(), sum)?,
            }
            observer.end(Stage::VisibilityLobes);
            let lobes = sum.lobes.lobes();
            let mut shadow = Vec3::ZERO;
            for c in lobes.iter() {
                let taken = tables.product(&product, &c).flux;
                if taken.abs().max_element() < self.threshold {
                    observer.prune();
                } else {
                    shadow += taken;
                }
            }
            lit.radiance += (unshadowed * sum.base + shadow).max(Vec3::ZERO);
            observer.count(lobes.len(), lobes.len());
            observer.end(Stage::Integration);
        }
        Ok(lit)
    }
}

/// A receiver looks, and the observer is told.
pub(crate) fn look<'q, 'v: 'q, V: VisibilityLobes + ?Sized>(
    visit: &mut Visit<'v, V>,
    at: &'q Receiver,
    cone: &'q Cone,
    outline: Option<&'q Outline>,
    observer: &mut impl Observer,
) -> Look<'q> {
    let seen = visit.look_through(at, cone, outline);
    observer.coverage(seen.coverage());
    observer.end(Stage::Mask);
    seen
}

/// What the strategy's lobes let through of a reflectance lobe, where a part of the light is seen.
pub(crate) fn partly_seen<V: VisibilityLobes + ?Sized>(
    visit: &mut Visit<'_, V>,
    seen: &PartlySeen<'_>,
    f: &Lobe,
    unshadowed: f32,
    sum: &mut VisibilitySum,
    observer: &mut impl Observer,
) -> Result<f32, LobesFull> {
    visit.lobes(seen, f, unshadowed, sum)?;
    observer.end(Stage::VisibilityLobes);
    let fraction = visible_fraction(seen.at, f, unshadowed, sum);
    let lobes = sum.lobes.lobes().len();
    observer.count(lobes, lobes + sum.whole.lobes().len());
    observer.end(Stage::Integration);
    Ok(fraction)
}
