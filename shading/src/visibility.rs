//! Visibility: the traits of a strategy, and the query object that keeps the order of the questions.

use crate::{Accuracy, LightId, Observer, Shaft, Stage};
use glam::Vec3;
use lobe_core::{
    BrdfLobe, Cone, LightImage, Lobe, Microfacets, Outline, Receiver, Sphere, VisibilitySum, light_integral,
    visible_fraction,
};

/// How much of a light a receiver sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// All of it: V = 1.
    Lit,
    /// Nothing: V = 0.
    Dark,
    /// A part: the fraction depends on the reflectance lobe.
    Partial,
}

/// A question to a visibility strategy: one receiver, one light.
#[derive(Clone, Copy, Debug)]
pub struct VisibilityQuery<'a> {
    /// The receiver.
    pub at: &'a Receiver,
    /// Which light.
    pub light: LightId,
    /// The light as seen from there, or the part of it that is queried.
    pub cone: &'a Cone,
    /// The part of the cone that is bright and above the receiver's horizon, where the light is flat. The cone may then be all of the hemisphere
    /// before the light's plane.
    pub outline: Option<&'a Outline>,
    /// How bright the outline is where, if not everywhere the same.
    pub image: Option<&'a LightImage>,
    /// The requested error.
    pub accuracy: Accuracy,
}

impl<'a> VisibilityQuery<'a> {
    /// About a light that is bright in all of its cone.
    #[must_use]
    pub const fn new(at: &'a Receiver, light: LightId, cone: &'a Cone, accuracy: Accuracy) -> Self {
        Self { at, light, cone, outline: None, image: None, accuracy }
    }

    /// The cosine lobe that stands for a reflectance lobe, and its integral (flux 1) over the light; `unshadowed` is that of `brdf`.
    pub(crate) fn cosine_lobe(&self, brdf: &BrdfLobe, unshadowed: f32) -> (Lobe, f32) {
        match brdf {
            BrdfLobe::Cosine(lobe) => (*lobe, unshadowed),
            BrdfLobe::Microfacets(facets) => {
                let lobe = facets.mirror_lobe(self.at.normal);
                (lobe, light_integral(self.at, &lobe.into(), self.cone, self.outline))
            }
        }
    }
}

/// A visibility strategy: the fraction of a light that a receiver sees, weighted by a reflectance lobe.
///
/// For a reflectance lobe `f` and a light of radiance `L` the *visible fraction* is
/// `∫ f(v) L(v) V(v) dv / ∫ f(v) L(v) dv`, with `V` 1 where the light is seen and 0 where a blocker hides it. It is in
/// `[0, 1]`, per colour channel, since an image may have other colours in its visible part.
///
/// For each receiver and light the caller first asks for the [`coverage`](Self::coverage) and, only where that is
/// [`Coverage::Partial`], for the [`fraction`](Self::fraction) of each reflectance lobe. [`LightVisibility`] keeps that order.
///
/// Static dispatch: use the strategy's type. Dynamic: `Box<dyn DynVisibility>` implements this trait too. Strategies that
/// write visibility as lobes implement [`VisibilityLobes`] as well.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::*;
/// use shading::*;
///
/// /// Frosted glass before every light: half of the light passes.
/// struct Veil;
///
/// impl Visibility for Veil {
///     type Scratch = ();
///     fn scratch(&self) {}
///     fn coverage(&self, _: &VisibilityQuery<'_>, _: &mut ()) -> Coverage {
///         Coverage::Partial
///     }
///     fn fraction(&self, _: &VisibilityQuery<'_>, _: &Lobe, _: f32, _: &mut ()) -> Vec3 {
///         Vec3::splat(0.5)
///     }
/// }
///
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
/// let sphere = Sphere { center: Vec3::new(0.0, 0.0, 5.0), radius: 1.0 };
/// let light = SeenLight::of_cone(Cone::of_sphere(at.position, sphere), Vec3::splat(3.0));
/// let brdf = [Lobe::new(at.normal, 1.0, Vec3::ONE).into()];
///
/// let boxed: Box<dyn DynVisibility> = Box::new(Veil);
/// let mut scratch = boxed.scratch();
/// let shaft = Shaft::new(Sphere { center: at.position, radius: 0.0 }, sphere, LightId(0));
/// let mut visibility = LightVisibility::enter(&boxed, &shaft, Accuracy::new(0.003), &mut scratch);
/// let point = Interaction { at: &at, brdf: &brdf, light: &light, threshold: 0.0 };
/// let lit = FractionIntegrator.radiance(&point, &mut visibility, &mut (), &mut ());
/// assert_eq!(lit.radiance, 0.5 * lit.unshadowed);
/// ```
pub trait Visibility: Sync {
    /// Working memory, one a thread.
    type Scratch: Send;

