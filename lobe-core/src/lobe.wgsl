// The lobe of lobe.rs. An infinite exponent is a delta function, its flux finite.

// 32 bytes.
struct Lobe {
    axis: vec3f,
    exponent: f32,
    flux: vec3f,
    factor: f32,
}

// Factors of lobes of microfacets.
const LOBE_MICROFACETS = 2.0f;
const LOBE_EDGE = 3.0f;

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
    return lobe.exponent == 1.0 && lobe.factor == 0.0 && all(lobe.axis == at.normal);
}
