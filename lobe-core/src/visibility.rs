//! How a visibility strategy is asked: the trait, and the visit that keeps the order of the questions.

use crate::{
    Accuracy, Cone, LightId, LightImage, Lobe, LobesFull, Outline, Receiver, Shaft, VisibilitySum, visible_fraction,
};

/// How much of a light a receiver sees, before any lobe is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// All of it: V = 1, no lobe is needed.
    Lit,
    /// Nothing: V = 0.
    Dark,
    /// A part: ask for lobes.
    Partial,
}

/// A question to a visibility strategy: one receiver, one light.
#[derive(Clone, Copy, Debug)]
pub struct VisibilityQuery<'a> {
    /// The receiver.
    pub at: &'a Receiver,
    /// Which light.
    pub light: LightId,
    /// The light as seen from there, or the part of it that is asked about.
    pub cone: &'a Cone,
    /// The part of the cone that is bright and above the receiver's horizon, where the light is flat. The cone may then be all of the hemisphere
    /// before the light's plane.
    pub outline: Option<&'a Outline>,
    /// How bright the outline is where, if not everywhere the same.
    pub image: Option<&'a LightImage>,
    /// What error is requested.
    pub accuracy: Accuracy,
}

impl<'a> VisibilityQuery<'a> {
    /// About a light that is bright in all of its cone.
    #[must_use]
    pub const fn new(at: &'a Receiver, light: LightId, cone: &'a Cone, accuracy: Accuracy) -> Self {
        Self { at, light, cone, outline: None, image: None, accuracy }
    }
}

/// A visibility strategy: decides which part of a light a receiver sees, and says it in lobes.
///
/// For each receiver and light the caller first asks for the [`coverage`](Self::coverage) and, only where that is
/// [`Coverage::Partial`], for the lobes of each reflectance lobe. A lit or dark point costs no lobe. [`Visit`](crate::Visit) asks in
/// that order, and nothing else can: only it gives the [`PartlySeen`] that lobes are asked with.
///
/// Static dispatch: use the strategy's type. Dynamic: `Box<dyn DynVisibility>` implements this trait too.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::*;
///
/// /// Frosted glass before every light: half of it comes through.
/// struct Veil;
///
/// impl VisibilityLobes for Veil {
///     type Scratch = ();
///     fn scratch(&self) {}
///     fn max_lobes(&self, _: Accuracy) -> usize {
///         0
///     }
///     fn coverage(&self, _: &VisibilityQuery<'_>, _: &mut ()) -> Coverage {
///         Coverage::Partial
///     }
///     fn visibility_lobes(
///         &self,
///         _: &PartlySeen<'_>,
///         _: &Lobe,
///         _: f32,
///         _: &mut (),
///         out: &mut VisibilitySum,
///     ) -> Result<(), LobesFull> {
///         out.base = 0.5;
///         out.lobes.writer();
///         out.whole.writer();
///         Ok(())
///     }
/// }
///
/// let at = Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: Vec3::Z, object: OWN_NONE };
/// let ball = Sphere { center: Vec3::new(0.0, 0.0, 5.0), radius: 1.0 };
/// let light = LightTerm::of_cone(Cone::of_sphere(at.position, ball), Vec3::splat(3.0));
/// let mut brdf = LobeBuffer::with_capacity(1);
/// brdf.writer().push(Lobe::new(at.normal, 1.0, Vec3::ONE)).unwrap();
///
/// let boxed: Box<dyn DynVisibility> = Box::new(Veil);
/// let (mut scratch, mut sum) = (boxed.scratch(), VisibilitySum::default());
/// let shaft = Shaft::new(Sphere { center: at.position, radius: 0.0 }, ball, LightId(0));
/// let mut visit = Visit::enter(&boxed, &shaft, Accuracy::new(0.003), &mut scratch);
/// let call = Call { at: &at, brdf: brdf.lobes(), light: &light };
/// let lit = Integrator::default().radiance(&call, &mut visit, &mut sum, &mut ()).unwrap();
/// assert_eq!(lit.radiance, 0.5 * lit.unshadowed);
/// ```
pub trait VisibilityLobes: Sync {
    /// Working memory, one a thread.
    type Scratch: Send;

