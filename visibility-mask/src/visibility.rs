use crate::accuracy::{CROWDED, crowding, evenly, mask_depth, tolerance, zoom_sigmas};
use crate::contour;
use crate::counts::Counts;
use crate::near_masks::is_faint;
use crate::spread::{Spread, along};
use crate::square::WIDEST_TAN;
use crate::window_masks::{SeenFacets, WindowMasks, image_fractions};
use crate::{Blockers, Edges, Fineness, LitArea, MAX_DEPTH, Mask, MaskLobes, UnitSquare};
use glam::{UVec2, Vec3};
use lobe_core::{BrdfLobe, Cone, LightImage, Lobe, Microfacets, Outline, Receiver, Schlick, Sphere, is_lambert};
use shading::{Coverage, Shaft, Visibility, VisibilityQuery};

/// A lobe whose logarithm falls by more than this over a radius of the light has masks as fine as a narrow one: otherwise a few
/// samples would carry its visible fraction, and each would be noticeable as it comes or goes.
pub(crate) const STEEP: f32 = 1.0;

/// A mask of a wider light than this (1 − cos θ) is turned as one of this width.
pub(crate) const WIDE: f32 = 0.6;

/// Squared sines of half-angles: a light's masks have samples so fine that openings between them are not looked for; openings are looked for
/// everywhere before the light.
pub(crate) const NARROW: f32 = 0.0025;
pub(crate) const WIDE_ANYWAY: f32 = 0.3;

/// Whether openings between the samples of a dark mask of a light are looked for only where blockers [say](Blockers::may_hide_openings) that there may be
/// some.
#[must_use]
pub fn asks_for_openings(light: &Cone) -> bool {
    (NARROW..WIDE_ANYWAY).contains(&light.sin_sq())
}

/// The width of an opening that is looked for, in windows' half sides: a thousandth of a sample of 64.
pub(crate) const NARROWEST_OPENING: f32 = 1.0 / 32768.0;

/// Where masks are drawn again around the lit part of a light that is so small that few samples measure its size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LookAgain {
    /// Nowhere: the tolerance is a part of the unshadowed radiance.
    Never,
    /// In all parts of a sky, and where less than a third of a light wider than 17° to each side is seen; of other lights where an opening is seen, whose lit part ends at blockers on
    /// two opposite sides, and where less than a tenth is seen. Before wide lights, and where nothing of a light wider than 3° is seen, also for openings between samples.
    #[default]
    Openings,
    /// In all dark ends of ordinary penumbrae, and for openings between the samples, so that the tolerance is a part of the receiver's own
    /// radiance. Up to 23 % slower.
    Everywhere,
}

