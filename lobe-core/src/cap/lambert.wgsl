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
    let s = sqrt(max(sin_sq, MIN_POSITIVE));
    let inverse = 1.0 / s;
    let cos_sq = positive(1.0 - sin_sq);
    let cos = max(sqrt(cos_sq), MIN_POSITIVE);
    let below = cos_beta < 0.0;
    let depth = abs(cos_beta);
    // s² − cos²β to its last digit: products of halves of cos β's digits are exact.
    let upper = bitcast<f32>(bitcast<u32>(depth) & 0xfffff000u);
    let lower = depth - upper;
    let rest = positive(((sin_sq - upper * upper) - 2.0 * upper * lower) - lower * lower);
    let q = sqrt(rest) * inverse;
    let height = cos * (depth * inverse);
    let sq = s * q;
    let scq = sq * cos;
    let u = sq * (1.0 / cos);
    let steep = q > height;
    let sliver = below && q <= 1.04 * height;
    let across = steep && !sliver;
    let k = select(q, height, across) / max(select(height, q, across), MIN_POSITIVE);
    let large = u > 1.0 || sin_sq > select(0.5, 0.65, below);
    let m = 1.0 - depth;
    let joint = m * (q * cos) / max(depth * inverse * cos_sq + sq * q, MIN_POSITIVE);
    let whole = min(sq, cos) / max(sq, cos);
    let second = select(u, select(whole, min(joint, 1.0), below), large);
    let a = k * k;
    let b = select(second * second, u * u, sliver);
    var arcs = ARC;
    var g = arcs[10];
    var divided = 0.0;
    for (var n = 9; n >= 0; n--) {
        divided = divided * a + g;
        g = g * b + arcs[n];
    }
    let g_of_a = g + divided * (a - b);
    if sliver {
        let value = (1.0 / 3.0 - g_of_a * (1.0 + a + b)) - b * (1.0 + b) * divided;
        return positive((sin_sq * u) * (a * (q * q)) * value);
    }
    let arc = k * (1.0 - a * (1.0 / 3.0 - a * g_of_a));
    let second_loss = b * (1.0 / 3.0 - b * g);
    let second_arc = second * (1.0 - second_loss);
    let lit = select(select(PI - arc, FRAC_PI_2 + arc, steep), FRAC_PI_2 - arc, below);
    if !large {
        return positive(sin_sq * (cos_beta * lit) + u * (sin_sq - second_loss));
    }
    if below {
        return positive((cos_sq + sin_sq * m) * lit - second_arc - scq);
    }
    let arc_of_u = select(FRAC_PI_2 - second_arc, second_arc, sq < cos);
    return positive(sin_sq * (cos_beta * lit) + (arc_of_u - scq));
}

// For a light that is not below.
fn lambert_integral(light: Seen) -> f32 {
    if light.above {
        return light.sin_sq * light.cos_beta;
    }
    return through_horizon(light.cos_beta, light.sin_sq) * FRAC_1_PI;
}