    /// New working memory.
    fn scratch(&self) -> Self::Scratch;

    /// Told before a group of receivers and one light: all queries until the next call stay inside `shaft`. A chance
    /// to cull; the results must not depend on it.
    ///
    /// [`Coverage::Lit`] says that every receiver of the group sees all of the light, as [`coverage`](Self::coverage) would say
    /// of each. Any other value says nothing.
    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        let _ = (shaft, scratch);
        Coverage::Partial
    }

    /// The width of the narrowest penumbra that blockers of this light may cast on a part of the group that [entered](Self::enter) last, in units of
    /// the scene: on receivers inside the sphere `part` that are on the face of `at`. While a receiver moves by this much, a
    /// shadow crosses the light:
    ///
    /// ```text
    /// width = 2R d/(D − d)        R, D: radius and distance of the light; d: distance of the blocker
    /// ```
    ///
    /// So no shadow is hidden between receivers that are less than half of it apart, however thin its blocker is. Infinite where all see the same: all of
    /// the light, or nothing. Provided: 0, which says nothing.
    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut Self::Scratch) -> f32 {
        let _ = (at, part, scratch);
        0.0
    }

    /// How much of the light is seen.
    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage;

    /// The visible fraction of one reflectance lobe, per channel, in `[0, 1]`. `unshadowed` is the integral of that lobe (flux 1)
    /// over the whole light. The query is the last one of [`coverage`](Self::coverage), and its answer was
    /// [`Coverage::Partial`].
    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut Self::Scratch) -> Vec3;

    /// The same of a lobe of microfacets. Provided: that of the cosine lobe that stands for it.
    fn microfacets_fraction(
        &self,
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        unshadowed: f32,
        scratch: &mut Self::Scratch,
    ) -> Vec3 {
        let (lobe, unshadowed) = query.cosine_lobe(&(*facets).into(), unshadowed);
        self.fraction(query, &lobe, unshadowed, scratch)
    }
}

/// A strategy that also writes visibility as a sum of cosine lobes (Eq. 8): for [`LobeIntegrator`](crate::LobeIntegrator) and for the
/// paper's method.
pub trait VisibilityLobes: Visibility {
    /// Writes the lobes of the visible part of the light into `out`, as detailed as the reflectance lobe `brdf` needs. The
    /// same preconditions as for [`fraction`](Visibility::fraction); `out` is overwritten.
    fn lobes(
        &self,
        query: &VisibilityQuery<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut Self::Scratch,
        out: &mut VisibilitySum,
    );

    /// The visible fraction that the [lobes](Self::lobes) give by closed products ([`visible_fraction`](lobe_core::visible_fraction)). Provided:
    /// [`fraction`](Visibility::fraction) of strategies that have nothing faster. `sum` is working memory.
    fn fraction_of_lobes(
        &self,
        query: &VisibilityQuery<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut Self::Scratch,
        sum: &mut VisibilitySum,
    ) -> Vec3 {
        self.lobes(query, brdf, unshadowed, scratch, sum);
        Vec3::splat(visible_fraction(query.at, brdf, unshadowed, sum))
    }
}