/// The `moments` visibility: any [`Blockers`] through the mask.
///
/// # Method
/// The blockers fill a mask of the whole light. If so little of it is lit that few samples measure its size, blockers find that part [as it is](Blockers::find_lit); if they cannot, masks are drawn again in
/// windows around the lit part and, before wide lights, around openings between samples that the blockers [mark](Blockers::mark_openings), so
/// that the error is small compared with the visible part; [`LookAgain`] says where. Behind leaves of triangles, where the lit part is in many pieces and even and odd rows of the mask do not
/// agree on its size within the tolerance, the mask is drawn again with twice the rows. A lobe narrower than the light has a mask of its own over the part of the light that it covers,
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
        MaskLobes::of(Self { is_single: true, ..self })
    }

    /// The direction across the edges of the blockers and, if it cuts the light, of the horizon.
    fn across(&self, query: &VisibilityQuery<'_>, scratch: &B::Scratch) -> Vec3 {
        if let Some(outline) = query.outline.filter(|outline| outline.has_sides()) {
            return outline.side();
        }
        let middle = query.outline.map(|outline| toward_middle(outline, query.cone));
        let query = VisibilityQuery { cone: middle.as_ref().unwrap_or(query.cone), ..*query };
        let mut edges = Edges::before(&query);
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
        unshadowed: f32,
        scratch: &mut MaskScratch<B::Scratch>,
    ) -> Vec3 {
        if let (Schlick::F90, Some((exponent, seen))) = (facets.part, scratch.seen.take())
            && exponent == facets.exponent
        {
            return unit(seen.fraction(facets.part, unshadowed));
        }
        if scratch.full.is_lit_known() {
            return Self::facets_fraction([true, false], query, facets, unshadowed, scratch);
        }
        let [broad, narrow] = [self.broad(query), self.narrow(query)];
        let highlight = facets.highlight(query.at.normal);
        let whole = *scratch.full.window();
        if let Some(outline) = query.outline.filter(|_| scratch.full.is_uneven() && shown(query).is_none()) {
            let spread = whole.highlight_spread(highlight, query.at.normal, outline);
            scratch.own.set_spread(Some(spread));
            self.draw_narrow(&whole, query, scratch);
            scratch.own.set_spread(None);
            scratch.is_whole = false;
            return Self::facets_fraction([false, false], query, facets, unshadowed, scratch);
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
        Self::facets_fraction([!finer, near.is_some()], query, facets, unshadowed, scratch)
    }

    /// The fraction by the masks of the whole light, coarse ones or own ones, and those of the highlight's window.
    fn facets_fraction(
        [is_full, has_near]: [bool; 2],
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        unshadowed: f32,
        scratch: &mut MaskScratch<B::Scratch>,
    ) -> Vec3 {
        let MaskScratch { full, own, counts: [counts, own_counts], .. } = scratch;
        let (whole, near) = (if is_full { &*full } else { &*own }, has_near.then_some(&*own));
        if let Some(shown) = shown(query) {
            return image_fractions(whole, near, query.at, &BrdfLobe::Microfacets(*facets), shown, counts);
        }
        let seen = SeenFacets::new(whole, near, query.at, facets, [counts, own_counts]);
        scratch.seen = (facets.part == Schlick::F0).then_some((facets.exponent, seen));
        unit(seen.fraction(facets.part, unshadowed))
    }

    /// Whether the lobe has masks of its own, `scratch.own`, which are then drawn; otherwise it uses those of the whole light,
    /// `scratch.full`.
    pub(crate) fn draw_own(
        &self,
        query: &VisibilityQuery<'_>,
        brdf: &Lobe,
        scratch: &mut MaskScratch<B::Scratch>,
    ) -> bool {
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
        (mask_depth(query.accuracy) + more).min(MAX_DEPTH)
    }

    /// Draws the masks of a window of narrow lobes; draws them again around the lit part if that was done for the whole light.
    fn draw_narrow(&self, square: &UnitSquare, query: &VisibilityQuery<'_>, scratch: &mut MaskScratch<B::Scratch>) {
        let MaskScratch { blockers, full, own, .. } = scratch;
        let fineness = [self.narrow(query), Fineness::narrow(evenly(query))];
        self.draw(square, fineness, query, blockers, own, full.has_near());
    }

    /// Draws the masks of a window with the first fineness, or a finer one; if `is_looked_into`, draws masks around a small lit part with the second one.
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
        let mut draw = |mask: &mut Mask| self.blockers.splat(query, blockers, mask);
        masks.draw(square, fineness, depth, query.at.normal, query.outline, &mut draw);
        if self.is_single || self.again == LookAgain::Never {
            return;
        }
        if self.blockers.refines_masks() && masks.is_rough(evenly(query)) {
            let (fineness, depth) = fineness.finer(depth);
            masks.draw(square, fineness, depth, query.at.normal, query.outline, draw);
        }
        if is_looked_into {
            self.draw_near(square, near, query, blockers, masks);
        }
    }

    /// Finds the lit part of a window as it is, or draws masks around it with a fineness, if it is small.
    fn draw_near(
        &self,
        square: &UnitSquare,
        near: Fineness,
        query: &VisibilityQuery<'_>,
        blockers: &mut B::Scratch,
        masks: &mut WindowMasks,
    ) {
        let counts = masks.lit_counts();
        let is_little = counts.are_slight() || counts.are_few();
        // A part of an environment, whose outline knows its sides, ends where the next one begins.
        let is_patch = query.outline.is_some_and(Outline::has_sides);
        let is_wide = square.half.max_element() > contour::WIDE;
        // Behind a window a part of a wide light, or a few parts of a sky, are all that is seen, whatever it is that ends them.
        let is_cut = (is_patch || is_wide && counts.are_little()) && masks.coverage() == Coverage::Partial;
        if !is_little && !is_cut {
            return;
        }
        let is_thorough = self.again == LookAgain::Everywhere || is_patch || is_cut;
        // Through an opening between samples much of a wide light's radiance may come; of a narrower one all, where nothing is lit.
        let is_wide = is_thorough
            || is_wide
            || counts.are_none() && asks_for_openings(query.cone) && self.blockers.may_hide_openings(blockers);
        let is_opening = is_thorough || masks.is_opening();
        let seeks = is_wide && is_opening;
        let is_few = counts.are_few() && (is_opening || counts.are_slight());
        let narrowest = NARROWEST_OPENING * square.half.x;
        let mut find = |mask: &Mask, lit: &mut LitArea| self.blockers.find_lit(query, blockers, mask, narrowest, lit);
        // Of an image that is seen through an opening each texel counts.
        let image = query.image.filter(|_| counts.are_little() && masks.is_opening());
        let holds_light = query.outline.is_some() || query.cone.tan() < WIDEST_TAN;
        if (seeks || is_few) && holds_light && masks.find_lit((image, !is_opening, query.image.is_some()), &mut find) {
            return;
        }
        let are_known = seeks && masks.mark(|mask| self.blockers.mark_openings(query, blockers, mask, narrowest));
        let is_narrow = seeks && counts.are_narrow();
        if !(is_cut && are_known) && !(is_little && (masks.has_openings() || is_narrow || is_few)) {
            return;
        }
        let is_found = masks.has_openings() || !counts.are_none();
        let depth = (query.accuracy.depth + u32::from(seeks && is_found)).clamp(1, MAX_DEPTH);
        masks.draw_near([near.coarse, seeks && !are_known, query.image.is_none()], |square, mask| {
            mask.reset_to(square, depth, query.at.normal, query.outline);
            if !mask.is_dark() {
                self.blockers.splat(query, blockers, mask);
                if seeks && is_found && is_faint(mask) {
                    self.blockers.mark_openings(query, blockers, mask, narrowest);
                }
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
        mask.reset_to(&square, mask_depth(query.accuracy), query.at.normal, query.outline);
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
    pub(crate) full: WindowMasks,
    pub(crate) own: WindowMasks,
    /// Whether `own` shows the whole light of the query.
    is_whole: bool,
    counts: [Counts; 2],
    /// The light of microfacets that is seen, of whose two lobes the second one follows, and their exponent.
    seen: Option<(f32, SeenFacets)>,
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
            seen: None,
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
        scratch.seen = None;
        let spread = query.outline.and_then(|outline| Spread::of_outline(outline, &square));
        scratch.full.set_spread(spread.filter(|_| !self.is_single));
        let fineness = [self.broad(query), Fineness::broad(evenly(query))];
        self.draw(&square, fineness, query, &mut scratch.blockers, &mut scratch.full, true);
        scratch.full.coverage()
    }

    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut Self::Scratch) -> Vec3 {
        let own = usize::from(!scratch.full.is_lit_known() && self.draw_own(query, brdf, scratch));
        let masks = [&scratch.full, &scratch.own][own];
        let counts = &mut scratch.counts[own];
        match shown(query) {
            None => unit(masks.fraction(query.at, brdf, unshadowed, counts)),
            Some(shown) => image_fractions(masks, None, query.at, &BrdfLobe::Cosine(*brdf), shown, counts),
        }
    }

    fn microfacets_fraction(
        &self,
        query: &VisibilityQuery<'_>,
        facets: &Microfacets,
        unshadowed: f32,
        scratch: &mut Self::Scratch,
    ) -> Vec3 {
        self.microfacets(query, facets, unshadowed, scratch)
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
