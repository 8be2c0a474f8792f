// `Capsules::splat`, one thread a row of the mask.

const CAPSULES_FAR = 1e30;

fn capsules_roots(a: f32, b: f32, c: f32) -> vec2f {
    let root = sqrt(b * b - a * c);
    let q = -(b + select(root, -root, b < 0.0));
    return vec2f(min(q / a, c / q), max(q / a, c / q));
}

fn capsules_sphere(c: vec3f, radius: f32, y: f32) -> vec2f {
    let power = dot(c, c) - radius * radius;
    let along = c.y * y + c.z;
    if power <= 0.0 {
        return vec2f(-CAPSULES_FAR, CAPSULES_FAR);
    }
    let a = power - c.x * c.x;
    let b = -c.x * along;
    let rest = power * (y * y + 1.0) - along * along;
    if b * b - a * rest >= 0.0 {
        let ends = capsules_roots(a, b, rest);
        if a > 0.0 {
            if c.x * ends.x + along > 0.0 {
                return ends;
            }
        } else if c.x > 0.0 {
            return vec2f(ends.y, CAPSULES_FAR);
        } else if c.x < 0.0 {
            return vec2f(-CAPSULES_FAR, ends.x);
        }
    }
    return vec2f(CAPSULES_FAR, -CAPSULES_FAR);
}

fn capsules_span(p: vec3f, q: vec3f, radius: f32, y: f32) -> vec2f {
    let one = capsules_sphere(p, radius, y);
    let other = capsules_sphere(q, radius, y);
    var span = vec2f(min(one.x, other.x), max(one.y, other.y));
    let long = distance(p, q);
    if long <= 1e-6 * radius {
        return span;
    }
    let u = (q - p) / long;
    let r = radius * radius;
    let g = cross(u, p);
    let w = y * y + 1.0;
    let g0 = g.y * y + g.z;
    let u0 = u.y * y + u.z;
    let a = g.x * g.x - r * (1.0 - u.x * u.x);
    let b = g.x * g0 + r * u.x * u0;
    let c = g0 * g0 - r * (w - u0 * u0);
    if b * b - a * c < 0.0 {
        return span;
    }
    let ends = capsules_roots(a, b, c);
    for (var k = 0u; k < 2u; k++) {
        let x = select(ends.x, ends.y, k == 1u);
        let d = vec3f(x, y, 1.0);
        let du = u.x * x + u0;
        let t = (dot(d, p) - du * dot(u, p)) / (dot(d, d) - du * du);
        let s = t * du - dot(u, p);
        if t > 0.0 && s >= 0.0 && s <= long {
            span = vec2f(min(span.x, x), max(span.y, x));
        }
    }
    return span;
}

fn capsules_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
    for (var i = 0u; i < arrayLength(&capsules_all); i++) {
        let capsule = capsules_all[i];
        if capsule.radius <= 0.0 {
            continue;
        }
        let p = square_local(mask.square, capsule.a - at.position);
        let q = square_local(mask.square, capsule.b - at.position);
        for (var k = 0u; k < 8u; k++) {
            let span = capsules_span(p, q, capsule.radius, mask_row_y(mask, lane) + mask_cell(mask).y * row_height(k));
            if span.x < span.y {
                mask_block_line(lane, k, mask_sample(mask, span.x), mask_sample(mask, span.y));
            }
        }
    }
}
