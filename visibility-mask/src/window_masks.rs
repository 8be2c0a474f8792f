use crate::counts::Counts;
use crate::lit_sums;
use crate::near_masks::{LitCounts, LitEnds, NearMasks};
use crate::places;
use crate::spread::Spread;
use crate::visible_fraction::{MIRROR, Shown, Sums, image_sums, microfacet_sums, narrowest, sums};
use crate::{Fineness, LitArea, Mask, UnitSquare, row};
use fearless_simd::{Level, dispatch};
use glam::{UVec2, Vec3};
use lobe_core::{BrdfLobe, LightImage, Lobe, Microfacets, Outline, Receiver, Schlick, light_image_integral};
use shading::Coverage;

/// The lit part is in many pieces if rows, of which one of LOOKED_AT is looked at, show as many in the mean.
const PIECES: u32 = 2;
const LOOKED_AT: usize = 4;
/// Masks are drawn again with more rows if half of these differ from the others by more than ROUGH times the tolerance. Both halves together err by less than half as much.
const ROUGH: f32 = 3.0;

/// The masks of a window: one, or several side by side if the tolerance needs more samples; and, if the lit part is small, that part as it is, or masks
/// around it.
#[derive(Clone, Debug, Default)]
pub(crate) struct WindowMasks {
    window: UnitSquare,
    masks: Vec<Mask>,
    /// Masks in use: side by side, and one above the other.
    grid: [u32; 2],
    /// Where the light of the next window is, if that is wide.
    spread: Option<Spread>,
    near: NearMasks,
    lit: LitArea,
    is_lit_known: bool,
}

impl WindowMasks {
    /// Clears the masks, and lets `draw` block each part on which anything emits.
    ///
    /// # Panics
    /// As [`Mask::reset`].
    pub(crate) fn draw(
        &mut self,
        window: &UnitSquare,
        fineness: Fineness,
        depth: u32,
        normal: Vec3,
        outline: Option<&Outline>,
        mut draw: impl FnMut(&mut Mask),
    ) {
        self.window = *window;
        let even = UVec2::from(fineness.grid);
        let uneven = self.spread.filter(|spread| spread.divides(window)).map(|spread| spread.parts(window, even));
        let across = uneven.as_ref().map_or(even, |(_, count)| *count);
        self.grid = across.to_array();
        let count = across.element_product() as usize;
        if self.masks.len() < count {
            self.masks.resize_with(count, Mask::default);
        }
        for (k, mask) in (0..).zip(&mut self.masks[..count]) {
            mask.set_coarse(fineness.coarse);
            let part = uneven.as_ref().map_or_else(|| window.part(k, even), |(parts, _)| parts[k as usize]);
            mask.reset_to(&part, depth, normal, outline);
            if across == UVec2::ONE || !mask.is_dark() {
                draw(mask);
            }
        }
        self.near.clear();
        self.is_lit_known = false;
    }

    /// The masks of the next windows are divided about this place where they are wide.
    pub(crate) fn set_spread(&mut self, spread: Option<Spread>) {
        self.spread = spread;
    }

    /// Whether the masks are not even over the window.
    pub(crate) fn is_uneven(&self) -> bool {
        self.spread.is_some_and(|spread| spread.divides(&self.window))
    }

    /// The numbers of lit samples.
    pub(crate) fn lit_counts(&self) -> LitCounts {
        let mut counts = LitCounts::default();
        self.masks().iter().for_each(|mask| counts.add(mask));
        counts
    }

    /// Whether the lit part is in many pieces whose size rows do not measure: half of them differ from the others by more than [`ROUGH`] times a tolerance, relative to all.
    pub(crate) fn is_rough(&self, tolerance: f32) -> bool {
        dispatch!(Level::new(), _simd => self.are_rows_rough(tolerance))
    }

    #[inline(always)]
    fn are_rows_rough(&self, tolerance: f32) -> bool {
        let (mut spans, mut lit_rows) = (0, 0);
        for mask in self.masks() {
            for j in (0..mask.side()).step_by(LOOKED_AT) {
                let more = row::spans(&mask.lit(j));
                spans += more;
                lit_rows += u32::from(more > 0);
            }
        }
        if spans < PIECES * lit_rows || spans == 0 {
            return false;
        }
        let mut sums = [0_u32; 2];
        for mask in self.masks() {
            for j in 0..mask.side() {
                sums[j % 2] += row::count(&mask.lit(j));
            }
        }
        sums[0].abs_diff(sums[1]) as f32 > ROUGH * tolerance * (sums[0] + sums[1]) as f32
    }

