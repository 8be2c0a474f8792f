use crate::{Blockers, Edges, LitArea, Mask};
use lobe_core::{Receiver, Sphere};
use shading::{Coverage, Shaft, VisibilityQuery};

/// Two kinds of blockers in one mask: a direction is hidden if either hides it. Pairs of pairs give more kinds.
///
/// A strategy per object (walls by rays, characters by spheres) is a mixture of strategies that have different objects. Each is
/// searched by itself; only those that find a blocker draw into the mask.
///
/// ```
/// use visibility_mask::{Blockers, MaskVisibility, Mixture};
/// fn mixed<A: Blockers, B: Blockers, C: Blockers>(a: A, b: B, c: C) -> MaskVisibility<Mixture<A, Mixture<B, C>>> {
///     MaskVisibility::new(Mixture::new(a, Mixture::new(b, c)))
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Mixture<A, B> {
    first: A,
    second: B,
}

impl<A, B> Mixture<A, B> {
    /// Both together.
    pub const fn new(first: A, second: B) -> Self {
        Self { first, second }
    }
}

/// Working memory of a [`Mixture`].
#[derive(Clone, Copy, Debug)]
pub struct MixtureScratch<A, B> {
    first: A,
    second: B,
    /// Which of the two have found a blocker.
    partial: (bool, bool),
}

impl<A: Blockers, B: Blockers> Blockers for Mixture<A, B> {
    type Scratch = MixtureScratch<A::Scratch, B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        MixtureScratch { first: self.first.scratch(), second: self.second.scratch(), partial: (false, false) }
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        let first = self.first.enter(shaft, &mut scratch.first);
        let second = self.second.enter(shaft, &mut scratch.second);
        if first == Coverage::Lit { second } else { first }
    }

    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut Self::Scratch) -> f32 {
        let first = self.first.narrowest_penumbra(at, part, &mut scratch.first);
        first.min(self.second.narrowest_penumbra(at, part, &mut scratch.second))
    }

    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        let first = self.first.select(query, &mut scratch.first);
        if first == Coverage::Dark {
            return Coverage::Dark;
        }
        let second = self.second.select(query, &mut scratch.second);
        scratch.partial = (first == Coverage::Partial, second == Coverage::Partial);
        match (first, second) {
            (_, Coverage::Dark) => Coverage::Dark,
            (Coverage::Lit, Coverage::Lit) => Coverage::Lit,
            _ => Coverage::Partial,
        }
    }

    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, edges: &mut Edges) {
        if scratch.partial.0 {
            self.first.edges(query, &scratch.first, edges);
        }
        if scratch.partial.1 {
            self.second.edges(query, &scratch.second, edges);
        }
    }

    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask) {
        if scratch.partial.0 {
            self.first.splat(query, &mut scratch.first, mask);
        }
        if scratch.partial.1 {
            self.second.splat(query, &mut scratch.second, mask);
        }
    }

    fn mark_openings(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &mut Mask,
        narrowest: f32,
    ) -> bool {
        let first = !scratch.partial.0 || self.first.mark_openings(query, &mut scratch.first, mask, narrowest);
        let second = !scratch.partial.1 || self.second.mark_openings(query, &mut scratch.second, mask, narrowest);
        first && second
    }

    fn add_hidden(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, mask: &Mask, lit: &mut LitArea) -> bool {
        let MixtureScratch { first, second, partial } = scratch;
        (!partial.0 || self.first.add_hidden(query, first, mask, lit))
            && (!partial.1 || self.second.add_hidden(query, second, mask, lit))
    }

    fn find_lit(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &Mask,
        narrowest: f32,
        lit: &mut LitArea,
    ) -> bool {
        let MixtureScratch { first, second, partial } = scratch;
        let of = (mask, narrowest);
        match *partial {
            (true, false) => self.first.find_lit(query, first, mask, narrowest, lit),
            (false, true) => self.second.find_lit(query, second, mask, narrowest, lit),
            (false, false) => false,
            (true, true) => {
                find_around(query, of, (&self.first, &mut *first), (&self.second, &mut *second), lit)
                    || find_around(query, of, (&self.second, second), (&self.first, first), lit)
            }
        }
    }

    fn refines_masks(&self) -> bool {
        self.first.refines_masks() || self.second.refines_masks()
    }

    fn may_hide_openings(&self, scratch: &Self::Scratch) -> bool {
        (scratch.partial.0 && self.first.may_hide_openings(&scratch.first))
            || (scratch.partial.1 && self.second.may_hide_openings(&scratch.second))
    }
}

/// Finds the lit part by blockers around what others hide, if these know its outlines; else if they hide no sample beside that part.
fn find_around<A: Blockers, B: Blockers>(
    query: &VisibilityQuery<'_>,
    (mask, narrowest): (&Mask, f32),
    (finder, scratch): (&A, &mut A::Scratch),
    (other, hiding): (&B, &mut B::Scratch),
    lit: &mut LitArea,
) -> bool {
    let start = lit.len();
    let mut find = |lit: &mut LitArea| {
        lit.truncate(start);
        finder.find_lit(query, scratch, mask, narrowest, lit)
    };
    let mut is_found = find(lit);
    if is_found {
        lit.look_at(start, mask.square());
        if other.add_hidden(query, hiding, mask, lit) {
            is_found = lit.hidden().is_empty() || find(lit);
        } else {
            let mut own = mask.clone();
            own.reset_to(mask.square(), mask.depth(), query.at.normal, query.outline);
            other.splat(query, hiding, &mut own);
            is_found = lit.is_clear(start, &own);
        }
        lit.clear_hidden();
    }
    if !is_found {
        lit.truncate(start);
    }
    is_found
}
