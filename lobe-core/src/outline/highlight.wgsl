// The highlight of microfacets on a light's plane.

// A slope in α.
fn highlight_slope(surface: MicrofacetsAt, h: vec3f, up: f32) -> vec3f {
    return (h - surface.normal * dot(surface.normal, h)) / (sqrt(surface.alpha_sq) * up);
}

// The direction in which it is longest: the plane of incidence.
fn highlight_turn(normal: vec3f, lobe: Lobe) -> vec3f {
    let seen = seen_from(normal, lobe.axis);
    return normal * seen.y + tangent_toward(normal, lobe.axis) * seen.x;
}

// Its widths along and across that, where the plane at distance 1 is stretched.
fn highlight_widths(normal: vec3f, lobe: Lobe, stretch: f32) -> vec2f {
    let alpha = sqrt(microfacets_alpha_sq(lobe.exponent));
    let cosine = seen_from(normal, lobe.axis).x;
    return 2.0 * alpha * vec2f(stretch, max(cosine, alpha) * sqrt(stretch));
}
