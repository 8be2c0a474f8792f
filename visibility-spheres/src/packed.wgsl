// Blockers as `SphereBlockers::pack` writes them: neighbours in space, in blocks that have a bound each.
struct BlockerSphere {
    center: vec3f,
    radius: f32,
    // The sphere that receivers of its own object see from inside it: from the centre to that sphere's, radius, and how far away a
    // ray must leave it to be blocked.
    own_offset: vec3f,
    own_radius: f32,
    object: u32,
    own_distance: f32,
    // Of the objects that have a sphere, the one at this sphere's place in ascending order; NO_OBJECT behind the last.
    caster: u32,
    pad: u32,
}

// More spheres than there is room for: the list says nothing.
const LIST_FULL = 1u;
// One sphere hides all of the light from all of the tile: the list may be short.
const LIST_DARK = 2u;
