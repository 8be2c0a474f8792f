use crate::counts::Counts;
use crate::visible_fraction::{Shown, Sums, image_sums, microfacet_sums, sums};
use crate::{Fineness, Mask, UnitSquare};
use glam::{UVec2, Vec3};
use lobe_core::{BrdfLobe, Coverage, LightImage, Lobe, Microfacets, Outline, Receiver};

/// The masks of a window: one, or several side by side where the tolerance wants more samples than one has.
#[derive(Clone, Debug, Default)]
pub(crate) struct WindowMasks {
    window: UnitSquare,
    masks: Vec<Mask>,
    used: usize,
}

impl WindowMasks {
    /// Starts anew and has `draw` block what is blocked of each part on which anything emits.
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
        self.used = fineness.count();
        if self.masks.len() < self.used {
            self.masks.resize_with(self.used, Mask::default);
        }
        let across = UVec2::from(fineness.grid);
        for (k, mask) in (0..).zip(&mut self.masks[..self.used]) {
            mask.set_coarse(fineness.coarse);
            mask.reset_to(&window.part(k, across), depth, normal, outline);
            if across == UVec2::ONE || !mask.is_dark() {
                draw(mask);
            }
        }
    }

    /// The window of all of them.
    pub(crate) fn window(&self) -> &UnitSquare {
        &self.window
    }

    /// The masks, row by row.
    pub(crate) fn masks(&self) -> &[Mask] {
        &self.masks[..self.used]
    }

    /// What they leave of what emits.
    pub(crate) fn coverage(&self) -> Coverage {
        if self.masks().iter().all(Mask::is_lit) {
            Coverage::Lit
        } else if self.masks().iter().all(Mask::is_dark) {
            Coverage::Dark
        } else {
            Coverage::Partial
        }
    }

    /// Fraction of the lobe's light that is lit.
    pub(crate) fn fraction(&self, at: &Receiver, lobe: &Lobe, counts: &mut Counts) -> f32 {
        let of_mask = |mask| sums(mask, &self.window, at, lobe, counts);
        let total = self.masks().iter().map(of_mask).fold(Sums::default(), |a, b| a + b);
        total.ratio(self.masks())
    }
}

/// What two masks, of a part of the light and of all of it, leave of microfacets' light: in `near`, if there is one, it counts what that shows.
pub(crate) fn microfacet_fractions(
    whole: &WindowMasks,
    near: Option<&WindowMasks>,
    at: &Receiver,
    facets: &Microfacets,
    counts: [&mut Counts; 2],
) -> [f32; 2] {
    let [whole_counts, near_counts] = counts;
    let mut total = [Sums::default(); 2];
    let mut add = |sums: [Sums; 2]| total = [total[0] + sums[0], total[1] + sums[1]];
    for mask in whole.masks() {
        add(microfacet_sums(mask, at, facets, near.map(WindowMasks::window), whole_counts));
    }
    for mask in near.map(WindowMasks::masks).unwrap_or_default() {
        add(microfacet_sums(mask, at, facets, None, near_counts));
    }
    total.map(|sums| sums.ratio(whole.masks()))
}

/// What is left of the light of an image, by channel: of all of the light's, or of all but what the masks in `near` show, and theirs.
pub(crate) fn image_fractions(
    whole: &WindowMasks,
    near: Option<&WindowMasks>,
    at: &Receiver,
    lobe: &BrdfLobe,
    (image, outline): (&LightImage, &Outline),
    counts: &mut Counts,
) -> Vec3 {
    // All windows of such a light are turned alike.
    let UnitSquare { right, up, .. } = whole.window;
    let shown = Shown { image, places: outline.places([right, up]) };
    let mut total = [Sums::default(); 3];
    let skip = near.map(WindowMasks::window);
    let masks = whole.masks().iter().map(|mask| (mask, skip));
    for (mask, skip) in masks.chain(near.into_iter().flat_map(WindowMasks::masks).map(|mask| (mask, None))) {
        let sums = image_sums(mask, at, lobe, &shown, skip, counts);
        total = core::array::from_fn(|k| total[k] + sums[k]);
    }
    Vec3::from_array(total.map(|sums| sums.ratio(whole.masks())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::Cone;
    use lobe_core::oracle::Random;

    /// A straight edge across a light that lobes of all widths see: the fraction through many masks is that through one mask, but for
    /// the samples of each.
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
                (drawn.coverage(), drawn.fraction(&at, &lobe, &mut Counts::default()))
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
