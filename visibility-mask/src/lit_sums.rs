//! The sums of [`visible_fraction`](crate::visible_fraction) over a [`LitArea`], in the same units, times areas of the plane.

use crate::visible_fraction::{Peak, Shown, outside_of};
use crate::{LitArea, UnitSquare};
use glam::Vec3;
use lobe_core::special::{exp, ln_1p};
use lobe_core::{BrdfLobe, BrushedAt, Facets, Lobe, Microfacets, Receiver, is_lambert};

/// `∫ w dA` of a lobe, as [`sums`](crate::visible_fraction::sums) weighs it.
pub(crate) fn integral(lit: &LitArea, window: &UnitSquare, at: &Receiver, lobe: &Lobe) -> f32 {
    let normal = window.local(at.normal);
    if is_lambert(at, lobe) {
        let [sum] = lit.integrals(|x, y, _| [lambert(normal, x, y)]);
        return sum;
    }
    let axis = window.local(lobe.axis);
    let half = 0.5 * lobe.exponent;
    let peak = Peak::new(window, lobe);
    // Smooth weights are in units of the largest.
    let (highest, over) =
        if peak.is_smooth { (half * ln_1p(peak.along * peak.along * peak.over - 1.0), peak.over) } else { (0.0, 1.0) };
    let [sum] = lit.integrals(|x, y, _| {
        let inverse = 1.0 / (x * x + y * y + 1.0);
        let along = axis.dot(Vec3::new(x, y, 1.0));
        let value = exp(half * ln_1p(along * along * inverse - 1.0) - highest);
        let root = inverse / over;
        let angle = if along > 0.0 { value * root * root.sqrt() } else { 0.0 };
        [if lobe.has_cosine { angle * normal.dot(Vec3::new(x, y, 1.0)) * root.sqrt() } else { angle }]
    });
    sum
}

/// Of both parts of microfacets, but for `skip`.
pub(crate) fn microfacet_integrals(
    lit: &LitArea,
    window: &UnitSquare,
    at: &Receiver,
    facets: &Microfacets,
    skip: Option<&UnitSquare>,
) -> [f32; 2] {
    let (here, normal) = (Microfacets { view: window.local(facets.view), ..*facets }, window.local(at.normal));
    let outside = outside_of(window, skip);
    match facets.grain {
        None => facet_integrals(lit, here.at(normal), outside),
        Some(grain) => facet_integrals(lit, BrushedAt::new(&here, grain, normal), outside),
    }
}

fn facet_integrals(lit: &LitArea, microfacets: impl Facets, outside: impl Fn(f32, f32) -> bool) -> [f32; 2] {
    lit.integrals(|x, y, _| {
        let inverse = 1.0 / (x * x + y * y + 1.0);
        let root = inverse.sqrt();
        let angle = if outside(x, y) { inverse * root } else { 0.0 };
        microfacets.both(Vec3::new(x * root, y * root, root)).map(|value| value * angle)
    })
}

/// Of a lobe times an image by channel, but for `skip`.
pub(crate) fn image_integrals(
    lit: &LitArea,
    window: &UnitSquare,
    at: &Receiver,
    lobe: &BrdfLobe,
    shown: &Shown<'_>,
    skip: Option<&UnitSquare>,
) -> [f32; 3] {
    let normal = window.local(at.normal);
    let outside = outside_of(window, skip);
    match lobe {
        BrdfLobe::Cosine(lobe) if is_lambert(at, lobe) => {
            shown_integrals(lit, shown, outside, |p, inverse| normal.dot(p) * inverse.sqrt())
        }
        BrdfLobe::Cosine(lobe) => {
            let axis = window.local(lobe.axis);
            shown_integrals(lit, shown, outside, |p, inverse| {
                let along = axis.dot(p);
                let value = exp(0.5 * lobe.exponent * ln_1p(along * along * inverse - 1.0));
                let value = if along > 0.0 { value } else { 0.0 };
                if lobe.has_cosine { value * normal.dot(p) * inverse.sqrt() } else { value }
            })
        }
        BrdfLobe::Microfacets(facets) => {
            let here = Microfacets { view: window.local(facets.view), ..*facets };
            match facets.grain {
                None => {
                    let microfacets = here.at(normal);
                    shown_integrals(lit, shown, outside, |p, inverse| microfacets.value(p * inverse.sqrt()))
                }
                Some(grain) => {
                    let brushed = BrushedAt::new(&here, grain, normal);
                    shown_integrals(lit, shown, outside, |p, inverse| facets.part.of(brushed.both(p * inverse.sqrt())))
                }
            }
        }
    }
}

/// `value(p, 1/p²)` for points p of the plane at distance 1, times the image's texel of the point's own area.
fn shown_integrals(
    lit: &LitArea,
    shown: &Shown<'_>,
    outside: impl Fn(f32, f32) -> bool,
    value: impl Fn(Vec3, f32) -> f32,
) -> [f32; 3] {
    let Shown { image, places } = shown;
    lit.integrals(|x, y, area| {
        let inverse = 1.0 / (x * x + y * y + 1.0);
        let value = value(Vec3::new(x, y, 1.0), inverse) * inverse * inverse.sqrt();
        if !(value > 0.0 && outside(x, y)) {
            return [0.0; 3];
        }
        let (level, place) = (image.level(places.area(area)).round() as usize, places.at(x, y));
        (image.row(level, place.y)[image.column(level, place.x)] * value).to_array()
    })
}

fn lambert(normal: Vec3, x: f32, y: f32) -> f32 {
    let inverse = 1.0 / (x * x + y * y + 1.0);
    normal.dot(Vec3::new(x, y, 1.0)) * inverse * inverse
}
