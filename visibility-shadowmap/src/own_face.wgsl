// Coverage of a light by a receiver's own face, and the flags of its object.

// The place of the light's map, or 0.
fn map_of_light() -> u32 {
    let table = 1u + (maps_word(0u) + 15u) / 16u;
    if frame.number >= maps_word(table) {
        return 0u;
    }
    return maps_word(table + 1u + frame.number);
}

// Flags of an object: bit 0 if maps were built from it, bit 1 if its receivers are left to other blockers.
fn map_object(object: u32) -> u32 {
    if object >= maps_word(0u) {
        return 0u;
    }
    return (maps_word(1u + (object >> 4u)) >> (2u * (object & 15u))) & 3u;
}

// Whether receivers on an object are left to other blockers.
fn map_leaves(object: u32) -> bool {
    return (map_object(object) & 2u) != 0u;
}

// Coverage of the light by the receiver's own facet.
fn map_own_face(at: Receiver, cone: Cone) -> u32 {
    if (map_object(at.object) & 1u) == 0u {
        return LIT;
    }
    return facet_coverage(at, cone);
}
