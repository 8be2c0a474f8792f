//! The visible fraction of a reflectance lobe through a mask, summed over its samples.

use crate::counts::{COARSE, Counts, FINE, middles};
use crate::lanes::{NUMBERS, sum};
use crate::row::{EIGHT, SIDE, WIDTH};
use crate::{Mask, UnitSquare};
use core::ops::{Add, Mul};
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use glam::{Vec2, Vec3};
use lobe_core::special::{exp, ln_1p};
use lobe_core::{BrdfLobe, BrushedAt, Facets, LightImage, Lobe, Microfacets, Places, Receiver, is_lambert};

/// The largest neglected third and fourth order of a weight's logarithm.
pub(crate) const LEFT_OUT: f32 = 0.004;
/// The largest `tan⁴θ/2` for which a Lambert lobe's weights are a product of one by row and one by column.
pub(crate) const CORNER: f32 = 2e-4;
/// The largest exponent, unless a lobe is wider than a cell even with a larger one: a mirror still needs some samples.
pub(crate) const MIRROR: f32 = 1e6;

/// `Σ w` over the lit samples of a mask and over the emitting ones; `w` is the lobe's value times the solid angle of a sample
/// (times the receiver's cosine if the lobe has it).
///
/// The plane's point `p = (x, y, 1)` has `w = (a·p)ᵉ |p|⁻⁽ᵉ⁺³⁾ dA`, times `n·p/|p|` for the cosine; a Lambert lobe `n·p |p|⁻⁴ dA`.
/// In a small window the logarithm of `w` is a polynomial of second order around its peak. The weights are then one by row times
/// one by column and a low polynomial, and the sum over a row is three products of a vector. Otherwise each weight is computed. The
/// unit is that of `window`: the same for all masks that are parts of it.
pub(crate) fn sums(mask: &Mask, window: &UnitSquare, at: &Receiver, lobe: &Lobe, counts: &mut Counts) -> Sums {
    sums_at(Level::new(), mask, window, at, lobe, counts)
}

fn sums_at(level: Level, mask: &Mask, window: &UnitSquare, at: &Receiver, lobe: &Lobe, counts: &mut Counts) -> Sums {
    dispatch!(level, simd => {
        if mask.width() == WIDTH {
            counts.fill::<FINE>(mask);
            of_counts::<_, FINE>(simd, mask, window, counts, at, lobe)
        } else {
            counts.fill::<COARSE>(mask);
            of_counts::<_, COARSE>(simd, mask, window, counts, at, lobe)
        }
    })
}

#[inline(always)]
fn of_counts<S: Simd, const B: usize>(
    simd: S,
    mask: &Mask,
    window: &UnitSquare,
    counts: &Counts,
    at: &Receiver,
    lobe: &Lobe,
) -> Sums {
    if is_lambert(at, lobe) {
        lambert::<S, B>(simd, mask, window, counts, mask.square().local(at.normal))
    } else {
        glossy::<S, B>(simd, mask, window, counts, at, lobe)
    }
}

/// The sums of [`sums`] for both parts of [`Microfacets`], in steradians of samples. Samples in `skip`, a part of the mask along
/// its cells, do not count.
pub(crate) fn microfacet_sums(
    mask: &Mask,
    at: &Receiver,
    facets: &Microfacets,
    skip: Option<&UnitSquare>,
    counts: &mut Counts,
) -> [Sums; 2] {
    let square = mask.square();
    let (here, normal) = (Microfacets { view: square.local(facets.view), ..*facets }, square.local(at.normal));
    match facets.grain {
        None => facet_sums(mask, here.at(normal), skip, counts),
        Some(grain) => facet_sums(mask, BrushedAt::new(&here, grain, normal), skip, counts),
    }
}

#[inline(always)]
fn facet_sums(mask: &Mask, microfacets: impl Facets, skip: Option<&UnitSquare>, counts: &mut Counts) -> [Sums; 2] {
    let outside = outside(mask, skip);
    let weight = |x: f32, y: f32| {
        let inverse = 1.0 / (x * x + y * y + 1.0);
        let root = inverse.sqrt();
        let [base, edge] = microfacets.both(Vec3::new(x * root, y * root, root));
        let angle = inverse * root;
        let angle = if outside(x, y) { angle } else { 0.0 };
        [base * angle, edge * angle]
    };
    dispatch!(Level::new(), simd => {
        if mask.width() == WIDTH {
            counts.fill::<FINE>(mask);
            by_sample::<_, FINE, 2>(simd, mask, counts, weight)
        } else {
            counts.fill::<COARSE>(mask);
            by_sample::<_, COARSE, 2>(simd, mask, counts, weight)
        }
    })
    .map(|sums| sums * mask.sample_area())
}

