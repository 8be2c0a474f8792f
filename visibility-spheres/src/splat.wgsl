// The cone that a sphere blocks, and what of it is in front of a light that the sphere meets. Needs blocked_cone and lighting's
// mask.wgsl.

// Adds its rim where that crosses the light's disc, as if the sphere were small and far.
fn blocked_add_edge(blocked: BlockedCone, frame: EdgeFrame, axis: vec3f, tan: f32) -> vec2f {
    let along = dot(blocked.to, axis);
    let aside = blocked.to - axis * along;
    let disc = max(abs(along * tan), 1.1754944e-38);
    return edges_add_circle(frame, aside, blocked.tangent_radius / disc, sqrt(dot(aside, aside)) / disc);
}

// Whether a unit direction is in the cone.
fn blocked_contains(blocked: BlockedCone, v: vec3f) -> bool {
    let along = dot(blocked.to, v);
    if (blocked.cos > 0.0) {
        // Not by the cosine, which for a small cone has lost its digits.
        let aside = blocked.to - v * along;
        return along > 0.0 && dot(aside, aside) <= blocked.tangent_radius * blocked.tangent_radius;
    }
    return blocked.cos <= -1.0 || along >= blocked.cos * sqrt(dot(blocked.to, blocked.to));
}

// Whether, along the unit direction `v`, the ball is entered before the light (both seen from the origin). Inside the ball
// counts as entered at 0.
fn order_by_ray(v: vec3f, blocked: BlockedCone, light: vec3f, light_radius: f32) -> bool {
    return ray_entry(v, blocked.to, blocked.radius) < ray_entry(v, light, light_radius);
}

fn ray_entry(v: vec3f, center: vec3f, radius: f32) -> f32 {
    let along = dot(center, v);
    // The distance of ray and centre directly: as a difference of squares it drowns a few hundred radii away.
    let aside = center - v * along;
    let half_sq = radius * radius - dot(aside, aside);
    return max(along - sqrt(max(half_sq, 0.0)), 0.0);
}

// Whether the ball hides the light that it meets in the plane's point `x` of row `j`.
fn hides_in_front(blocked: BlockedCone, light: vec3f, light_radius: f32, mask: Mask, x: f32, y: f32) -> bool {
    let v = square_world(mask.square, vec3f(x, y, 1.0));
    let direction = v * (1.0 / sqrt(dot(v, v)));
    return blocked_contains(blocked, direction) && order_by_ray(direction, blocked, light, light_radius);
}

// Blocks of the own row `j` where the ball is in front of the light that it meets (centre and radius): at most two runs of
// cell centres and one to the end, their ends found between two centres by bisection.
fn splat_in_front(blocked: BlockedCone, light: vec3f, light_radius: f32, mask: Mask, j: u32) {
    let y = mask_row_y(mask, j);
    let far = 1e9;
    var before = mask_cell_center(mask, 0u, j).x;
    var hidden = hides_in_front(blocked, light, light_radius, mask, before, y);
    var start = -far;
    var runs = 0u;
    for (var i = 1u; i < SIDE; i++) {
        let center = mask_cell_center(mask, i, j).x;
        if (hides_in_front(blocked, light, light_radius, mask, center, y) != hidden) {
            var low = before;
            var high = center;
            for (var step = 0u; step < 8u; step++) {
                let middle = 0.5 * (low + high);
                if (hides_in_front(blocked, light, light_radius, mask, middle, y) == hidden) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let edge = 0.5 * (low + high);
            if (!hidden) {
                start = edge;
            } else if (runs < 2u) {
                mask_block_span(mask, j, start, edge);
                runs++;
            }
            hidden = !hidden;
        }
        before = center;
    }
    if (hidden) {
        mask_block_span(mask, j, start, far);
    }
}
