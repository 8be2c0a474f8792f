// Microfacets seen from one direction, as in cap/brushed_facets.rs. Those without a grain are as rough along it as across it.

struct Facets {
    // The eye along and across the grain.
    view: vec2f,
    // Its cosine to the normal.
    cosine: f32,
    // Its direction where slopes are over both α, and both.
    up: f32,
    stretched: vec2f,
    alphas: vec2f,
}

// A half vector of any length: its square, its height, its product with the eye's direction, and its parts along the surface.
struct FacetHalf {
    square: f32,
    up: f32,
    seen: f32,
    flat: vec2f,
}

fn facets_of(at: Receiver, lobe: Lobe) -> Facets {
    let seen = seen_from(at.normal, lobe.axis);
    let grain = grain_of(lobe);
    let turn = grain_turn(grain);
    let fine = sqrt(microfacets_alpha_sq(lobe.exponent));
    let alphas = vec2f(grain_alpha(grain, fine), fine);
    let view = vec2f(seen.y * turn.x, -seen.y * turn.y);
    let flat = alphas * view;
    let length = 1.0 / sqrt(dot(flat, flat) + seen.x * seen.x);
    return Facets(view, seen.x, seen.x * length, flat * length, alphas);
}

fn facets_half(facets: Facets, z: f32, turn: vec2f) -> FacetHalf {
    let flat = sqrt(positive((1.0 - z) * (1.0 + z)));
    let h = vec3f(facets.alphas * (flat * turn + facets.stretched), z + facets.up);
    return FacetHalf(dot(h, h), h.z, dot(facets.view, h.xy) + facets.cosine * h.z, h.xy);
}

// `√(α_t² x² + α_b² y² + z²)`.
fn facets_smith(facets: Facets, v: vec2f, z: f32) -> f32 {
    let rough = facets.alphas * v;
    return sqrt(dot(rough, rough) + z * z);
}

// Both parts at one place between the horizon and the top of the cap, times its weight in the mean.
fn facets_node(facets: Facets, range: f32, turn: vec2f, node: vec2f) -> vec2f {
    let half = facets_half(facets, 1.0 - range * node.x, turn);
    let inverse = 1.0 / max(half.square, 1e-30);
    let twice = 2.0 * half.seen * inverse;
    let light = positive(twice * half.up - facets.cosine);
    let of_view = facets_smith(facets, facets.view, facets.cosine);
    let of_light = facets_smith(facets, twice * half.flat - facets.view, light);
    let masking = light * (facets.cosine + of_view) / (light * of_view + facets.cosine * of_light);
    let fifth = schlick(half.seen * sqrt(inverse));
    let value = masking * node.y * range / (1.0 + facets.up) * (1.0 / f32(ALBEDO_AROUND));
    return vec2f(value * (1.0 - fifth), value * fifth);
}