    /// New working memory.
    fn scratch(&self) -> Self::Scratch;

    /// The largest number of lobes that [`visibility_lobes`](Self::visibility_lobes) writes into either sum.
    fn max_lobes(&self, accuracy: Accuracy) -> usize;

    /// Told before a group of receivers and one light: all queries until the next call stay inside `shaft`. A chance
    /// to cull; the results must not depend on it.
    ///
    /// [`Coverage::Lit`] says that all of them will see all of the light, as [`coverage`](Self::coverage) would say of each:
    /// no need to ask. Anything else says nothing.
    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        let _ = (shaft, scratch);
        Coverage::Partial
    }

    /// How much of the light is seen.
    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage;

    /// The lobes of what is seen, as detailed as the reflectance lobe `brdf` needs. `unshadowed` is the integral of
    /// that lobe (flux 1) over the whole light. The query is the last one that [`coverage`](Self::coverage) was asked for.
    ///
    /// # Errors
    /// [`LobesFull`] when `out` has no room.
    fn visibility_lobes(
        &self,
        seen: &PartlySeen<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut Self::Scratch,
        out: &mut VisibilitySum,
    ) -> Result<(), LobesFull>;
}

/// A group of receivers asks a strategy about one light: the group enters, each receiver asks how much it sees, and who sees a
/// part asks for lobes. The types hold that order.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::*;
/// let at = Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: Vec3::Z, object: OWN_NONE };
/// let light = Sphere { center: Vec3::new(0.0, 0.0, 5.0), radius: 1.0 };
/// let shaft = Shaft::new(Sphere::default(), light, LightId(0));
/// let mut scratch = Unshadowed.scratch();
/// let mut visit = Visit::enter(&Unshadowed, &shaft, Accuracy::default(), &mut scratch);
/// assert_eq!(visit.entered(), Coverage::Lit);
/// let cone = Cone::of_sphere(at.position, light);
/// assert!(matches!(visit.look(&at, &cone), Look::Lit));
/// ```
#[derive(Debug)]
pub struct Visit<'v, V: VisibilityLobes + ?Sized> {
    visibility: &'v V,
    scratch: &'v mut V::Scratch,
    light: LightId,
    image: Option<&'v LightImage>,
    accuracy: Accuracy,
    entered: Coverage,
    /// How many receivers have looked.
    looks: u32,
}

/// How much of a light a receiver sees.
#[derive(Debug)]
pub enum Look<'q> {
    /// All of it.
    Lit,
    /// Nothing.
    Dark,
    /// A part: what lobes are asked with.
    Partial(PartlySeen<'q>),
}

impl Look<'_> {
    /// The same without the right to ask for lobes.
    #[must_use]
    pub const fn coverage(&self) -> Coverage {
        match self {
            Self::Lit => Coverage::Lit,
            Self::Dark => Coverage::Dark,
            Self::Partial(_) => Coverage::Partial,
        }
    }
}

/// A query whose answer was [`Coverage::Partial`]: the right to ask for lobes, which only [`Visit::look`] gives.
#[derive(Debug)]
pub struct PartlySeen<'q> {
    query: VisibilityQuery<'q>,
    /// Which look of the visit it was.
    look: u32,
}

impl<'q> core::ops::Deref for PartlySeen<'q> {
    type Target = VisibilityQuery<'q>;
    fn deref(&self) -> &Self::Target {
        &self.query
    }
}

impl<'v, V: VisibilityLobes + ?Sized> Visit<'v, V> {
    /// The group enters: all receivers that will look are inside `shaft`.
    pub fn enter(visibility: &'v V, shaft: &Shaft, accuracy: Accuracy, scratch: &'v mut V::Scratch) -> Self {
        let entered = visibility.enter(shaft, scratch);
        Self { entered, ..Self::alone(visibility, shaft.id, accuracy, scratch) }
    }

    /// One receiver that looks alone: the strategy is told of no group, and must not have been told of another one with this
    /// scratch.
    pub fn alone(visibility: &'v V, light: LightId, accuracy: Accuracy, scratch: &'v mut V::Scratch) -> Self {
        Self { visibility, scratch, light, image: None, accuracy, entered: Coverage::Partial, looks: 0 }
    }

