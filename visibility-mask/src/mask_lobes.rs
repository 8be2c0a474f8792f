use crate::quadtree_cut::{QuadtreeCut, QuadtreeMoments};
use crate::visibility::MaskScratch;
use crate::{Blockers, MaskVisibility};
use glam::Vec3;
use lobe_core::{Lobe, VisibilitySum};
use shading::{Coverage, Shaft, Visibility, VisibilityLobes, VisibilityQuery};

/// The same masks with visibility as a sum of lobes, cut from the mask's quad-tree ([`MaskVisibility`] describes both methods).
#[derive(Clone, Copy, Debug)]
pub struct MaskLobes<B> {
    masks: MaskVisibility<B>,
}

impl<B> MaskLobes<B> {
    /// Of masks that are single.
    pub(crate) const fn of(masks: MaskVisibility<B>) -> Self {
        Self { masks }
    }
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
