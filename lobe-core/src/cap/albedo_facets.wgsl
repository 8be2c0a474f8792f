// Microfacets seen from one direction, as in cap/albedo.rs.

struct Facets {
    alpha_sq: f32,
    // The eye's sine and cosine to the normal.
    sine: f32,
    cosine: f32,
    // The eye's direction where slopes are over α.
    across: f32,
    up: f32,
}

// A half vector of any length: its square, its height, and its product with the eye's direction.
struct FacetHalf {
    square: f32,
    up: f32,
    seen: f32,
}

fn facets_of(at: Receiver, lobe: Lobe) -> Facets {
    let seen = seen_from(at.normal, lobe.axis);
    let alpha_sq = microfacets_alpha_sq(lobe.exponent);
    let length = 1.0 / sqrt(alpha_sq * seen.y * seen.y + seen.x * seen.x);
    return Facets(alpha_sq, seen.y, seen.x, sqrt(alpha_sq) * seen.y * length, seen.x * length);
}

fn facets_half(facets: Facets, z: f32, turn: vec2f) -> FacetHalf {
    let flat = sqrt(positive((1.0 - z) * (1.0 + z)));
    let alpha = sqrt(facets.alpha_sq);
    let h = vec3f(alpha * (flat * turn.x + facets.across), alpha * flat * turn.y, z + facets.up);
    return FacetHalf(dot(h, h), h.z, facets.sine * h.x + facets.cosine * h.z);
}

// Both parts at one place between the horizon and the top of the cap, times its weight in the mean.
fn facets_node(facets: Facets, range: f32, turn: vec2f, node: vec2f) -> vec2f {
    let half = facets_half(facets, 1.0 - range * node.x, turn);
    let inverse = 1.0 / max(half.square, 1e-30);
    let light = positive(2.0 * half.seen * half.up * inverse - facets.cosine);
    let of_view = sqrt(facets.cosine * facets.cosine * (1.0 - facets.alpha_sq) + facets.alpha_sq);
    let of_light = sqrt(light * light * (1.0 - facets.alpha_sq) + facets.alpha_sq);
    let masking = light * (facets.cosine + of_view) / (light * of_view + facets.cosine * of_light);
    let fifth = schlick(half.seen * sqrt(inverse));
    let value = masking * node.y * range / (1.0 + facets.up) * (1.0 / f32(ALBEDO_AROUND));
    return vec2f(value * (1.0 - fifth), value * fifth);
}
