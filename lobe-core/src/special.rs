//! The few special functions that lobes need, in f32.
//!
//! No call into the system's mathematics library and no fused multiply-add: a value is the same on every machine and at
//! every vector width, bit for bit. All of them are total (a finite value for every finite input) and free of branches, so
//! that a loop over them becomes vector instructions.

mod eight;

// For the workspace alone.
#[doc(hidden)]
pub use eight::{exp_of_eight, ln_1p_of_eight};

/// Adding and subtracting it rounds to the nearest integer, which then stands in the lowest bits.
const ROUND: f32 = 12_582_912.0;
/// Bits of √½, where a power of two ends and the next begins.
const HALF_ROOT: i32 = 0x3f35_04f3;

/// `eˣ`; relative error ≤ 2e-7 for `|x| ≤ 1`, growing with `|x|` as the rounding of `x` itself does; 0 below −87.3, the
/// value at 88.3 above.
///
/// `x = n ln 2 + r`, a polynomial of degree 6 in `r`, the power of two by its bits.
#[inline(always)]
#[must_use]
pub fn exp(x: f32) -> f32 {
    let capped = if x < 88.3 { x } else { 88.3 };
    let y = if capped > -87.3 { capped } else { -87.3 };
    let rounded = y * core::f32::consts::LOG2_E + ROUND;
    let n = rounded - ROUND;
    let r = (y - n * 0.693_359_4) + n * 2.121_944_4e-4;
    let tail = 0.499_999_93 + r * (0.166_665_2 + r * (0.041_668_39 + r * (0.008_368_715 + r * 0.001_381_454_5)));
    let power = f32::from_bits((rounded.to_bits() << 23).wrapping_add(0x3f80_0000));
    if x < -87.3 { 0.0 } else { (1.0 + r + r * r * tail) * power }
}

/// `ln(1 + y)`; relative error ≤ 3e-7, also next to 0. −88.03 for `y ≤ −1`, where the logarithm ends.
///
/// `1 + y = 2ᵏ(1 + f)`, then the series of `ln((1+s)/(1−s))` in `s = f/(2 + f)`; for k = 0 `f` is `y` itself, digit by
/// digit.
#[inline(always)]
#[must_use]
pub fn ln_1p(y: f32) -> f32 {
    let y = if y > -1.0 { y } else { -1.0 };
    ln_of(1.0 + y, y)
}

/// `ln u` for `u ≥ 0` by `u` and `y = u − 1`, of which either may have lost its digits where the other is small.
#[inline(always)]
#[must_use]
pub fn ln_of(u: f32, y: f32) -> f32 {
    let bits = u.to_bits() as i32;
    let k = (bits - HALF_ROOT) >> 23;
    let mantissa = f32::from_bits((bits - (k << 23)) as u32);
    let f = if k == 0 { y } else { mantissa - 1.0 };
    let s = f / (2.0 + f);
    let z = s * s;
    let series = z * (0.333_333_88 + z * (0.199_887_64 + z * 0.149_360_53));
    let two_s = s + s;
    k as f32 * core::f32::consts::LN_2 + (two_s + two_s * series)
}

/// `sin x` for `|x| ≤ π/4`; relative error ≤ 1e-7.
#[inline(always)]
pub(crate) fn sin_of_octant(x: f32) -> f32 {
    let z = x * x;
    x + x * z * (-0.166_666_46 + z * (0.008_331_676 - z * 1.945_344_4e-4))
}

/// Numerator and denominator of `erf(√x)/√x`, relative error 3e-7 up to `x =` [`ERF_END`].
#[inline(always)]
pub(crate) fn erf_ratio(x: f32) -> (f32, f32) {
    let p = 1.128_378_8 + x * (0.322_473_3 + x * (0.068_712_47 + x * (0.008_932_01 + x * 3.170_042e-4)));
    let q = 1.0
        + x * (0.619_108_43 + x * (0.167_311_36 + x * (0.025_493_767 + x * (0.002_251_252_4 + x * 1.836_636_5e-5))));
    (p, q)
}

