//! The three sources of lobes (reflectance, light, visibility) and what they exchange.

use crate::{
    Accuracy, Cone, LightId, LightImage, LightTerm, Lobe, LobeBuffer, LobesFull, LobesMut, Outline, PartlySeen,
    Receiver, Shaft, Sphere, Tile, TileLight, TileLobes,
};
use core::any::Any;
use glam::Vec3;

/// Reflectance as a sum of lobes of `f̃ = f_r·(n·v)` (Eq. 6), cosine included.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{BrdfLobes, Lobe, LobeBuffer, LobesFull, LobesMut, OWN_NONE, Receiver};
///
/// /// Reflects back to where the light came from.
/// struct Retro;
///
/// impl BrdfLobes for Retro {
///     fn max_lobes(&self) -> usize {
///         1
///     }
///     fn brdf_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
///         out.push(Lobe::new(at.view, 40.0, Vec3::splat(2.0)).times_cosine())
///     }
/// }
///
/// let at = Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: Vec3::new(0.6, 0.0, 0.8), object: OWN_NONE };
/// let mut buffer = LobeBuffer::with_capacity(Retro.max_lobes());
/// Retro.brdf_lobes(&at, &mut buffer.writer()).unwrap();
/// let toward_eye = buffer.lobes().eval(at.normal, at.view).x; // 2·(n·v)
/// assert!((toward_eye - 1.6).abs() < 1e-5);
/// ```
pub trait BrdfLobes {
    /// The largest number of lobes that [`brdf_lobes`](Self::brdf_lobes) writes.
    fn max_lobes(&self) -> usize;

    /// Appends the lobes of `f̃` as seen from `at.view`. All of them are to be understood as zero below the horizon of
    /// `at.normal`. A Lambert lobe has exponent 1 and *exactly* `at.normal` as its axis: integrators know it by that. Lobes of
    /// [microfacets](Lobe::microfacets) only where [`takes_microfacets`](LobesMut::takes_microfacets) says so.
    ///
    /// # Errors
    /// [`LobesFull`] when `out` has no room.
    fn brdf_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull>;

    /// The lobes of all receivers of a tile, receiver `i` of material `of[i]`. Provided: one receiver after the other. A set of
    /// models that has something faster overrides it; the lobes are to be the same, in the same order, bit for bit.
    ///
    /// # Errors
    /// [`LobesFull`] when a material has more lobes than its [`max_lobes`](Self::max_lobes).
    ///
    /// # Panics
    /// When `of`, `at` and `tile` differ in length, or a number in `of` is not that of a material.
    fn tile_lobes(
        materials: &[Self],
        of: &[u32],
        at: &[Receiver],
        tile: &Tile,
        out: &mut TileLobes,
    ) -> Result<(), LobesFull>
    where
        Self: Sized,
    {
        out.one_by_one(materials, of, at, tile)
    }
}

impl<B: BrdfLobes + ?Sized> BrdfLobes for Box<B> {
    fn max_lobes(&self) -> usize {
        (**self).max_lobes()
    }
    fn brdf_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
        (**self).brdf_lobes(at, out)
    }
}

/// An area light, seen as a uniformly bright cone of directions, or as a uniformly bright convex polygon in such a cone.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{Cone, LightLobes, LobeBuffer, LobesFull, LobesMut, Lobe, OWN_NONE, Receiver, Sphere, cone_lobe};
///
/// /// A sun of half-angle 0.27°.
/// struct Sun {
///     direction: Vec3,
/// }
///
/// impl LightLobes for Sun {
///     fn bounds(&self) -> Sphere {
///         Sphere { center: self.direction * 1e9, radius: 4.7e6 }
///     }
///     fn cone(&self, _: &Receiver) -> Cone {
///         Cone { axis: self.direction, one_minus_cos: 1.1e-5, distance: f32::INFINITY }
///     }
///     fn radiance(&self, _: &Receiver) -> Vec3 {
///         Vec3::splat(2e4)
///     }
///     fn light_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
///         let lobe = cone_lobe(&self.cone(at));
///         out.push(Lobe { flux: lobe.flux * self.radiance(at), ..lobe })
///     }
/// }
///
/// let at = Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: Vec3::Z, object: OWN_NONE };
/// let mut buffer = LobeBuffer::with_capacity(1);
/// Sun { direction: Vec3::Z }.light_lobes(&at, &mut buffer.writer()).unwrap();
/// assert!((buffer.lobes().get(0).flux.x - 1.382).abs() < 1e-3); // 2π·1.1e-5·2e4
/// ```
pub trait LightLobes {
    /// A ball around the light: where the shafts of groups of receivers end. A light at infinity has a far away one, of the angle
    /// under which it is seen.
    fn bounds(&self) -> Sphere;

