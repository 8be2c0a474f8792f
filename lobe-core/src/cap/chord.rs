use super::pair::Pair;
use crate::orthonormal_basis;
use crate::special::{ERF_END, erf_ratio, exp, ln_1p, ln_of};
use core::f32::consts::TAU;
use glam::Vec3;

/// Nodes of a whole light above the horizon, and of one that is narrow beside the lobe; of each piece of a disc that the
/// horizon crosses; of pieces for lobes with an edge (exponent < 1).
pub(super) const MANY: usize = 10;
pub(super) const FEW: usize = 6;
pub(super) const PIECE: usize = 14;
pub(super) const EDGE: usize = 32;

/// The lobe's window: it has fallen by `exp(−KAPPA)` at its end.
pub(super) const KAPPA: f32 = 12.0;

/// A light from this `1 − cos θ` on has chords that end as abruptly as pieces do: hardly shorter at the rim.
pub(super) const ENDS: f32 = 0.6;

/// A piece of a light, cut into chords: slices by the planes that contain the cross product of the two axes.
///
/// In the frame (a, t, p), a the lobe's axis and t toward the light: `v = (cos λ cos ψ, cos λ sin ψ, sin λ)`,
/// `dv = cos λ dλ dψ`, `a·v = cos λ cos ψ`; chords are at `tan ½(ψ−δ) = tan ½θ·ξ`, ξ in `middle ± half`. The tangent of half
/// the angle needs no root, and up to a hemisphere of light the integrand stays as smooth in it as it is in the angle.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Chord {
    /// Factor of the sum over the nodes; 0 where lobe and light do not meet.
    pub(super) weight: f32,
    half_exponent: f32,
    /// `m/2`, `m = n + ½`, of the power `n` of `cos λ` along a chord; and `1/m²`.
    half_m: f32,
    inverse_m_sq: f32,
    /// `tan ½θ` and `sin θ`.
    tan: f32,
    sin_theta: f32,
    sin_delta: f32,
    cos_delta: f32,
    middle: f32,
    half: f32,
    /// 1 where the receiver's cosine multiplies the lobe, else 0.
    cosine: f32,
    /// The normal along the light's axis, across it away from the lobe, and across the plane of both as an absolute value.
    normal: [f32; 3],
    /// That component over `n·½√(2π/m)`: the cosine along a chord is integrated in closed form too.
    across: f32,
}

/// The frame of a pair of axes, and what a lobe's window leaves of the light.
struct Frame {
    t: Vec3,
    sin_delta: f32,
    cos_delta: f32,
    tan: f32,
    sin_theta: f32,
    low: f32,
    high: f32,
}

impl Frame {
    #[inline(always)]
    fn new(pair: &Pair, t: Vec3) -> Self {
        let y = pair.one_minus_cos_delta();
        let cos_delta = 1.0 - y;
        let sin_delta = positive(y * (2.0 - y)).sqrt();
        let sin_theta = positive(pair.one_minus_cos * (2.0 - pair.one_minus_cos)).sqrt();
        let tan = sin_theta / (2.0 - pair.one_minus_cos);
        // 1 − exp(−2κ/e), by its series where that cancels.
        let z = 2.0 * KAPPA / pair.exponent;
        let sin_w_sq = if z < 0.02 { z * (1.0 - 0.5 * z * (1.0 - z * (1.0 / 3.0))) } else { 1.0 - exp(-z) };
        let (sin_w, cos_w) = (sin_w_sq.sqrt(), positive(1.0 - sin_w_sq).sqrt());
        // tan ½(±ψ_w − δ): the window's ends. An angle beyond −180° is no limit below, and one at −180° is all above.
        let (cc, ss) = (cos_w * cos_delta, sin_w * sin_delta);
        let (sc, cs) = (sin_w * cos_delta, cos_w * sin_delta);
        let (from, to) = (sc + cs, sc - cs);
        let (below, above) = (larger(1.0 + (cc - ss), 1e-9), larger(1.0 + (cc + ss), 1e-9));
        let inverse = 1.0 / larger(tan * below * above, f32::MIN_POSITIVE);
        let low = if from > 0.0 { larger(-from * above * inverse, -1.0) } else { -1.0 };
        let high = smaller(to * below * inverse, 1.0);
        Self { t, sin_delta, cos_delta, tan, sin_theta, low, high }
    }

