// The chords of chord.rs, at any position of the horizon, by one loop over the nodes.

const FEW = 6u;
const MANY = 10u;
const PIECE = 16u;
const EDGE = 32u;
const KAPPA = 9.0f;

// The first halves of the four rules; the second have the opposite sign.
const NODES = array<vec2f, 32>(
    vec2f(0.90096885, 0.19472657),
    vec2f(0.6234898, 0.35088515),
    vec2f(0.22252093, 0.4375466),
    vec2f(0.959493, 0.08046263),
    vec2f(0.8412535, 0.15440665),
    vec2f(0.65486073, 0.21584158),
    vec2f(0.41541502, 0.2597903),
    vec2f(0.14231484, 0.28269234),
    vec2f(0.9829731, 0.033956833),
    vec2f(0.9324722, 0.06675731),
    vec2f(0.85021716, 0.097284436),
    vec2f(0.7390089, 0.124498665),
    vec2f(0.6026346, 0.14747325),
    vec2f(0.44573835, 0.16542579),
    vec2f(0.27366298, 0.17774497),
    vec2f(0.09226836, 0.18401125),
    vec2f(0.9954719, 0.009049314),
    vec2f(0.9819287, 0.018016675),
    vec2f(0.959493, 0.026820878),
    vec2f(0.9283679, 0.03538218),
    vec2f(0.88883543, 0.043623064),
    vec2f(0.8412535, 0.051468886),
    vec2f(0.7860531, 0.058848597),
    vec2f(0.723734, 0.06569537),
    vec2f(0.65486073, 0.071947195),
    vec2f(0.5800569, 0.077547446),
    vec2f(0.5, 0.08244543),
    vec2f(0.41541502, 0.086596765),
    vec2f(0.32706797, 0.08996387),
    vec2f(0.23575893, 0.09251624),
    vec2f(0.14231484, 0.09423078),
    vec2f(0.047581915, 0.09509195),
);

struct Chord {
    // What multiplies the sum over the nodes; 0 where lobe and light do not meet.
    weight: f32,
    half_exponent: f32,
    half_m: f32,
    inverse_m_sq: f32,
    sin_theta: f32,
    sin_delta: f32,
    cos_delta: f32,
    middle: f32,
    half: f32,
    cosine: f32,
    normal: vec3f,
    across: f32,
}

struct ChordFrame {
    t: vec3f,
    sin_delta: f32,
    cos_delta: f32,
    sin_theta: f32,
    low: f32,
    high: f32,
}

fn chord_frame(pair: Pair, t: vec3f) -> ChordFrame {
    let y = one_minus_cos_delta(pair);
    let cos_delta = 1.0 - y;
    let sin_delta = sqrt(positive(y * (2.0 - y)));
    let sin_theta = sqrt(positive(pair.one_minus_cos * (2.0 - pair.one_minus_cos)));
    // 1 − exp(−2κ/e), by its series where that cancels.
    let z = 2.0 * KAPPA / max(pair.exponent, 1e-30);
    var sin_w_sq = z * (1.0 - 0.5 * z * (1.0 - z * 0.33333334));
    if z >= 0.02 {
        sin_w_sq = 1.0 - exp_f32(-z);
    }
    let sin_w = sqrt(sin_w_sq);
    let cos_w = sqrt(positive(1.0 - sin_w_sq));
    // sin(±ψ_w − δ), unless that angle is beyond 90°.
    let inverse = 1.0 / sin_theta;
    let cc = cos_w * cos_delta;
    let ss = sin_w * sin_delta;
    let sc = sin_w * cos_delta;
    let cs = cos_w * sin_delta;
    let low = select(-1.0, max((-sc - cs) * inverse, -1.0), cc > ss);
    let beyond = select(1.0, -1.0, cos_delta < 0.0);
    let high = select(beyond, min((sc - cs) * inverse, 1.0), cc + ss > 0.0);
    return ChordFrame(t, sin_delta, cos_delta, sin_theta, low, high);
}

fn chord_between(frame: ChordFrame, pair: Pair, low: f32, high: f32) -> Chord {
    let half = positive(0.5 * (high - low));
    let n = pair.exponent + 1.0 + pair.cosine;
    let m = n + 0.5;
    let of_arc = 0.5 * sqrt(TAU / m);
    let across = abs(dot(pair.normal, cross(pair.axis, frame.t)));
    return Chord(
        half * frame.sin_theta * of_arc * ((pair.exponent + 1.0) * FRAC_1_TAU),
        0.5 * pair.exponent,
        0.5 * m,
        1.0 / (m * m),
        frame.sin_theta,
        frame.sin_delta,
        frame.cos_delta,
        0.5 * (low + high),
        half,
        pair.cosine,
        vec3f(dot(pair.normal, pair.axis), dot(pair.normal, frame.t), across),
        across / (n * of_arc),
    );
}

