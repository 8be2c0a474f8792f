// The polygon or disc of light that a point sees: outline/mod.rs. A light's text makes it by `outline_new` or `outline_disc`;
// with no corners the light is its cone.

struct Outline {
    // Corners.
    count: u32,
    // Whether a horizon has cut something off it.
    is_clipped: bool,
    axis: vec3f,
    height: f32,
    // The middle of the whole light.
    center: vec3f,
    // Of a disc, else 0.
    radius: f32,
}

var<private> outline: Outline;
// Relative to the receiver.
var<private> outline_corners: array<vec3f, OUTLINE_ROOM>;
// On the plane at distance 1 along the axis, in the frame of `outline_project`.
var<private> outline_points: array<vec2f, OUTLINE_ROOM>;
var<private> outline_point_count: u32;
// A step along a half side times its own of these is one, times the other's zero; 0 for lights without places on them.
var<private> outline_sides: array<vec3f, 2>;

// Those of the `k`-th.
fn outline_turn(k: u32) -> vec2f {
    let turn = OUTLINE_TURNS[k % 6u];
    let other = select(turn, vec2f(-turn.y, turn.x), (k / 6u) % 2u == 1u);
    return select(other, -other, k >= 12u);
}

fn light_is_flat() -> bool { return outline.count > 0u; }

// The axis, and how far surfaces block along it.
fn light_plane() -> vec4f { return vec4f(outline.axis, OUTLINE_DEPTH * outline.height); }

fn light_corner_count() -> u32 { return outline.count; }

// On the plane at distance 1.
fn light_corner(i: u32) -> vec3f { return outline_corners[i] / outline.height; }

// How far a ray along a direction inside the outline goes before surfaces do not block it any more.
fn light_distance(direction: vec3f) -> f32 {
    let along = dot(outline.axis, direction);
    return select(3e38, OUTLINE_DEPTH * outline.height / along, along > 0.0);
}

// Toward a point inside: the mean of the corners.
fn light_middle() -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < outline.count; i++) {
        sum += outline_corners[i];
    }
    return sum / sqrt(dot(sum, sum));
}

// Of the first `count` corners; none where the receiver is in the plane or behind it.
fn outline_new(count: u32, axis: vec3f) {
    outline = Outline(0u, false, axis, 0.0, vec3f(0.0), 0.0);
    outline_sides = array<vec3f, 2>();
    var center = vec3f(0.0);
    var height = 0.0;
    var size = 0.0;
    for (var i = 0u; i < count; i++) {
        let p = outline_corners[i];
        center += p;
        height += dot(axis, p);
        size = max(size, max(max(abs(p.x), abs(p.y)), abs(p.z)));
    }
    height /= f32(count);
    if (!(height > 1e-5 * size && size < 3e38)) {
        return;
    }
    var twice_area = 0.0;
    for (var i = 1u; i + 1u < count; i++) {
        let first = outline_corners[0];
        twice_area += dot(axis, cross(outline_corners[i] - first, outline_corners[i + 1u] - first));
    }
    if (twice_area < 0.0) {
        for (var i = 0u; i < count / 2u; i++) {
            let corner = outline_corners[i];
            outline_corners[i] = outline_corners[count - 1u - i];
            outline_corners[count - 1u - i] = corner;
        }
    }
    outline.count = count;
    outline.height = height;
    outline.center = center / f32(count);
}

fn outline_disc(center: vec3f, radius: f32, axis: vec3f) {
    let u = orthonormal_basis_u(axis);
    let v = orthonormal_basis_v(axis);
    for (var k = 0u; k < OUTLINE_MOST; k++) {
        let turn = outline_turn(k);
        outline_corners[k] = center + (u * turn.x + v * turn.y) * (radius * OUTLINE_AROUND);
    }
    outline_new(OUTLINE_MOST, axis);
    outline.center = center;
    outline.radius = radius;
}

// Gives the light places: from its middle along two half sides at right angles. Windows on it are turned as these are.
fn outline_set_sides(u: vec3f, v: vec3f) {
    let across = cross(v, outline.axis);
    let upward = cross(u, outline.axis);
    outline_sides = array<vec3f, 2>(across / dot(u, across), upward / dot(v, upward));
}

fn outline_has_sides() -> bool { return any(outline_sides[0] != vec3f(0.0)); }

// The direction of the first half side.
fn outline_side() -> vec3f { return cross(outline_sides[1], outline.axis); }

