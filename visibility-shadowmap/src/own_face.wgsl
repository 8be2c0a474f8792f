// How a receiver's own face lies to a light. Needs layer.wgsl and geometry.wgsl of lobe-core.

// Whether maps were made of an object.
fn map_casts(object: u32) -> bool {
    if object >= map_word(0) {
        return false;
    }
    return ((map_word(1u + (object >> 5u)) >> (object & 31u)) & 1u) == 1u;
}

// How a receiver's own face lies to the light, where that hides some of it and the receiver's horizon does not.
fn map_own_face(at: Receiver, cone: Cone) -> u32 {
    if all(at.face == at.normal) || !map_casts(at.object) {
        return LIT;
    }
    let elevation = dot(at.face, cone.axis);
    let sine = sqrt(cone_sin_sq(cone));
    if elevation >= sine {
        return LIT;
    }
    return select(PARTIAL, DARK, elevation <= -sine);
}
