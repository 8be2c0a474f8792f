use super::{HALF_ROOT, ROUND};
use core::f32::consts::{LN_2, LOG2_E};
use fearless_simd::{Simd, f32x8, i32x8, prelude::*, u32x8};

/// [`exp`](super::exp) of eight numbers, bit for bit.
#[inline(always)]
pub fn exp_of_eight<S: Simd>(simd: S, x: f32x8<S>) -> f32x8<S> {
    let [zero, most, least] = [0.0, 88.3, -87.3].map(|x| f32x8::splat(simd, x));
    let capped = x.simd_lt(most).select(x, most);
    let y = capped.simd_gt(least).select(capped, least);
    let rounded = y * LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = (y - n * 0.693_359_4) + n * 2.121_944_4e-4;
    let tail = r * (r * (r * (r * 0.001_381_454_5 + 0.008_368_715) + 0.041_668_39) + 0.166_665_2) + 0.499_999_93;
    let power = (rounded.bitcast::<u32x8<S>>() << 23) + 0x3f80_0000;
    let value = (r + 1.0 + r * r * tail) * power.bitcast::<f32x8<S>>();
    x.simd_lt(least).select(zero, value)
}

/// [`ln_1p`](super::ln_1p) of eight numbers, bit for bit.
#[inline(always)]
pub fn ln_1p_of_eight<S: Simd>(simd: S, y: f32x8<S>) -> f32x8<S> {
    let end = f32x8::splat(simd, -1.0);
    let y = y.simd_gt(end).select(y, end);
    let bits = (y + 1.0).bitcast::<i32x8<S>>();
    let k = (bits - HALF_ROOT) >> 23;
    let mantissa = (bits - (k << 23)).bitcast::<f32x8<S>>();
    let f = k.simd_eq(i32x8::splat(simd, 0)).select(y, mantissa - 1.0);
    let s = f / (f + 2.0);
    let z = s * s;
    let series = z * (z * (z * 0.149_360_53 + 0.199_887_64) + 0.333_333_88);
    let two_s = s + s;
    k.to_float::<f32x8<S>>() * LN_2 + (two_s + two_s * series)
}

#[cfg(test)]
mod tests {
    use super::super::{exp, ln_1p};
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// Over all that is finite.
    #[test]
    fn eight_are_as_one() {
        for i in 0..=u32::MAX / (8 * 9973) {
            let x: [f32; 8] = core::array::from_fn(|k| f32::from_bits((8 * i + k as u32).wrapping_mul(9973)));
            let x = x.map(|x| if x.is_finite() { x } else { 0.0 });
            let [exps, logs] = dispatch!(Level::new(), simd => {
                let x = f32x8::simd_from(simd, x);
                [exp_of_eight(simd, x), ln_1p_of_eight(simd, x)].map(<[f32; 8]>::from)
            });
            assert_eq!(exps.map(f32::to_bits), x.map(|x| exp(x).to_bits()), "{x:?}");
            assert_eq!(logs.map(f32::to_bits), x.map(|x| ln_1p(x).to_bits()), "{x:?}");
        }
    }
}
