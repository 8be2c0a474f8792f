// The slab form of slab.rs.

fn slab(pair: Pair) -> f32 {
    let y = one_minus_cos_delta(pair);
    let e = pair.exponent + pair.cosine;
    let theta = slab_arc(pair.one_minus_cos);
    let delta = slab_arc(y);
    let q = (e + 1.0) * theta * theta;
    let root = sqrt(e + 0.5);
    let radius_sq = q * (1.0 - (0.26353 + 0.06766 * q) / (1.0 + 0.15977 * q + 0.06766 * q * q));
    let sigma_sq = 1.0 + 0.01726 * q / (1.0 - 0.08454 * q + 0.03046 * q * q);
    let radius = sqrt(abs(radius_sq)) * (1.0 + (-0.12769 + 0.00076 * q) / ((1.0 + 0.02368 * q) * e));
    let sigma = sqrt(abs(sigma_sq)) * (1.0 + (0.08199 - 0.48943 * q) / ((1.0 + 3.0 * q) * e));
    let kappa = FRAC_1_SQRT_2 / sigma;
    let r = kappa * radius;
    let d = kappa * root * delta;
    let near = r - d;
    let far = r + d;
    let whole = (1.0 - exp_f32((e + 1.0) * ln_1p(-pair.one_minus_cos))) * ((pair.exponent + 1.0) / (e + 1.0));
    let norm = whole / (2.0 * erf(r));
    let value = erf(far) + erf(near);
    if pair.cosine <= 0.0 {
        return positive(norm * value);
    }
    // With the cosine n·M; the slope of the integral is two Gaussians.
    let slope = FRAC_2_SQRT_PI * (exp_f32(-far * far) - exp_f32(-near * near)) * kappa * root;
    let moment = dot(pair.normal, pair.axis) * value - dot(pair.normal, aside(pair)) * (slope / (pair.exponent + 1.0));
    return positive(norm * moment);
}

fn slab_arc(one_minus_cos: f32) -> f32 {
    let y = 2.0 * one_minus_cos;
    return sqrt(y) * (1.0 + y * (0.0416507 + y * (0.00477875 + y * (0.000521976 + y * 0.000245232))));
}
