// Coverage of a light by a receiver's own facet.

// Coverage of a light by the plane of the receiver's own facet, for receivers on an object that blocks; a partly covered light
// counts as LIT if the horizon leaves out the same directions.
fn facet_coverage(at: Receiver, cone: Cone) -> u32 {
    let elevation = dot(at.face, cone.axis);
    let sine = sqrt(cone_sin_sq(cone));
    if (elevation <= -sine) {
        return DARK;
    }
    return select(LIT, PARTIAL, elevation < sine && any(at.face != at.normal));
}
