// The directional albedo of microfacets, as in cap/albedo.rs, by the half vectors of albedo_facets.wgsl or brushed_facets.wgsl.

fn microfacets_albedo(at: Receiver, lobe: Lobe) -> vec2f {
    let facets = facets_of(at, lobe);
    var sum = vec2f(0.0);
    for (var i = 0u; i < ALBEDO_AROUND; i++) {
        let turn = ALBEDO_TURNS[i];
        // Where reflected light passes the horizon.
        var low = -facets.up;
        var high = 1.0;
        for (var k = 0u; k < ALBEDO_HALVINGS; k++) {
            let middle = 0.5 * (low + high);
            let half = facets_half(facets, middle, turn);
            if (2.0 * half.seen * half.up > facets.cosine * half.square) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let range = 1.0 - 0.5 * (low + high);
        for (var k = 0u; k < 8u; k++) {
            sum += facets_node(facets, range, turn, ALBEDO_PLACES[k]);
        }
    }
    return sum;
}
