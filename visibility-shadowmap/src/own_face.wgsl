// How a receiver's own face lies to a light, and whether maps speak of it. Needs layer.wgsl and facet.wgsl of visibility-mask.

// Where the map of the light is, or 0.
fn map_of_light() -> u32 {
    let table = 1u + (maps_word(0u) + 15u) / 16u;
    if frame.number >= maps_word(table) {
        return 0u;
    }
    return maps_word(table + 1u + frame.number);
}

// Of an object: bit 0 whether maps were made of it, bit 1 whether its receivers are left to others.
fn map_object(object: u32) -> u32 {
    if object >= maps_word(0u) {
        return 0u;
    }
    return (maps_word(1u + (object >> 4u)) >> (2u * (object & 15u))) & 3u;
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