    /// Whether the lit part is that of an opening: it ends at blockers on two opposite sides at least. The lit part of an ordinary penumbra
    /// ends at the light's own outline along the rows and across them.
    pub(crate) fn is_opening(&self) -> bool {
        let [across, up] = self.grid;
        let mut ends = LitEnds::default();
        for (k, mask) in (0..).zip(self.masks()) {
            let place: [u32; 2] = [k % across, k / across];
            ends.add(mask, [0, 1].map(|axis| [place[axis] > 0, place[axis] + 1 < [across, up][axis]]));
        }
        ends.are_of_an_opening()
    }

    /// Lets `mark` mark openings between the samples of each mask. Returns whether it does so for all.
    pub(crate) fn mark(&mut self, mut mark: impl FnMut(&mut Mask) -> bool) -> bool {
        let count = (self.grid[0] * self.grid[1]) as usize;
        let mut are_known = true;
        for mask in &mut self.masks[..count] {
            are_known &= mark(mask);
        }
        are_known
    }

    /// Whether openings between samples are marked.
    pub(crate) fn has_openings(&self) -> bool {
        self.masks().iter().any(|mask| !mask.openings().is_empty())
    }

    /// Whether the lit part is known as it is.
    pub(crate) fn is_lit_known(&self) -> bool {
        self.is_lit_known
    }

    /// Whether the lit part is known apart from the masks of the whole window.
    pub(crate) fn has_near(&self) -> bool {
        self.is_lit_known || !self.near.masks().is_empty()
    }

    /// Lets `find` find the lit part of each mask as it is, as finely as the light's image wants, and whether it is that of an ordinary penumbra. Returns whether it does so for all.
    pub(crate) fn find_lit(
        &mut self,
        (image, is_ordinary, shows_image): (Option<&LightImage>, bool, bool),
        mut find: impl FnMut(&Mask, &mut LitArea) -> bool,
    ) -> bool {
        self.lit.begin(image, is_ordinary, shows_image);
        let count = (self.grid[0] * self.grid[1]) as usize;
        let Self { masks, lit, .. } = self;
        if !masks[..count].iter().all(|mask| find(mask, lit)) {
            return false;
        }
        // Dark masks stay so where nothing is open between their samples.
        self.is_lit_known = !self.lit.is_empty() || self.masks().iter().any(|mask| !mask.is_dark());
        true
    }

    /// Lets `draw` block windows around the lit part, in masks with a fineness; each is filled by at least a quarter if [`NearMasks`] can do so.
    /// Where no place is lit, one is looked for if that is requested (`seeks`).
    pub(crate) fn draw_near(
        &mut self,
        [coarse, seeks, may_turn]: [bool; 3],
        mut draw: impl FnMut(&UnitSquare, &mut Mask),
    ) {
        let mut places = Vec::new();
        self.masks().iter().for_each(|mask| places::add(mask, &self.window, &mut places));
        if seeks || !places.is_empty() {
            self.near.draw(&self.window, places, may_turn, |square, mask| {
                mask.set_coarse(coarse);
                draw(square, mask);
            });
        }
    }

    /// The window of all masks together.
    pub(crate) fn window(&self) -> &UnitSquare {
        &self.window
    }

    /// The masks, row by row.
    pub(crate) fn masks(&self) -> &[Mask] {
        &self.masks[..(self.grid[0] * self.grid[1]) as usize]
    }

    /// Coverage of the emitting region by all masks.
    pub(crate) fn coverage(&self) -> Coverage {
        if self.has_near() {
            Coverage::Partial
        } else if self.masks().iter().all(Mask::is_lit) {
            Coverage::Lit
        } else if self.masks().iter().all(Mask::is_dark) {
            Coverage::Dark
        } else {
            Coverage::Partial
        }
    }

    /// The sums of all masks, in units of solid angle or in samples of the masks of the whole window. If there are masks around the
    /// lit part, these give the lit sums.
    fn total<const N: usize>(&self, mut sums: impl FnMut(&Mask, bool) -> [Sums; N]) -> [Sums; N] {
        let mut total = [Sums::default(); N];
        let mut add = |mask: &Mask, near: bool, part: fn(Sums) -> Sums| {
            for (total, sums) in total.iter_mut().zip(sums(mask, near)) {
                *total = *total + part(sums);
            }
        };
        let near = self.near.masks();
        for mask in self.masks() {
            add(mask, false, if self.has_near() { Sums::emitting } else { |sums| sums });
        }
        for mask in near {
            add(mask, true, Sums::lit);
        }
        total
    }

