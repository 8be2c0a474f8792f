use super::{Outline, nearest_of};
use crate::microfacets::seen_from;
use crate::special::{atan2, exp, ln_of};
use crate::{Lobe, Microfacets, Receiver};
use core::f32::consts::{FRAC_1_PI, TAU};
use fearless_simd::{Level, dispatch};
use glam::{Vec2, Vec3};

/// Columns that are evaluated together.
const LANES: usize = 16;

/// Pieces of this part of all rows are taken together.
const SMALL: f32 = 0.04;

/// A lobe that is nowhere on a light more than this part of its largest value adds nothing.
const NOTHING: f32 = 1e-9;

/// Gauss–Legendre rules on [−1, 1] of 2, 4, 8 and 16 nodes: node and weight, the other half mirrored.
const TWO: [(f32, f32); 1] = [(0.577_350_26, 1.0)];
const FOUR: [(f32, f32); 2] = [(0.339_981_05, 0.652_145_15), (0.861_136_3, 0.347_854_85)];
const EIGHT: [(f32, f32); 4] = [
    (0.183_434_64, 0.362_683_78),
    (0.525_532_4, 0.313_706_65),
    (0.796_666_5, 0.222_381_03),
    (0.960_289_84, 0.101_228_54),
];
const SIXTEEN: [(f32, f32); 8] = [
    (0.095_012_51, 0.189_450_61),
    (0.281_603_55, 0.182_603_41),
    (0.458_016_78, 0.169_156_52),
    (0.617_876_24, 0.149_595_99),
    (0.755_404_4, 0.124_628_97),
    (0.865_631_2, 0.095_158_51),
    (0.944_575, 0.062_253_524),
    (0.989_400_9, 0.027_152_46),
];

/// `∫ f(v) dv` over what of a polygon of light is above the receiver's horizon, for a reflectance lobe of flux 1, as
/// [`cap_integral`](crate::cap_integral) over a cone.
///
/// - Lambert: Lambert's own formula, `½ Σ θᵢ n·Γᵢ` over the edges of the clipped polygon (*Photometria*, 1760), where the light is
///   wide enough for it not to cancel;
/// - else: Gauss–Legendre rules over rows and columns of the light's plane, gathered where the lobe, or `1/r³`, has its peak: with
///   `t` in its widths from there, nodes are even in `t/√(1+t²)`.
///
/// # Accuracy
/// Against quadrature in f64 over rectangles, tilted, near and far, above the horizon and through it, relative to what the same
/// light gives along the lobe's axis: see the tests.
///
/// # Cost
/// 100 to 300 evaluations of the lobe, sixteen at a time.
#[must_use]
pub fn outline_integral(at: &Receiver, lobe: &Lobe, light: &Outline) -> f32 {
    light.above(at.normal).map_or(0.0, |above| integral(at.normal, lobe, &above))
}

/// The same over a light that is above the horizon.
pub(crate) fn integral(normal: Vec3, lobe: &Lobe, light: &Outline) -> f32 {
    let is_lambert = lobe.exponent == 1.0 && lobe.factor == 0.0 && lobe.axis == normal;
    let value = if is_lambert {
        lambert(normal, light)
    } else if lobe.is_microfacets() {
        microfacets(normal, lobe, light)
    } else {
        power(normal, lobe, light)
    };
    if value > 0.0 && value.is_finite() { value } else { 0.0 }
}

fn lambert(normal: Vec3, light: &Outline) -> f32 {
    let corners = light.corners();
    let mut sum = 0.0;
    let mut around = 0.0_f32;
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let cross = a.cross(b - *a);
        let size = cross.length();
        let angle = atan2(size, a.dot(b));
        around += angle;
        if size > 0.0 {
            sum += angle * normal.dot(cross) / size;
        }
    }
    if around > 0.6 && light.circle([normal; 2]).is_none() {
        return sum / TAU;
    }
    let frame = light.frame(normal);
    let local = |v: Vec3| Vec3::new(frame[0].dot(v), frame[1].dot(v), light.axis().dot(v));
    let lobe = Cosine { normal: local(normal) };
    let peak = nearest_of(light.on_plane(frame), Vec2::ZERO);
    cubature(light, frame, &Peak { point: peak, width: Vec2::splat((1.0 + peak.length_squared()).sqrt()) }, &lobe)
}

