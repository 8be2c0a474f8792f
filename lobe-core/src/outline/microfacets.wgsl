// Lobes of microfacets over an outline, whose highlights are those of highlight.wgsl or brushed.wgsl.

// Those of the lobe, in the frame of the light's plane.
var<private> outline_surface: MicrofacetsAt;
var<private> outline_is_edge: bool;

fn outline_facets(v: vec3f) -> f32 {
    let both = microfacets_both(outline_surface, v);
    return select(both.x, both.y, outline_is_edge);
}

// The slope of a half vector in its widths.
fn outline_facets_slope(direction: vec3f) -> vec3f {
    let h = direction + outline_surface.view;
    return highlight_slope(outline_surface, h, max(dot(outline_surface.normal, h), 1e-4));
}

// Rows across the direction in which highlights are longer.
fn outline_facets_turn(normal: vec3f, lobe: Lobe) -> vec3f {
    let mirror = microfacets_mirror(microfacets_of(normal, lobe));
    let turn = highlight_turn(normal, lobe);
    let toward = dot(outline.axis, mirror);
    return select(mirror, turn - mirror * (dot(outline.axis, turn) / toward), toward > 1e-3);
}

fn outline_microfacets(right: vec3f, normal: vec3f, lobe: Lobe) -> OutlineTerm {
    let surface = microfacets_of(normal, lobe);
    let alpha = sqrt(surface.alpha_sq);
    let mirror = microfacets_mirror(surface);
    let axis = outline_local(right, mirror);
    let length = sqrt(dot(axis.xy, axis.xy));
    let far = select(vec2f(0.0), axis.xy * (1e3 / length), length > 0.0);
    let place = select(far, axis.xy / axis.z, axis.z > 1e-3);
    var point = outline_nearest(place);
    let stretch = 1.0 + dot(point, point);
    // Their tails are powers of the distance.
    let apart = place - point;
    let beside = 0.5 * sqrt(dot(apart, apart));
    var width = max(highlight_widths(normal, lobe, stretch), vec2f(beside));
    // Next to the receiver the light's own `1/r³` may matter more.
    let foot = outline_nearest(vec2f(0.0));
    if (min(width.x, width.y) > sqrt(1.0 + dot(foot, foot))) {
        point = foot;
    }
    width = min(width, vec2f(sqrt(1.0 + dot(point, point))));
    outline_surface = microfacets_local(surface, right, cross(outline.axis, right), outline.axis);
    outline_is_edge = microfacets_is_edge(lobe);
    let value = OutlineValue(OUTLINE_FACETS, false, 0.0, outline_surface.normal, axis);
    return OutlineTerm(1.0, OutlinePeak(point, width), value);
}
