// The light above the horizon of cap/mod.rs, and the closed Lambert integral of lambert.rs.

struct Seen {
    axis: vec3f,
    one_minus_cos: f32,
    cos_beta: f32,
    sin_sq: f32,
    above: bool,
    below: bool,
}

fn seen_light(at: Receiver, cone: Cone) -> Seen {
    // Inside the light: everything above the horizon.
    let inside = cone.one_minus_cos > 1.0;
    let axis = select(cone.axis, at.normal, inside);
    let one_minus_cos = select(cone.one_minus_cos, 1.0, inside);
    let sin_sq = one_minus_cos * (2.0 - one_minus_cos);
    let sine = sqrt(sin_sq);
    let cos_beta = dot(at.normal, axis);
    let below = one_minus_cos <= 0.0 || cos_beta <= -sine;
    return Seen(axis, one_minus_cos, cos_beta, sin_sq, cos_beta >= sine, below);
}

fn through_horizon(cos_beta: f32, sin_sq: f32) -> f32 {
    let sin_beta = sqrt(positive((1.0 - cos_beta) * (1.0 + cos_beta)));
    let x = sqrt((1.0 - sin_sq) / max(sin_sq, MIN_POSITIVE));
    // y·sin β and q by products, so that nothing is lost as y → ±1.
    let y_sin = -x * cos_beta;
    let q = sqrt(positive((sin_beta - y_sin) * (sin_beta + y_sin)));
    return positive(sin_sq * (cos_beta * atan2_f32(q, y_sin) - x * q) + atan2_f32(q, x));
}

// For a light that is not below.
fn lambert_integral(light: Seen) -> f32 {
    if light.above {
        return light.sin_sq * light.cos_beta;
    }
    return through_horizon(light.cos_beta, light.sin_sq) * FRAC_1_PI;
}
