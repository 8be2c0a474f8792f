// The functions of special.rs, by the same polynomials. No builtin logarithm, power, exponential or inverse tangent: WGSL
// allows them errors that a large exponent turns into per cents.

fn positive(x: f32) -> f32 {
    return max(x, 0.0);
}

fn copy_sign(x: f32, sign: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(x) & 0x7fffffffu) | (bitcast<u32>(sign) & 0x80000000u));
}

// `exp` of special.rs.
fn exp_f32(x: f32) -> f32 {
    let y = clamp(x, -87.3, 88.3);
    let n = round(y * LOG2_E);
    let r = (y - n * 0.6933594) + n * 2.1219444e-4;
    let tail = 0.49999993 + r * (0.1666652 + r * (0.04166839 + r * (0.008368715 + r * 0.0013814545)));
    let power = bitcast<f32>((i32(n) + 127) << 23u);
    return select((1.0 + r + r * r * tail) * power, 0.0, x < -87.3);
}

fn ln_1p(y: f32) -> f32 {
    let above = max(y, -1.0);
    return ln_of(1.0 + above, above);
}

fn ln_of(u: f32, y: f32) -> f32 {
    let bits = bitcast<i32>(u);
    // Bits of the root of a half, where a power of two ends and the next begins.
    let k = (bits - 0x3f3504f3) >> 23u;
    let mantissa = bitcast<f32>(bits - (k << 23u));
    let f = select(mantissa - 1.0, y, k == 0);
    let s = f / (2.0 + f);
    let z = s * s;
    let series = z * (0.33333388 + z * (0.19988764 + z * 0.14936053));
    let two_s = s + s;
    return f32(k) * LN_2 + (two_s + two_s * series);
}

fn sin_of_octant(x: f32) -> f32 {
    let z = x * x;
    return x + x * z * (-0.16666646 + z * (0.008331676 - z * 1.9453444e-4));
}

// Numerator and denominator of erf(√x)/√x.
fn erf_ratio(x: f32) -> vec2f {
    let p = 1.1283788 + x * (0.3224733 + x * (0.06871247 + x * (0.00893201 + x * 3.170042e-4)));
    let q = 1.0
        + x * (0.61910843 + x * (0.16731136 + x * (0.025493767 + x * (0.0022512524 + x * 1.8366365e-5))));
    return vec2f(p, q);
}

fn erf(x: f32) -> f32 {
    let y = clamp(x, -3.937, 3.937);
    let ratio = erf_ratio(y * y);
    return y * (ratio.x / ratio.y);
}

// `atan2` of special.rs: y ≥ 0.
fn atan2_f32(y: f32, x: f32) -> f32 {
    let width = abs(x);
    let a = min(y, width) / max(max(y, width), MIN_POSITIVE);
    let z = a * a;
    let high = 0.10640907 + z * (-0.07504231 + z * (0.042690706 + z * (-0.01606809 + z * 0.0028497443)));
    let octant = a + a * z * (-0.33333073 + z * (0.19992619 + z * (-0.14203638 + z * high)));
    let angle = select(FRAC_PI_2 - octant, octant, y < width);
    return select(angle, PI - angle, x < 0.0);
}

fn gamma_ratio(x: f32) -> f32 {
    let x0 = min(x, 1e18);
    let y = x0 + 2.25;
    let i = 1.0 / (y * y);
    return (x0 + 1.0) * (x0 + 2.0) / ((x0 + 0.5) * (x0 + 1.5)) * (1.0 / sqrt(y))
        * (1.0 + i * (-0.015625 + i * 0.0025634765625));
}

fn cosine_power_arc(n: f32) -> f32 {
    return 1.7724539 * gamma_ratio(0.5 * n);
}
