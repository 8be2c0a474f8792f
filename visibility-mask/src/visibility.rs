use crate::contour;
use crate::counts::Counts;
use crate::quadtree_cut::{QuadtreeCut, QuadtreeMoments};
use crate::spread::{Spread, along};
use crate::square::WIDEST_TAN;
use crate::window_masks::{WindowMasks, image_fractions, microfacet_fractions};
use crate::{Edges, Fineness, MAX_DEPTH, Mask, UnitSquare};
use glam::{UVec2, Vec2, Vec3};
use lobe_core::{
    BrdfLobe, Cone, LightImage, Lobe, Microfacets, Outline, Receiver, Schlick, Sphere, VisibilitySum, is_lambert,
};
use shading::{Accuracy, Coverage, Shaft, Visibility, VisibilityLobes, VisibilityQuery};

/// A lobe whose logarithm falls by more than this over a radius of the light has masks as fine as a narrow one: otherwise a few
/// samples would carry its visible fraction, and each would be noticeable as it comes or goes.
pub(crate) const STEEP: f32 = 1.0;

/// A flat light that fills at least 1/FILLED of its circle has a mask like any other.
const FILLED: f32 = 3.0;

/// A mask of a wider light than this (1 − cos θ) is turned as one of this width.
pub(crate) const WIDE: f32 = 0.6;

/// The crowding from which on there are more samples (the solid angle of samples in the middle of the light over their mean):
/// lights of 65° and more. Masks are deeper from there on, and once more from four times that, 79°.
pub(crate) const CROWDED: f32 = 4.0;

/// Blockers of light that can be rasterised: the interface of a visibility strategy.
///
/// [`MaskVisibility`] makes a [`Visibility`] of them: masks, cuts and lobes are the same for all strategies.
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

    /// The width of the narrowest penumbra on a part of the group: see [`Visibility::narrowest_penumbra`]. Provided: 0, not known.
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
        let mut edges = Edges::new(query.cone);
        self.edges(query, scratch, &mut edges);
        edges.across()
    }

    /// Two corners of a box in the plane that contains all edges in a window, if known: samples may be wrong only there. Call it
    /// only after [`splat`](Self::splat) of the same query. Provided: `None`.
    fn edge_bounds(
        &self,
        query: &VisibilityQuery<'_>,
        scratch: &Self::Scratch,
        window: &UnitSquare,
    ) -> Option<[Vec2; 2]> {
        let _ = (query, scratch, window);
        None
    }

    /// Blocks cells of the mask, whose window is any part of the receiver's unit square. Call it only after
    /// [`select`](Self::select) of the same query.
    fn splat(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch, mask: &mut Mask);
}

/// Where masks are drawn again around the lit part of a light that is so small that few samples measure its size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LookAgain {
    /// Nowhere: the tolerance is a part of the unshadowed radiance.
    Never,
    /// In all parts of a sky, where an opening is seen, whose lit part ends at blockers on two opposite sides, and where less than a tenth of the
    /// light is seen.
    #[default]
    Openings,
    /// In all dark ends of ordinary penumbrae, and for openings between the samples, so that the tolerance is a part of the receiver's own
    /// radiance. Up to 23 % slower.
    Everywhere,
}

/// The `moments` visibility: any [`Blockers`] through the mask.
///
/// # Method
/// The blockers fill a mask of the whole light. If so little of it is lit that few samples measure its size, masks are drawn again in
/// windows around the lit part, or around all edges as well if these take less than half of the light, so that the error is small
/// compared with the visible part; [`LookAgain`] says where. A lobe narrower than the light has a mask of its own over the part of the light that it covers,
/// since the cells of the whole mask would limit its accuracy. As things move, samples come and go. Below a tolerance of 0.5 % the
/// window of a narrow lobe is divided into 2 × 2 parts with a mask each, below 0.2 % into 3 × 2 and the whole light into 2 × 2
/// ([`Fineness`]): with gentle motion 95 % of the pops are then smaller than the tolerance. The visible part of the light for a
/// reflectance lobe is then
/// - a *visible fraction* (the default), summed over the mask's samples: the sum of one lobe times every sample in closed form. It
///   costs as much as a few visibility lobes, and no lobe is written. Or
/// - *lobes* ([`MaskLobes`]): a Lambert lobe takes one lobe of the mask, whose total and mean vector are those of the lit part; a
///   glossy lobe takes a cut of the quad-tree, refined where the reflectance varies over a node and the node is partly lit. Each
///   node gives a lobe of its lit part and one of the whole node; the visible fraction is their ratio.
///
/// # Cost
/// Nothing for lit and fully hidden receivers; otherwise one mask, plus one for each narrow lobe; if the tolerance divides the
/// window, one mask for each part.
#[derive(Clone, Copy, Debug)]
pub struct MaskVisibility<B> {
    blockers: B,
    /// Whether there is a single mask of full fineness, whatever the tolerance, since a cut needs one mask.
    is_single: bool,
    again: LookAgain,
}

