//! Integrals over the plane of an outline by rows of nodes that are gathered about a peak.

use super::Outline;
use super::on_plane::OnPlane;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use glam::{Vec2, Vec3};

/// Samples that are evaluated together, and that wait to be at most.
const LANES: usize = 16;
const BATCH: usize = 128;

/// The rules of 8 and 16 for what begins and ends like a root, outermost last as above: `sin ½πx` and `½π w cos ½πx`.
const TURNED_EIGHT: [(f32, f32); 4] =
    [(0.284_167_92, 0.546_216_13), (0.734_889_9, 0.334_189_4), (0.949_425_4, 0.109_682_47), (0.998_055_2, 0.009912028)];
const TURNED_SIXTEEN: [(f32, f32); 8] = [
    (0.148_691_86, 0.294_280_2),
    (0.428_057_07, 0.259_225_6),
    (0.658_971_9, 0.199_858_77),
    (0.825_200_86, 0.132_728_68),
    (0.927_094_9, 0.073_378_6),
    (0.977_808_1, 0.031315292),
    (0.996_212_54, 0.008_502_77),
    (0.999_861_4, 0.000710062),
];

/// Pieces of this part of all rows are taken together.
pub(super) const SMALL: f32 = 0.04;

/// Gauss–Legendre rules on [−1, 1] of 2, 4, 6, 8, 12 and 16 nodes: node and weight, the other half mirrored.
pub(super) const TWO: [(f32, f32); 1] = [(0.577_350_26, 1.0)];
pub(super) const FOUR: [(f32, f32); 2] = [(0.339_981_05, 0.652_145_15), (0.861_136_3, 0.347_854_85)];
pub(super) const SIX: [(f32, f32); 3] =
    [(0.238_619_2, 0.467_913_93), (0.661_209_4, 0.360_761_57), (0.932_469_5, 0.171_324_49)];
pub(super) const EIGHT: [(f32, f32); 4] = [
    (0.183_434_64, 0.362_683_78),
    (0.525_532_4, 0.313_706_65),
    (0.796_666_5, 0.222_381_03),
    (0.960_289_84, 0.101_228_54),
];
pub(super) const TWELVE: [(f32, f32); 6] = [
    (0.125_233_41, 0.249_147_05),
    (0.367_831_5, 0.233_492_54),
    (0.587_317_95, 0.203_167_43),
    (0.769_902_67, 0.160_078_33),
    (0.904_117_3, 0.106_939_33),
    (0.981_560_63, 0.047_175_336),
];
pub(super) const SIXTEEN: [(f32, f32); 8] = [
    (0.095_012_51, 0.189_450_6),
    (0.281_603_55, 0.182_603_4),
    (0.458_016_78, 0.169_156_52),
    (0.617_876_24, 0.149_595_99),
    (0.755_404_4, 0.124_628_97),
    (0.865_631_2, 0.095_158_51),
    (0.944_575, 0.062_253_524),
    (0.989_400_9, 0.027_152_46),
];

/// The rules in a row, for WGSL.
pub(super) fn half_rules() -> Vec<(f32, f32)> {
    [TWO.as_slice(), &FOUR, &EIGHT, &SIXTEEN, &TURNED_EIGHT, &TURNED_SIXTEEN].concat()
}

/// Where an integrand is largest on the light's plane, and how wide about there.
#[derive(Clone, Copy)]
pub(super) struct Peak {
    pub(super) point: Vec2,
    pub(super) width: Vec2,
}

/// A reflectance in the direction of a point of the plane at distance 1; `inverse` is one over its squared length.
pub(super) trait Value: Copy {
    fn at(&self, p: Vec3, inverse: f32) -> f32;
}

/// An integrand: a reflectance, and where it is largest.
struct Integrand<V> {
    peak: Peak,
    value: V,
}