/// The sums of [`sums`] by channel for a light that shows an image, in steradians of samples. Samples in `skip`, a part of the mask
/// along its cells, do not count.
pub(crate) fn image_sums(
    mask: &Mask,
    at: &Receiver,
    lobe: &BrdfLobe,
    shown: &Shown<'_>,
    skip: Option<&UnitSquare>,
    counts: &mut Counts,
) -> [Sums; 3] {
    let square = mask.square();
    let normal = square.local(at.normal);
    let sums = match lobe {
        BrdfLobe::Cosine(lobe) if is_lambert(at, lobe) => {
            shown_sums(mask, shown, skip, counts, |p, inverse| normal.dot(p) * inverse.sqrt())
        }
        BrdfLobe::Cosine(lobe) => {
            let axis = square.local(lobe.axis);
            let half = 0.5 * lobe.exponent;
            let cosine = lobe.has_cosine;
            shown_sums(mask, shown, skip, counts, |p, inverse| {
                let along = axis.dot(p);
                let value = exp(half * ln_1p(along * along * inverse - 1.0));
                let value = if along > 0.0 { value } else { 0.0 };
                if cosine { value * normal.dot(p) * inverse.sqrt() } else { value }
            })
        }
        BrdfLobe::Microfacets(facets) => {
            let here = Microfacets { view: square.local(facets.view), ..*facets };
            match facets.grain {
                None => {
                    let microfacets = here.at(normal);
                    shown_sums(mask, shown, skip, counts, |p, inverse| microfacets.value(p * inverse.sqrt()))
                }
                Some(grain) => {
                    let brushed = BrushedAt::new(&here, grain, normal);
                    let value = |p: Vec3, inverse: f32| facets.part.of(brushed.both(p * inverse.sqrt()));
                    shown_sums(mask, shown, skip, counts, value)
                }
            }
        }
    };
    sums.map(|sums| sums * mask.sample_area())
}

/// The image that a mask's light shows, and its place in the mask's plane.
pub(crate) struct Shown<'a> {
    pub(crate) image: &'a LightImage,
    pub(crate) places: Places,
}

/// `value(p, 1/p²)` for points p of the plane at distance 1, times the image.
#[inline(always)]
fn shown_sums(
    mask: &Mask,
    shown: &Shown<'_>,
    skip: Option<&UnitSquare>,
    counts: &mut Counts,
    value: impl Fn(Vec3, f32) -> f32,
) -> [Sums; 3] {
    let outside = outside(mask, skip);
    let weight = |x: f32, y: f32| {
        let inverse = 1.0 / (x * x + y * y + 1.0);
        let value = value(Vec3::new(x, y, 1.0), inverse) * inverse * inverse.sqrt();
        if (value > 0.0) & outside(x, y) { value } else { 0.0 }
    };
    dispatch!(Level::new(), simd => {
        if mask.width() == WIDTH {
            counts.fill::<FINE>(mask);
            by_texel::<_, FINE>(simd, mask, counts, shown, weight)
        } else {
            counts.fill::<COARSE>(mask);
            by_texel::<_, COARSE>(simd, mask, counts, shown, weight)
        }
    })
}

