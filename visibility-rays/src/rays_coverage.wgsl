// How much of the light may be hidden: `RayBlockers::select`.
fn rays_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {
    any_hit_of(at.object);
    let facet = rays_facet(at, cone);
    if facet == DARK {
        return DARK;
    }
    let origin = any_hit_leave(at);
    if cone.one_minus_cos <= 0.0 {
        return select(LIT, DARK, any_hit(origin, cone.axis, cone.distance));
    }
    // No ray is traced below a facet that cuts the light.
    let is_above = facet == PARTIAL || dot(at.face, cone.axis) >= sqrt(cone_sin_sq(cone));
    return select(facet, PARTIAL, any_hit_cone(origin, cone, select(vec3f(0.0), at.face, is_above)));
}