    /// The lit fraction of the emitting area.
    fn lit_fraction(&self) -> f32 {
        let area = |masks: &[Mask], count: fn(&Mask) -> u32| {
            masks.iter().map(|mask| count(mask) as f32 * mask.sample_area()).sum::<f32>()
        };
        let near = self.near.masks();
        let lit = if near.is_empty() { self.masks() } else { near };
        let lit = if self.is_lit_known { self.lit.area() } else { area(lit, Mask::lit_count) };
        let all = area(self.masks(), Mask::emitting_count);
        if all > 0.0 { lit / all } else { 0.0 }
    }

    /// The exponent of lobes as narrow as cells of the masks of the whole window: a mirror still needs some samples.
    fn narrowest(&self) -> f32 {
        self.masks().first().map_or(MIRROR, narrowest)
    }

    /// The visible fraction of the lobe, whose integral of flux 1 over all of the light is `unshadowed`.
    pub(crate) fn fraction(&self, at: &Receiver, lobe: &Lobe, unshadowed: f32, counts: &mut Counts) -> f32 {
        let lobe = Lobe { exponent: lobe.exponent.min(self.narrowest()), ..*lobe };
        if self.is_lit_known {
            // By what the light is integrated with, whose error then goes.
            let lit = lit_sums::of_cosine(&self.lit, &self.window, at, &lobe);
            return Sums { lit, all: unshadowed }.ratio(|| self.lit_fraction());
        }
        let whole = self.masks().first().map_or(1.0, Mask::sample_area);
        let is_uneven = self.is_uneven();
        let [total] = self.total(|mask, near| {
            let sums = sums(mask, &self.window, at, &lobe, counts);
            [if near || is_uneven { sums * (mask.sample_area() / whole) } else { sums }]
        });
        total.ratio(|| self.lit_fraction())
    }
}

/// The light of both parts of microfacets that is seen: a fraction of all of it, or, if the lit part is known as it is, its integral.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SeenFacets {
    Fractions([f32; 2]),
    Integrals([f32; 2]),
}

impl SeenFacets {
    /// From the masks of the whole light and, if given, those `near` of a part, which count instead.
    pub(crate) fn new(
        whole: &WindowMasks,
        near: Option<&WindowMasks>,
        at: &Receiver,
        facets: &Microfacets,
        counts: [&mut Counts; 2],
    ) -> Self {
        if whole.is_lit_known {
            return Self::Integrals(lit_sums::of_microfacets(&whole.lit, &whole.window, at, facets));
        }
        let [whole_counts, near_counts] = counts;
        let skip = near.map(WindowMasks::window);
        let mut total = whole.total(|mask, _| microfacet_sums(mask, at, facets, skip, whole_counts));
        if let Some(near) = near {
            let mut sums = near.total(|mask, _| microfacet_sums(mask, at, facets, None, near_counts));
            if near.is_lit_known {
                let lit = lit_sums::of_microfacets(&near.lit, &near.window, at, facets);
                sums.iter_mut().zip(lit).for_each(|(sums, lit)| sums.lit = lit);
            }
            total = [total[0] + sums[0], total[1] + sums[1]];
        }
        Self::Fractions(total.map(|sums| sums.ratio(|| whole.lit_fraction())))
    }

    /// The visible fraction of a part whose integral over all of the light is `unshadowed`.
    pub(crate) fn fraction(self, part: Schlick, unshadowed: f32) -> f32 {
        match self {
            Self::Fractions(both) => part.of(both),
            Self::Integrals(both) => Sums { lit: part.of(both), all: unshadowed }.ratio(|| 0.0),
        }
    }
}

