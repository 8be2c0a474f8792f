// How a receiver's own face lies to a light. Needs layer.wgsl and facet.wgsl of lighting.

// Whether maps were made of an object.
fn map_casts(object: u32) -> bool {
    if object >= map_word(0) {
        return false;
    }
    return ((map_word(1u + (object >> 5u)) >> (object & 31u)) & 1u) == 1u;
}

// How much of the light the receiver's own facet hides.
fn map_own_face(at: Receiver, cone: Cone) -> u32 {
    if !map_casts(at.object) {
        return LIT;
    }
    return facet_coverage(at, cone);
}