impl<B: Blockers> MaskVisibility<B> {
    /// The visible fraction of each lobe, from masks of the depth of a query's accuracy, clamped to 1…[`MAX_DEPTH`].
    #[must_use]
    pub const fn new(blockers: B) -> Self {
        Self { blockers, is_single: false, again: LookAgain::Openings }
    }

    /// Sets where masks are drawn again around the lit part of a light, if that is small.
    #[must_use]
    pub fn look_again(self, again: LookAgain) -> Self {
        Self { again, ..self }
    }

    /// The same blockers with visibility as lobes.
    #[must_use]
    pub fn with_lobes(self) -> MaskLobes<B> {
        MaskLobes { masks: Self { is_single: true, ..self } }
    }

    /// The direction across the edges of the blockers and, if it cuts the light, of the horizon.
    fn across(&self, query: &VisibilityQuery<'_>, scratch: &B::Scratch) -> Vec3 {
        if let Some(outline) = query.outline.filter(|outline| outline.has_sides()) {
            return outline.side();
        }
        let middle = query.outline.map(|outline| toward_middle(outline, query.cone));
        let query = VisibilityQuery { cone: middle.as_ref().unwrap_or(query.cone), ..*query };
        let mut edges = Edges::new(query.cone);
        self.blockers.edges(&query, scratch, &mut edges);
        edges.add_plane(query.at.normal, query.cone);
        let across = edges.across();
        query.outline.and_then(|outline| along(outline, across)).unwrap_or(across)
    }

    /// The window around the whole emitting region.
    fn whole(query: &VisibilityQuery<'_>, across: Vec3) -> UnitSquare {
        match query.outline {
            None => UnitSquare::facing(query.cone, across).above(query.at.normal),
            Some(outline) => UnitSquare::around_outline(outline, across),
        }
    }

    /// The window of a lobe that needs a mask of its own: the part of the light that it covers, turned by the edges in that part;
    /// or the whole light, if that is for more samples.
    fn window(
        &self,
        query: &VisibilityQuery<'_>,
        brdf: &Lobe,
        whole: &UnitSquare,
        scratch: &B::Scratch,
    ) -> Option<UnitSquare> {
        if is_lambert(query.at, brdf) {
            return None;
        }
        let peak = |whole: &UnitSquare| whole.peak(brdf, query.at.normal, query.outline);
        let (at_whole, sigmas) = (peak(whole), zoom_sigmas(query.accuracy.tolerance));
        let square = whole.around(&at_whole, sigmas);
        if square == *whole {
            return (self.broad(query) != self.narrow(query) && at_whole.fall() > STEEP).then_some(square);
        }
        let cone = square.cone(query.cone.distance);
        let across = match query.outline {
            None => self.across(&VisibilityQuery { cone: &cone, ..*query }, scratch),
            Some(_) => whole.right,
        };
        let whole = Self::whole(query, across);
        Some(whole.around(&peak(&whole), sigmas))
    }

