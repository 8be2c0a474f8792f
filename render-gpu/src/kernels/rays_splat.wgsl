// Masks from shadow rays: `RayBlockers::splat`. Needs rays.wgsl, and visibility-mask's contour.wgsl and edges.wgsl.

// Where the rays of the point that is shaded begin, and the light.
var<private> rays_origin: vec3f;
var<private> rays_light: Cone;
// Normal of the point's facet where that hides a part of the light, or 0.
var<private> rays_face: vec3f;

// Sine of the least elevation above a facet at which it is asked for light: rounding does not turn such a ray down.
const GRAZING = 1e-6;

fn light_is_hidden(v: vec3f) -> bool {
    // A ray below the plane would meet the facet or pass its edge.
    let below = GRAZING - dot(v, rays_face);
    let above = select(v, unit(v + rays_face * below), below > 0.0 && any(rays_face != vec3f(0.0)));
    return rays_occluded(rays_origin, above, rays_to_surface(above) * nodes[0].low.x);
}

// Distance of the light's near surface along a unit direction inside the cone, or of its middle beside it.
fn rays_to_surface(v: vec3f) -> f32 {
    if light_is_flat() {
        return min(light_distance(v), 1e30 / nodes[0].low.x);
    }
    if rays_light.distance > 1e30 {
        return 1e30 / nodes[0].low.x;
    }
    let along = dot(rays_light.axis, v);
    let aside = rays_light.axis - v * along;
    // In units of the distance: the ray passes the centre at sin δ, the light's radius is sin θ.
    let half_sq = cone_sin_sq(rays_light) - dot(aside, aside);
    return rays_light.distance * (along - sqrt(max(half_sq, 0.0)));
}

// The facet's edge, by the first thread.
fn rays_edges(lane: u32, at: Receiver, light: Cone, window: Cone) -> vec2f {
    if lane > 0u || rays_facet(at, light) != PARTIAL {
        return vec2f(0.0);
    }
    return edges_add_plane(edges_frame(window.axis), at.face, window);
}

// Blocks what is hidden. Requires uniform control flow.
fn rays_splat(lane: u32, at: Receiver, light: Cone, mask: Mask) {
    rays_origin = rays_leave(at);
    rays_light = light;
    rays_face = vec3f(0.0);
    var span = emitting;
    if rays_facet(at, light) == PARTIAL {
        rays_face = at.face;
        span = mask_block_below(mask, lane, at.face);
    }
    contour_block(lane, mask, span);
}
