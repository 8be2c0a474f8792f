use crate::{Blockers, Edges, LitArea, Mask};
use lobe_core::{Receiver, Sphere};
use shading::{Coverage, Shaft, VisibilityQuery};

/// Blockers that a scene may not have: `None` blocks nothing, at the cost of one branch a query.
///
/// One [`Mixture`](crate::Mixture) of optional kinds serves every scene, and is compiled once.
///
/// ```
/// use visibility_mask::{Blockers, MaskVisibility, Mixture};
/// fn either<A: Blockers, B: Blockers>(a: Option<A>, b: Option<B>) -> MaskVisibility<Mixture<Option<A>, Option<B>>> {
///     MaskVisibility::new(Mixture::new(a, b))
/// }
/// ```
impl<B: Blockers> Blockers for Option<B> {
    type Scratch = Option<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        self.as_ref().map(B::scratch)
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        match (self, scratch) {
            (Some(blockers), Some(scratch)) => blockers.enter(shaft, scratch),
            _ => Coverage::Lit,
        }
    }

    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut Self::Scratch) -> f32 {
        match (self, scratch) {
            (Some(blockers), Some(scratch)) => blockers.narrowest_penumbra(at, part, scratch),
            _ => f32::INFINITY,
        }
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        match (self, scratch) {
            (Some(blockers), Some(scratch)) => blockers.select(query, scratch),
            _ => Coverage::Lit,
        }
    }

    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, edges: &mut Edges) {
        if let (Some(blockers), Some(scratch)) = (self, scratch) {
            blockers.edges(query, scratch, edges);
        }
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask) {
        if let (Some(blockers), Some(scratch)) = (self, scratch) {
            blockers.splat(query, scratch, mask);
        }
    }

    fn mark_openings(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &mut Mask,
        narrowest: f32,
    ) -> bool {
        match (self, scratch) {
            (Some(blockers), Some(scratch)) => blockers.mark_openings(query, scratch, mask, narrowest),
            _ => true,
        }
    }

    fn add_hidden(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, mask: &Mask, lit: &mut LitArea) -> bool {
        match (self, scratch) {
            (Some(blockers), Some(scratch)) => blockers.add_hidden(query, scratch, mask, lit),
            _ => true,
        }
    }

    fn find_lit(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &Mask,
        narrowest: f32,
        lit: &mut LitArea,
    ) -> bool {
        match (self, scratch) {
            (Some(blockers), Some(scratch)) => blockers.find_lit(query, scratch, mask, narrowest, lit),
            _ => false,
        }
    }

    fn refines_masks(&self) -> bool {
        self.as_ref().is_some_and(Blockers::refines_masks)
    }

    fn may_hide_openings(&self, scratch: &Self::Scratch) -> bool {
        matches!((self, scratch), (Some(blockers), Some(scratch)) if blockers.may_hide_openings(scratch))
    }
}

/// Borrowed blockers, for example those that are kept from frame to frame.
impl<B: Blockers> Blockers for &B {
    type Scratch = B::Scratch;

    fn scratch(&self) -> Self::Scratch {
        B::scratch(self)
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        B::enter(self, shaft, scratch)
    }

    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut Self::Scratch) -> f32 {
        B::narrowest_penumbra(self, at, part, scratch)
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        B::select(self, query, scratch)
    }

    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, edges: &mut Edges) {
        B::edges(self, query, scratch, edges);
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask) {
        B::splat(self, query, scratch, mask);
    }

    fn mark_openings(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &mut Mask,
        narrowest: f32,
    ) -> bool {
        B::mark_openings(self, query, scratch, mask, narrowest)
    }

    fn add_hidden(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, mask: &Mask, lit: &mut LitArea) -> bool {
        B::add_hidden(self, query, scratch, mask, lit)
    }

    fn find_lit(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &Mask,
        narrowest: f32,
        lit: &mut LitArea,
    ) -> bool {
        B::find_lit(self, query, scratch, mask, narrowest, lit)
    }

    fn refines_masks(&self) -> bool {
        B::refines_masks(self)
    }

    fn may_hide_openings(&self, scratch: &Self::Scratch) -> bool {
        B::may_hide_openings(self, scratch)
    }
}