    /// The visible fraction of microfacets' light. The highlight has a mask of its own if it is narrow compared with the light; the
    /// rest is summed over the mask of the whole light. Computes both lobes at once.
    fn microfacets(
        &self,
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        scratch: &mut MaskScratch<B::Scratch>,
    ) -> Vec3 {
        if let (Schlick::F90, Some((exponent, fraction))) = (facets.part, scratch.edge.take())
            && exponent == facets.exponent
        {
            return unit(fraction);
        }
        let [broad, narrow] = [self.broad(query), self.narrow(query)];
        let highlight = facets.highlight(query.at.normal);
        let whole = *scratch.full.window();
        if scratch.full.is_uneven() && shown(query).is_none() {
            let spread = whole.highlight_spread(highlight, query.at.normal, query.outline);
            scratch.own.set_spread(Some(spread));
            self.draw_narrow(&whole, query, scratch);
            scratch.own.set_spread(None);
            scratch.is_whole = false;
            let both @ [_, edge] =
                microfacet_fractions(&scratch.own, None, query.at, facets, scratch.counts.each_mut());
            scratch.edge = (facets.part == Schlick::F0).then_some((facets.exponent, edge));
            return unit(facets.part.of(both));
        }
        let cells = UVec2::from(broad.grid) * UVec2::new(broad.columns(), 1 << self.depth(query));
        let near = whole.highlight(highlight, query.at.normal, cells, query.accuracy.tolerance, query.outline);
        let size = if query.outline.is_some() { whole.half.max_element() } else { whole.disc };
        let finer = near.is_none() && broad != narrow && size > 2.0 * highlight.1;
        if let Some(square) = near.or(finer.then_some(whole)) {
            if !(finer && scratch.is_whole) {
                self.draw_narrow(&square, query, scratch);
            }
            scratch.is_whole = finer;
        }
        let whole = if finer { &scratch.own } else { &scratch.full };
        let near = near.map(|_| &scratch.own);
        let [counts, own_counts] = &mut scratch.counts;
        if let Some(shown) = shown(query) {
            return image_fractions(whole, near, query.at, &BrdfLobe::Microfacets(*facets), shown, counts);
        }
        let both @ [_, edge] = microfacet_fractions(whole, near, query.at, facets, [counts, own_counts]);
        scratch.edge = (facets.part == Schlick::F0).then_some((facets.exponent, edge));
        unit(facets.part.of(both))
    }

    /// Whether the lobe has masks of its own, `scratch.own`, which are then drawn; otherwise it uses those of the whole light,
    /// `scratch.full`.
    fn draw_own(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, scratch: &mut MaskScratch<B::Scratch>) -> bool {
        let whole = scratch.full.window();
        let Some(square) = self.window(query, brdf, whole, &scratch.blockers) else { return false };
        let is_whole = square == *whole;
        if !(is_whole && scratch.is_whole) {
            self.draw_narrow(&square, query, scratch);
            scratch.is_whole = is_whole;
        }
        true
    }

    /// The fineness of masks for broad lobes: full for a cut, which needs one mask.
    fn broad(&self, query: &VisibilityQuery<'_>) -> Fineness {
        if self.is_single { Fineness::FINE } else { Fineness::broad(tolerance(query)) }
    }

    fn narrow(&self, query: &VisibilityQuery<'_>) -> Fineness {
        if self.is_single { Fineness::FINE } else { Fineness::narrow(tolerance(query)) }
    }

    /// The depth of the masks.
    fn depth(&self, query: &VisibilityQuery<'_>) -> u32 {
        let crowding = if self.is_single { 1.0 } else { crowding(query) };
        let more = u32::from(crowding >= CROWDED) + u32::from(crowding >= 4.0 * CROWDED);
        (depth(query.accuracy) + more).min(MAX_DEPTH)
    }

    /// Draws the masks of a window of narrow lobes; draws them again around the lit part if that was done for the whole light.
    fn draw_narrow(&self, square: &UnitSquare, query: &VisibilityQuery<'_>, scratch: &mut MaskScratch<B::Scratch>) {
        let MaskScratch { blockers, full, own, .. } = scratch;
        let fineness = [self.narrow(query), Fineness::narrow(evenly(query))];
        self.draw(square, fineness, query, blockers, own, full.has_near());
    }

    /// Draws the masks of a window with the first fineness; if `is_looked_into`, draws masks around a small lit part with the
    /// second one.
    fn draw(
        &self,
        square: &UnitSquare,
        [fineness, near]: [Fineness; 2],
        query: &VisibilityQuery<'_>,
        blockers: &mut B::Scratch,
        masks: &mut WindowMasks,
        is_looked_into: bool,
    ) {
        let depth = self.depth(query);
        let draw = |mask: &mut Mask| self.blockers.splat(query, blockers, mask);
        masks.draw(square, fineness, depth, query.at.normal, query.outline, draw);
        if self.is_single || self.again == LookAgain::Never || !is_looked_into {
            return;
        }
        let counts = masks.lit_counts();
        if !counts.are_few() {
            return;
        }
        // A part of an environment, whose outline knows its sides, ends where the next one begins.
        let is_patch = query.outline.is_some_and(Outline::has_sides);
        // Through an opening between samples much of a wide light's radiance may come.
        let is_hidden = counts.are_none() && square.half.max_element() > contour::WIDE;
        let is_thorough = self.again == LookAgain::Everywhere || is_patch || is_hidden;
        if !is_thorough && !counts.are_slight() && !masks.is_opening() {
            return;
        }
        let edges = self.blockers.edge_bounds(query, blockers, square);
        masks.draw_near(edges, [near.coarse, is_thorough], |square, mask| {
            mask.reset_to(square, query.accuracy.depth.clamp(1, MAX_DEPTH), query.at.normal, query.outline);
            if !mask.is_dark() {
                self.blockers.splat(query, blockers, mask);
            }
        });
    }

