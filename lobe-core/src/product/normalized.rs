//! Products of lobes with a flux, a receiver and perhaps its cosine.

use super::{Peak, high, low_block, product_of_angle};
use crate::lanes::{Columns, WIDTH};
use crate::{Lobe, Lobes, Receiver};
use core::f32::consts::TAU;
use fearless_simd::{Level, dispatch};
use glam::Vec3;

/// Lobes from this exponent on are deltas beside any other: a millionth of a radian wide.
pub(crate) const DELTA: f32 = 1e12;

/// `∫ f·c dv` for two lobes of flux 1; `f`'s receiver cosine is taken at the product's mean direction.
///
/// An infinite exponent is a delta function. A Lambert lobe (exponent 1 about the
/// normal) with a lobe that stands for directions above the horizon is exact: `n·∫v c(v) dv`.
#[must_use]
pub(crate) fn normalized_product(at: &Receiver, f: &Lobe, c: &Lobe) -> f32 {
    if is_lambert(at, f) {
        return of_lambert(at.normal, c.axis, c.exponent);
    }
    let delta = |finite: &Lobe, direction: Vec3| {
        let exponent = finite.exponent.min(DELTA);
        let value = (exponent + 1.0) / TAU * crate::power(finite.axis, direction, exponent);
        if f.has_cosine { value * at.normal.dot(direction).max(0.0) } else { value }
    };
    if c.exponent >= DELTA {
        delta(f, c.axis)
    } else if f.exponent >= DELTA {
        delta(c, f.axis)
    } else {
        let y = 0.5 * (f.axis - c.axis).length_squared();
        let factor = if f.has_cosine { factor::<true> } else { factor::<false> };
        product_of_angle(f.exponent, c.exponent, y) * factor(at.normal, f, c.axis, c.exponent, y)
    }
}

/// `Σ w·∫ f c/(fluxes) dv` over the lobes `c` of a sum, `w` the first channel of their flux: [`normalized_product`] of all of
/// them, added in order. Sixteen side by side.
pub(crate) fn normalized_total(at: &Receiver, f: &Lobe, lobes: Lobes<'_>) -> f32 {
    total_at(Level::new(), at, f, lobes)
}

fn total_at(level: Level, at: &Receiver, f: &Lobe, lobes: Lobes<'_>) -> f32 {
    let one_by_one =
        |sum: f32, lobes: Lobes<'_>| lobes.iter().fold(sum, |sum, c| sum + c.flux.x * normalized_product(at, f, &c));
    // Of one or two lobes a block would be mostly empty.
    if f.exponent >= DELTA || lobes.len() < 3 {
        return one_by_one(0.0, lobes);
    }
    let lambert = is_lambert(at, f);
    let [x, y, z, exponent, weight, ..] = lobes.columns();
    let mut sum = 0.0;
    for start in (0..lobes.len()).step_by(WIDTH) {
        let range = start..lobes.len().min(start + WIDTH);
        let count = range.len();
        if !lambert && exponent[range.clone()].iter().any(|e| *e >= DELTA) {
            sum = one_by_one(sum, lobes.range(range));
            continue;
        }
        let mut columns = [[0.0; WIDTH]; 4];
        for (column, from) in columns.iter_mut().zip([x, y, z, exponent]) {
            column[..count].copy_from_slice(&from[range.clone()]);
        }
        let values = if lambert {
            lambert_block(level, at.normal, &columns)
        } else if f.has_cosine {
            block::<true>(level, at.normal, f, &columns, count)
        } else {
            block::<false>(level, at.normal, f, &columns, count)
        };
        sum = weight[range].iter().zip(values).fold(sum, |sum, (weight, value)| sum + weight * value);
    }
    sum
}

/// `f` with a block of lobes: axes and exponents.
fn block<const COSINE: bool>(level: Level, normal: Vec3, f: &Lobe, columns: &Columns<4>, count: usize) -> [f32; WIDTH] {
    let [x, y, z, exponent] = columns;
    let mut pairs = [[f.exponent; WIDTH], *exponent, [0.0; WIDTH]];
    let (mut factors, mut values) = ([0.0; WIDTH], [0.0; WIDTH]);
    dispatch!(level, _simd => {
        for j in 0..WIDTH {
            let axis = Vec3::new(x[j], y[j], z[j]);
            let d = f.axis - axis;
            let one_minus_cos = 0.5 * d.dot(d);
            pairs[2][j] = one_minus_cos;
            factors[j] = factor::<COSINE>(normal, f, axis, exponent[j], one_minus_cos);
            values[j] = high(f.exponent, exponent[j], one_minus_cos);
        }
    });
    if values[..count].iter().any(|value| *value < 0.0) {
        let low = low_block(level, &pairs);
        for (value, low) in values.iter_mut().zip(low).filter(|(value, _)| **value < 0.0) {
            *value = low;
        }
    }
    for (value, factor) in values.iter_mut().zip(factors) {
        *value *= factor;
    }
    values
}