/// `weight(x, y)` times the texel there, for each column of each row. Rows run along the image's rows, and texels are about as
/// large as cells: each texel is the mean of its surroundings.
#[inline(always)]
fn by_texel<S: Simd, const B: usize>(
    simd: S,
    mask: &Mask,
    counts: &Counts,
    shown: &Shown<'_>,
    weight: impl Fn(f32, f32) -> f32,
) -> [Sums; 3] {
    let x = middles::<B>(mask);
    let Vec2 { x: width, y: height } = 2.0 * mask.square().half;
    let cell = width * height / (B * EIGHT * mask.side()) as f32;
    let level = shown.image.level(shown.places.area(cell)).round() as usize;
    let columns = x.map(|x| x.map(|x| shown.image.column(level, shown.places.at(x, mask.row_y(0)).x)));
    let none = f32x8::splat(simd, 0.0);
    let (mut lit, mut all) = ([none; 3], [none; 3]);
    for (j, (open, emitting)) in counts.rows::<B>(mask).enumerate() {
        let (from, to) = mask.emitting(j);
        if from >= to {
            continue;
        }
        let y = mask.row_y(j);
        let texels = shown.image.row(level, shown.places.at(0.0, y).y);
        for block in 0..B {
            let mut values = [0.0; EIGHT];
            for (value, x) in values.iter_mut().zip(&x[block]) {
                *value = weight(*x, y);
            }
            let mut weights = [[0.0; EIGHT]; 3];
            for k in 0..EIGHT {
                let texel = texels[columns[block][k]] * values[k];
                weights[0][k] = texel.x;
                weights[1][k] = texel.y;
                weights[2][k] = texel.z;
            }
            for k in 0..3 {
                let weight = f32x8::simd_from(simd, weights[k]);
                lit[k] += f32x8::simd_from(simd, open[block]) * weight;
                all[k] += f32x8::simd_from(simd, emitting[block]) * weight;
            }
        }
    }
    core::array::from_fn(|k| Sums { lit: sum(lit[k]), all: sum(all[k]) })
}

/// Whether a point of a mask is outside a window.
fn outside(mask: &Mask, skip: Option<&UnitSquare>) -> impl Fn(f32, f32) -> bool + use<> {
    let turn = skip.map_or(Vec2::X, |skip| skip.turn_to(mask.square()));
    let none = [Vec2::splat(f32::INFINITY), Vec2::splat(f32::NEG_INFINITY)];
    let [low, high] = skip.map_or(none, |skip| [skip.center - skip.half, skip.center + skip.half]);
    move |x, y| {
        let Vec2 { x, y } = turn.rotate(Vec2::new(x, y));
        !((x > low.x) & (x < high.x) & (y > low.y) & (y < high.y))
    }
}

/// The exponent of lobes as narrow as the cells: a mirror still needs some samples.
pub(crate) fn narrowest(mask: &Mask) -> f32 {
    (2.0 / mask.cell().max_element().powi(2)).max(MIRROR)
}

/// The lit part of a lobe's light, and all of it, in some unit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    pub(crate) lit: f32,
    pub(crate) all: f32,
}

impl Add for Sums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { lit: self.lit + other.lit, all: self.all + other.all }
    }
}

impl Mul<f32> for Sums {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        Self { lit: self.lit * factor, all: self.all * factor }
    }
}

impl Sums {
    /// Only the lit part.
    pub(crate) fn lit(self) -> Self {
        Self { all: 0.0, ..self }
    }

    /// Only the whole.
    pub(crate) fn emitting(self) -> Self {
        Self { lit: 0.0, ..self }
    }

    /// The visible fraction. If all weights vanish, since the whole light is far outside the lobe, every sample of the masks counts
    /// alike: the fraction is then the lit part `share` of the area.
    pub(crate) fn ratio(self, share: impl FnOnce() -> f32) -> f32 {
        let fraction = self.lit / self.all;
        if self.all > 0.0 && fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { share() }
    }
}

#[inline(always)]
fn lambert<S: Simd, const B: usize>(simd: S, mask: &Mask, window: &UnitSquare, counts: &Counts, normal: Vec3) -> Sums {
    let corner = window.center.abs() + window.half;
    let far = corner.length_squared();
    if far * far > 8.0 * CORNER {
        let [sums] = by_sample::<S, B, 1>(simd, mask, counts, |x, y| {
            let inverse = 1.0 / (x * x + y * y + 1.0);
            [(normal.x * x + (normal.y * y + normal.z)) * inverse * inverse]
        });
        return sums;
    }
    let weight = |x: f32| {
        let inverse = 1.0 / (x * x + 1.0);
        inverse * inverse
    };
    let columns = by_column::<B>(mask, 0.0, weight);
    by_row::<S, B, _>(simd, mask, counts, &columns, &LambertRows { normal })
}

struct LambertRows {
    normal: Vec3,
}

impl Rows for LambertRows {
    const THIRD: bool = false;

    #[inline(always)]
    fn factors<S: Simd>(&self, simd: S, y: f32x8<S>) -> [f32x8<S>; 3] {
        let inverse = f32x8::splat(simd, 1.0) / (y * y + 1.0);
        let w = inverse * inverse;
        [w * (y * self.normal.y + self.normal.z), w * self.normal.x, f32x8::splat(simd, 0.0)]
    }
}

