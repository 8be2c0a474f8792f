// Of the lobes of microfacets of microfacets.rs, with a grain and without.

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

// The eye's direction mirrored by the normal.
fn microfacets_mirror(microfacets: MicrofacetsAt) -> vec3f {
    return 2.0 * dot(microfacets.normal, microfacets.view) * microfacets.normal - microfacets.view;
}

fn schlick(vh: f32) -> f32 {
    let x = positive(1.0 - vh);
    return x * x * x * x * x;
}
