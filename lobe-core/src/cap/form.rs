//! How an integral is taken: a number for each form, and which of them a lobe and a light need.

use super::{chord, slab};
use crate::PackedLobe;
use crate::seen::Seen;

/// Lobes from this exponent on, infinity included, see the one direction of their axis.
pub(super) const MIRROR: f32 = 1e9;

/// It has been.
pub(super) const DONE: f32 = 0.0;
/// Lambert, a light that the horizon crosses.
pub(super) const CROSSED: f32 = 1.0;
/// A wide light and a narrow lobe above the horizon.
pub(super) const SLAB: f32 = 2.0;
/// A light above the horizon.
pub(super) const WHOLE: f32 = 3.0;
/// A light that the horizon crosses.
pub(super) const PIECES: f32 = 4.0;
/// A lobe that ends with an infinite slope.
pub(super) const EDGE: f32 = 5.0;
/// Microfacets, and a light above the horizon; microfacets, and one that it crosses; microfacets, and light from everywhere.
pub(super) const MICROFACETS: f32 = 6.0;
pub(super) const MICROFACETS_CUT: f32 = 7.0;
pub(super) const MICROFACETS_ALL: f32 = 8.0;
/// Between these three and those of microfacets with a grain.
pub(super) const BRUSHED: f32 = 3.0;

/// The form, and the value where that is done.
#[inline(always)]
pub(super) fn of(light: &Seen, lobe: &PackedLobe) -> [f32; 2] {
    let e = lobe.exponent;
    // Whether the horizon leaves all of it; whether none.
    let above = light.cos_beta >= light.sin;
    let below = light.one_minus_cos <= 0.0 || light.cos_beta <= -light.sin;
    let lambert = lobe.is_lambert(light.normal);
    let wide = e >= slab::EXPONENT && 0.5 * (e + 1.0) * light.one_minus_cos >= slab::WIDTH;
    let chords = if above { WHOLE } else { PIECES };
    let glossy = if wide && above { SLAB } else { chords };
    let glossy = if e < 1.0 || light.one_minus_cos > chord::ENDS { EDGE } else { glossy };
    let glossy = if e >= MIRROR { DONE } else { glossy };
    let diffuse = if above { DONE } else { CROSSED };
    let microfacets = if above { MICROFACETS } else { MICROFACETS_CUT };
    let everywhere = light.one_minus_cos >= 1.0 && light.axis == light.normal;
    let microfacets = if everywhere { MICROFACETS_ALL } else { microfacets };
    let microfacets = if lobe.kind >= PackedLobe::MICROFACETS_GRAIN { microfacets + BRUSHED } else { microfacets };
    let glossy = if lobe.is_microfacets() { microfacets } else { glossy };
    let form = if lambert { diffuse } else { glossy };

    let cos = light.normal.dot(lobe.axis);
    let inside = 0.5 * (lobe.axis - light.axis).length_squared() <= light.one_minus_cos;
    let mirrored = if lobe.kind > PackedLobe::PLAIN { cos } else { 1.0 };
    let mirrored = if inside && cos > 0.0 { mirrored } else { 0.0 };
    let value = if lambert { light.sin_sq * light.cos_beta } else { mirrored };
    let done = form == DONE && !below;
    [if below { DONE } else { form }, if done { value } else { 0.0 }]
}
