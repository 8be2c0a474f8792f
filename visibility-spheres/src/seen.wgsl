// A sphere as a receiver sees it, and the objects that have spheres.

// How much a receiver of the own object at the distance d sees of the near sphere instead of the whole one.
fn nearness(whole: f32, d: f32) -> f32 {
    return whole / max(max(d, whole), 1.1754944e-38);
}

// The cone that a sphere hides from a receiver.
fn spheres_blocked(index: u32, at: Receiver) -> BlockedCone {
    let sphere = spheres[index];
    let own = sphere.object == at.object;
    var to = sphere.center - at.position;
    var radius = sphere.radius;
    if (own) {
        let w = nearness(radius, length(to));
        to += sphere.own_offset * w;
        radius -= (radius - sphere.own_radius) * w;
    }
    return blocked_cone(to, radius, select(0.0, sphere.own_distance, own));
}

// Whether an object has a sphere.
fn spheres_cast(object: u32) -> bool {
    var first = 0u;
    var end = arrayLength(&spheres);
    while (first < end) {
        let middle = (first + end) / 2u;
        if (spheres[middle].caster < object) {
            first = middle + 1u;
        } else {
            end = middle;
        }
    }
    return object != NO_OBJECT && first < arrayLength(&spheres) && spheres[min(first, arrayLength(&spheres) - 1u)].caster == object;
}