/// The visibility of one light for a group of receivers: the group enters, each receiver asks for its coverage, and receivers in
/// penumbra ask for fractions. The types keep that order.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::*;
/// use shading::*;
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
/// let light = Sphere { center: Vec3::new(0.0, 0.0, 5.0), radius: 1.0 };
/// let shaft = Shaft::new(Sphere::default(), light, LightId(0));
/// let mut scratch = Unshadowed.scratch();
/// let mut visibility = LightVisibility::enter(&Unshadowed, &shaft, Accuracy::default(), &mut scratch);
/// assert_eq!(visibility.group_coverage(), Coverage::Lit);
/// let cone = Cone::of_sphere(at.position, light);
/// assert!(matches!(visibility.coverage(&at, &cone, None), LightCoverage::Lit));
/// ```
#[derive(Debug)]
pub struct LightVisibility<'v, V: Visibility + ?Sized> {
    visibility: &'v V,
    scratch: &'v mut V::Scratch,
    light: LightId,
    image: Option<&'v LightImage>,
    accuracy: Accuracy,
    group: Coverage,
    /// Number of queries so far.
    queries: u32,
}

/// How much of a light a receiver sees; in penumbra with the right to ask for fractions.
#[derive(Debug)]
pub enum LightCoverage<'q> {
    /// All of it.
    Lit,
    /// Nothing.
    Dark,
    /// A part.
    Partial(Penumbra<'q>),
}

impl LightCoverage<'_> {
    /// The same without the right to ask for fractions.
    #[must_use]
    pub const fn coverage(&self) -> Coverage {
        match self {
            Self::Lit => Coverage::Lit,
            Self::Dark => Coverage::Dark,
            Self::Partial(_) => Coverage::Partial,
        }
    }
}

/// A query whose answer was [`Coverage::Partial`]: the right to ask for fractions and lobes, which only
/// [`LightVisibility::coverage`] gives.
#[derive(Debug)]
pub struct Penumbra<'q> {
    query: VisibilityQuery<'q>,
    /// Which query of the group it was.
    number: u32,
}

impl<'q> core::ops::Deref for Penumbra<'q> {
    type Target = VisibilityQuery<'q>;
    fn deref(&self) -> &Self::Target {
        &self.query
    }
}

impl<'v, V: Visibility + ?Sized> LightVisibility<'v, V> {
    /// A group enters: all receivers that will ask are inside `shaft`.
    pub fn enter(visibility: &'v V, shaft: &Shaft, accuracy: Accuracy, scratch: &'v mut V::Scratch) -> Self {
        let group = visibility.enter(shaft, scratch);
        Self { group, ..Self::alone(visibility, shaft.id, accuracy, scratch) }
    }

    /// A light that nothing hides: no receiver needs to ask.
    pub fn unhidden(visibility: &'v V, light: LightId, accuracy: Accuracy, scratch: &'v mut V::Scratch) -> Self {
        Self { group: Coverage::Lit, ..Self::alone(visibility, light, accuracy, scratch) }
    }

    /// A single receiver: the strategy has entered no group with this scratch.
    pub fn alone(visibility: &'v V, light: LightId, accuracy: Accuracy, scratch: &'v mut V::Scratch) -> Self {
        Self { visibility, scratch, light, image: None, accuracy, group: Coverage::Partial, queries: 0 }
    }

    /// The same for a light that shows an image ([`LightLobes::image`](crate::LightLobes::image)).
    #[must_use]
    pub fn with_image(self, image: Option<&'v LightImage>) -> Self {
        Self { image, ..self }
    }

