// The cone that a sphere blocks, and what of it is in front of a light that the sphere meets.

// Adds its rim where that crosses the light's disc, as if the sphere were small and far.
fn blocked_add_edge(blocked: BlockedCone, frame: EdgeFrame, axis: vec3f, tan: f32) -> vec2f {
    let of_disc = 1.0 / max(abs(dot(blocked.to, axis) * tan), 1.1754944e-38);
    return edges_add_circle(frame, blocked.to * of_disc, blocked.tangent_radius * of_disc);
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

// Whether, along the unit direction `v`, the sphere is entered before the light (both seen from the origin). Inside the sphere
// counts as entered at 0.
fn order_by_ray(v: vec3f, blocked: BlockedCone, light: vec3f, light_radius: f32) -> bool {
    let entry = ray_entry(v, blocked.to, blocked.radius);
    if (light_is_flat()) {
        let plane = light_plane();
        return entry * dot(plane.xyz, v) < plane.w;
    }
    return entry < ray_entry(v, light, light_radius);
}

fn ray_entry(v: vec3f, center: vec3f, radius: f32) -> f32 {
    let along = dot(center, v);
    // The distance of ray and centre directly: as a difference of squares it drowns a few hundred radii away.
    let aside = center - v * along;
    let half_sq = radius * radius - dot(aside, aside);
    return max(along - sqrt(max(half_sq, 0.0)), 0.0);
}

// Whether the sphere hides the light that it meets in the plane's point `x` of row `j`.
fn hides_in_front(blocked: BlockedCone, light: vec3f, light_radius: f32, mask: Mask, x: f32, y: f32) -> bool {
    let v = square_world(mask.square, vec3f(x, y, 1.0));
    let direction = v * (1.0 / sqrt(dot(v, v)));
    return blocked_contains(blocked, direction) && order_by_ray(direction, blocked, light, light_radius);
}

// Blocks of the own row `j` where the sphere is in front of the light that it meets (centre and radius): at most two runs of
// cell centres and one to the end, their ends found between two centres by bisection. Rounds of loops are few: Mesa's software
// driver has 65 535 of them for a thread.
fn splat_in_front(blocked: BlockedCone, light: vec3f, light_radius: f32, mask: Mask, j: u32) {
    let far = 1e9;
    var cells = vec2u(0u);
    for (var first = 0u; first < SIDE; first += 8u) {
        let eight = hidden_cells(blocked, light, light_radius, mask, first, j) << (first & 31u);
        cells |= select(vec2u(eight, 0u), vec2u(0u, eight), first >= 32u);
    }
    // Bit i: cells i and i + 1 differ.
    var differ = (cells ^ vec2u((cells.x >> 1u) | (cells.y << 31u), cells.y >> 1u)) & CELL_PAIRS;
    var hidden = (cells.x & 1u) != 0u;
    var start = -far;
    var runs = 0u;
    while (any(differ != vec2u(0u))) {
        let i = select(32u + firstTrailingBit(differ.y), firstTrailingBit(differ.x), differ.x != 0u);
        differ = select(vec2u(0u, differ.y & (differ.y - 1u)), vec2u(differ.x & (differ.x - 1u), differ.y), differ.x != 0u);
        var ends = vec2f(mask_cell_center(mask, i, j).x, mask_cell_center(mask, i + 1u, j).x);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        ends = nearer_ends(blocked, light, light_radius, mask, ends, hidden, j);
        let edge = 0.5 * (ends.x + ends.y);
        if (!hidden) {
            start = edge;
        } else if (runs < 2u) {
            mask_block_span(mask, j, start, edge);
            runs++;
        }
        hidden = !hidden;
    }
    if (hidden) {
        mask_block_span(mask, j, start, far);
    }
}

// Neighbours in a row, by the left one.
const CELL_PAIRS = vec2u(0xffffffffu >> (32u - min(SIDE - 1u, 32u)), (1u << (max(SIDE, 33u) - 33u)) - 1u);

// Which of eight cells from `first` on are hidden, by their centres.
fn hidden_cells(blocked: BlockedCone, light: vec3f, light_radius: f32, mask: Mask, first: u32, j: u32) -> u32 {
    return hidden_cell(blocked, light, light_radius, mask, first, j)
        | (hidden_cell(blocked, light, light_radius, mask, first + 1u, j) << 1u)
        | (hidden_cell(blocked, light, light_radius, mask, first + 2u, j) << 2u)
        | (hidden_cell(blocked, light, light_radius, mask, first + 3u, j) << 3u)
        | (hidden_cell(blocked, light, light_radius, mask, first + 4u, j) << 4u)
        | (hidden_cell(blocked, light, light_radius, mask, first + 5u, j) << 5u)
        | (hidden_cell(blocked, light, light_radius, mask, first + 6u, j) << 6u)
        | (hidden_cell(blocked, light, light_radius, mask, first + 7u, j) << 7u);
}

fn hidden_cell(blocked: BlockedCone, light: vec3f, light_radius: f32, mask: Mask, i: u32, j: u32) -> u32 {
    let center = mask_cell_center(mask, i, j);
    return select(0u, 1u, hides_in_front(blocked, light, light_radius, mask, center.x, center.y));
}

// Half of an interval at whose start it is hidden or not, as said.
fn nearer_ends(
    blocked: BlockedCone,
    light: vec3f,
    light_radius: f32,
    mask: Mask,
    ends: vec2f,
    hidden: bool,
    j: u32,
) -> vec2f {
    let middle = 0.5 * (ends.x + ends.y);
    let as_start = hides_in_front(blocked, light, light_radius, mask, middle, mask_row_y(mask, j)) == hidden;
    return select(vec2f(ends.x, middle), vec2f(middle, ends.y), as_start);
}
