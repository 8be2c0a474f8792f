// The lobe of packed_lobe.rs, which declares its kinds as well. An infinite exponent is a delta function, its flux finite.

// 32 bytes.
struct Lobe {
    axis: vec3f,
    exponent: f32,
    flux: vec3f,
    kind: f32,
}

// `max(a·v, 0)^exponent` from the chord of the two directions.
fn power(a: vec3f, v: vec3f, exponent: f32) -> f32 {
    let d = a - v;
    let half_chord_sq = 0.5 * dot(d, d);
    if half_chord_sq >= 1.0 {
        return 0.0;
    }
    return exp_f32(min(exponent, MAX_FLOAT) * ln_1p(-half_chord_sq));
}

// Exponent 1 about the normal itself.
fn is_lambert(at: Receiver, lobe: Lobe) -> bool {
    return lobe.exponent == 1.0 && lobe.kind == LOBE_PLAIN && all(lobe.axis == at.normal);
}
