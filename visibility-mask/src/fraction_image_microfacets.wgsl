// Microfacet lobes for the light of an image.

// The lobe's microfacets, in the frame of a mask's square.
var<private> image_surface: MicrofacetsAt;
var<private> image_is_edge: bool;

fn image_alpha(lobe: Lobe) -> f32 { return microfacets_width(lobe); }

fn image_highlight(whole: UnitSquare, at: Receiver, tolerance: f32, lobe: Lobe) -> UnitSquare {
    return microfacets_highlight(whole, at, lobe, tolerance);
}

fn image_facets_in(square: UnitSquare, at: Receiver, lobe: Lobe) {
    image_surface = microfacets_in(square, microfacets_of(at.normal, lobe));
    image_is_edge = microfacets_is_edge(lobe);
}

fn image_facets(v: vec3f) -> f32 {
    let both = microfacets_both(image_surface, v);
    return select(both.x, both.y, image_is_edge);
}
