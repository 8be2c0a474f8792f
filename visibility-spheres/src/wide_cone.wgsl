// Cones that reach the plane through the receiver across the light, on the mask: spheres beside the receiver, or about it.

// Blocks of the own row `j` the directions about the unit axis `to`, in the square's frame, of at least this cosine.
fn splat_wide(to: vec3f, cos: f32, mask: Mask, j: u32) {
    if (cos <= -1.0) {
        mask_block_all();
        return;
    }
    // A cone of less than a hemisphere, or all directions outside it.
    let outside = cos < 0.0;
    let m = select(to, -to, outside);
    let y = mask_row_y(mask, j);
    let cell = mask_cell(mask).y;
    // An end that is farther than the window on both sides of the row moves there unseen.
    let moved = abs(wide_row(m, abs(cos), y - cell) - wide_row(m, abs(cos), y + cell));
    if (all(moved <= vec2f(2.0 * FLAT * mask_cell(mask).x))) {
        let ends = wide_row(m, abs(cos), y);
        if (outside) {
            mask_block_span(mask, j, -WIDE_LIMIT, ends.x);
            mask_block_span(mask, j, ends.y, WIDE_LIMIT);
        } else {
            mask_block_span(mask, j, ends.x, ends.y);
        }
        return;
    }
    for (var k = 0u; k < 8u; k++) {
        let ends = wide_row(m, abs(cos), y + cell * row_height(k));
        if (outside) {
            mask_block_line(j, k, 0u, mask_sample(mask, ends.x));
            mask_block_line(j, k, mask_sample(mask, ends.y), row_width);
        } else {
            mask_block_line(j, k, mask_sample(mask, ends.x), mask_sample(mask, ends.y));
        }
    }
}

// Where the row at height y enters and leaves it: `m·p ≥ cos|p|`, `p = (x, y, 1)`, which squared is `a x² + 2b x + c = 0`, has
// one interval in each row. An empty one ends before it begins.
fn wide_row(m: vec3f, cos: f32, y: f32) -> vec2f {
    let along = y * m.y + m.z;
    let e = y * y + 1.0;
    // Differences of squares are products: what is near zero at the edge of a small window keeps its digits.
    let rim = sqrt(e) * cos;
    let a = (m.x - cos) * (m.x + cos);
    let b = along * m.x;
    let c = (along - rim) * (along + rim);
    // b² − ac = cos²(m.x² e + c).
    let discriminant = e * (m.x * m.x) + c;
    let root = sqrt(max(discriminant, 0.0)) * cos;
    let q = -(b + select(root, -root, b < 0.0));
    let r1 = quotient(q, a);
    let r2 = quotient(c, q);
    let left = min(r1, r2);
    let right = max(r1, r2);
    if (a >= 0.0 && m.x > 0.0) {
        return vec2f(right, WIDE_LIMIT);
    }
    if (a >= 0.0 && m.x < 0.0) {
        return vec2f(-WIDE_LIMIT, left);
    }
    let none = vec2f(WIDE_LIMIT, -WIDE_LIMIT);
    if (a < 0.0) {
        return select(none, vec2f(left, right), discriminant > 0.0 && along > 0.0);
    }
    // A plane along the rows.
    return select(none, -none, along > 0.0);
}

// Within ±WIDE_LIMIT; the limit for 0/0.
fn quotient(a: f32, b: f32) -> f32 {
    if (abs(a) >= WIDE_LIMIT * abs(b)) {
        return select(WIDE_LIMIT, -WIDE_LIMIT, a != 0.0 && (a < 0.0) != (b < 0.0));
    }
    return a / b;
}