// Leaves what is above the plane through the receiver with this normal; no corners where nothing is.
fn outline_keep_above(normal: vec3f) {
    let corners = outline_corners;
    let count = outline.count;
    var is_above = true;
    for (var i = 0u; i < count; i++) {
        is_above = is_above && dot(normal, corners[i]) >= 0.0;
    }
    if (is_above) {
        return;
    }
    outline.is_clipped = true;
    outline.count = 0u;
    for (var i = 0u; i < count; i++) {
        let p = corners[i];
        let q = corners[select(i + 1u, 0u, i + 1u == count)];
        let h = dot(normal, p);
        let g = dot(normal, q);
        if (h >= 0.0) {
            outline_push(p);
        }
        if ((h >= 0.0) != (g >= 0.0)) {
            outline_push(p + (q - p) * (h / (h - g)));
        }
    }
    if (outline.count > 0u && outline_is_last(outline_corners[0])) {
        outline.count -= 1u;
    }
    if (outline.count < 3u) {
        outline.count = 0u;
    }
}

// Whether a point is the last corner, but for rounding.
fn outline_is_last(p: vec3f) -> bool {
    let apart = outline_corners[max(outline.count, 1u) - 1u] - p;
    return outline.count > 0u && dot(apart, apart) <= 1e-11 * dot(p, p);
}

fn outline_push(p: vec3f) {
    if (outline.count < OUTLINE_ROOM && !outline_is_last(p)) {
        outline_corners[outline.count] = p;
        outline.count += 1u;
    }
}

// The first direction of a frame whose third is the axis, as near to `across` as that allows; the second is `cross(axis, right)`.
fn outline_frame(across: vec3f) -> vec3f {
    let axis = outline.axis;
    let aside = across - axis * dot(across, axis);
    let square = dot(aside, aside);
    if (square > 1e-10 * dot(across, across) && square > 1e-30 && square < 3e38) {
        var right = aside / sqrt(square);
        right -= axis * dot(right, axis);
        return right / sqrt(dot(right, right));
    }
    return orthonormal_basis_u(axis);
}

// Fills `outline_points`.
fn outline_project(right: vec3f) {
    let up = cross(outline.axis, right);
    for (var i = 0u; i < outline.count; i++) {
        outline_points[i] = vec2f(dot(right, outline_corners[i]), dot(up, outline_corners[i])) / outline.height;
    }
    outline_point_count = outline.count;
}

// The point of the projected outline next to `p`.
fn outline_nearest(p: vec2f) -> vec2f {
    var best = p;
    var least = 3e38;
    var is_inside = true;
    var previous = outline_points[outline_point_count - 1u];
    for (var i = 0u; i < outline_point_count; i++) {
        let corner = outline_points[i];
        let edge = corner - previous;
        let to = p - previous;
        is_inside = is_inside && edge.x * to.y - edge.y * to.x >= 0.0;
        let square = dot(edge, edge);
        let t = select(0.0, clamp(dot(edge, to) / square, 0.0, 1.0), square > 0.0);
        let here = previous + edge * t;
        let apart = here - p;
        if (dot(apart, apart) < least) {
            best = here;
            least = dot(apart, apart);
        }
        previous = corner;
    }
    return select(best, p, is_inside);
}

// Middle and radius on the plane at distance 1, of a disc.
fn outline_circle(right: vec3f) -> vec3f {
    let up = cross(outline.axis, right);
    return vec3f(dot(right, outline.center), dot(up, outline.center), outline.radius) / outline.height;
}

// A cone around all of it; an empty one toward `middle` where there is none.
fn outline_cone(middle: vec3f) -> Cone {
    if (outline.count == 0u) {
        let length = sqrt(dot(middle, middle));
        let is_there = length > 0.0 && length < 3e38;
        return Cone(select(vec3f(0.0, 0.0, 1.0), middle / length, is_there), 0.0, max(length, 1.1754944e-38));
    }
    let toward = outline.center / sqrt(dot(outline.center, outline.center));
    var fall = 0.0;
    var depth = 0.0;
    for (var i = 0u; i < outline.count; i++) {
        let p = outline_corners[i];
        let apart = p / sqrt(dot(p, p)) - toward;
        fall = max(fall, 0.5 * dot(apart, apart));
        depth = max(depth, dot(p, toward));
    }
    if (fall > OUTLINE_WIDEST) {
        return Cone(outline.axis, 1.0, 3e38);
    }
    let cos = 1.0 - fall;
    return Cone(toward, fall, depth / (cos * cos));
}
