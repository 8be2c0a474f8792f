//! Blockers behind `dyn`: the same trait with the type of the scratch erased, and any number of such in one mask.

use crate::{Blockers, Edges, Mask};
use core::fmt::{self, Debug, Formatter};
use shading::{Coverage, DynScratch, Shaft, VisibilityQuery};

/// [`Blockers`] in object-safe form: same operations, scratch erased. Implemented for all.
pub trait DynBlockers: Sync {
    /// See [`Blockers::scratch`].
    fn dyn_scratch(&self) -> DynScratch;
    /// See [`Blockers::enter`].
    fn dyn_enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage;
    /// See [`Blockers::select`].
    fn dyn_select(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage;
    /// See [`Blockers::edges`].
    fn dyn_edges(&self, query: &VisibilityQuery<'_>, scratch: &DynScratch, edges: &mut Edges);
    /// See [`Blockers::splat`].
    fn dyn_splat(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch, mask: &mut Mask);
}

const OF_ANOTHER: &str = "scratch was made by other blockers";

fn downcast<S: 'static>(scratch: &mut DynScratch) -> &mut S {
    scratch.downcast_mut().expect(OF_ANOTHER)
}

impl<B> DynBlockers for B
where
    B: Blockers,
    B::Scratch: 'static,
{
    fn dyn_scratch(&self) -> DynScratch {
        Box::new(self.scratch())
    }
    fn dyn_enter(&self, shaft: &Shaft, scratch: &mut DynScratch) -> Coverage {
        self.enter(shaft, downcast(scratch))
    }
    fn dyn_select(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch) -> Coverage {
        self.select(query, downcast(scratch))
    }
    fn dyn_edges(&self, query: &VisibilityQuery<'_>, scratch: &DynScratch, edges: &mut Edges) {
        self.edges(query, scratch.downcast_ref().expect(OF_ANOTHER), edges);
    }
    fn dyn_splat(&self, query: &VisibilityQuery<'_>, scratch: &mut DynScratch, mask: &mut Mask) {
        self.splat(query, downcast(scratch), mask);
    }
}

/// Any number of blockers in one mask, chosen at run time. A [`Mixture`](crate::Mixture) is for blockers that are known at compile
/// time.
#[derive(Clone, Default)]
pub struct DynMixture<'a>(pub Vec<&'a dyn DynBlockers>);

impl Debug for DynMixture<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_tuple("DynMixture").field(&self.0.len()).finish()
    }
}

impl Blockers for DynMixture<'_> {
    /// The scratch of each, and whether it has found a blocker.
    type Scratch = Vec<(DynScratch, bool)>;

    fn scratch(&self) -> Self::Scratch {
        self.0.iter().map(|blockers| (blockers.dyn_scratch(), false)).collect()
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        let mut coverage = Coverage::Lit;
        for (blockers, (scratch, _)) in self.0.iter().zip(scratch) {
            let own = blockers.dyn_enter(shaft, scratch);
            if coverage == Coverage::Lit {
                coverage = own;
            }
        }
        coverage
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        let mut coverage = Coverage::Lit;
        for (blockers, (scratch, is_partial)) in self.0.iter().zip(scratch) {
            match blockers.dyn_select(query, scratch) {
                Coverage::Dark => return Coverage::Dark,
                own => *is_partial = own == Coverage::Partial,
            }
            if *is_partial {
                coverage = Coverage::Partial;
            }
        }
        coverage
    }

    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, edges: &mut Edges) {
        for (blockers, (scratch, _)) in self.0.iter().zip(scratch).filter(|(_, (_, is_partial))| *is_partial) {
            blockers.dyn_edges(query, scratch, edges);
        }
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask) {
        for (blockers, (scratch, _)) in self.0.iter().zip(scratch).filter(|(_, (_, is_partial))| *is_partial) {
            blockers.dyn_splat(query, scratch, mask);
        }
    }
}

// Object-safe.
const _: fn(&dyn DynBlockers) = |_| {};
