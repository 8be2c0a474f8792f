//! Visibility as a sum of lobes, and the fraction of the light that the sum lets through.

use crate::product::normalized_total;
use crate::{Lobe, LobeBuffer, Receiver};

/// Visibility inside a light's cone as a sum of lobes (Eq. 8), written for one reflectance lobe.
///
/// `V ≈ base + Σ lobes`. When `whole` is not empty it holds, cut by the same nodes, the lobes of the *whole* light, and
/// the visible fraction is the ratio of the two sums: exact in both limits, and most errors cancel.
#[derive(Clone, Debug, Default)]
pub struct VisibilitySum {
    /// The constant term (`c_unit` of Eq. 38): a scalar, never a lobe of exponent 0.
    pub base: f32,
    /// Lobes of V; their flux is a solid angle (negative where they take light away).
    pub lobes: LobeBuffer,
    /// Lobes of the unoccluded light over the same nodes; empty when the sum is to be used directly.
    pub whole: LobeBuffer,
}

impl VisibilitySum {
    /// Starts a new sum: a constant, without lobes.
    pub fn clear(&mut self, base: f32) {
        self.base = base;
        self.lobes.clear();
        self.whole.clear();
    }

    /// How many lobes it has, and how many products with a reflectance lobe it takes.
    #[must_use]
    pub fn counts(&self) -> [usize; 2] {
        let [lobes, whole] = [self.lobes.lobes().len(), self.whole.lobes().len()];
        [lobes, lobes + whole]
    }
}

/// The fraction of an unshadowed integral that a visibility sum lets through, for one reflectance lobe.
///
/// With lobes of the whole light beside: `Σ P(f, lit)/Σ P(f, whole)`, exact where all or nothing is lit. Without:
/// `base + Σ P(f, lobes)/unshadowed`. In [0, 1]; `unshadowed` is the integral of `f` at flux 1.
#[must_use]
pub fn visible_fraction(at: &Receiver, f: &Lobe, unshadowed: f32, sum: &VisibilitySum) -> f32 {
    if sum.lobes.lobes().is_empty() && sum.whole.lobes().is_empty() {
        return sum.base.clamp(0.0, 1.0);
    }
    let seen = normalized_total(at, f, sum.lobes.lobes());
    let fraction = if sum.whole.lobes().is_empty() {
        sum.base + if unshadowed > 0.0 { seen / unshadowed } else { 0.0 }
    } else {
        let whole = normalized_total(at, f, sum.whole.lobes());
        if whole > 0.0 { seen / whole } else { sum.base }
    };
    fraction.clamp(0.0, 1.0)
}