    /// A ball around what receivers in a ball may ask about: where their shafts end. [`bounds`](Self::bounds) by default; less for a light
    /// at infinity, [`Outline::BEYOND`] times as much for a flat one, whose windows are larger than it.
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        let _ = receivers;
        self.bounds()
    }

    /// The cone in which the light is seen from `at`.
    fn cone(&self, at: &Receiver) -> Cone;

    /// Radiance inside the cone, W·m⁻²·sr⁻¹ per channel.
    fn radiance(&self, at: &Receiver) -> Vec3;

    /// What of the cone is bright, where that is not all of it: of a flat light, around which the cone is. None by default. A light that
    /// faces away has an empty cone.
    fn outline(&self, at: &Receiver) -> Option<Outline> {
        let _ = at;
        None
    }

    /// How bright the [outline](Self::outline) is where: factors of [`radiance`](Self::radiance), which is then their mean. None, which is
    /// the default, where all of it is as bright. Outlines of a light with an image have [sides](Outline::with_sides).
    fn image(&self) -> Option<&LightImage> {
        None
    }

    /// All but the image. Provided; the same, bit for bit.
    fn term(&self, at: &Receiver) -> LightTerm {
        LightTerm { cone: self.cone(at), radiance: self.radiance(at), outline: self.outline(at) }
    }

    /// Appends lobes of the incident radiance (Eq. 7): here the moment lobe of the cone, whose flux and mean vector
    /// are exact.
    ///
    /// # Errors
    /// [`LobesFull`] when `out` has no room.
    fn light_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull>;

    /// The light as all receivers of a tile see it. Provided: one [`term`](Self::term) after the other. A kind of light that has
    /// something faster overrides it; the terms are to be the same, bit for bit.
    ///
    /// # Panics
    /// When `at` is not as long as the tile.
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        out.one_by_one(tile, at.iter().map(|at| self.term(at)));
    }
}

impl<L: LightLobes + ?Sized> LightLobes for Box<L> {
    fn bounds(&self) -> Sphere {
        (**self).bounds()
    }
    fn bounds_from(&self, receivers: &Sphere) -> Sphere {
        (**self).bounds_from(receivers)
    }
    fn cone(&self, at: &Receiver) -> Cone {
        (**self).cone(at)
    }
    fn radiance(&self, at: &Receiver) -> Vec3 {
        (**self).radiance(at)
    }
    fn outline(&self, at: &Receiver) -> Option<Outline> {
        (**self).outline(at)
    }
    fn image(&self) -> Option<&LightImage> {
        (**self).image()
    }
    fn term(&self, at: &Receiver) -> LightTerm {
        (**self).term(at)
    }
    fn light_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
        (**self).light_lobes(at, out)
    }
    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        (**self).tile_light(at, tile, out);
    }
}

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

/// What is asked of a visibility strategy: one receiver, one light.
#[derive(Clone, Copy, Debug)]
pub struct VisibilityQuery<'a> {
    /// The receiver.
    pub at: &'a Receiver,
    /// Which light.
    pub light: LightId,
    /// The light as seen from there, or the part of it that is asked about.
    pub cone: &'a Cone,
    /// What of the cone is bright and above the receiver's horizon, where the light is flat. The cone may then be all of the hemisphere
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

