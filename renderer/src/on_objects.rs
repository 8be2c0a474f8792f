//! Blockers that act on some receivers only.

use shading::{Coverage, Shaft, VisibilityQuery};
use visibility_mask::{Blockers, Edges, LitArea, Mask};

/// Blockers that hide lights only from receivers on certain objects.
#[derive(Debug)]
pub(crate) struct OnObjects<B> {
    blockers: B,
    /// For each object whether its receivers are shadowed.
    objects: Vec<bool>,
}

impl<B> OnObjects<B> {
    pub(crate) const fn new(blockers: B, objects: Vec<bool>) -> Self {
        Self { blockers, objects }
    }
}

/// Working memory of [`OnObjects`].
#[derive(Debug)]
pub(crate) struct OnObjectsScratch<S> {
    blockers: S,
    /// A group that the blockers have not entered yet: most groups have no such receiver.
    waiting: Option<Shaft>,
}

impl<B: Blockers> Blockers for OnObjects<B> {
    type Scratch = OnObjectsScratch<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        OnObjectsScratch { blockers: self.blockers.scratch(), waiting: None }
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        scratch.waiting = Some(*shaft);
        Coverage::Partial
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        if !self.objects.get(query.at.object as usize).is_some_and(|is| *is) {
            return Coverage::Lit;
        }
        if let Some(shaft) = scratch.waiting.take() {
            self.blockers.enter(&shaft, &mut scratch.blockers);
        }
        self.blockers.select(query, &mut scratch.blockers)
    }

    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, edges: &mut Edges) {
        self.blockers.edges(query, &scratch.blockers, edges);
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask) {
        self.blockers.splat(query, &mut scratch.blockers, mask);
    }

    fn mark_openings(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &mut Mask,
        narrowest: f32,
    ) -> bool {
        self.blockers.mark_openings(query, &mut scratch.blockers, mask, narrowest)
    }

    fn add_hidden(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, mask: &Mask, lit: &mut LitArea) -> bool {
        self.blockers.add_hidden(query, &scratch.blockers, mask, lit)
    }

    fn find_lit(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &Mask,
        narrowest: f32,
        lit: &mut LitArea,
    ) -> bool {
        self.blockers.find_lit(query, &mut scratch.blockers, mask, narrowest, lit)
    }

    fn may_hide_openings(&self, scratch: &Self::Scratch) -> bool {
        self.blockers.may_hide_openings(&scratch.blockers)
    }
}