fn power(normal: Vec3, lobe: &Lobe, light: &Outline) -> f32 {
    let frame = light.frame(lobe.axis);
    let local = |v: Vec3| Vec3::new(frame[0].dot(v), frame[1].dot(v), light.axis().dot(v));
    let axis = local(lobe.axis);
    let e = lobe.exponent.min(1e8);
    let place = if axis.z > 1e-3 { axis.truncate() / axis.z } else { axis.truncate().normalize_or_zero() * 1e3 };
    let point = nearest_of(light.on_plane(frame), place);
    let stretch = 1.0 + point.length_squared();
    // How it falls from there: by its own width, or with the slope that it has beside its axis.
    let along = axis.truncate().dot(point) + axis.z;
    let sin_sq = axis.cross(point.extend(1.0)).length_squared() / stretch;
    if !(along > 0.0) || 0.5 * e * ln_of(along * along / stretch, -sin_sq) < NOTHING.ln() {
        return 0.0;
    }
    let slope = e * (axis.truncate() / along.max(1e-3) - point / stretch);
    let narrow = |sigma: f32, slope: f32| 1.5 * sigma / (0.5 * slope.abs() * sigma).max(1.0);
    let sigma = 1.0 / e.max(1e-3).sqrt();
    let width = Vec2::new(narrow(stretch * sigma, slope.x), narrow(stretch.sqrt() * sigma, slope.y));
    let peak = Peak { point, width }.or_foot(light, frame);
    let f = Power { axis, half_exponent: 0.5 * e, normal: local(normal), has_cosine: lobe.factor > 0.0 };
    (e + 1.0) / TAU * cubature(light, frame, &peak, &f)
}

fn microfacets(normal: Vec3, lobe: &Lobe, light: &Outline) -> f32 {
    let shape = Microfacets::new(normal, lobe);
    let (mirror, alpha) = shape.highlight();
    // Rows across the plane of incidence: highlights are longer along it.
    let (cos, sin, forward) = seen_from(normal, lobe.axis);
    let turn = normal * sin + forward * cos;
    let toward = light.axis().dot(mirror);
    let across = if toward > 1e-3 { turn - mirror * (light.axis().dot(turn) / toward) } else { mirror };
    let frame = light.frame(across);
    let local = |v: Vec3| Vec3::new(frame[0].dot(v), frame[1].dot(v), light.axis().dot(v));
    let axis = local(mirror);
    let place = if axis.z > 1e-3 { axis.truncate() / axis.z } else { axis.truncate().normalize_or_zero() * 1e3 };
    let point = nearest_of(light.on_plane(frame), place);
    let stretch = 1.0 + point.length_squared();
    // Their tails are powers of the distance.
    let beside = 0.5 * place.distance(point);
    let width =
        Vec2::new((2.0 * alpha * stretch).max(beside), (2.0 * alpha * cos.max(alpha) * stretch.sqrt()).max(beside));
    let peak = Peak { point, width }.or_foot(light, frame);
    let lobe = Lobe { axis: local(lobe.axis), ..*lobe };
    cubature(light, frame, &peak, &Facets(Microfacets::new(local(normal), &lobe)))
}

/// Where an integrand is largest on the light's plane, and how wide about there.
struct Peak {
    point: Vec2,
    width: Vec2,
}

