// The cone that a sphere blocks, on the mask: whatever is not an ellipse. Needs blocked_cone and lighting's mask.wgsl.

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

// The one or two spans of a row, from left to right; empty ones else.
struct Spans {
    a: vec2f,
    b: vec2f,
}

const SPAN_LIMIT = 1e9;

// Blocks of the own row `j` what is in any cone, with the unit axis `m` and the cosine in the square's frame: between, or
// outside, the roots of a quadratic.
fn splat_wide(m: vec3f, cos: f32, mask: Mask, j: u32) {
    if (cos <= -1.0) {
        mask_block_all();
        return;
    }
    let flat = 2.0 * FLAT * mask_cell(mask);
    let below = row_spans(m, cos, mask_row_y(mask, max(j, 1u) - 1u));
    let here = row_spans(m, cos, mask_row_y(mask, j));
    let above = row_spans(m, cos, mask_row_y(mask, min(j + 1u, SIDE - 1u)));
    // An edge that is farther than the window on both sides of the row moves there unseen.
    let moves = vec2<bool>(any(abs(below.a - above.a) > vec2f(flat)), any(abs(below.b - above.b) > vec2f(flat)));
    if (!moves.x) {
        mask_block_span(mask, j, here.a.x, here.a.y);
    }
    if (!moves.y) {
        mask_block_span(mask, j, here.b.x, here.b.y);
    }
    if (any(moves)) {
        for (var k = 0u; k < 8u; k++) {
            let line = row_spans(m, cos, mask_row_y(mask, j) + mask_cell(mask) * row_height(k));
            if (moves.x) {
                block_line(line.a, mask, j, k);
            }
            if (moves.y) {
                block_line(line.b, mask, j, k);
            }
        }
    }
}

fn block_line(span: vec2f, mask: Mask, j: u32, k: u32) {
    if (span.x < span.y) {
        mask_block_line(j, k, mask_sample(mask, span.x), mask_sample(mask, span.y));
    }
}

// The spans of the row `y` in which `m·p ≥ cos|p|`, `p = (x, y, 1)`. Differences of squares are products here: what is
// near zero at the edge of a small window keeps its digits.
fn row_spans(m: vec3f, cos: f32, y: f32) -> Spans {
    let along = m.y * y + m.z;
    let e = y * y + 1.0;
    let rim = abs(cos) * sqrt(e);
    // (m·p)² = cos²|p|² as a x² + 2b x + c = 0; b² − ac = cos²(m.x² e + c).
    let a = (m.x - cos) * (m.x + cos);
    let b = m.x * along;
    let c = (along - rim) * (along + rim);
    let discriminant = m.x * m.x * e + c;
    var left = -SPAN_LIMIT;
    var right = SPAN_LIMIT;
    if (discriminant > 0.0) {
        let root = abs(cos) * sqrt(discriminant);
        let q = -(b + select(root, -root, b < 0.0));
        let r1 = quotient(q, a);
        let r2 = quotient(c, q);
        left = min(r1, r2);
        right = max(r1, r2);
    }
    let low = span_inside(m, cos, along, e, -SPAN_LIMIT, left);
    let middle = span_inside(m, cos, along, e, left, right);
    let high = span_inside(m, cos, along, e, right, SPAN_LIMIT);
    let none = vec2f(0.0);
    if (middle) {
        return Spans(vec2f(select(left, -SPAN_LIMIT, low), select(right, SPAN_LIMIT, high)), none);
    }
    return Spans(select(none, vec2f(-SPAN_LIMIT, left), low), select(none, vec2f(right, SPAN_LIMIT), high));
}

// Within ±SPAN_LIMIT; the limit for 0/0.
fn quotient(a: f32, b: f32) -> f32 {
    if (abs(a) >= SPAN_LIMIT * abs(b)) {
        return select(SPAN_LIMIT, -SPAN_LIMIT, a != 0.0 && (a < 0.0) != (b < 0.0));
    }
    return a / b;
}

// Whether there is anything between two roots and it is blocked.
fn span_inside(m: vec3f, cos: f32, along: f32, e: f32, first: f32, to: f32) -> bool {
    let x = 0.5 * (first + to);
    return to > first && m.x * x + along >= cos * sqrt(x * x + e);
}