    /// The chords between `low` and `high`.
    #[inline(always)]
    fn chord<const CUT: bool>(&self, pair: &Pair, low: f32, high: f32) -> Chord {
        let half = positive(0.5 * (high - low));
        let n = pair.exponent + 1.0 + pair.cosine;
        let m = n + 0.5;
        let of_arc = 0.5 * (TAU / m).sqrt();
        let normal = self.normal::<CUT>(pair);
        Chord {
            weight: half * (2.0 * self.tan) * of_arc * ((pair.exponent + 1.0) * (1.0 / TAU)),
            half_exponent: 0.5 * pair.exponent,
            half_m: 0.5 * m,
            inverse_m_sq: 1.0 / (m * m),
            tan: self.tan,
            sin_theta: self.sin_theta,
            sin_delta: self.sin_delta,
            cos_delta: self.cos_delta,
            middle: 0.5 * (low + high),
            half,
            cosine: pair.cosine,
            normal,
            across: normal[2] / (n * of_arc),
        }
    }

    /// The normal in the light's frame; for a light that the horizon crosses by its own product with the light, on which the
    /// height above the horizon hangs.
    #[inline(always)]
    fn normal<const CUT: bool>(&self, pair: &Pair) -> [f32; 3] {
        let (along, aside) = (pair.normal.dot(pair.axis), pair.normal.dot(self.t));
        let height = along * self.cos_delta + aside * self.sin_delta;
        let height = if CUT { pair.normal.dot(pair.light) } else { height };
        let across = pair.normal.dot(pair.axis.cross(self.t)).abs();
        [height, aside * self.cos_delta - along * self.sin_delta, across]
    }

    /// The two ξ at which the light's rim meets the receiver's horizon, on the rim at the azimuth φ from the plane of both axes:
    /// `n·v = c cos θ + sin θ (n₁ cos φ + n₂ sin φ) = 0`; between them the one at which the middle of a chord meets it,
    /// `c cos x + n₁ sin x = 0`: a horizon along the chords turns from one end of a chord to the other there.
    #[inline(always)]
    fn corners(&self, pair: &Pair) -> [f32; 3] {
        let [c, n1, n2] = self.normal::<true>(pair);
        let cos = 1.0 - pair.one_minus_cos;
        let sin = self.sin_theta;
        let root = n2 * positive((sin - c) * (sin + c)).sqrt();
        let scale = 1.0 / larger(sin * (n1 * n1 + n2 * n2), f32::MIN_POSITIVE);
        let corner = |side: f32| {
            let cos_phi = smaller(larger((side * root - c * cos * n1) * scale, -1.0), 1.0);
            let across = sin * cos_phi;
            let length = (cos * cos + across * across).sqrt();
            cos_phi * (1.0 + cos) / larger(length + cos, f32::MIN_POSITIVE)
        };
        // tan x = −c/n₁; by the half angle, on the side where the light's axis is.
        let length = (c * c + n1 * n1).sqrt();
        let middle = -c.copysign(c * n1) / larger(self.tan * (n1.abs() + length), f32::MIN_POSITIVE);
        [corner(-1.0), middle, corner(1.0)]
    }
}

impl Chord {
    /// All of a light that is above the horizon.
    #[inline(always)]
    pub(super) fn whole(pair: &Pair) -> Self {
        let frame = Frame::new(pair, pair.aside());
        frame.chord::<false>(pair, frame.low, frame.high)
    }

    /// A light that the horizon may cross, cut where the horizon meets its rim, because chords change their kind there.
    pub(super) fn pieces(pair: &Pair) -> impl Iterator<Item = Self> {
        let aside = pair.aside();
        let frame = Frame::new(pair, if aside == Vec3::ZERO { orthonormal_basis(pair.axis).0 } else { aside });
        let (low, high) = (frame.low, larger(frame.low, frame.high));
        let [first, middle, second] = frame.corners(pair).map(|xi| smaller(larger(xi, low), high));
        let (first, second) = (smaller(first, second), larger(first, second));
        let cuts = [low, first, smaller(larger(middle, first), second), second, high];
        let pair = *pair;
        let chords = (0..4).map(move |k| frame.chord::<true>(&pair, cuts[k], cuts[k + 1]));
        chords.filter(|chord| chord.weight > 0.0 && !chord.is_below())
    }

    /// Whether a piece's middle chord is wholly below the horizon: then all of its chords are.
    fn is_below(&self) -> bool {
        let at = self.at::<true>(0.0);
        self.horizon(&at) > at.sin_sq.sqrt()
    }