/// Samples of rows, to be evaluated side by side.
struct Samples {
    /// Place along the row, height of the row, weight.
    u: [f32; BATCH],
    y: [f32; BATCH],
    weight: [f32; BATCH],
    count: usize,
}

impl Samples {
    /// Takes a row's samples; the sum of those that had no room beside them.
    #[inline(always)]
    fn row<S: Simd>(
        &mut self,
        simd: S,
        [low, high]: [f32; 2],
        y: f32,
        weight: f32,
        integrand: &Integrand<impl Value>,
    ) -> f32 {
        let [middle, half] = [0.5 * (low + high), 0.5 * (high - low)];
        let rule = rule(high - low);
        let full = self.count + 2 * rule.len() > BATCH;
        let sum = if full { self.sum(simd, integrand) } else { 0.0 };
        for (node, part) in both_halves(rule) {
            self.u[self.count] = middle + half * node;
            self.y[self.count] = y;
            self.weight[self.count] = weight * half * part;
            self.count += 1;
        }
        sum
    }

    /// The sum of those that wait.
    #[inline(always)]
    fn sum<S: Simd>(&mut self, simd: S, integrand: &Integrand<impl Value>) -> f32 {
        let mut sums = f32x16::splat(simd, 0.0);
        // In registers, not behind a reference that stores might change.
        let (value, Peak { point, width }) = (integrand.value, integrand.peak);
        let [(u, _), (y, _), (weight, _)] = [&self.u, &self.y, &self.weight].map(|column| column.as_chunks::<LANES>());
        for ((u, y), weight) in u.iter().zip(y).zip(weight).take(self.count.div_ceil(LANES)) {
            let [mut weights, mut values] = [[0.0; LANES]; 2];
            for lane in 0..LANES {
                let rest = (1.0 - u[lane]) * (1.0 + u[lane]);
                let rest = 1.0 / if rest > 1e-12 { rest } else { 1e-12 };
                let root = rest.sqrt();
                let x = point.x + width.x * u[lane] * root;
                let inverse = 1.0 / (1.0 + x * x + y[lane] * y[lane]);
                weights[lane] = weight[lane] * rest * root * (inverse * inverse.sqrt());
                values[lane] = value.at(Vec3::new(x, y[lane], 1.0), inverse);
            }
            sums += f32x16::simd_from(simd, weights) * f32x16::simd_from(simd, values);
        }
        // Lanes behind the last sample weigh nothing from now on.
        self.weight = [0.0; BATCH];
        self.count = 0;
        <[f32; LANES]>::from(sums).into_iter().fold(0.0, |sum, x| sum + x)
    }
}

/// The integral of a reflectance.
pub(super) fn cubature(normal: Vec3, light: &OnPlane<'_>, peak: Peak, value: impl Value) -> f32 {
    let integrand = Integrand { peak, value };
    dispatch!(Level::new(), simd => of_rows(simd, normal, light, &integrand))
}

#[inline(always)]
fn of_rows<S: Simd>(simd: S, normal: Vec3, light: &OnPlane<'_>, integrand: &Integrand<impl Value>) -> f32 {
    let peak = &integrand.peak;
    // Relative to the peak, in its widths.
    let mut corners = [Vec2::ZERO; Outline::ROOM];
    let count = light.corners().len();
    for (corner, p) in corners.iter_mut().zip(light.corners()) {
        *corner = (*p - peak.point) / peak.width;
    }
    let corners = &corners[..count];
    let mut cuts = [0.0; Outline::ROOM];
    for (cut, corner) in cuts.iter_mut().zip(corners) {
        *cut = corner.y;
    }
    let cuts = &mut cuts[..count];
    // Half-planes `a x + b y + c ≥ 0`.
    let mut sides = [[0.0; 3]; Outline::ROOM];
    // A circle in widths is an ellipse, of which the horizon may leave a part.
    if let Some((center, radius)) = light.outline.circle(light.frame) {
        let (center, half) = ((center - peak.point) / peak.width, Vec2::splat(radius) / peak.width);
        let [low, high] = cuts.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], y| [l.min(*y), h.max(*y)]);
        let ends = [low.max(center.y - half.y), high.min(center.y + half.y)];
        let n = light.local(normal);
        let above = n.z + n.x * peak.point.x + n.y * peak.point.y;
        sides[0] = [n.x * peak.width.x, n.y * peak.width.y, above];
        return over_pieces(simd, &ends, &sides[..1], Some((center, half)), integrand);
    }
    for (i, side) in sides.iter_mut().enumerate().take(count) {
        let (p, q) = (corners[i], corners[(i + 1) % count]);
        let edge = q - p;
        *side = [-edge.y, edge.x, edge.y * p.x - edge.x * p.y];
    }
    // Rows of a piece between two corners are smooth.
    cuts.sort_unstable_by(f32::total_cmp);
    over_pieces(simd, few(cuts), &sides[..count], None, integrand)
}

