use core::f32::consts::{FRAC_PI_2, PI};

/// Irradiance of a sphere light of radiance 1 on a Lambert receiver, at every position of the horizon.
///
/// `E = π s² cos β` above the horizon (`s = sin σ`, σ the light's half-angle, β the angle between normal and centre);
/// through it `E = s²(cos β acos y − x q) + atan(q/x)` with `x = √(1/s²−1)`, `y = −x cot β`, `q = √(1 − (cos β/s)²)`;
/// 0 below. `sin_sq` = s² in [0, 1], clamped.
///
/// Relative error ≤ 1e-5 for every size and position of the light, small lights and slivers above the horizon included
/// (where E is above 1e-14 s³ and above the smallest normal number).
#[inline]
#[must_use]
pub fn sphere_light_irradiance(cos_beta: f32, sin_sq: f32) -> f32 {
    let sin_sq = sin_sq.clamp(0.0, 1.0);
    let s = sin_sq.sqrt();
    if cos_beta >= s {
        PI * sin_sq * cos_beta
    } else if cos_beta <= -s || sin_sq <= 0.0 {
        0.0
    } else {
        through_horizon(cos_beta, sin_sq)
    }
}

/// The middle case: `|cos β| < s`.
///
/// The terms of the closed form are of order s² and their sum of order s³, or `s³(1 + cos β/s)^2.5` where little of the light
/// is left. So the formula is rewritten, by `atan k = k − k³/3 + k⁵g(k²)`:
///
/// - centre below the horizon, `w = q/(cos σ·|cos β|/s) ≤ 1.04`: `E = s²·u·w²q²·{1/3 − g(w²)(1 + w² + u²) + u²(1 + u²)D}` with
///   `u = q/x` and D the divided difference of g between u² and w²: no term is much larger than the sum;
/// - else, `s² ≤ ½`: `E = s² cos β acos y + u(s² − u²(1/3 − u²g(u²)))`;
/// - else, centre above the horizon: the formula as it stands;
/// - else: `atan u` and `−s³ atan(w)·|cos β|/s` share one arc, `E = (1 − s²|cos β|) atan w − atan((w−u)/(1+uw)) − s cos σ q`.
#[inline(always)]
pub(super) fn through_horizon(cos_beta: f32, sin_sq: f32) -> f32 {
    let larger = |x: f32, than: f32| if x > than { x } else { than };
    let smaller = |x: f32, than: f32| if x < than { x } else { than };
    let positive = |x: f32| larger(x, 0.0);
    let s = larger(sin_sq, f32::MIN_POSITIVE).sqrt();
    let inverse = 1.0 / s;
    let cos_sq = positive(1.0 - sin_sq);
    let cos = larger(cos_sq.sqrt(), f32::MIN_POSITIVE);
    let below = cos_beta < 0.0;
    let depth = cos_beta.abs();
    // s² − cos²β to its last digit: products of halves of cos β's digits are exact.
    let upper = f32::from_bits(depth.to_bits() & 0xffff_f000);
    let lower = depth - upper;
    let rest = positive(((sin_sq - upper * upper) - 2.0 * upper * lower) - lower * lower);
    let q = rest.sqrt() * inverse;
    let height = cos * (depth * inverse);
    let sq = s * q;
    let scq = sq * cos;
    let u = sq * (1.0 / cos);
    // acos y = π/2 ± atan k, or π − atan k, k ≤ 1; w or 1/w.
    let steep = q > height;
    let sliver = below && q <= 1.04 * height;
    let (small, great) = if sliver || !steep { (q, height) } else { (height, q) };
    let k = small / larger(great, f32::MIN_POSITIVE);
    // The second arc.
    let large = u > 1.0 || sin_sq > if below { 0.65 } else { 0.5 };
    let m = 1.0 - depth;
    let joint = m * (q * cos) / larger(depth * inverse * cos_sq + sq * q, f32::MIN_POSITIVE);
    let whole = smaller(sq, cos) / larger(sq, cos);
    let second = if large { if below { smaller(joint, 1.0) } else { whole } } else { u };
    let (a, b) = (k * k, if sliver { u * u } else { second * second });
    // g(b), and its divided difference to a.
    let (mut g, mut divided) = (G[10], 0.0);
    for coefficient in [G[9], G[8], G[7], G[6], G[5], G[4], G[3], G[2], G[1], G[0]] {
        divided = divided * a + g;
        g = g * b + coefficient;
    }
    let g_of_a = g + divided * (a - b);
    let in_sliver = (1.0 / 3.0 - g_of_a * (1.0 + a + b)) - b * (1.0 + b) * divided;
    let sliver_value = (sin_sq * u) * (a * (q * q)) * in_sliver;
    let arc = k * (1.0 - a * (1.0 / 3.0 - a * g_of_a));
    let second_loss = b * (1.0 / 3.0 - b * g);
    let second_arc = second * (1.0 - second_loss);
    let lit = if below {
        FRAC_PI_2 - arc
    } else if steep {
        FRAC_PI_2 + arc
    } else {
        PI - arc
    };
    let small_value = sin_sq * (cos_beta * lit) + u * (sin_sq - second_loss);
    let arc_of_u = if sq < cos { second_arc } else { FRAC_PI_2 - second_arc };
    let high_value = sin_sq * (cos_beta * lit) + (arc_of_u - scq);
    let low_value = (cos_sq + sin_sq * m) * lit - second_arc - scq;
    let large_value = if below { low_value } else { high_value };
    let value = if large { large_value } else { small_value };
    positive(if sliver { sliver_value } else { value })
}

/// `g(z)` of `atan k = k − k³/3 + k⁵g(k²)` on [0, 1.1]: relative error 3e-8, of its slope 5e-7.
pub(super) const G: [f32; 11] = [
    0.2,
    -0.142_856_99,
    0.111_105_05,
    -0.090_818_83,
    0.076_219_69,
    -0.063_372_38,
    0.048_759_77,
    -0.031_387_113,
    0.014_962_723,
    -0.004_511_447_6,
    0.000_631_019_7,
];
