// The chords of chord.rs, at any position of the horizon, by one loop over the nodes.

struct Chord {
    // Factor of the sum over the nodes; 0 where lobe and light do not meet.
    weight: f32,
    half_exponent: f32,
    half_m: f32,
    inverse_m_sq: f32,
    tan: f32,
    sin_theta: f32,
    sin_delta: f32,
    cos_delta: f32,
    middle: f32,
    half: f32,
    cosine: f32,
    // The normal along the light's axis, across it away from the lobe, across both as an absolute value.
    normal: vec3f,
    across: f32,
}

struct ChordFrame {
    t: vec3f,
    sin_delta: f32,
    cos_delta: f32,
    tan: f32,
    sin_theta: f32,
    low: f32,
    high: f32,
}

fn chord_frame(pair: Pair, t: vec3f) -> ChordFrame {
    let y = one_minus_cos_delta(pair);
    let cos_delta = 1.0 - y;
    let sin_delta = sqrt(positive(y * (2.0 - y)));
    let sin_theta = sqrt(positive(pair.one_minus_cos * (2.0 - pair.one_minus_cos)));
    let tan = sin_theta / (2.0 - pair.one_minus_cos);
    // 1 − exp(−2κ/e), by its series where that cancels.
    let z = 2.0 * KAPPA / max(pair.exponent, 1e-30);
    var sin_w_sq = z * (1.0 - 0.5 * z * (1.0 - z * 0.33333334));
    if z >= 0.02 {
        sin_w_sq = 1.0 - exp_f32(-z);
    }
    let sin_w = sqrt(sin_w_sq);
    let cos_w = sqrt(positive(1.0 - sin_w_sq));
    // tan ½(±ψ_w − δ): the window's ends.
    let cc = cos_w * cos_delta;
    let ss = sin_w * sin_delta;
    let from_low = sin_w * cos_delta + cos_w * sin_delta;
    let from_high = sin_w * cos_delta - cos_w * sin_delta;
    let below = max(1.0 + (cc - ss), 1e-9);
    let above = max(1.0 + (cc + ss), 1e-9);
    let inverse = 1.0 / max(tan * below * above, MIN_POSITIVE);
    let low = select(-1.0, max(-from_low * above * inverse, -1.0), from_low > 0.0);
    let high = min(from_high * below * inverse, 1.0);
    return ChordFrame(t, sin_delta, cos_delta, tan, sin_theta, low, high);
}

fn chord_normal(frame: ChordFrame, pair: Pair, cut: bool) -> vec3f {
    let along = dot(pair.normal, pair.axis);
    let across = dot(pair.normal, frame.t);
    let height = along * frame.cos_delta + across * frame.sin_delta;
    return vec3f(
        select(height, dot(pair.normal, pair.light), cut),
        across * frame.cos_delta - along * frame.sin_delta,
        abs(dot(pair.normal, cross(pair.axis, frame.t))),
    );
}

fn chord_between(frame: ChordFrame, pair: Pair, low: f32, high: f32, cut: bool) -> Chord {
    let half = positive(0.5 * (high - low));
    let n = pair.exponent + 1.0 + pair.cosine;
    let m = n + 0.5;
    let of_arc = 0.5 * sqrt(TAU / m);
    let normal = chord_normal(frame, pair, cut);
    return Chord(
        half * (2.0 * frame.tan) * of_arc * ((pair.exponent + 1.0) * FRAC_1_TAU),
        0.5 * pair.exponent,
        0.5 * m,
        1.0 / (m * m),
        frame.tan,
        frame.sin_theta,
        frame.sin_delta,
        frame.cos_delta,
        0.5 * (low + high),
        half,
        pair.cosine,
        normal,
        normal.z / (n * of_arc),
    );
}

