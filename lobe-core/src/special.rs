//! The few special functions that lobes need, in f32.

/// `Γ(x+½)/Γ(x+1)` for `−¼ ≤ x ≤ 1e18`, relative error < 2e-6; beyond, its value at 1e18.
///
/// Asymptotic in `1/(x+9/4)²` after two steps of the recurrence; never a difference of two `ln Γ`.
#[inline]
#[must_use]
pub fn gamma_ratio(x: f32) -> f32 {
    let x = x.min(1e18);
    let y = x + 2.25;
    let i = 1.0 / (y * y);
    (x + 1.0) * (x + 2.0) / ((x + 0.5) * (x + 1.5)) * y.sqrt().recip() * (1.0 + i * (-1.0 / 64.0 + i * (21.0 / 8192.0)))
}

/// `A(n) = ∫_{−π/2}^{π/2} cosⁿψ dψ = √π Γ((n+1)/2)/Γ(n/2+1)`, `n ≥ 0`.
#[inline]
#[must_use]
pub fn cosine_power_arc(n: f32) -> f32 {
    1.772_453_9 * gamma_ratio(0.5 * n)
}

/// Error function; absolute error < 3e-7 (Abramowitz & Stegun 7.1.28).
#[inline]
#[must_use]
pub fn erf(x: f32) -> f32 {
    let a = x.abs();
    let p = 1.0
        + a * (0.070_523_08
            + a * (0.042_282_01
                + a * (0.009_270_527 + a * (0.000_152_014_3 + a * (0.000_276_567_2 + a * 0.000_043_063_8)))));
    let p = p.min(200.0);
    let p4 = (p * p) * (p * p);
    let p16 = (p4 * p4) * (p4 * p4);
    // Near 0 the complement of a 16th power has lost its digits; the series has not.
    let tail = if a < 0.05 { a * core::f32::consts::FRAC_2_SQRT_PI * (1.0 - a * a / 3.0) } else { 1.0 - p16.recip() };
    tail.copysign(x)
}