#[inline(always)]
fn glossy<S: Simd, const B: usize>(
    simd: S,
    mask: &Mask,
    window: &UnitSquare,
    counts: &Counts,
    at: &Receiver,
    lobe: &Lobe,
) -> Sums {
    let cosine = lobe.has_cosine;
    let e = lobe.exponent;
    let m = e + 3.0;
    let Peak { place: c, along: d, over, is_smooth } = Peak::new(window, lobe);
    // The mask may be turned.
    let square = mask.square();
    let (axis, normal) = (square.local(lobe.axis), square.local(at.normal));
    let (aside, c) = (axis.truncate(), square.turn_to(window).rotate(c));
    if !is_smooth {
        let [sums] = by_sample::<S, B, 1>(simd, mask, counts, |x, y| {
            let inverse = 1.0 / (x * x + y * y + 1.0);
            let along = axis.x * x + (axis.y * y + axis.z);
            let value = exp(0.5 * e * ln_1p(along * along * inverse - 1.0));
            let value = if along > 0.0 { value } else { 0.0 };
            let angle = value * inverse * inverse.sqrt();
            [if cosine { angle * (normal.x * x + (normal.y * y + normal.z)) * inverse.sqrt() } else { angle }]
        });
        return sums;
    }
    // ln w at c: gradient g, second derivatives h; the cosine's own factor 1/|p| counts too.
    let m = if cosine { m + 1.0 } else { m };
    let of_d = 1.0 / d;
    let g = aside * (e * of_d) - c * (m * over);
    let h = |i: usize, k: usize| {
        let same = if i == k { m * over } else { 0.0 };
        2.0 * m * over * over * c[i] * c[k] - e * of_d * of_d * aside[i] * aside[k] - same
    };
    let (hxx, hyy, hxy) = (h(0, 0), h(1, 1), h(0, 1));
    let columns = by_column::<B>(mask, c.x, |dx| exp((g.x + 0.5 * hxx * dx) * dx));
    let normal = if cosine { normal } else { Vec3::Z };
    let rows = GlossyRows { peak: c, gradient: g.y, hyy, hxy, normal };
    by_row::<S, B, _>(simd, mask, counts, &columns, &rows)
}

/// The peak of a lobe's weights in a window: the point of the light nearest to the lobe's axis.
struct Peak {
    place: Vec2,
    /// The scalar product of the lobe's axis and the point `p`, and `1/p²`.
    along: f32,
    over: f32,
    /// Whether the logarithm of weights, in units of the peak's, is of second order.
    is_smooth: bool,
}

impl Peak {
    fn new(window: &UnitSquare, lobe: &Lobe) -> Self {
        let axis = window.local(lobe.axis);
        let e = lobe.exponent;
        let m = e + 3.0;
        let aside = axis.truncate();
        let peak = if axis.z > 1e-3 { aside / axis.z } else { aside.normalize_or_zero() * 1e3 };
        let c = peak.clamp_length_max(window.disc);
        let c = c.clamp(window.center - window.half, window.center + window.half);
        let d = aside.dot(c) + axis.z;
        let over = 1.0 / (1.0 + c.length_squared());
        let slope = aside.length() / d;
        let reach = window.half.max_element().min(2.0 / m.sqrt());
        let third = e * (slope * reach).powi(3) / 3.0 + m * (c.length() + 0.25 * reach) * reach.powi(3);
        let is_smooth = d > 0.0 && slope * window.half.max_element() < 0.5 && third < LEFT_OUT;
        Self { place: c, along: d, over, is_smooth }
    }
}

struct GlossyRows {
    peak: Vec2,
    gradient: f32,
    hyy: f32,
    hxy: f32,
    normal: Vec3,
}

impl Rows for GlossyRows {
    const THIRD: bool = true;

    #[inline(always)]
    fn factors<S: Simd>(&self, simd: S, y: f32x8<S>) -> [f32x8<S>; 3] {
        let dy = y - self.peak.y;
        let mut w: [f32; EIGHT] = ((dy * (0.5 * self.hyy) + self.gradient) * dy).into();
        for w in &mut w {
            *w = exp(*w);
        }
        let w = f32x8::simd_from(simd, w);
        // exp(h_xy dx dy) by its series, times n·p.
        let t = dy * self.hxy;
        let n = y * self.normal.y + (self.normal.x * self.peak.x + self.normal.z);
        [w * n, w * (n * t + self.normal.x), w * (n * t * 0.5 + self.normal.x) * t]
    }
}