/// From here on `erf(√x)` is 1 to the last bit but one.
pub(crate) const ERF_END: f32 = 15.5;

/// Error function; relative error ≤ 8e-7.
#[inline(always)]
#[must_use]
pub fn erf(x: f32) -> f32 {
    const END: f32 = 3.937;
    let high = if x < END { x } else { END };
    let x = if high > -END { high } else { -END };
    let (p, q) = erf_ratio(x * x);
    x * (p / q)
}

/// Angle of the vector `(x, y)`, `y ≥ 0`, from the x axis, in [0, π]; absolute error ≤ 5e-7. π/2 for the zero vector.
#[inline(always)]
#[must_use]
pub fn atan2(y: f32, x: f32) -> f32 {
    let width = x.abs();
    let (small, large) = if y < width { (y, width) } else { (width, y) };
    let a = small / if large > f32::MIN_POSITIVE { large } else { f32::MIN_POSITIVE };
    let z = a * a;
    let high = 0.106_409_07 + z * (-0.075_042_31 + z * (0.042_690_706 + z * (-0.016_068_09 + z * 0.002_849_744_3)));
    let angle = a + a * z * (-0.333_330_73 + z * (0.199_926_19 + z * (-0.142_036_38 + z * high)));
    let angle = if y < width { angle } else { core::f32::consts::FRAC_PI_2 - angle };
    if x < 0.0 { core::f32::consts::PI - angle } else { angle }
}

/// `Γ(x+½)/Γ(x+1)` for `−¼ ≤ x ≤ 1e18`, relative error < 2e-6; beyond, its value at 1e18.
///
/// Asymptotic in `1/(x+9/4)²` after two steps of the recurrence; never a difference of two `ln Γ`.
#[inline(always)]
#[must_use]
pub fn gamma_ratio(x: f32) -> f32 {
    let x = if x < 1e18 { x } else { 1e18 };
    let y = x + 2.25;
    let i = 1.0 / (y * y);
    (x + 1.0) * (x + 2.0) / ((x + 0.5) * (x + 1.5)) * (1.0 / y.sqrt()) * (1.0 + i * (-1.0 / 64.0 + i * (21.0 / 8192.0)))
}

/// The product of two [`gamma_ratio`]s for one square root and two divisions.
#[inline(always)]
pub(crate) fn gamma_ratios(a: f32, b: f32) -> f32 {
    let limit = |x: f32| if x < 1e18 { x } else { 1e18 };
    let (a, b) = (limit(a), limit(b));
    let (p, q) = (a + 2.25, b + 2.25);
    let inverse = 1.0 / (p * q);
    let (i, j) = (q * inverse, p * inverse);
    let series = |i: f32| 1.0 + i * i * (-1.0 / 64.0 + i * i * (21.0 / 8192.0));
    let steps = |x: f32| ((x + 1.0) * (x + 2.0), (x + 0.5) * (x + 1.5));
    let ((a1, a2), (b1, b2)) = (steps(a), steps(b));
    // Each quotient is at most 1.2; both denominators together would overflow.
    inverse.sqrt() * (series(i) * series(j)) * ((a1 * i * i) * (b1 * j * j) / ((a2 * i * i) * (b2 * j * j)))
}