/// Rows between cuts, each as far as half-planes and an ellipse let it.
#[inline(always)]
fn over_pieces<S: Simd>(
    simd: S,
    cuts: &[f32],
    sides: &[[f32; 3]],
    ellipse: Option<(Vec2, Vec2)>,
    integrand: &Integrand<impl Value>,
) -> f32 {
    let peak = &integrand.peak;
    let mut samples = Samples { u: [0.0; BATCH], y: [0.0; BATCH], weight: [0.0; BATCH], count: 0 };
    let mut sum = 0.0;
    for pair in cuts.windows(2) {
        let (from, to) = (place(pair[0]), place(pair[1]));
        if to - from <= 1e-6 * (pair[1].abs() + 1e-6) {
            continue;
        }
        // Rows of what is round begin and end like roots: more of them.
        let is_round = ellipse.is_some();
        let rule = if is_round { turned_rule(to - from) } else { rule(to - from) };
        for (node, weight) in both_halves(rule) {
            let u = 0.5 * ((from + to) + (to - from) * node);
            let rest = 1.0 / ((1.0 - u) * (1.0 + u)).max(1e-12);
            let y = u * rest.sqrt();
            let weight = 0.5 * (to - from) * weight * rest * rest.sqrt();
            let (mut low, mut high) = (f32::NEG_INFINITY, f32::INFINITY);
            if let Some((center, half)) = ellipse {
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
                } else if ellipse.is_some() && rest <= 0.0 {
                    high = low;
                }
            }
            if low < high && high - low < f32::INFINITY {
                let y = peak.point.y + peak.width.y * y;
                sum += samples.row(simd, [place(low), place(high)], y, weight, integrand);
            }
        }
    }
    (sum + samples.sum(simd, integrand)) * peak.width.x * peak.width.y
}

/// A place in widths from the peak, as nodes are even in it.
#[inline(always)]
fn place(t: f32) -> f32 {
    t / (1.0 + t * t).sqrt()
}

/// Cuts without those that only divide what is small: the ends of tubes have many corners.
fn few(cuts: &mut [f32]) -> &[f32] {
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

/// The rule for a length in places.
#[inline(always)]
fn rule(length: f32) -> &'static [(f32, f32)] {
    match length {
        length if length < 0.08 => &TWO,
        length if length < 0.5 => &FOUR,
        length if length < 1.1 => &EIGHT,
        _ => &SIXTEEN,
    }
}

/// The rule for rows of something round.
#[inline(always)]
fn turned_rule(length: f32) -> &'static [(f32, f32)] {
    if length < 0.5 { &TURNED_EIGHT } else { &TURNED_SIXTEEN }
}

pub(super) fn both_halves(rule: &[(f32, f32)]) -> impl Iterator<Item = (f32, f32)> {
    rule.iter().rev().map(|(node, weight)| (-node, *weight)).chain(rule.iter().copied())
}
