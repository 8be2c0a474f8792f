// Answers the questions of other strategies about the scene's triangles, in units of the scene. Needs rays.wgsl.

fn any_hit_leave(at: Receiver) -> vec3f { return rays_leave(at) / nodes[0].low.x; }

fn any_hit_has(object: u32) -> bool { return rays_have(object); }

fn any_hit(origin: vec3f, direction: vec3f, distance: f32) -> bool {
    let scale = nodes[0].low.x;
    return rays_occluded(origin * scale, direction, distance * scale);
}

fn any_hit_side(a: vec3f, b: vec3f, c: vec3f, x: vec3f) -> f32 {
    let scale = nodes[0].low.x;
    return plane_of(Primitive(a * scale, 0u, b * scale, 0u, c * scale, 0u), x * scale).w;
}