    /// `sin λ` where a chord goes through the horizon, `A cos λ + B sin λ = 0`.
    #[inline(always)]
    fn horizon(&self, at: &Node) -> f32 {
        let (a, b) = (at.cos_normal, self.normal[2]);
        -a / larger(a * a + b * b, f32::MIN_POSITIVE).sqrt()
    }

    /// Whether so few nodes serve that their number is [`FEW`]: less than one width of the lobe between middle and end
    /// (2e-5 of the on-axis value).
    #[inline(always)]
    pub(super) fn is_narrow(&self) -> bool {
        let width = self.half * (2.0 * self.tan);
        2.0 * self.half_exponent * width * width < 1.0
    }

    /// The integrand at the node τ: above the horizon, or `CUT` by it.
    #[inline(always)]
    pub(super) fn node<const CUT: bool>(&self, cos_tau: f32, weight: f32) -> f32 {
        if CUT { self.cut(cos_tau, weight) } else { self.above(cos_tau, weight) }
    }

    #[inline(always)]
    fn above(&self, cos_tau: f32, weight: f32) -> f32 {
        let at = self.at::<false>(cos_tau);
        let along = 1.0 + self.cosine * (at.cos_normal - 1.0);
        let arc = self.half_arc(self.length(at.sin_sq));
        let value = weight * at.in_plane * (along * (arc + arc));
        if at.cos_psi > 0.0 { value } else { 0.0 }
    }

    /// With the chord cut at the horizon, `A cos λ + B sin λ > 0` (B ≥ 0).
    #[inline(always)]
    fn cut(&self, cos_tau: f32, weight: f32) -> f32 {
        let at = self.at::<true>(cos_tau);
        let sin = at.sin_sq.sqrt();
        let low = larger(smaller(self.horizon(&at), sin), -sin);
        let (high_length, low_length) = (self.length(at.sin_sq), self.length(low * low));
        let arc = self.half_arc(high_length) - self.half_arc(low_length).copysign(low);
        let power = |length: f32| exp(-(self.half_m - 0.25) * length);
        let with_cosine = at.cos_normal * arc + self.across * (power(low_length) - power(high_length));
        let value = weight * at.in_plane * if self.cosine > 0.0 { with_cosine } else { arc };
        if at.cos_psi > 0.0 { value } else { 0.0 }
    }

    #[inline(always)]
    fn at<const CUT: bool>(&self, cos_tau: f32) -> Node {
        let xi = self.middle + self.half * cos_tau;
        let t = self.tan * xi;
        // sin x and cos x of x = ψ − δ by t = tan ½x, with one division for all.
        let all = 1.0 + t * t;
        // Only pieces come near the rim of a hemisphere.
        let rest = if CUT { larger((1.0 - t) * (1.0 + t), 1e-6) } else { 1.0 - t * t };
        let inverse = 1.0 / (rest * all);
        let over_all = inverse * rest;
        let (s, q) = ((t + t) * over_all, rest * over_all);
        let sin_psi = self.sin_delta * q + self.cos_delta * s;
        let cos_psi = self.cos_delta * q - self.sin_delta * s;
        // sin²Λ = (sin²θ − sin²x)/cos²x; by T = tan ½θ it is sin²θ (1 − ξ²)(1 − T²t²)/(1 − t²)², to the last digit at the rim.
        let sin_sq = if CUT {
            let (tt, over_rest) = (self.tan * t, inverse * all);
            let span = positive((1.0 - xi) * (1.0 + xi)) * ((1.0 - tt) * (1.0 + tt));
            let sin = self.sin_theta * over_rest;
            smaller(sin * sin * span, 1.0)
        } else {
            let over_q = inverse * (all * all);
            (self.sin_theta - s) * (self.sin_theta + s) * (over_q * over_q)
        };
        Node {
            cos_psi,
            cos_normal: self.normal[0] * q + self.normal[1] * s,
            sin_sq,
            in_plane: exp(self.half_exponent * ln_of(cos_psi * cos_psi, -(sin_psi * sin_psi))) * over_all,
        }
    }

    /// `L = −ln cos²Λ` of a half chord.
    #[inline(always)]
    fn length(&self, sin_sq: f32) -> f32 {
        -ln_1p(-sin_sq)
    }

