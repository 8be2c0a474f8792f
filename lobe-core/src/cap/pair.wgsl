// The pair of pair.rs.

struct Pair {
    axis: vec3f,
    exponent: f32,
    normal: vec3f,
    // 1 where the receiver's cosine multiplies the lobe, else 0.
    cosine: f32,
    light: vec3f,
    one_minus_cos: f32,
}

fn one_minus_cos_delta(pair: Pair) -> f32 {
    let d = pair.axis - pair.light;
    return 0.5 * dot(d, d);
}

// Zero where the two axes are one.
fn aside(pair: Pair) -> vec3f {
    let d = pair.light - pair.axis;
    let across = d - pair.axis * dot(pair.axis, d);
    let square = dot(across, across);
    if square > 1e-30 {
        return across * (1.0 / sqrt(square));
    }
    return vec3f(0.0);
}
