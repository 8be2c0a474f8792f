// Microfacets that are as rough along all directions, as `MicrofacetsAt` of microfacets.rs.

struct MicrofacetsAt {
    normal: vec3f,
    alpha_sq: f32,
    // The eye's direction; above the horizon.
    view: vec3f,
    shadowing: f32,
}

fn microfacets_of(normal: vec3f, lobe: Lobe) -> MicrofacetsAt {
    let seen = seen_from(normal, lobe.axis);
    let alpha_sq = microfacets_alpha_sq(lobe.exponent);
    let shadowing = sqrt(seen.x * seen.x * (1.0 - alpha_sq) + alpha_sq);
    return MicrofacetsAt(normal, alpha_sq, normal * seen.x + tangent_toward(normal, lobe.axis) * seen.y, shadowing);
}

// The same in a frame of these unit vectors.
fn microfacets_local(world: MicrofacetsAt, x: vec3f, y: vec3f, z: vec3f) -> MicrofacetsAt {
    let normal = vec3f(dot(x, world.normal), dot(y, world.normal), dot(z, world.normal));
    let view = vec3f(dot(x, world.view), dot(y, world.view), dot(z, world.view));
    return MicrofacetsAt(normal, world.alpha_sq, view, world.shadowing);
}

fn microfacets_is_edge(lobe: Lobe) -> bool { return lobe.kind == LOBE_MICROFACETS_F90; }

// The largest α.
fn microfacets_width(lobe: Lobe) -> f32 { return sqrt(microfacets_alpha_sq(lobe.exponent)); }

// `D·W·(1 − s)` and `D·W·s`.
fn microfacets_both(microfacets: MicrofacetsAt, v: vec3f) -> vec2f {
    let h = microfacets.view + v;
    let along = dot(microfacets.normal, h);
    let beside = cross(microfacets.normal, h);
    let square = dot(h, h);
    let ratio = square / max(microfacets.alpha_sq * along * along + dot(beside, beside), 1e-30);
    let d = microfacets.alpha_sq * FRAC_1_PI * ratio * ratio;
    let fifth = schlick(0.5 * sqrt(square));
    let light = dot(microfacets.normal, v);
    let value = d * masking(light, dot(microfacets.normal, microfacets.view), microfacets.alpha_sq, microfacets.shadowing);
    return vec2f(value * (1.0 - fifth), value * fifth);
}

fn masking(light: f32, view: f32, alpha_sq: f32, shadowing: f32) -> f32 {
    let l = positive(light);
    return 0.5 * l / (l * shadowing + view * sqrt(l * l * (1.0 - alpha_sq) + alpha_sq));
}