/// Visibility inside a light's cone as a sum of lobes (Eq. 8), written for one reflectance lobe.
///
/// `V ≈ base + Σ lobes`. When `whole` is not empty it holds, cut by the same nodes, the lobes of the *whole* light, and
/// the visible fraction is the ratio of the two sums: exact in both limits, and most errors cancel.
#[derive(Clone, Debug, Default)]
pub struct VisibilitySum {
    /// The constant term (`c_unit` of Eq. 38): a scalar, never a lobe of exponent 0.
    pub base: f32,
    /// The visible fraction by channel, of a light with a [`LightImage`]; it stands for all else in the sum. [`Visit::lobes`](crate::Visit::lobes)
    /// empties it.
    pub by_channel: Option<Vec3>,
    /// Lobes of V; their flux is a solid angle (negative where they take light away).
    pub lobes: LobeBuffer,
    /// Lobes of the unoccluded light over the same nodes; empty when the sum is to be used directly.
    pub whole: LobeBuffer,
}

impl VisibilitySum {
    /// Room for `capacity` lobes in each of the two sums.
    #[must_use]
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            base: 0.0,
            by_channel: None,
            lobes: LobeBuffer::with_capacity(capacity),
            whole: LobeBuffer::with_capacity(capacity),
        }
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
/// let shaft = Shaft { receivers: Sphere { center: at.position, radius: 0.0 }, light: ball, id: LightId(0) };
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

/// Working memory of a strategy behind `dyn`.
pub type DynScratch = Box<dyn Any + Send>;

/// [`VisibilityLobes`] in object-safe form: same operations, scratch erased. Implemented for every strategy.
pub trait DynVisibility: Sync {
    /// See [`VisibilityLobes::scratch`].
    fn dyn_scratch(&self) -> DynScratch;
    /// See [`VisibilityLobes::max_lobes`].
    fn dyn_max_lobes(&self, accuracy: Accuracy) -> usize;
    /// See [`VisibilityLobes::enter`].
    fn dyn_enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage;
    /// See [`VisibilityLobes::coverage`].
    fn dyn_coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage;
    /// See [`VisibilityLobes::visibility_lobes`].
    ///
    /// # Errors
    /// [`LobesFull`] when `out` has no room.
    fn dyn_visibility_lobes(
        &self,
        seen: &PartlySeen<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut DynScratch,
        out: &mut VisibilitySum,
    ) -> Result<(), LobesFull>;
}

fn downcast<S: 'static>(scratch: &mut DynScratch) -> &mut S {
    scratch.downcast_mut().expect("scratch was made by another strategy")
}

impl<V> DynVisibility for V
where
    V: VisibilityLobes,
    V::Scratch: 'static,
{
    fn dyn_scratch(&self) -> DynScratch {
        Box::new(self.scratch())
    }
    fn dyn_max_lobes(&self, accuracy: Accuracy) -> usize {
        self.max_lobes(accuracy)
    }
    fn dyn_enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage {
        self.enter(shaft, downcast(scratch))
    }
    fn dyn_coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage {
        self.coverage(query, downcast(scratch))
    }
    fn dyn_visibility_lobes(
        &self,
        seen: &PartlySeen<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut DynScratch,
        out: &mut VisibilitySum,
    ) -> Result<(), LobesFull> {
        self.visibility_lobes(seen, brdf, unshadowed, downcast(scratch), out)
    }
}

impl<'v> VisibilityLobes for Box<dyn DynVisibility + 'v> {
    type Scratch = DynScratch;

    fn scratch(&self) -> DynScratch {
        (**self).dyn_scratch()
    }
    fn max_lobes(&self, accuracy: Accuracy) -> usize {
        (**self).dyn_max_lobes(accuracy)
    }
    fn enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage {
        (**self).dyn_enter(shaft, scratch)
    }
    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage {
        (**self).dyn_coverage(query, scratch)
    }
    fn visibility_lobes(
        &self,
        seen: &PartlySeen<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut DynScratch,
        out: &mut VisibilitySum,
    ) -> Result<(), LobesFull> {
        (**self).dyn_visibility_lobes(seen, brdf, unshadowed, scratch, out)
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

// The three sources stay object-safe.
const _: fn(&dyn DynVisibility, &dyn BrdfLobes, &dyn LightLobes) = |_, _, _| {};
