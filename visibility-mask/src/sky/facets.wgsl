// Lobes of microfacets, for the sums over a sky.

var<private> sky_microfacets: MicrofacetsAt;

fn sky_set_facets(at: Receiver, lobe: Lobe) {
    if (lobe.kind >= LOBE_MICROFACETS_F0) {
        sky_microfacets = microfacets_of(at.normal, lobe);
    }
}

fn sky_facets(lobe: Lobe, v: vec3f) -> f32 {
    let both = microfacets_both(sky_microfacets, v);
    return select(both.x, both.y, microfacets_is_edge(lobe));
}