    /// The same visit to a light that shows an image ([`LightLobes::image`](crate::LightLobes::image)).
    #[must_use]
    pub fn to_image(self, image: Option<&'v LightImage>) -> Self {
        Self { image, ..self }
    }

    /// What the light shows.
    #[must_use]
    pub const fn image(&self) -> Option<&'v LightImage> {
        self.image
    }

    /// What was said of the whole group: [`Coverage::Lit`] when nobody needs to look.
    #[must_use]
    pub const fn entered(&self) -> Coverage {
        self.entered
    }

    /// Each receiver looks, whatever was said of the group. For groups in which facets differ from shading normals: the
    /// facet may hide light that nothing else does.
    pub fn let_each_look(&mut self) {
        self.entered = Coverage::Partial;
    }

    /// How much of the light a receiver sees, whose cone from there is `cone`.
    pub fn look<'q>(&mut self, at: &'q Receiver, cone: &'q Cone) -> Look<'q>
    where
        'v: 'q,
    {
        self.look_through(at, cone, None)
    }

    /// The same of a light of which only what is inside of an outline is bright.
    pub fn look_through<'q>(&mut self, at: &'q Receiver, cone: &'q Cone, outline: Option<&'q Outline>) -> Look<'q>
    where
        'v: 'q,
    {
        let query =
            VisibilityQuery { outline, image: self.image, ..VisibilityQuery::new(at, self.light, cone, self.accuracy) };
        self.looks = self.looks.wrapping_add(1);
        match self.visibility.coverage(&query, self.scratch) {
            Coverage::Lit => Look::Lit,
            Coverage::Dark => Look::Dark,
            Coverage::Partial => Look::Partial(PartlySeen { query, look: self.looks }),
        }
    }

    /// The lobes of what the last receiver sees, see [`VisibilityLobes::visibility_lobes`].
    ///
    /// # Errors
    /// [`LobesFull`] when `out` has no room.
    ///
    /// # Panics
    /// When another receiver has looked since.
    pub fn lobes(
        &mut self,
        seen: &PartlySeen<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        out: &mut VisibilitySum,
    ) -> Result<(), LobesFull> {
        assert_eq!(seen.look, self.looks, "lobes are of the receiver that looked last");
        out.by_channel = None;
        self.visibility.visibility_lobes(seen, brdf, unshadowed, self.scratch, out)
    }

    /// A receiver looks: what it sees of one reflectance lobe times the light, see [`visible_fraction`]. `unshadowed` is the integral
    /// of that lobe (flux 1) over the whole light.
    ///
    /// # Errors
    /// [`LobesFull`] when `sum` is smaller than the strategy's `max_lobes`.
    pub fn fraction(
        &mut self,
        at: &Receiver,
        cone: &Cone,
        brdf: &Lobe,
        unshadowed: f32,
        sum: &mut VisibilitySum,
    ) -> Result<f32, LobesFull> {
        match self.look(at, cone) {
            Look::Lit => Ok(1.0),
            Look::Dark => Ok(0.0),
            Look::Partial(seen) => {
                self.lobes(&seen, brdf, unshadowed, sum)?;
                Ok(visible_fraction(at, brdf, unshadowed, sum))
            }
        }
    }
}

/// The strategy without blockers: every receiver sees all of every light, at no cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unshadowed;

impl VisibilityLobes for Unshadowed {
    type Scratch = ();

    fn scratch(&self) {}
    fn max_lobes(&self, _: Accuracy) -> usize {
        0
    }
    fn enter(&self, _: &Shaft, (): &mut ()) -> Coverage {
        Coverage::Lit
    }
    fn coverage(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Lit
    }
    fn visibility_lobes(
        &self,
        _: &PartlySeen<'_>,
        _: &Lobe,
        _: f32,
        (): &mut (),
        out: &mut VisibilitySum,
    ) -> Result<(), LobesFull> {
        out.base = 1.0;
        out.lobes.writer();
        out.whole.writer();
        Ok(())
    }
}