/// `A(n) = ∫_{−π/2}^{π/2} cosⁿψ dψ = √π Γ((n+1)/2)/Γ(n/2+1)`, `n ≥ 0`.
#[inline(always)]
#[must_use]
pub fn cosine_power_arc(n: f32) -> f32 {
    1.772_453_9 * gamma_ratio(0.5 * n)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest relative error over `n` arguments, against f64.
    fn relative(x: impl Iterator<Item = f32>, f: fn(f32) -> f32, exact: fn(f64) -> f64) -> f64 {
        x.map(|x| (f64::from(f(x)) / exact(f64::from(x)) - 1.0).abs()).fold(0.0, f64::max)
    }

    fn steps(from: f32, to: f32) -> impl Iterator<Item = f32> {
        (0..=400_000).map(move |i| from + (to - from) * (i as f32 / 400_000.0))
    }

    /// `±10^from … ±10^to`.
    fn magnitudes(from: f32, to: f32) -> impl Iterator<Item = f32> {
        steps(from, to).map(|m| 10.0_f32.powf(m))
    }

    #[test]
    fn exponential_as_stated() {
        let near = relative(steps(-1.0, 1.0), exp, f64::exp);
        let all = relative(steps(-87.0, 88.0), exp, f64::exp);
        println!("exp: {near:.1e} up to 1, {all:.1e} up to 88");
        assert!(near < 2e-7 && all < 1e-6);
        assert_eq!((exp(0.0), exp(-1e30), exp(f32::NEG_INFINITY)), (1.0, 0.0, 0.0));
        assert!(exp(1e30).is_finite() && exp(f32::INFINITY) > 1e38);
    }

    #[test]
    fn logarithm_as_stated() {
        let below = relative(magnitudes(-30.0, -1e-5).map(|y| -y), ln_1p, f64::ln_1p);
        let above = relative(magnitudes(-30.0, 20.0), ln_1p, f64::ln_1p);
        println!("ln(1+y): {below:.1e} below 0, {above:.1e} above");
        assert!(below < 3e-7 && above < 3e-7);
        assert_eq!(ln_1p(0.0), 0.0);
        for end in [-1.0, -1.5, -1e30, f32::NEG_INFINITY] {
            assert!((ln_1p(end) + 88.03).abs() < 0.01);
        }
    }

    /// By its series near 0 and its continued fraction beyond 2.
    fn exact_erf(x: f64) -> f64 {
        let scale = core::f64::consts::FRAC_2_SQRT_PI * (-x * x).exp();
        if x < 2.5 {
            let (mut term, mut sum) = (x, x);
            for k in 1..80 {
                term *= 2.0 * x * x / (2.0 * f64::from(k) + 1.0);
                sum += term;
            }
            return scale * sum;
        }
        let fraction = (1..120).rev().fold(x, |f, k| x + 0.5 * f64::from(k) / f);
        1.0 - 0.5 * scale / fraction
    }

    #[test]
    fn error_function_as_stated() {
        let worst = relative(steps(1e-4, 6.0), erf, exact_erf).max(relative(magnitudes(-30.0, 0.0), erf, exact_erf));
        println!("erf: {worst:.1e}");
        assert!(worst < 8e-7);
        assert_eq!((erf(0.0), erf(-0.7)), (0.0, -erf(0.7)));
        assert!((erf(1e30) - 1.0).abs() < 2e-7 && (erf(f32::INFINITY) - 1.0).abs() < 2e-7);
    }

    #[test]
    fn angles_as_stated() {
        let mut worst = 0.0_f64;
        for i in 0..=100_000 {
            let angle = core::f64::consts::PI * f64::from(i) / 100_000.0;
            for length in [1e-15, 1.0, 1e15] {
                let (x, y) = ((length * angle.cos()) as f32, (length * angle.sin().max(0.0)) as f32);
                worst = worst.max((f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x))).abs());
            }
        }
        println!("atan2: {worst:.1e}");
        assert!(worst < 5e-7);
        assert_eq!(atan2(0.0, 0.0), core::f32::consts::FRAC_PI_2);
    }

    #[test]
    fn finite_for_every_bit_pattern_that_is() {
        for i in 0..=u32::MAX / 9973 {
            let x = f32::from_bits(i.wrapping_mul(9973));
            if x.is_finite() {
                for value in [exp(x), ln_1p(x), erf(x), atan2(x.abs(), 1.0 - x), gamma_ratio(x.abs())] {
                    assert!(value.is_finite(), "{x}: {value}");
                }
            }
        }
    }
}