    /// One fine mask of the whole light, of the depth that the query requests, and how much of the light it shows: to be looked at, and
    /// not on the way of shading, which divides it or draws it coarser as the tolerance allows.
    pub fn mask(&self, query: &VisibilityQuery<'_>) -> (Coverage, Mask) {
        let mut scratch = self.blockers.scratch();
        let coverage = self.blockers.select(query, &mut scratch);
        let square = Self::whole(query, self.across(query, &scratch));
        let mut mask = Mask::default();
        mask.reset_to(&square, depth(query.accuracy), query.at.normal, query.outline);
        match coverage {
            Coverage::Lit => {}
            Coverage::Dark => (0..mask.side()).for_each(|row| mask.block_span(row, f32::NEG_INFINITY, f32::INFINITY)),
            Coverage::Partial => self.blockers.splat(query, &mut scratch, &mut mask),
        }
        (coverage, mask)
    }

    /// Returns the blockers.
    #[must_use]
    pub fn into_blockers(self) -> B {
        self.blockers
    }

    /// The blockers.
    pub fn blockers(&self) -> &B {
        &self.blockers
    }
}

/// Working memory of [`MaskVisibility`].
#[derive(Clone, Debug)]
pub struct MaskScratch<S> {
    blockers: S,
    full: WindowMasks,
    own: WindowMasks,
    /// Whether `own` shows the whole light of the query.
    is_whole: bool,
    counts: [Counts; 2],
    /// The visible fraction of the microfacets' edge lobe, which follows, and its exponent.
    edge: Option<(f32, f32)>,
}

impl<B: Blockers> Visibility for MaskVisibility<B> {
    type Scratch = MaskScratch<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        MaskScratch {
            blockers: self.blockers.scratch(),
            full: WindowMasks::default(),
            own: WindowMasks::default(),
            is_whole: false,
            counts: Default::default(),
            edge: None,
        }
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        self.blockers.enter(shaft, &mut scratch.blockers)
    }

    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut Self::Scratch) -> f32 {
        self.blockers.narrowest_penumbra(at, part, &mut scratch.blockers)
    }

    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        if query.outline.is_none() && query.cone.one_minus_cos > 1.0 {
            // Inside the light there is no disc to cover.
            return Coverage::Lit;
        }
        let selected = self.blockers.select(query, &mut scratch.blockers);
        if selected != Coverage::Partial {
            return selected;
        }
        if query.cone.one_minus_cos <= 0.0 {
            // A blocker that touches the direction of a point light hides it.
            return Coverage::Dark;
        }
        let square = Self::whole(query, self.across(query, &scratch.blockers));
        scratch.is_whole = false;
        scratch.edge = None;
        let spread = query.outline.and_then(|outline| Spread::of_outline(outline, &square));
        scratch.full.set_spread(spread.filter(|_| !self.is_single));
        let fineness = [self.broad(query), Fineness::broad(evenly(query))];
        self.draw(&square, fineness, query, &mut scratch.blockers, &mut scratch.full, true);
        scratch.full.coverage()
    }

    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, _: f32, scratch: &mut Self::Scratch) -> Vec3 {
        let own = usize::from(self.draw_own(query, brdf, scratch));
        let masks = [&scratch.full, &scratch.own][own];
        let counts = &mut scratch.counts[own];
        match shown(query) {
            None => unit(masks.fraction(query.at, brdf, counts)),
            Some(shown) => image_fractions(masks, None, query.at, &BrdfLobe::Cosine(*brdf), shown, counts),
        }
    }

    fn microfacets_fraction(
        &self,
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        _: f32,
        scratch: &mut Self::Scratch,
    ) -> Vec3 {
        self.microfacets(query, facets, scratch)
    }
}

/// The same masks with visibility as a sum of lobes, cut from the mask's quad-tree ([`MaskVisibility`] describes both methods).
#[derive(Clone, Copy, Debug)]
pub struct MaskLobes<B> {
    masks: MaskVisibility<B>,
}

