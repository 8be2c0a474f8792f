use crate::{Edges, LitArea, Mask};
use glam::Vec3;
use lobe_core::{Receiver, Sphere};
use shading::{Coverage, Shaft, VisibilityQuery};

/// Blockers of light that can be rasterised: the interface of a visibility strategy.
///
/// [`MaskVisibility`](crate::MaskVisibility) makes a [`Visibility`](shading::Visibility) of them: masks, cuts and lobes are the same for all strategies.
///
/// ```
/// use glam::Vec3;
/// use visibility_mask::{Blockers, Mask, MaskVisibility};
/// use shading::{Coverage, VisibilityQuery};
///
/// /// Hides everything to the left of the light's middle.
/// struct Curtain;
///
/// impl Blockers for Curtain {
///     type Scratch = ();
///     fn scratch(&self) {}
///     fn select(&self, _: &VisibilityQuery<'_>, _: &mut ()) -> Coverage {
///         Coverage::Partial
///     }
///     fn splat(&self, _: &VisibilityQuery<'_>, _: &mut (), mask: &mut Mask) {
///         for row in 0..mask.side() {
///             mask.block_span(row, f32::NEG_INFINITY, 0.0);
///         }
///     }
/// }
///
/// let strategy = MaskVisibility::new(Curtain); // a shading::Visibility
/// # let _ = strategy;
/// ```
pub trait Blockers: Sync {
    /// Working memory, one a thread.
    type Scratch: Send;

    /// New working memory.
    fn scratch(&self) -> Self::Scratch;

    /// Called before a group of receivers and one light: all following receivers are inside `shaft` until the next call.
    /// [`Coverage::Lit`] means that no receiver meets a blocker, as [`select`](Self::select) would return for each, except for the
    /// facets of receivers whose shading normal differs from the facet's.
    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        let _ = (shaft, scratch);
        Coverage::Partial
    }

    /// The width of the narrowest penumbra on a part of the group: see [`Visibility::narrowest_penumbra`](shading::Visibility::narrowest_penumbra). Provided: 0, not known.
    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut Self::Scratch) -> f32 {
        let _ = (at, part, scratch);
        0.0
    }

    /// Finds the blockers that may meet this receiver's light cone. [`Coverage::Lit`] if there are none, [`Coverage::Dark`] if a
    /// single one hides the whole light; no mask is drawn in either case.
    fn select(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage;

    /// Adds the edges across the light, so that masks are turned in the direction in which most of them are exact. Add none if
    /// their directions do not matter to [`splat`](Self::splat). Call it only after [`select`](Self::select) of the same query.
    fn edges(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, edges: &mut Edges) {
        let _ = (query, scratch, edges);
    }

    /// The direction across which most of these edges run. Provided.
    fn across(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch) -> Vec3 {
        let mut edges = Edges::before(query);
        self.edges(query, scratch, &mut edges);
        edges.across()
    }

    /// Marks openings that lie between two samples of a row and are at least `narrowest` wide in plane coordinates: see
    /// [`Mask::mark_opening`]. Returns whether it knows all of them. Call it only after [`splat`](Self::splat) of the same query and mask. Provided:
    /// it knows none.
    fn mark_openings(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &mut Mask,
        narrowest: f32,
    ) -> bool {
        let _ = (query, scratch, mask, narrowest);
        false
    }

    /// Whether a mask that [`splat`](Self::splat) has left dark since [`select`](Self::select) may have an opening between its samples; costs less than
    /// [`mark_openings`](Self::mark_openings). Counts before lights of [`asks_for_openings`](crate::asks_for_openings) alone. Provided: no.
    fn may_hide_openings(&self, scratch: &Self::Scratch) -> bool {
        let _ = scratch;
        false
    }

    /// Whether masks behind many small pieces are drawn again with more rows, where these do not measure the lit part. Provided: no.
    fn refines_masks(&self) -> bool {
        false
    }

    /// Adds what it hides of a mask's window, as polygons ([`LitArea::hide`]), for others that find the lit part. Returns `false`, whatever it has added, where it
    /// cannot. Call it only after [`select`](Self::select) of the same query. Provided: it cannot.
    fn add_hidden(&self, query: &VisibilityQuery<'_>, scratch: &Self::Scratch, mask: &Mask, lit: &mut LitArea) -> bool {
        let _ = (query, scratch, mask, lit);
        false
    }

    /// Finds the lit part of a mask's window at once, but for what is [hidden](LitArea::hidden) already, where outlines are exact and few; else returns `false`. Intervals of
    /// its rows narrower than `narrowest`, in plane coordinates, are left out. Call it only after [`select`](Self::select) of the same query. Provided: it finds none.
    fn find_lit(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &mut Self::Scratch,
        mask: &Mask,
        narrowest: f32,
        lit: &mut LitArea,
    ) -> bool {
        let _ = (query, scratch, mask, narrowest, lit);
        false
    }

    /// Blocks cells of the mask, whose window is any part of the receiver's unit square. Call it only after
    /// [`select`](Self::select) of the same query.
    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask);
}
