// Masks from shadow rays: `RayBlockers::splat`.

// Where the rays of the point that is shaded begin, and the light.
var<private> rays_origin: vec3f;
var<private> rays_light: Cone;
// Normal of the point's facet where that hides a part of the light, or 0.
var<private> rays_face: vec3f;

fn light_is_hidden(v: vec3f) -> bool {
    // A ray below the plane would meet the facet or pass its edge.
    let below = GRAZING - dot(v, rays_face);
    let above = select(v, unit(v + rays_face * below), below > 0.0 && any(rays_face != vec3f(0.0)));
    return any_hit(rays_origin, above, rays_to_surface(above));
}

// Distance of the light's near surface along a unit direction inside the cone, or of its middle beside it.
fn rays_to_surface(v: vec3f) -> f32 {
    if light_is_flat() {
        return light_distance(v);
    }
    if rays_light.distance > 1e30 {
        return rays_light.distance;
    }
    let along = dot(rays_light.axis, v);
    let aside = rays_light.axis - v * along;
    // In units of the distance: the ray passes the centre at sin δ, the light's radius is sin θ.
    let half_sq = cone_sin_sq(rays_light) - dot(aside, aside);
    return rays_light.distance * (along - sqrt(max(half_sq, 0.0)));
}

// The facet's edge, by the first thread.
fn rays_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f {
    if lane > 0u || rays_facet(at, light) != PARTIAL {
        return vec4f(0.0);
    }
    return edges_add_plane(edges_frame_of(window), at.face, window);
}

// Blocks what is hidden. Requires uniform control flow.
fn rays_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
    any_hit_of(at.object);
    rays_origin = any_hit_leave(at);
    rays_light = light;
    rays_face = vec3f(0.0);
    var span = emitting;
    if rays_facet(at, light) == PARTIAL {
        rays_face = at.face;
        span = mask_block_below(mask, lane, at.face);
    }
    contour_block(lane, mask, span, !outline_has_sides());
}