    /// The light's image.
    #[must_use]
    pub const fn image(&self) -> Option<&'v LightImage> {
        self.image
    }

    /// The coverage of the whole group: [`Coverage::Lit`] when no receiver needs to ask.
    #[must_use]
    pub const fn group_coverage(&self) -> Coverage {
        self.group
    }

    /// Makes each receiver ask, whatever was said of the group. For groups in which facets differ from shading normals: a
    /// facet may hide light that no blocker hides.
    pub const fn query_each_receiver(&mut self) {
        self.group = Coverage::Partial;
    }

    /// The width of the narrowest penumbra on a part of the group: see [`Visibility::narrowest_penumbra`].
    pub fn narrowest_penumbra(&mut self, at: &Receiver, part: Sphere) -> f32 {
        self.visibility.narrowest_penumbra(at, part, self.scratch)
    }

    /// How much of the light a receiver sees, whose cone from there is `cone` and whose bright part, if that is not all of the
    /// cone, is `outline`.
    pub fn coverage<'q>(&mut self, at: &'q Receiver, cone: &'q Cone, outline: Option<&'q Outline>) -> LightCoverage<'q>
    where
        'v: 'q,
    {
        let query =
            VisibilityQuery { outline, image: self.image, ..VisibilityQuery::new(at, self.light, cone, self.accuracy) };
        self.queries = self.queries.wrapping_add(1);
        match self.visibility.coverage(&query, self.scratch) {
            Coverage::Lit => LightCoverage::Lit,
            Coverage::Dark => LightCoverage::Dark,
            Coverage::Partial => LightCoverage::Partial(Penumbra { query, number: self.queries }),
        }
    }

    /// The same, and the observer hears of it.
    pub fn observed<'q>(
        &mut self,
        at: &'q Receiver,
        cone: &'q Cone,
        outline: Option<&'q Outline>,
        observer: &mut impl Observer,
    ) -> LightCoverage<'q>
    where
        'v: 'q,
    {
        let coverage = self.coverage(at, cone, outline);
        observer.coverage(coverage.coverage());
        observer.end(Stage::Mask);
        coverage
    }

    /// The visible fraction of a reflectance lobe for the receiver of the last query, see [`Visibility::fraction`].
    ///
    /// # Panics
    /// When there was another query since.
    pub fn fraction(&mut self, penumbra: &Penumbra<'_>, brdf: impl Into<BrdfLobe>, unshadowed: f32) -> Vec3 {
        self.check(penumbra);
        match brdf.into() {
            BrdfLobe::Cosine(lobe) => self.visibility.fraction(penumbra, &lobe, unshadowed, self.scratch),
            BrdfLobe::Microfacets(facets) => {
                self.visibility.microfacets_fraction(penumbra, &facets, unshadowed, self.scratch)
            }
        }
    }

    /// Coverage and fraction in one call: the visible fraction of a reflectance lobe, per channel.
    pub fn visible_fraction(&mut self, at: &Receiver, cone: &Cone, brdf: &Lobe, unshadowed: f32) -> Vec3 {
        match self.coverage(at, cone, None) {
            LightCoverage::Lit => Vec3::ONE,
            LightCoverage::Dark => Vec3::ZERO,
            LightCoverage::Partial(penumbra) => self.fraction(&penumbra, brdf, unshadowed),
        }
    }

    fn check(&self, penumbra: &Penumbra<'_>) {
        assert_eq!(penumbra.number, self.queries, "fractions are of the receiver that asked last");
    }
}

impl<V: VisibilityLobes + ?Sized> LightVisibility<'_, V> {
    /// The lobes of the visible part for the receiver of the last query, see [`VisibilityLobes::lobes`].
    ///
    /// # Panics
    /// When there was another query since.
    pub fn lobes(&mut self, penumbra: &Penumbra<'_>, brdf: &Lobe, unshadowed: f32, out: &mut VisibilitySum) {
        self.check(penumbra);
        self.visibility.lobes(penumbra, brdf, unshadowed, self.scratch, out);
    }
}

/// The strategy without blockers: every receiver sees all of every light, at no cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unshadowed;

impl Visibility for Unshadowed {
    type Scratch = ();

    fn scratch(&self) {}
    fn enter(&self, _: &Shaft, (): &mut ()) -> Coverage {
        Coverage::Lit
    }
    fn narrowest_penumbra(&self, _: &Receiver, _: Sphere, (): &mut ()) -> f32 {
        f32::INFINITY
    }
    fn coverage(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Lit
    }
    fn fraction(&self, _: &VisibilityQuery<'_>, _: &Lobe, _: f32, (): &mut ()) -> Vec3 {
        Vec3::ONE
    }
}

impl VisibilityLobes for Unshadowed {
    fn lobes(&self, _: &VisibilityQuery<'_>, _: &Lobe, _: f32, (): &mut (), out: &mut VisibilitySum) {
        out.clear(1.0);
    }
}
