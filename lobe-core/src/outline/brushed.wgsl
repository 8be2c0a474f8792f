// The highlight of microfacets that may have a grain on a light's plane: `Grain::highlight`.

// A slope in α along the grain and across it.
fn highlight_slope(surface: MicrofacetsAt, h: vec3f, up: f32) -> vec3f {
    let along = dot(surface.tangent, h);
    let across = dot(cross(surface.normal, surface.tangent), h);
    return vec3f(along / (surface.along * up), across / (sqrt(surface.alpha_sq) * up), 0.0);
}

// The ellipse of the spread of the mirrored view: squares along the plane of incidence and aside of it, and their product.
fn highlight_spread(normal: vec3f, lobe: Lobe) -> vec3f {
    let grain = grain_of(lobe);
    let turn = grain_turn(grain);
    let cosine = seen_from(normal, lobe.axis).x;
    let across = sqrt(microfacets_alpha_sq(lobe.exponent));
    // Half vectors that turn aside turn the mirror's direction by less.
    let a = vec2f(turn.x, turn.y * cosine) * grain_alpha(grain, across);
    let b = vec2f(-turn.y, turn.x * cosine) * across;
    return vec3f(a * a + b * b, a.x * a.y + b.x * b.y);
}

// Half the difference of the squares of its axes.
fn highlight_half(spread: vec3f) -> f32 {
    let difference = 0.5 * (spread.x - spread.y);
    return sqrt(difference * difference + spread.z * spread.z);
}

// The direction in which it is longest.
fn highlight_turn(normal: vec3f, lobe: Lobe) -> vec3f {
    let spread = highlight_spread(normal, lobe);
    let half = highlight_half(spread);
    let double = select(1.0, 0.5 * (spread.x - spread.y) / half, half > 1e-30);
    let long = sqrt(max(0.5 * vec2f(1.0 + double, 1.0 - double), vec2f(0.0)));
    let seen = seen_from(normal, lobe.axis);
    let ahead = tangent_toward(normal, lobe.axis);
    let turn = normal * seen.y + ahead * seen.x;
    return turn * long.x + cross(normal, ahead) * select(long.y, -long.y, spread.z < 0.0);
}

// Its widths along and across that, where the plane at distance 1 is stretched.
fn highlight_widths(normal: vec3f, lobe: Lobe, stretch: f32) -> vec2f {
    let spread = highlight_spread(normal, lobe);
    let mean = 0.5 * (spread.x + spread.y);
    let half = highlight_half(spread);
    let across = microfacets_alpha_sq(lobe.exponent);
    return 2.0 * vec2f(sqrt(mean + half) * stretch, max(sqrt(positive(mean - half)), across) * sqrt(stretch));
}