/// A Lambert lobe with a block of lobes.
fn lambert_block(level: Level, normal: Vec3, columns: &Columns<4>) -> [f32; WIDTH] {
    let [x, y, z, exponent] = columns;
    dispatch!(level, _simd => {
        let mut values = [0.0; WIDTH];
        for j in 0..WIDTH {
            values[j] = of_lambert(normal, Vec3::new(x[j], y[j], z[j]), exponent[j]);
        }
        values
    })
}

/// A Lambert lobe with a lobe of directions above the horizon: the latter's mean vector is (e+1)/(e+2) along its axis.
#[inline(always)]
fn of_lambert(normal: Vec3, axis: Vec3, exponent: f32) -> f32 {
    let mean = 1.0 - 1.0 / (exponent + 2.0);
    let cosine = normal.dot(axis);
    2.0 / TAU * mean * if cosine > 0.0 { cosine } else { 0.0 }
}

/// The factor of a product of lobes of scale 1: the scales of flux 1, and the receiver's cosine in the product's
/// mean direction.
#[inline(always)]
fn factor<const COSINE: bool>(normal: Vec3, f: &Lobe, axis: Vec3, exponent: f32, one_minus_cos: f32) -> f32 {
    let scales = (f.exponent + 1.0) * (1.0 / TAU) * ((exponent + 1.0) * (1.0 / TAU));
    if !COSINE {
        return scales;
    }
    // The mean vector, up to terms of second order in the product's width, is along the peak (Eq. 19): sin(α−t) : sin t
    // are the weights of the two axes in the unit vector at angle t.
    let peak = Peak::new(f.exponent, exponent, one_minus_cos);
    let [s1, s2] = peak.tan.map(|t| t / (1.0 + t * t).sqrt());
    let along = f.axis * s2 + axis * s1;
    let square = along.dot(along);
    // Two lobes about one axis peak there.
    let along = if square > 1e-30 { along * (1.0 / square.sqrt()) } else { axis };
    let cosine = normal.dot(along) * (1.0 - 1.0 / (f.exponent + exponent + 2.0));
    scales * if cosine > 0.0 { cosine } else { 0.0 }
}

/// Whether `f` is the Lambert lobe at this receiver: exponent 1, axis the normal itself.
#[must_use]
pub fn is_lambert(at: &Receiver, f: &Lobe) -> bool {
    f.exponent == 1.0 && !f.has_cosine && f.axis == at.normal
}

#[cfg(test)]
mod tests {
    use super::{normalized_product, total_at};
    use crate::oracle::Random;
    use crate::tests::{levels, receiver};
    use crate::{Lobe, LobeBuffer};
    use glam::Vec3;

    #[test]
    fn a_sum_is_its_lobes_added_in_order() {
        let mut random = Random::new(26);
        let mut buffer = LobeBuffer::default();
        for case in 0..400 {
            let at = receiver(random.axis());
            let axis = if case % 7 == 0 { at.normal } else { random.axis().as_vec3() };
            let e = if case % 7 == 0 { 1.0 } else { random.exponent(1e5) as f32 };
            let f = Lobe { has_cosine: case % 2 == 1, ..Lobe::with_flux(axis, e, Vec3::ONE) };
            let mut out = buffer.writer();
            for k in 0..case % 50 {
                let near = random.axis_near(f.axis.as_dvec3()).as_vec3();
                let e = if k % 29 == 28 { f32::INFINITY } else { random.exponent(1e6) as f32 };
                out.push(Lobe::with_flux(near, e, Vec3::splat(random.uniform() as f32)));
            }
            let sum = |x: f32, c: Lobe| x + c.flux.x * normalized_product(&at, &f, &c);
            let want = buffer.lobes().iter().fold(0.0, sum);
            for level in levels() {
                assert_eq!(total_at(level, &at, &f, buffer.lobes()).to_bits(), want.to_bits(), "{level:?} {f:?}");
            }
        }
    }
}