// The integral by chords: of a light above the horizon, or, `cut`, of one that the horizon may cross, in pieces between
// the points where it meets the rim and the one where it meets the middle of a chord.
fn chords(pair: Pair, cut: bool) -> f32 {
    var t = aside(pair);
    if cut && all(t == vec3f(0.0)) {
        t = orthonormal_basis_u(pair.axis);
    }
    let frame = chord_frame(pair, t);
    if !cut {
        let chord = chord_between(frame, pair, frame.low, frame.high, false);
        let width = chord.half * (2.0 * chord.tan);
        let narrow = 2.0 * chord.half_exponent * width * width < 1.0;
        return chord_sum(chord, select(MANY, FEW, narrow), false);
    }
    let low = frame.low;
    let high = max(low, frame.high);
    let corners = clamp(chord_corners(frame, pair), vec3f(low), vec3f(high));
    let a = min(corners.x, corners.z);
    let b = max(corners.x, corners.z);
    var ends = array<f32, 5>(low, a, clamp(corners.y, a, b), b, high);
    let count = select(PIECE, EDGE, pair.exponent < 1.0 || pair.one_minus_cos > ENDS);
    var sum = 0.0;
    for (var k = 0u; k < 4u; k++) {
        sum += chord_sum(chord_between(frame, pair, ends[k], ends[k + 1u], true), count, true);
    }
    return sum;
}

// Where a light's rim is on the receiver's horizon, and between them where the middle of a chord is.
fn chord_corners(frame: ChordFrame, pair: Pair) -> vec3f {
    let n = chord_normal(frame, pair, true);
    let cosine = 1.0 - pair.one_minus_cos;
    let sine = frame.sin_theta;
    let root = n.z * sqrt(positive((sine - n.x) * (sine + n.x)));
    let scale = 1.0 / max(sine * (n.y * n.y + n.z * n.z), MIN_POSITIVE);
    let length = sqrt(n.x * n.x + n.y * n.y);
    let middle = -copy_sign(n.x, n.x * n.y) / max(frame.tan * (abs(n.y) + length), MIN_POSITIVE);
    return vec3f(
        chord_of_corner((-root - n.x * cosine * n.y) * scale, cosine, sine),
        middle,
        chord_of_corner((root - n.x * cosine * n.y) * scale, cosine, sine),
    );
}

fn chord_of_corner(azimuth: f32, cosine: f32, sine: f32) -> f32 {
    let cos_phi = clamp(azimuth, -1.0, 1.0);
    let across = sine * cos_phi;
    let length = sqrt(cosine * cosine + across * across);
    return cos_phi * (1.0 + cosine) / max(length + cosine, MIN_POSITIVE);
}

struct Node {
    cos_psi: f32,
    cos_normal: f32,
    sin_sq: f32,
    in_plane: f32,
}

fn chord_at(chord: Chord, cos_tau: f32) -> Node {
    let xi = chord.middle + chord.half * cos_tau;
    let t = chord.tan * xi;
    let rest = max((1.0 - t) * (1.0 + t), 1e-6);
    let whole = 1.0 + t * t;
    let inverse = 1.0 / (rest * whole);
    let over_all = inverse * rest;
    let s = (t + t) * over_all;
    let q = rest * over_all;
    let sin_psi = chord.sin_delta * q + chord.cos_delta * s;
    let cos_psi = chord.cos_delta * q - chord.sin_delta * s;
    let tt = chord.tan * t;
    let span = positive((1.0 - xi) * (1.0 + xi)) * ((1.0 - tt) * (1.0 + tt));
    let sine = chord.sin_theta * (inverse * whole);
    let sin_sq = sine * sine * span;
    let in_plane = exp_f32(chord.half_exponent * ln_of(cos_psi * cos_psi, -(sin_psi * sin_psi))) * over_all;
    return Node(cos_psi, chord.normal.x * q + chord.normal.y * s, min(sin_sq, 1.0), in_plane);
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
    // 0, 3, 8, 15.
    let start = select(select(3u, 0u, count == FEW), select(8u, 15u, count == EDGE), count >= PIECE);
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
