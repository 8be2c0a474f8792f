//! How accurate the mask of a query has to be.

use crate::MAX_DEPTH;
use crate::spread::along;
use crate::square::WIDEST_TAN;
use glam::Vec3;
use lobe_core::Outline;
use shading::{Accuracy, VisibilityQuery};

/// A flat light that fills at least 1/FILLED of its circle has a mask like any other.
const FILLED: f32 = 3.0;

/// The crowding from which on there are more samples (the solid angle of samples in the middle of the light over their mean):
/// lights of 65° and more. Masks are deeper from there on, and once more from four times that, 79°.
pub(crate) const CROWDED: f32 = 4.0;

/// The tolerance of a light that fills its window with equal samples: a long light has few of the window's samples, a wide one few
/// that count.
pub(crate) fn tolerance(query: &VisibilityQuery<'_>) -> f32 {
    evenly(query) * (2.0 * CROWDED / crowding(query)).min(1.0)
}

/// The same if samples count alike.
pub(crate) fn evenly(query: &VisibilityQuery<'_>) -> f32 {
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
pub(crate) fn crowding(query: &VisibilityQuery<'_>) -> f32 {
    if query.outline.is_some() {
        return 1.0;
    }
    let cos = (1.0 - query.cone.one_minus_cos).max(1.0 / WIDEST_TAN);
    (1.0 + cos) / (2.0 * cos * cos)
}

/// The depth of masks that an accuracy sets, at least 1 and at most [`MAX_DEPTH`].
///
/// ```
/// use shading::Accuracy;
/// use visibility_mask::mask_depth;
/// assert_eq!([0, 3, 9].map(|depth| mask_depth(Accuracy::default().with_depth(depth))), [1, 3, 6]);
/// ```
#[must_use]
pub fn mask_depth(accuracy: Accuracy) -> u32 {
    accuracy.depth.clamp(1, MAX_DEPTH)
}

/// The reach of a lobe's own window, in its standard deviations: `√(2 ln(2/τ))` leaves less than half the tolerance outside.
pub(crate) fn zoom_sigmas(tolerance: f32) -> f32 {
    (2.0 * (2.0 / tolerance.clamp(1e-6, 0.5)).ln()).sqrt()
}
