//! Visibility strategies behind `dyn`: the same trait with the type of the scratch erased.

use crate::{Accuracy, Coverage, Lobe, LobesFull, PartlySeen, Shaft, VisibilityLobes, VisibilityQuery, VisibilitySum};
use core::any::Any;

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

// Object-safe.
const _: fn(&dyn DynVisibility) = |_| {};