impl Peak {
    /// Next to the receiver the light's own `1/r³` may be the narrower of the two.
    fn or_foot(self, light: &Outline, frame: [Vec3; 2]) -> Self {
        let foot = nearest_of(light.on_plane(frame), Vec2::ZERO);
        let own = (1.0 + foot.length_squared()).sqrt();
        if self.width.min_element() > own {
            return Self { point: foot, width: Vec2::splat(own) };
        }
        Self { width: self.width.min(Vec2::splat((1.0 + self.point.length_squared()).sqrt())), ..self }
    }
}

/// A reflectance in the direction of a point of the plane at distance 1; `inverse` is one over its squared length.
trait Value {
    fn at(&self, p: Vec3, inverse: f32) -> f32;
}

struct Cosine {
    normal: Vec3,
}

impl Value for Cosine {
    #[inline(always)]
    fn at(&self, p: Vec3, inverse: f32) -> f32 {
        FRAC_1_PI * self.normal.dot(p) * inverse.sqrt()
    }
}

struct Power {
    axis: Vec3,
    half_exponent: f32,
    normal: Vec3,
    has_cosine: bool,
}

impl Value for Power {
    #[inline(always)]
    fn at(&self, p: Vec3, inverse: f32) -> f32 {
        let along = self.axis.dot(p);
        // sin² by the cross product, since 1 − cos² has lost its digits.
        let sin_sq = self.axis.cross(p).length_squared() * inverse;
        let value = exp(self.half_exponent * ln_of(along * along * inverse, -sin_sq));
        let cos = self.normal.dot(p) * inverse.sqrt();
        let factor = if self.has_cosine { cos } else { 1.0 };
        if along > 0.0 { value * factor } else { 0.0 }
    }
}

struct Facets(Microfacets);

impl Value for Facets {
    #[inline(always)]
    fn at(&self, p: Vec3, inverse: f32) -> f32 {
        self.0.value(p * inverse.sqrt())
    }
}

fn cubature<V: Value>(light: &Outline, frame: [Vec3; 2], peak: &Peak, value: &V) -> f32 {
    // Relative to the peak, in its widths.
    let mut corners = [Vec2::ZERO; Outline::ROOM];
    let count = light.corners().len();
    for (corner, p) in corners.iter_mut().zip(light.on_plane(frame)) {
        *corner = (p - peak.point) / peak.width;
    }
    let corners = &corners[..count];
    // Half-planes `a x + b y + c ≥ 0`.
    let mut sides = [[0.0; 3]; Outline::ROOM];
    for (i, side) in sides.iter_mut().enumerate().take(count) {
        let (p, q) = (corners[i], corners[(i + 1) % count]);
        let edge = q - p;
        *side = [-edge.y, edge.x, edge.y * p.x - edge.x * p.y];
    }
    // A circle in widths is an ellipse.
    let circle = light
        .circle(frame)
        .map(|(center, radius)| ((center - peak.point) / peak.width, Vec2::splat(radius) / peak.width));
    let sides = &sides[..count];
    // Rows of a piece between two corners are smooth.
    let mut cuts = [0.0; Outline::ROOM];
    for (cut, corner) in cuts.iter_mut().zip(corners) {
        *cut = corner.y;
    }
    let cuts = &mut cuts[..count];
    cuts.sort_unstable_by(f32::total_cmp);
    let mut round = [cuts[0], cuts[count - 1]];
    if let Some((center, half)) = circle {
        round = [round[0].max(center.y - half.y), round[1].min(center.y + half.y)];
    }
    let is_round = circle.is_some();
    let cuts = if is_round { &round[..] } else { few(cuts, place) };
    let mut sum = 0.0;
    for pair in cuts.windows(2) {
        let (from, to) = (place(pair[0]), place(pair[1]));
        if to - from <= 1e-6 * (pair[1].abs() + 1e-6) {
            continue;
        }
        let rule: &[(f32, f32)] = match to - from {
            _ if is_round => &SIXTEEN,
            length if length < 0.05 => &TWO,
            length if length < 0.4 => &FOUR,
            length if length < 1.0 => &EIGHT,
            _ => &SIXTEEN,
        };
        for (node, weight) in both_halves(rule) {
            // Rows of what is round begin and end like roots.
            let (node, weight) = if is_round {
                let angle = core::f32::consts::FRAC_PI_2 * node;
                let (sin, cos) = angle.sin_cos();
                (sin, weight * core::f32::consts::FRAC_PI_2 * cos)
            } else {
                (node, weight)
            };
            let u = 0.5 * ((from + to) + (to - from) * node);
            let rest = 1.0 / ((1.0 - u) * (1.0 + u)).max(1e-12);
            let y = u * rest.sqrt();
            let weight = 0.5 * (to - from) * weight * rest * rest.sqrt();
            let (mut low, mut high) = (f32::NEG_INFINITY, f32::INFINITY);
            if let Some((center, half)) = circle {
                let rest = (y - center.y) / half.y;
                let reach = half.x * ((1.0 - rest) * (1.0 + rest)).max(0.0).sqrt();
                (low, high) = (center.x - reach, center.x + reach);
            }
            for [a, b, c] in sides {
                let rest = b * y + c;
                if *a > 0.0 {
                    low = low.max(-rest / a);
                } else if *a < 0.0 {
                    high = high.min(-rest / a);
                }
            }
            if low < high && high - low < f32::INFINITY {
                let [low, high] = [place(low), place(high)];
                let y = peak.point.y + peak.width.y * y;
                sum += weight * row([low, high], y, peak, value);
            }
        }
    }
    sum * peak.width.x * peak.width.y
}

