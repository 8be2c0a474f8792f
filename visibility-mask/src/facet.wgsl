// How a receiver's own facet lies to a light. Needs geometry.wgsl of lobe-core.

// How much of a light the plane of the receiver's own facet hides, for receivers on an object that blocks; a part is no more
// than LIT where the horizon leaves out the same directions.
fn facet_coverage(at: Receiver, cone: Cone) -> u32 {
    let elevation = dot(at.face, cone.axis);
    let sine = sqrt(cone_sin_sq(cone));
    if (elevation <= -sine) {
        return DARK;
    }
    return select(LIT, PARTIAL, elevation < sine && any(at.face != at.normal));
}