/// Working memory of [`MaskLobes`].
#[derive(Clone, Debug)]
pub struct MaskLobesScratch<S> {
    masks: MaskScratch<S>,
    cut: QuadtreeMoments,
    sum: VisibilitySum,
}

impl<B: Blockers> Visibility for MaskLobes<B> {
    type Scratch = MaskLobesScratch<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        MaskLobesScratch { masks: self.masks.scratch(), cut: QuadtreeMoments::default(), sum: VisibilitySum::default() }
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        self.masks.enter(shaft, &mut scratch.masks)
    }

    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        self.masks.coverage(query, &mut scratch.masks)
    }

    /// The fraction of the [lobes](VisibilityLobes::lobes), by closed products.
    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut Self::Scratch) -> Vec3 {
        let mut sum = core::mem::take(&mut scratch.sum);
        let fraction = self.fraction_of_lobes(query, brdf, unshadowed, scratch, &mut sum);
        scratch.sum = sum;
        fraction
    }
}

impl<B: Blockers> VisibilityLobes for MaskLobes<B> {
    fn lobes(
        &self,
        query: &VisibilityQuery<'_>,
        brdf: &Lobe,
        unshadowed: f32,
        scratch: &mut Self::Scratch,
        out: &mut VisibilitySum,
    ) {
        out.clear(0.0);
        let own = self.masks.draw_own(query, brdf, &mut scratch.masks);
        let masks = if own { &scratch.masks.own } else { &scratch.masks.full };
        let [mask] = masks.masks() else { return };
        scratch.cut.build(mask);
        QuadtreeCut::new(mask, &scratch.cut, query.at, brdf, unshadowed, query.accuracy.tolerance).write(out);
    }
}

/// A fraction that is the same in all channels, in `[0, 1]`.
fn unit(fraction: f32) -> Vec3 {
    Vec3::splat(fraction.clamp(0.0, 1.0))
}

/// The image that a light shows, and its outline.
fn shown<'q>(query: &VisibilityQuery<'q>) -> Option<(&'q LightImage, &'q Outline)> {
    query.image.zip(query.outline)
}

/// The cone that the rotation of a polygon's mask follows: toward the middle of what a horizon leaves of it, and less than a hemisphere.
fn toward_middle(outline: &Outline, cone: &Cone) -> Cone {
    if cone.one_minus_cos < WIDE && !outline.is_clipped() {
        return *cone;
    }
    Cone { axis: outline.middle().normalize_or(cone.axis), one_minus_cos: cone.one_minus_cos.min(WIDE), ..*cone }
}

/// The tolerance of a light that fills its window with equal samples: a long light has few of the window's samples, a wide one few
/// that count.
fn tolerance(query: &VisibilityQuery<'_>) -> f32 {
    evenly(query) * (2.0 * CROWDED / crowding(query)).min(1.0)
}

/// The same if samples count alike.
fn evenly(query: &VisibilityQuery<'_>) -> f32 {
    let fill =
        |outline: &Outline| if along(outline, Vec3::X).is_some() { 1.0 } else { fill_factor(outline.roundness()) };
    query.accuracy.tolerance * query.outline.map_or(1.0, fill)
}

/// The fill factor of a mask: masks of a flat light with a [roundness](Outline::roundness) are drawn for this fraction of the
/// tolerance.
#[must_use]
pub fn fill_factor(roundness: f32) -> f32 {
    (FILLED * roundness).min(1.0)
}

/// The solid angle of samples in the middle of a round light over their mean, since samples are even on a plane in front of it:
/// `tan²θ/2(1 − cos θ) = (1 + cos θ)/2cos²θ`.
fn crowding(query: &VisibilityQuery<'_>) -> f32 {
    if query.outline.is_some() {
        return 1.0;
    }
    let cos = (1.0 - query.cone.one_minus_cos).max(1.0 / WIDEST_TAN);
    (1.0 + cos) / (2.0 * cos * cos)
}

/// The depth of an accuracy.
fn depth(accuracy: Accuracy) -> u32 {
    accuracy.depth.clamp(1, MAX_DEPTH)
}

/// The reach of a lobe's own window, in its standard deviations: `√(2 ln(2/τ))` leaves less than half the tolerance outside.
pub(crate) fn zoom_sigmas(tolerance: f32) -> f32 {
    (2.0 * (2.0 / tolerance.clamp(1e-6, 0.5)).ln()).sqrt()
}
