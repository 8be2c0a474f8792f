// Masks from shadow rays: `RayBlockers::splat`. Needs rays.wgsl and lighting's contour.wgsl.

// Where the rays of the point that is shaded begin, and the light.
var<private> rays_origin: vec3f;
var<private> rays_light: Cone;

fn light_is_hidden(v: vec3f) -> bool {
    return rays_occluded(rays_origin, v, rays_to_surface(v) * nodes[0].low.x);
}

// Distance of the light's near surface along a unit direction inside the cone, or of its middle beside it.
fn rays_to_surface(v: vec3f) -> f32 {
    if rays_light.distance > 1e30 {
        return 1e30 / nodes[0].low.x;
    }
    let along = dot(rays_light.axis, v);
    let aside = rays_light.axis - v * along;
    // In units of the distance: the ray passes the centre at sin δ, the light's radius is sin θ.
    let half_sq = cone_sin_sq(rays_light) - dot(aside, aside);
    return rays_light.distance * (along - sqrt(max(half_sq, 0.0)));
}

// Blocks what is hidden. Only where all threads come by.
fn rays_splat(lane: u32, at: Receiver, light: Cone, mask: Mask) {
    rays_origin = rays_leave(at);
    rays_light = light;
    contour_block(lane, mask);
}