/// The visible fraction of an image's light, by channel: from the masks of the whole light and, if given, those `near` of a part,
/// which count instead.
pub(crate) fn image_fractions(
    whole: &WindowMasks,
    near: Option<&WindowMasks>,
    at: &Receiver,
    lobe: &BrdfLobe,
    (image, outline): (&LightImage, &Outline),
    counts: &mut Counts,
) -> Vec3 {
    // All windows on such a light are turned alike.
    let UnitSquare { right, up, .. } = whole.window;
    let shown = Shown { image, places: outline.places([right, up]) };
    let lobe = |masks: &WindowMasks| match lobe {
        BrdfLobe::Microfacets(facets) => BrdfLobe::Microfacets(*facets),
        BrdfLobe::Cosine(lobe) => Lobe { exponent: lobe.exponent.min(masks.narrowest()), ..*lobe }.into(),
    };
    let skip = near.map(WindowMasks::window);
    let of_whole = lobe(whole);
    let integrals = |masks: &WindowMasks, of: &BrdfLobe| lit_sums::of_image(&masks.lit, &masks.window, at, of, &shown);
    let mut total = if whole.is_lit_known {
        // By what the light is integrated with, whose error then goes.
        let all = light_image_integral(at, &of_whole, outline, image).to_array();
        let lit = integrals(whole, &of_whole);
        core::array::from_fn(|k| Sums { lit: lit[k], all: all[k] })
    } else {
        whole.total(|mask, _| image_sums(mask, at, &of_whole, &shown, skip, counts))
    };
    if let Some(near) = near {
        let of_near = lobe(near);
        let mut sums = near.total(|mask, _| image_sums(mask, at, &of_near, &shown, None, counts));
        if near.is_lit_known {
            sums.iter_mut().zip(integrals(near, &of_near)).for_each(|(sums, lit)| sums.lit = lit);
        }
        total = core::array::from_fn(|k| total[k] + sums[k]);
    }
    Vec3::from_array(total.map(|sums| sums.ratio(|| whole.lit_fraction())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::Cone;
    use lobe_core::oracle::Random;

    /// A straight edge across a light, for lobes of all widths: many masks give the same fraction as one mask, except for the
    /// samples of each.
    #[test]
    fn many_masks_see_what_one_mask_sees() {
        let mut random = Random::new(31);
        let (mut worst, mut counted) = ([0.0_f32; 2], 0);
        for case in 0..400 {
            let theta = random.log_uniform(0.003, 1.0);
            let axis = random.axis();
            let tilt = random.between(0.0, 1.5);
            let normal = random.axis_at(axis, tilt).as_vec3().normalize();
            let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
            let aside = theta * random.between(0.0, 1.2);
            let exponent = random.log_uniform(1.0, 1e5) as f32;
            let lobe = match case % 3 {
                0 => Lobe::new(normal, 1.0, Vec3::ONE),
                _ => Lobe::new(random.axis_at(axis, aside).as_vec3().normalize(), exponent, Vec3::ONE).times_cosine(),
            };
            let one_minus_cos = (1.0 - theta.cos()) as f32;
            let cone = Cone { axis: axis.as_vec3().normalize(), one_minus_cos, distance: f32::INFINITY };
            let whole = UnitSquare::facing(&cone, random.axis().as_vec3()).above(normal);
            let window = if case % 3 == 0 { whole } else { whole.zoomed(&lobe, normal, 3.6) };
            let edge = window.center.x + window.half.x * random.between(-0.8, 0.8) as f32;
            let slope = random.between(-0.5, 0.5) as f32 * window.half.x / window.half.y;
            let fraction = |grid| {
                let mut drawn = WindowMasks::default();
                let fineness = Fineness { grid, ..Fineness::FINE };
                drawn.draw(&window, fineness, 6, normal, None, |mask| {
                    for j in 0..mask.side() {
                        let y = mask.row_y(j) - window.center.y;
                        mask.block_span(j, f32::NEG_INFINITY, edge + slope * y);
                    }
                });
                (drawn.coverage(), drawn.fraction(&at, &lobe, 1.0, &mut Counts::default()))
            };
            let [one, many] = [fraction([1, 1]), fraction([3, 2])];
            if one.0 == Coverage::Partial {
                assert_eq!(one.0, many.0, "case {case}");
                let k = usize::from(window != whole);
                worst[k] = worst[k].max((one.1 - many.1).abs());
                counted += 1;
            }
        }
        println!("{counted} cases, whole lights and windows differ by {worst:?}");
        assert!(counted > 250 && worst.iter().all(|w| *w < 0.004), "{worst:?}");
    }

    /// A light that is lit in one part and hidden in the others is partly lit.
    #[test]
    fn coverage_is_that_of_all() {
        let cone = Cone { axis: Vec3::Z, one_minus_cos: 0.01, distance: f32::INFINITY };
        let window = UnitSquare::facing(&cone, Vec3::X);
        let fineness = Fineness { grid: [2, 2], ..Fineness::FINE };
        for dark in 0..=4 {
            let (mut masks, mut drawn) = (WindowMasks::default(), 0);
            masks.draw(&window, fineness, 5, Vec3::Z, None, |mask| {
                if drawn < dark {
                    mask.block_all();
                }
                drawn += 1;
            });
            let want = [Coverage::Lit, Coverage::Partial, Coverage::Partial, Coverage::Partial, Coverage::Dark];
            assert_eq!((masks.coverage(), drawn), (want[dark], 4));
        }
    }
}