/// The factors of the three sums of a row. A trait instead of a closure: a closure may not be inlined into the code that has the
/// wide instructions.
trait Rows {
    /// Whether there is a third factor.
    const THIRD: bool;
    /// The factors of eight rows, at their heights.
    fn factors<S: Simd>(&self, simd: S, y: f32x8<S>) -> [f32x8<S>; 3];
}

/// Weights by column: `u`, `u·dx`, `u·dx²`, with `dx` measured from `origin`.
#[inline(always)]
fn by_column<const B: usize>(mask: &Mask, origin: f32, weight: impl Fn(f32) -> f32) -> [[[f32; EIGHT]; B]; 3] {
    let x = middles::<B>(mask);
    let mut weights = [[[0.0; EIGHT]; B]; 3];
    for block in 0..B {
        for k in 0..EIGHT {
            let dx = x[block][k] - origin;
            let u = weight(dx);
            weights[0][block][k] = u;
            weights[1][block][k] = u * dx;
            weights[2][block][k] = u * dx * dx;
        }
    }
    weights
}

#[inline(always)]
fn by_row<S: Simd, const B: usize, R: Rows>(
    simd: S,
    mask: &Mask,
    counts: &Counts,
    columns: &[[[f32; EIGHT]; B]; 3],
    rows: &R,
) -> Sums {
    let side = mask.side();
    let mut factors = [[0.0; SIDE]; 3];
    let mut y = f32x8::simd_from(simd, NUMBERS) * mask.cell().y + mask.row_y(0);
    for first in (0..side).step_by(EIGHT) {
        for (column, factor) in factors.iter_mut().zip(rows.factors(simd, y)) {
            factor.store_slice(&mut column[first..first + EIGHT]);
        }
        y += f32x8::splat(simd, EIGHT as f32 * mask.cell().y);
    }
    let [u, v, w] = columns;
    let (mut lit, mut all) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 0.0));
    for (j, (open, emitting)) in counts.rows::<B>(mask).enumerate() {
        let p = f32x8::splat(simd, factors[0][j]);
        let q = f32x8::splat(simd, factors[1][j]);
        let r = f32x8::splat(simd, factors[2][j]);
        for block in 0..B {
            let mut weight = p * f32x8::simd_from(simd, u[block]) + q * f32x8::simd_from(simd, v[block]);
            if R::THIRD {
                weight += r * f32x8::simd_from(simd, w[block]);
            }
            lit += f32x8::simd_from(simd, open[block]) * weight;
            all += f32x8::simd_from(simd, emitting[block]) * weight;
        }
    }
    Sums { lit: sum(lit), all: sum(all) }
}

/// `weight(x, y)`, one or several, for each column of each row.
#[inline(always)]
fn by_sample<S: Simd, const B: usize, const N: usize>(
    simd: S,
    mask: &Mask,
    counts: &Counts,
    weight: impl Fn(f32, f32) -> [f32; N],
) -> [Sums; N] {
    let x = middles::<B>(mask);
    let none = f32x8::splat(simd, 0.0);
    let (mut lit, mut all) = ([none; N], [none; N]);
    for (j, (open, emitting)) in counts.rows::<B>(mask).enumerate() {
        let (from, to) = mask.emitting(j);
        if from >= to {
            continue;
        }
        let y = mask.row_y(j);
        let mut weights = [[[0.0; EIGHT]; N]; B];
        for (weights, x) in weights.iter_mut().zip(&x) {
            for (k, x) in x.iter().enumerate() {
                for (column, w) in weights.iter_mut().zip(weight(*x, y)) {
                    // A partly emitting column is sampled at its centre, which may be below the horizon.
                    column[k] = if w > 0.0 { w } else { 0.0 };
                }
            }
        }
        for block in 0..B {
            for k in 0..N {
                let weight = f32x8::simd_from(simd, weights[block][k]);
                lit[k] += f32x8::simd_from(simd, open[block]) * weight;
                all[k] += f32x8::simd_from(simd, emitting[block]) * weight;
            }
        }
    }
    core::array::from_fn(|k| Sums { lit: sum(lit[k]), all: sum(all[k]) })
}

#[cfg(test)]
#[path = "visible_fraction_tests.rs"]
mod tests;