// The integral by chords: of a light above the horizon, or, `cut`, of one that the horizon may cross, in pieces between
// the points where it meets the rim.
fn chords(pair: Pair, cut: bool) -> f32 {
    var t = aside(pair);
    if cut && all(t == vec3f(0.0)) {
        t = orthonormal_basis_u(pair.axis);
    }
    let frame = chord_frame(pair, t);
    if !cut {
        let chord = chord_between(frame, pair, frame.low, frame.high);
        let width = chord.half * chord.sin_theta;
        let narrow = 2.0 * chord.half_exponent * width * width < 1.0;
        return chord_sum(chord, select(MANY, FEW, narrow), false);
    }
    let low = frame.low;
    let high = max(low, frame.high);
    let rim = rim_at_horizon(pair);
    let to_light = pair.axis * -frame.sin_delta + frame.t * frame.cos_delta;
    let first = chord_of_corner(rim.foot + rim.across, to_light, pair.light, frame.sin_theta);
    let second = chord_of_corner(rim.foot - rim.across, to_light, pair.light, frame.sin_theta);
    let a = select(high, min(max(first, low), high), rim.crosses);
    let b = select(high, min(max(second, low), high), rim.crosses);
    let ends = vec4f(low, min(a, b), max(a, b), high);
    let count = select(PIECE, EDGE, pair.exponent < 1.0);
    var sum = 0.0;
    for (var k = 0u; k < 3u; k++) {
        sum += chord_sum(chord_between(frame, pair, ends[k], ends[k + 1u]), count, true);
    }
    return sum;
}

fn chord_of_corner(corner: vec3f, to_light: vec3f, light: vec3f, sin_theta: f32) -> f32 {
    let across = dot(corner, to_light);
    let along = dot(corner, light);
    return across / max(sin_theta * sqrt(across * across + along * along), MIN_POSITIVE);
}

struct Rim {
    foot: vec3f,
    across: vec3f,
    crosses: bool,
}

// The directions foot ± across, in which a light's rim is on the receiver's horizon.
fn rim_at_horizon(pair: Pair) -> Rim {
    let c = dot(pair.normal, pair.light);
    let sin_beta_sq = (1.0 - c) * (1.0 + c);
    let cosine = 1.0 - pair.one_minus_cos;
    let rest = sin_beta_sq - cosine * cosine;
    if rest <= 0.0 || sin_beta_sq <= 0.0 {
        return Rim(vec3f(0.0), vec3f(0.0), false);
    }
    let foot = (pair.light - pair.normal * c) * (cosine / sin_beta_sq);
    return Rim(foot, cross(pair.light, pair.normal) * (sqrt(rest) / sin_beta_sq), true);
}

struct Node {
    cos_psi: f32,
    cos_normal: f32,
    sin_sq: f32,
    in_plane: f32,
}

fn chord_at(chord: Chord, cos_tau: f32) -> Node {
    let xi = chord.middle + chord.half * cos_tau;
    let s = chord.sin_theta * xi;
    let q_sq = max((1.0 - s) * (1.0 + s), 1e-12);
    let q = sqrt(q_sq);
    let inverse = 1.0 / q_sq;
    let sin_psi = chord.sin_delta * q + chord.cos_delta * s;
    let cos_psi = chord.cos_delta * q - chord.sin_delta * s;
    let sin_sq = chord.sin_theta * chord.sin_theta * positive((1.0 - xi) * (1.0 + xi)) * inverse;
    let in_plane = exp_f32(chord.half_exponent * ln_1p(-(sin_psi * sin_psi))) * (q * inverse);
    return Node(cos_psi, chord.normal.x * cos_psi + chord.normal.y * sin_psi, min(sin_sq, 1.0), in_plane);
}

// `sin λ` where a chord goes through the horizon.
fn chord_horizon(chord: Chord, cos_normal: f32) -> f32 {
    let b = chord.normal.z;
    return -cos_normal / sqrt(max(cos_normal * cos_normal + b * b, MIN_POSITIVE));
}

// `∫₀^Λ cosⁿλ dλ` over ½√(2π/m), of L = −ln cos²Λ.
fn half_arc(chord: Chord, length: f32) -> f32 {
    let x = min(chord.half_m * length, ERF_END);
    let pq = erf_ratio(x);
    let r = x
        * x
        * (0.01916035 + x * (-0.002230259 + x * (0.0002602364 + x * (-9.882837e-6 + x * 1.555687e-7))));
    return sqrt(x) * ((pq.x - r * chord.inverse_m_sq) / pq.y);
}

fn chord_sum(chord: Chord, count: u32, cut: bool) -> f32 {
    if chord.weight <= 0.0 {
        return 0.0;
    }
    if cut {
        // A piece whose middle chord is wholly below the horizon is below it.
        let at = chord_at(chord, 0.0);
        if chord_horizon(chord, at.cos_normal) > sqrt(at.sin_sq) {
            return 0.0;
        }
    }
    var nodes = NODES;
    // 0, 3, 8, 16.
    let start = select(select(3u, 0u, count == FEW), count / 2u, count >= PIECE);
    var sum = 0.0;
    for (var k = 0u; k < count; k++) {
        let mirrored = count - 1u - k;
        let node = nodes[start + min(k, mirrored)];
        let at = chord_at(chord, select(node.x, -node.x, k > mirrored));
        let high_length = -ln_1p(-at.sin_sq);
        let high_arc = half_arc(chord, high_length);
        var value = 0.0;
        if cut {
            let sine = sqrt(at.sin_sq);
            let low = clamp(chord_horizon(chord, at.cos_normal), -sine, sine);
            let low_length = -ln_1p(-(low * low));
            let arc = high_arc - copy_sign(half_arc(chord, low_length), low);
            value = arc;
            if chord.cosine > 0.0 {
                let steep = -(chord.half_m - 0.25);
                value = at.cos_normal * arc
                    + chord.across * (exp_f32(steep * low_length) - exp_f32(steep * high_length));
            }
        } else {
            value = (1.0 + chord.cosine * (at.cos_normal - 1.0)) * (high_arc + high_arc);
        }
        sum += select(0.0, node.y * at.in_plane * value, at.cos_psi > 0.0);
    }
    return positive(chord.weight * sum);
}
