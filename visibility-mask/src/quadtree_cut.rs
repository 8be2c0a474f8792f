//! The quad-tree cut: the nodes of the mask that become lobes.

use crate::Mask;
use crate::moments::{Discs, Moments, Part, Pyramid, block};
use glam::Vec3;
use lobe_core::{Lobe, LobeWriter, Receiver, VisibilitySum, is_lambert};

/// Calibration of the error estimate against measured errors: a cut is refined while `E > CUT·τ²·U`.
const CUT: f32 = 40.0;

/// A node counts as partly lit in full if its smaller part is a fraction of 1/PARTLY or more.
const PARTLY: f32 = 20.0;

/// Larger exponents, infinite ones included, are refined like this one.
const NARROWEST: f32 = 1e9;

/// Working memory of a cut.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuadtreeMoments {
    lit: Pyramid,
    whole: Pyramid,
    discs: Discs,
}

impl QuadtreeMoments {
    /// Sums the moments of a filled mask.
    pub(crate) fn build(&mut self, mask: &Mask) {
        self.whole.build_emitting(mask, &mut self.discs);
        self.lit.build_lit(mask, &self.whole);
    }
}

/// The inputs of a cut.
pub(crate) struct QuadtreeCut<'a> {
    pub(crate) mask: &'a Mask,
    pub(crate) scratch: &'a QuadtreeMoments,
    pub(crate) at: &'a Receiver,
    pub(crate) brdf: &'a Lobe,
    /// Threshold on the error estimate of a node, in the units of a lobe of scale 1.
    threshold: f32,
    /// Normal and reflectance axis in the square's frame.
    normal: Vec3,
    axis: Vec3,
}

impl<'a> QuadtreeCut<'a> {
    /// `unshadowed` is the lobe's integral at flux 1.
    pub(crate) fn new(
        mask: &'a Mask,
        scratch: &'a QuadtreeMoments,
        at: &'a Receiver,
        brdf: &'a Lobe,
        unshadowed: f32,
        tolerance: f32,
    ) -> Self {
        let of_scale_one = unshadowed * core::f32::consts::TAU / (brdf.exponent.min(NARROWEST) + 1.0);
        Self {
            mask,
            scratch,
            at,
            brdf,
            threshold: CUT * tolerance * tolerance * of_scale_one,
            normal: mask.square().local(at.normal),
            axis: mask.square().local(brdf.axis),
        }
    }

    /// Writes the lobes of the lit part and, node by node, of the whole light.
    ///
    /// A Lambert lobe needs one node: total and mean vector of the lit samples are exact whatever their shape.
    pub(crate) fn write(&self, out: &mut VisibilitySum) {
        out.base = 0.0;
        self.node(0, 0, 0, 1.0, &mut out.lobes.writer(), &mut out.whole.writer());
    }

    fn node(
        &self,
        level: usize,
        x: usize,
        y: usize,
        weight: f32,
        lit: &mut LobeWriter<'_>,
        whole: &mut LobeWriter<'_>,
    ) {
        let all = self.moments(&self.scratch.whole, Part::Emitting, level, x, y);
        if all.omega <= 0.0 {
            return;
        }
        let open = self.moments(&self.scratch.lit, Part::Lit, level, x, y);
        let refined = self.refinement(level, &all, open.omega);
        if refined < 1.0 {
            self.emit(&all, (1.0 - refined) * weight, whole);
            self.emit(&open, (1.0 - refined) * weight, lit);
        }
        if refined > 0.0 {
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                self.node(level + 1, 2 * x + dx, 2 * y + dy, refined * weight, lit, whole);
            }
        }
    }

    fn moments(&self, pyramid: &Pyramid, part: Part, level: usize, x: usize, y: usize) -> Moments {
        pyramid.get(level, x, y).unwrap_or_else(|| {
            let size = self.mask.side() >> level;
            block(self.mask, part, x * size, y * size, size)
        })
    }

    /// The fraction of a node that its children replace: 0 below the threshold, 1 above twice the threshold, smooth between, so
    /// that nothing pops as a node is refined.
    ///
    /// The moment lobe of a node is right to first order. The rest of the reflectance's variation over the node has the relative
    /// size `r = e_f(1−R)` if the node is partly lit, `r²` if not, under the envelope of the reflectance lobe as far as the node
    /// reaches: `exp(−z²/2(1+r))`, `z² = −2 e_f ln cos` of the angle between the two.
    fn refinement(&self, level: usize, all: &Moments, lit: f32) -> f32 {
        if level as u32 == self.mask.depth() || is_lambert(self.at, self.brdf) {
            return 0.0;
        }
        let node = all.lobe(self.mask.cell().min_element());
        // A mirror is refined like a narrow lobe.
        let e = self.brdf.exponent.min(NARROWEST);
        let r = e * node.spread;
        let one_minus_cos = 0.5 * (node.axis - self.axis).length_squared();
        // A node behind the lobe still reaches in front by its own width.
        let log_cos = (-one_minus_cos.min(0.999_9)).ln_1p();
        let envelope = (e * log_cos / (1.0 + r)).exp();
        // Continuous as the last bit of a node becomes hidden or lit: the rest of it is its error.
        let share = lit / all.omega;
        let partly = (PARTLY * share.min(1.0 - share)).clamp(0.0, 1.0);
        let relative = 0.1 * r * r + partly * (0.4 * r + 0.2 * r * r);
        let cosine = if self.brdf.has_cosine {
            (self.normal.dot(node.axis) + (2.0 * node.spread).sqrt()).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let error = all.omega * envelope * relative.min(1.0) * cosine;
        let t = (error / self.threshold.max(f32::MIN_POSITIVE)).log2().clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    fn emit(&self, moments: &Moments, weight: f32, out: &mut LobeWriter<'_>) {
        if moments.omega <= 0.0 {
            return;
        }
        let lobe = moments.lobe(self.mask.cell().min_element());
        let axis = self.mask.square().world(lobe.axis).normalize();
        // A lobe's mean vector is never below half its flux, while that of a wide light's ring is. For a Lambert lobe the vector
        // must be kept.
        let kept = if lobe.spread > 0.5 && is_lambert(self.at, self.brdf) { 2.0 * (1.0 - lobe.spread) } else { 1.0 };
        out.push(Lobe::with_flux(axis, lobe.exponent, Vec3::splat(moments.omega * weight * kept)));
    }
}
