// The lobes of microfacets of microfacets.rs.

struct MicrofacetsAt {
    normal: vec3f,
    alpha_sq: f32,
    // The eye's direction; above the horizon.
    view: vec3f,
    shadowing: f32,
}

// Cosine and sine of the eye's direction to the normal.
fn seen_from(normal: vec3f, view: vec3f) -> vec2f {
    let cosine = dot(normal, view);
    let across = view - normal * cosine;
    let sine = min(sqrt(dot(across, across)), 1.0);
    return vec2f(clamp(cosine, MICROFACETS_GRAZING, 1.0), select(sqrt(1.0 - MICROFACETS_GRAZING * MICROFACETS_GRAZING), sine, cosine > MICROFACETS_GRAZING));
}

// The tangent toward the eye.
fn tangent_toward(normal: vec3f, view: vec3f) -> vec3f {
    let across = view - normal * dot(normal, view);
    let length = sqrt(dot(across, across));
    if (length > 1e-6) {
        return across / length;
    }
    return orthonormal_basis_u(normal);
}

fn microfacets_alpha_sq(exponent: f32) -> f32 { return 2.0 / (exponent + 2.0); }

fn microfacets_of(normal: vec3f, lobe: Lobe) -> MicrofacetsAt {
    let seen = seen_from(normal, lobe.axis);
    let alpha_sq = microfacets_alpha_sq(lobe.exponent);
    let shadowing = sqrt(seen.x * seen.x * (1.0 - alpha_sq) + alpha_sq);
    return MicrofacetsAt(normal, alpha_sq, normal * seen.x + tangent_toward(normal, lobe.axis) * seen.y, shadowing);
}

// The eye's direction mirrored by the normal.
fn microfacets_mirror(microfacets: MicrofacetsAt) -> vec3f {
    return 2.0 * dot(microfacets.normal, microfacets.view) * microfacets.normal - microfacets.view;
}

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

fn schlick(vh: f32) -> f32 {
    let x = positive(1.0 - vh);
    return x * x * x * x * x;
}

fn masking(light: f32, view: f32, alpha_sq: f32, shadowing: f32) -> f32 {
    let l = positive(light);
    return 0.5 * l / (l * shadowing + view * sqrt(l * l * (1.0 - alpha_sq) + alpha_sq));
}
