// How a receiver's own face lies to a light, and whether maps speak of it. Needs layer.wgsl and facet.wgsl of lighting.

// Of an object: bit 0 whether maps were made of it, bit 1 whether its receivers are left to others.
fn map_object(object: u32) -> u32 {
    if object >= map_word(0) {
        return 0u;
    }
    return (map_word(1u + (object >> 4u)) >> (2u * (object & 15u))) & 3u;
}

// Whether receivers on it are for other blockers.
fn map_leaves(object: u32) -> bool {
    return (map_object(object) & 2u) != 0u;
}

// How much of the light the receiver's own facet hides.
fn map_own_face(at: Receiver, cone: Cone) -> u32 {
    if (map_object(at.object) & 1u) == 0u {
        return LIT;
    }
    return facet_coverage(at, cone);
}
