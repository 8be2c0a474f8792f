//! Integrals of reflectance lobes over a [`LitArea`].

use crate::visible_fraction::Shown;
use crate::{LitArea, UnitSquare};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};
use lobe_core::special::{exp, ln_1p};
use lobe_core::{BrdfLobe, BrushedAt, Facets, Lobe, Microfacets, Receiver, is_lambert};

/// `∫ f(v) dv` over the lit part for a reflectance lobe of flux 1, as [`light_integral`](lobe_core::light_integral) over all of a light.
pub(crate) fn of_cosine(lit: &LitArea, window: &UnitSquare, at: &Receiver, lobe: &Lobe) -> f32 {
    let (normal, axis) = (window.local(at.normal), window.local(lobe.axis));
    let [sum] = if is_lambert(at, lobe) {
        lit.integrals_about(Focus::FOOT, |x, y, _| [lambert(normal, x, y)])
    } else {
        let value = cosine(normal, axis, lobe);
        lit.integrals_about(Focus::of_cosine(axis, lobe), |x, y, _| {
            let inverse = 1.0 / (x * x + y * y + 1.0);
            [value(Vec3::new(x, y, 1.0), inverse) * inverse * inverse.sqrt()]
        })
    };
    sum * scale(lobe)
}

/// Of both parts of microfacets.
pub(crate) fn of_microfacets(lit: &LitArea, window: &UnitSquare, at: &Receiver, facets: &Microfacets) -> [f32; 2] {
    let (here, normal) = (Microfacets { view: window.local(facets.view), ..*facets }, window.local(at.normal));
    let focus = Focus::of_microfacets(window, at, facets);
    match facets.grain {
        None => facet_integrals(lit, focus, here.at(normal)),
        Some(grain) => facet_integrals(lit, focus, BrushedAt::new(&here, grain, normal)),
    }
}

fn facet_integrals(lit: &LitArea, focus: Focus, microfacets: impl Facets) -> [f32; 2] {
    lit.integrals_about(focus, |x, y, _| {
        let inverse = 1.0 / (x * x + y * y + 1.0);
        let root = inverse.sqrt();
        microfacets.both(Vec3::new(x * root, y * root, root)).map(|value| value * (inverse * root))
    })
}

/// `max(a·v, 0)ᵉ`, times the receiver's cosine where the lobe has it, of points p of the plane at distance 1 and `1/p²`.
fn cosine(normal: Vec3, axis: Vec3, lobe: &Lobe) -> impl Fn(Vec3, f32) -> f32 {
    let (half, has_cosine) = (0.5 * lobe.exponent, lobe.has_cosine);
    move |p, inverse| {
        let along = axis.dot(p);
        let value = exp(half * ln_1p(along * along * inverse - 1.0));
        let value = if along > 0.0 { value } else { 0.0 };
        if has_cosine { value * normal.dot(p) * inverse.sqrt() } else { value }
    }
}

/// The value along the axis of a lobe of flux 1.
fn scale(lobe: &Lobe) -> f32 {
    0.5 * FRAC_1_PI * (lobe.exponent + 1.0)
}

/// Where a lobe varies most on the plane of a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Focus {
    pub(crate) place: Vec2,
    /// Its width there.
    pub(crate) width: f32,
    /// The part of the distance from there in which it falls as much at least.
    pub(crate) slope: f32,
}

/// Highlights that are longer than their width by more than this are integrated as if they were so long.
const NARROWEST_SLOPE: f32 = 0.3;

impl Focus {
    /// The foot of the perpendicular: beside it solid angles and the receiver's cosine fall.
    pub(crate) const FOOT: Self = Self { place: Vec2::ZERO, width: 0.4, slope: 0.4 };

    /// The scale on which it varies at a distance from there.
    pub(crate) fn size(&self, beside: f32) -> f32 {
        self.width.max(self.slope * beside)
    }

    /// The place of a direction in the frame of the window, and a width in radians there.
    fn new(direction: Vec3, width: f32, slope: f32) -> Self {
        let aside = direction.truncate();
        let place = if direction.z > 1e-3 { aside / direction.z } else { aside.normalize_or(Vec2::X) * 1e3 };
        let stretch = (1.0 + place.length_squared()).sqrt();
        Self { place, width: (width * slope).min(1.0) * stretch, slope }
    }

    fn of_cosine(axis: Vec3, lobe: &Lobe) -> Self {
        Self::new(axis, 1.0 / lobe.exponent.max(1.0).sqrt(), 1.0)
    }

    fn of_microfacets(window: &UnitSquare, at: &Receiver, facets: &Microfacets) -> Self {
        let (mirror, alpha) = facets.at(at.normal).highlight();
        // Half vectors that turn aside turn the mirror's direction by less.
        let cos = at.normal.dot(facets.view).clamp(0.0, 1.0);
        let slope = if facets.grain.is_some() { NARROWEST_SLOPE } else { cos.max(NARROWEST_SLOPE) };
        Self::new(window.local(mirror), alpha, 0.5 * slope)
    }
}

/// Of a lobe times an image by channel.
pub(crate) fn of_image(
    lit: &LitArea,
    window: &UnitSquare,
    at: &Receiver,
    lobe: &BrdfLobe,
    shown: &Shown<'_>,
) -> [f32; 3] {
    let normal = window.local(at.normal);
    match lobe {
        BrdfLobe::Cosine(lobe) if is_lambert(at, lobe) => {
            let sums = lit.integrals(shown.times(|p, inverse| normal.dot(p) * inverse.sqrt()));
            sums.map(|sum| sum * scale(lobe))
        }
        BrdfLobe::Cosine(lobe) => {
            let axis = window.local(lobe.axis);
            let sums = lit.integrals_about(Focus::of_cosine(axis, lobe), shown.times(cosine(normal, axis, lobe)));
            sums.map(|sum| sum * scale(lobe))
        }
        BrdfLobe::Microfacets(facets) => {
            let here = Microfacets { view: window.local(facets.view), ..*facets };
            let focus = Focus::of_microfacets(window, at, facets);
            match facets.grain {
                None => {
                    let microfacets = here.at(normal);
                    let value = |p: Vec3, inverse: f32| microfacets.value(p * inverse.sqrt());
                    lit.integrals_about(focus, shown.times(value))
                }
                Some(grain) => {
                    let brushed = BrushedAt::new(&here, grain, normal);
                    let value = |p: Vec3, inverse: f32| facets.part.of(brushed.both(p * inverse.sqrt()));
                    lit.integrals_about(focus, shown.times(value))
                }
            }
        }
    }
}

impl Shown<'_> {
    /// `value(p, 1/p²)` for points p of the plane at distance 1, times the image's texel of the point's own area.
    fn times(&self, value: impl Fn(Vec3, f32) -> f32) -> impl Fn(f32, f32, f32) -> [f32; 3] {
        let Self { image, places } = self;
        move |x, y, area| {
            let inverse = 1.0 / (x * x + y * y + 1.0);
            let value = value(Vec3::new(x, y, 1.0), inverse) * inverse * inverse.sqrt();
            if value.is_nan() || value <= 0.0 {
                return [0.0; 3];
            }
            let (level, place) = (image.level(places.area(area)).round() as usize, places.at(x, y));
            (image.row(level, place.y)[image.column(level, place.x)] * value).to_array()
        }
    }
}

fn lambert(normal: Vec3, x: f32, y: f32) -> f32 {
    let inverse = 1.0 / (x * x + y * y + 1.0);
    normal.dot(Vec3::new(x, y, 1.0)) * inverse * inverse
}