/// A place in widths from the peak, as nodes are even in it.
#[inline(always)]
fn place(t: f32) -> f32 {
    t / (1.0 + t * t).sqrt()
}

/// Cuts without those that only divide what is small: the ends of tubes have many corners.
fn few(cuts: &mut [f32], place: impl Fn(f32) -> f32) -> &[f32] {
    let small = SMALL * (place(cuts[cuts.len() - 1]) - place(cuts[0]));
    let mut kept = 1;
    for i in 1..cuts.len() {
        // From the last cut but one to this one.
        if kept >= 2 && place(cuts[i]) - place(cuts[kept - 2]) < small {
            kept -= 1;
        }
        cuts[kept] = cuts[i];
        kept += 1;
    }
    &cuts[..kept]
}

/// The integral along a row, over `dx` in widths.
fn row<V: Value>([low, high]: [f32; 2], y: f32, peak: &Peak, value: &V) -> f32 {
    let [middle, half] = [0.5 * (low + high), 0.5 * (high - low)];
    let rule: &[(f32, f32)] = if high - low < 0.5 {
        &FOUR
    } else if high - low < 1.2 {
        &EIGHT
    } else {
        &SIXTEEN
    };
    let mut nodes = [0.0; LANES];
    let mut weights = [0.0; LANES];
    for (k, (node, weight)) in both_halves(rule).enumerate() {
        (nodes[k], weights[k]) = (node, weight);
    }
    let of = |lane: usize| {
        let u = middle + half * nodes[lane];
        let rest = (1.0 - u) * (1.0 + u);
        let rest = 1.0 / if rest > 1e-12 { rest } else { 1e-12 };
        let root = rest.sqrt();
        let x = peak.point.x + peak.width.x * u * root;
        let inverse = 1.0 / (1.0 + x * x + y * y);
        let angle = inverse * inverse.sqrt();
        weights[lane] * rest * root * angle * value.at(Vec3::new(x, y, 1.0), inverse)
    };
    dispatch!(Level::new(), _simd => {
        let mut terms = [0.0; LANES];
        for (lane, term) in terms.iter_mut().enumerate() {
            *term = of(lane);
        }
        half * terms.into_iter().fold(0.0, |sum, x| sum + x)
    })
}

fn both_halves(rule: &[(f32, f32)]) -> impl Iterator<Item = (f32, f32)> {
    rule.iter().map(|(node, weight)| (-node, *weight)).chain(rule.iter().rev().copied())
}
