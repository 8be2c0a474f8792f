// Microfacets that may have a grain, as `BrushedAt` of grain.rs. Those without are as rough along it as across it.

struct MicrofacetsAt {
    normal: vec3f,
    // Across the grain.
    alpha_sq: f32,
    // The eye's direction; above the horizon.
    view: vec3f,
    shadowing: f32,
    // The unit tangent along the grain, and α there.
    tangent: vec3f,
    along: f32,
}

// The bits of a lobe's grain; 0 without one.
fn grain_of(lobe: Lobe) -> u32 {
    return select(0u, bitcast<u32>(lobe.kind) % GRAIN_HALF, lobe.kind >= LOBE_MICROFACETS_GRAIN);
}

// `Grain::alpha`.
fn grain_alpha(grain: u32, across: f32) -> f32 {
    let strength = f32(grain % GRAIN_STEPS) / f32(GRAIN_STEPS - 1u);
    return across + (1.0 - across) * (strength * strength);
}

// `Grain::turn`.
fn grain_turn(grain: u32) -> vec2f { return cos_sin(PI * f32(grain / GRAIN_STEPS) / f32(GRAIN_STEPS)); }

// The kind of a lobe of microfacets that are rougher along a tangent: `Grain::new`.
fn grain_kind(at: Receiver, tangent: vec3f, strength: f32, is_edge: bool) -> f32 {
    let ahead = tangent_toward(at.normal, at.view);
    let place = vec2f(dot(tangent, ahead), dot(tangent, cross(at.normal, ahead)));
    // Both directions of a line are one grain. A tangent of no length lies along the eye's side.
    let line = atan2_f32(abs(place.y), select(place.x, -place.x, place.y < 0.0));
    let angle = select(line, 0.0, all(place == vec2f(0.0)));
    let turn = u32(floor(angle / PI * f32(GRAIN_STEPS) + 0.5)) % GRAIN_STEPS;
    let steps = u32(floor(saturate(strength) * f32(GRAIN_STEPS - 1u) + 0.5));
    let half = select(0u, GRAIN_HALF, is_edge);
    return bitcast<f32>(bitcast<u32>(LOBE_MICROFACETS_GRAIN) + half + turn * GRAIN_STEPS + steps);
}

fn microfacets_of(normal: vec3f, lobe: Lobe) -> MicrofacetsAt {
    let seen = seen_from(normal, lobe.axis);
    let ahead = tangent_toward(normal, lobe.axis);
    let grain = grain_of(lobe);
    let turn = grain_turn(grain);
    let alpha_sq = microfacets_alpha_sq(lobe.exponent);
    let across = sqrt(alpha_sq);
    let along = grain_alpha(grain, across);
    let flat = seen.y * vec2f(along, across) * turn;
    let shadowing = sqrt(dot(flat, flat) + seen.x * seen.x);
    let tangent = ahead * turn.x + cross(normal, ahead) * turn.y;
    return MicrofacetsAt(normal, alpha_sq, normal * seen.x + ahead * seen.y, shadowing, tangent, along);
}

// The same in a right-handed frame of these unit vectors.
fn microfacets_local(world: MicrofacetsAt, x: vec3f, y: vec3f, z: vec3f) -> MicrofacetsAt {
    let normal = vec3f(dot(x, world.normal), dot(y, world.normal), dot(z, world.normal));
    let view = vec3f(dot(x, world.view), dot(y, world.view), dot(z, world.view));
    let tangent = vec3f(dot(x, world.tangent), dot(y, world.tangent), dot(z, world.tangent));
    return MicrofacetsAt(normal, world.alpha_sq, view, world.shadowing, tangent, world.along);
}

fn microfacets_is_edge(lobe: Lobe) -> bool {
    let is_brushed_edge = lobe.kind >= LOBE_MICROFACETS_GRAIN && (bitcast<u32>(lobe.kind) & GRAIN_HALF) != 0u;
    return lobe.kind == LOBE_MICROFACETS_F90 || is_brushed_edge;
}

// The largest α.
fn microfacets_width(lobe: Lobe) -> f32 {
    return grain_alpha(grain_of(lobe), sqrt(microfacets_alpha_sq(lobe.exponent)));
}

// `D·W·(1 − s)` and `D·W·s`.
fn microfacets_both(microfacets: MicrofacetsAt, v: vec3f) -> vec2f {
    let aside = cross(microfacets.normal, microfacets.tangent);
    let alphas = vec2f(microfacets.along, sqrt(microfacets.alpha_sq));
    let h = microfacets.view + v;
    let up = dot(microfacets.normal, h);
    let fine = vec2f(dot(microfacets.tangent, h), dot(aside, h)) / alphas;
    let square = dot(h, h);
    let ratio = square / max(up * up + dot(fine, fine), 1e-30);
    let d = FRAC_1_PI / (alphas.x * alphas.y) * ratio * ratio;
    let light = positive(dot(microfacets.normal, v));
    let rough = vec2f(dot(microfacets.tangent, v), dot(aside, v)) * alphas;
    let shadowed = sqrt(light * light + dot(rough, rough));
    let fifth = schlick(0.5 * sqrt(square));
    let value = d * (0.5 * light / (light * microfacets.shadowing + shadowed * dot(microfacets.normal, microfacets.view)));
    return vec2f(value * (1.0 - fifth), value * fifth);
}
