// Lambert's lobes and others.

struct Weights {
    by_row: bool,
    is_lambert: bool,
    lambert: LambertWeights,
    glossy: GlossyWeights,
}

fn weights_of(mask: Mask, window: UnitSquare, at: Receiver, lobe: Lobe) -> Weights {
    var weights: Weights;
    weights.is_lambert = is_lambert(at, lobe);
    if (weights.is_lambert) {
        weights.lambert = lambert_of(window, at);
        weights.by_row = weights.lambert.by_row;
    } else {
        weights.glossy = glossy_of(mask, window, at, lobe);
        weights.by_row = weights.glossy.by_row;
    }
    return weights;
}

fn weights_columns(weights: Weights, x: vec4f) -> mat3x4f {
    if (weights.is_lambert) {
        return lambert_columns(x);
    }
    return glossy_columns(weights.glossy, x);
}

fn weights_row(weights: Weights, y: f32) -> vec3f {
    if (weights.is_lambert) {
        return lambert_row(weights.lambert, y);
    }
    return glossy_row(weights.glossy, y);
}

fn weights_samples(weights: Weights, x: vec4f, y: f32) -> vec4f {
    if (weights.is_lambert) {
        return lambert_samples(weights.lambert, x, y);
    }
    return glossy_samples(weights.glossy, x, y);
}
