//! Visibility strategies behind `dyn`: the same trait with the type of the scratch erased.

use crate::{Coverage, Shaft, Visibility, VisibilityQuery};
use core::any::Any;
use glam::Vec3;
use lobe_core::{Lobe, Microfacets, Receiver, Sphere};

/// Working memory of a strategy behind `dyn`.
pub type DynScratch = Box<dyn Any + Send>;

/// [`Visibility`] in object-safe form: same operations, scratch erased. Implemented for every strategy.
pub trait DynVisibility: Sync {
    /// See [`Visibility::scratch`].
    fn dyn_scratch(&self) -> DynScratch;
    /// See [`Visibility::enter`].
    fn dyn_enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage;
    /// See [`Visibility::narrowest_penumbra`].
    fn dyn_narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut DynScratch) -> f32;
    /// See [`Visibility::coverage`].
    fn dyn_coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage;
    /// See [`Visibility::fraction`].
    fn dyn_fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut DynScratch)
    -> Vec3;
    /// See [`Visibility::microfacets_fraction`].
    fn dyn_microfacets_fraction(
        &self,
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        unshadowed: f32,
        scratch: &mut DynScratch,
    ) -> Vec3;
}

fn downcast<S: 'static>(scratch: &mut DynScratch) -> &mut S {
    scratch.downcast_mut().expect("scratch was made by another strategy")
}

impl<V> DynVisibility for V
where
    V: Visibility,
    V::Scratch: 'static,
{
    fn dyn_scratch(&self) -> DynScratch {
        Box::new(self.scratch())
    }
    fn dyn_enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage {
        self.enter(shaft, downcast(scratch))
    }
    fn dyn_narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut DynScratch) -> f32 {
        self.narrowest_penumbra(at, part, downcast(scratch))
    }
    fn dyn_coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage {
        self.coverage(query, downcast(scratch))
    }
    fn dyn_fraction(
        &self,
        query: &VisibilityQuery<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut DynScratch,
    ) -> Vec3 {
        self.fraction(query, brdf, unshadowed, downcast(scratch))
    }
    fn dyn_microfacets_fraction(
        &self,
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        unshadowed: f32,
        scratch: &mut DynScratch,
    ) -> Vec3 {
        self.microfacets_fraction(query, facets, unshadowed, downcast(scratch))
    }
}

impl<'v> Visibility for Box<dyn DynVisibility + 'v> {
    type Scratch = DynScratch;

    fn scratch(&self) -> DynScratch {
        (**self).dyn_scratch()
    }
    fn enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage {
        (**self).dyn_enter(shaft, scratch)
    }
    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut DynScratch) -> f32 {
        (**self).dyn_narrowest_penumbra(at, part, scratch)
    }
    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage {
        (**self).dyn_coverage(query, scratch)
    }
    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut DynScratch) -> Vec3 {
        (**self).dyn_fraction(query, brdf, unshadowed, scratch)
    }
    fn microfacets_fraction(
        &self,
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        unshadowed: f32,
        scratch: &mut DynScratch,
    ) -> Vec3 {
        (**self).dyn_microfacets_fraction(query, facets, unshadowed, scratch)
    }
}

// Object-safe.
const _: fn(&dyn DynVisibility) = |_| {};