    /// `∫₀^Λ cosⁿλ dλ` over `½√(2π/m)`: `erf √x·(1 − κ(x)/m²)`, `x = ½mL`. κ is the next term of the expansion in 1/m, a
    /// function of x alone, as a polynomial over the denominator of erf (relative error 2e-5 for n ≥ 1, 3e-7 from n = 20 on).
    #[inline(always)]
    fn half_arc(&self, length: f32) -> f32 {
        let x = smaller(self.half_m * length, ERF_END);
        let (p, q) = erf_ratio(x);
        let r = x
            * x
            * (0.019_160_35 + x * (-0.002_230_259 + x * (0.000_260_236_4 + x * (-9.882_837e-6 + x * 1.555_687e-7))));
        x.sqrt() * ((p - r * self.inverse_m_sq) / q)
    }
}

/// One chord: where it is, and its plane's part of the integrand.
struct Node {
    cos_psi: f32,
    /// The normal's part along the middle of the chord.
    cos_normal: f32,
    /// Of half the chord.
    sin_sq: f32,
    in_plane: f32,
}

/// The first halves of the four rules in a row, for WGSL; the second ones mirror them.
pub(super) fn half_rules() -> Vec<(f32, f32)> {
    let halves = [
        &nodes::<FEW>()[..FEW / 2],
        &nodes::<MANY>()[..MANY / 2],
        &nodes::<PIECE>()[..PIECE / 2],
        &nodes::<EDGE>()[..EDGE / 2],
    ];
    halves.concat()
}

/// Node and weight at `cos τ`, `τ = kπ/(N+1)`, k = 1…N.
///
/// [`FEW`] and [`MANY`]: the Chebyshev rule of the second kind, `π sin τ/(N+1)`, exact for polynomials times the square root
/// that a whole light's chords have at both ends. Others: Fejér's second rule, `4 sin τ/(N+1)·Σ sin((2j−1)τ)/(2j−1)`, exact for
/// polynomials, because pieces end anywhere.
pub(super) const fn nodes<const N: usize>() -> [(f32, f32); N] {
    let mut out = [(0.0, 0.0); N];
    let count = N as f64 + 1.0;
    let step = core::f64::consts::PI / count;
    let mut k = 0;
    while k < N {
        // Counted from the middle, where the series converge fastest: cos τ = −sin x, sin τ = cos x.
        let x = (k as f64 + 1.0) * step - core::f64::consts::FRAC_PI_2;
        let (mut sin, mut cos, mut term, mut i) = (0.0, 0.0, 1.0, 0);
        while i < 24 {
            let sign = if i % 4 < 2 { 1.0 } else { -1.0 };
            if i % 2 == 0 {
                cos += sign * term;
            } else {
                sin += sign * term;
            }
            i += 1;
            term *= x / i as f64;
        }
        let (cos, sin) = (-sin, cos);
        // Sines of odd multiples by turning twice as far each time.
        let (cos_2, sin_2) = (1.0 - 2.0 * sin * sin, 2.0 * sin * cos);
        let (mut c, mut s, mut sum, mut j) = (cos, sin, 0.0, 0);
        while 2 * j < N + 1 {
            sum += s / (2 * j + 1) as f64;
            (c, s) = (c * cos_2 - s * sin_2, s * cos_2 + c * sin_2);
            j += 1;
        }
        let weight = if N <= MANY { sin * step } else { 4.0 * sin * sum / count };
        out[k] = (cos as f32, weight as f32);
        k += 1;
    }
    out
}

#[inline(always)]
fn positive(x: f32) -> f32 {
    larger(x, 0.0)
}

/// One instruction each, where the standard library's treatment of NaN takes three.
#[inline(always)]
fn larger(x: f32, than: f32) -> f32 {
    if x > than { x } else { than }
}

#[inline(always)]
fn smaller(x: f32, than: f32) -> f32 {
    if x < than { x } else { than }
}

/// Not below zero, whatever rounding has done.
#[inline(always)]
pub(super) fn finish(weight: f32, sum: f32) -> f32 {
    let value = weight * sum;
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{EDGE, FEW, MANY, PIECE, nodes};
    use core::f32::consts::PI;

    #[test]
    fn second_halves_are_first_ones_mirrored() {
        for all in [&nodes::<FEW>()[..], &nodes::<MANY>(), &nodes::<PIECE>(), &nodes::<EDGE>()] {
            for (a, b) in all.iter().zip(all.iter().rev()) {
                assert!((a.0 + b.0).abs() < 1e-7 && (a.1 - b.1).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn nodes_are_those_of_the_rule() {
        for (k, (cos, weight)) in nodes::<10>().into_iter().enumerate() {
            let tau = (k as f32 + 1.0) * PI / 11.0;
            assert!((cos - tau.cos()).abs() < 2e-7 && (weight - tau.sin() * PI / 11.0).abs() < 1e-7);
        }
    }
}
