// Edges of meshes, and which of them are silhouettes before a receiver's light: `select.rs` and `hull.rs`. Reads `frame`, calls
// the functions `any_hit…` of `GpuBlockers`. SILHOUETTES_DEPTH is the depth of the hierarchy.

// Rounding of the distance of a box from a plane, relative to its numbers.
const SILHOUETTES_ROUNDING = 2e-6;

// The outline of a flat light, or an octagon around it, as `Beside`: inward normals of planes through the receiver and its sides, and its
// corners on the plane at distance 1.
var<private> silhouettes_planes: array<vec3f, SILHOUETTES_CORNERS>;
var<private> silhouettes_corners: array<vec3f, SILHOUETTES_CORNERS>;
var<private> silhouettes_plane_count: u32;
var<private> silhouettes_margin: f32;

// A receiver and its light.
struct SilhouetteEye {
    // The start of rays, and its |x| + |y| + |z|.
    x: vec3f,
    reach: f32,
    cone: Cone,
    // Unit vectors across the light.
    u: vec3f,
    v: vec3f,
    // The axis times tan θ: the inward normals of a square around the disc are this ± u and ± v.
    slope: vec3f,
    // Wide lights have no such square.
    is_wide: bool,
    // Depth of the circle where the cone touches the light.
    far: f32,
}

fn silhouettes_eye(at: Receiver, cone: Cone) -> SilhouetteEye {
    let x = any_hit_leave(at);
    let tan = SILHOUETTES_AROUND * cone_tan(cone);
    silhouettes_set_outline();
    return SilhouetteEye(
        x,
        silhouettes_reach(x),
        cone,
        orthonormal_basis_u(cone.axis),
        orthonormal_basis_v(cone.axis),
        cone.axis * tan,
        cone.one_minus_cos >= 0.9,
        silhouettes_far(cone)
    );
}

fn silhouettes_set_outline() {
    let axis = light_plane().xyz;
    var middle = vec3f(0.0);
    for (var i = 0u; i < light_corner_count(); i++) {
        middle += light_corner(i) / f32(light_corner_count());
    }
    var square = 0.0;
    for (var i = 0u; i < light_corner_count(); i++) {
        let apart = light_corner(i) - middle;
        square = max(square, dot(apart, apart));
    }
    silhouettes_margin = SILHOUETTES_MARGIN * sqrt(square);
    silhouettes_plane_count = min(light_corner_count(), SILHOUETTES_CORNERS);
    if (light_corner_count() > SILHOUETTES_CORNERS) {
        silhouettes_push_around();
    } else {
        for (var i = 0u; i < light_corner_count(); i++) {
            silhouettes_corners[i] = light_corner(i);
        }
    }
    let count = silhouettes_plane_count;
    for (var i = 0u; i < count; i++) {
        let p = silhouettes_corners[i];
        let q = silhouettes_corners[select(i + 1u, 0u, i + 1u == count)];
        let normal = cross(p, q - p);
        let aside = normal - axis * dot(axis, normal);
        let length = sqrt(dot(aside, aside));
        // The direction of a shorter side is rounding.
        let bounds = length > SILHOUETTES_SHORTEST * silhouettes_margin;
        silhouettes_planes[i] = select(vec3f(0.0), normal / max(length, 1.1754944e-38), bounds) + axis * silhouettes_margin;
    }
}

// An octagon around an outline of many corners, along the longest way between two of them.
fn silhouettes_push_around() {
    let axis = light_plane().xyz;
    let half = light_corner_count() / 2u;
    var long = vec3f(0.0);
    for (var i = 0u; i < half; i++) {
        let across = light_corner(i + half) - light_corner(i);
        long = select(long, across, dot(across, across) > dot(long, long));
    }
    let aside = long - axis * dot(axis, long);
    let length = sqrt(dot(aside, aside));
    let u = select(orthonormal_basis_u(axis), aside / length, length > 0.0);
    let v = cross(axis, u);
    var low = vec2f(3e38);
    var high = vec2f(-3e38);
    for (var i = 0u; i < light_corner_count(); i++) {
        let p = vec2f(dot(u, light_corner(i)), dot(v, light_corner(i)));
        low = min(low, p);
        high = max(high, p);
    }
    // Corners of the box, cut at 45° about a middle that stretches it to a square.
    let center = 0.5 * (low + high);
    let size = max(0.5 * (high - low), vec2f(1.1754944e-38));
    for (var k = 0u; k < 4u; k++) {
        let mirror = vec2f(select(-1.0, 1.0, k < 2u), select(-1.0, 1.0, k == 1u || k == 2u));
        var cut = -3e38;
        for (var i = 0u; i < light_corner_count(); i++) {
            let p = vec2f(dot(u, light_corner(i)), dot(v, light_corner(i)));
            let at = mirror * (p - center) / size;
            cut = max(cut, at.x + at.y);
        }
        // From the box's side to the cut, and from the cut to the next side.
        let rest = clamp(cut - 1.0, 0.0, 1.0);
        let is_odd = mirror.x * mirror.y > 0.0;
        let first = center + mirror * select(vec2f(rest, 1.0), vec2f(1.0, rest), is_odd) * size;
        let second = center + mirror * select(vec2f(1.0, rest), vec2f(rest, 1.0), is_odd) * size;
        silhouettes_corners[2u * k] = u * first.x + v * first.y + axis;
        silhouettes_corners[2u * k + 1u] = u * second.x + v * second.y + axis;
    }
}

// Whether an edge certainly passes beside a flat light, or lies behind its plane.
fn silhouettes_beside_outline(a: vec3f, b: vec3f) -> bool {
    let plane = light_plane();
    let is_behind = dot(plane.xyz, a) > plane.w && dot(plane.xyz, b) > plane.w;
    return silhouettes_plane_count > 0u && (is_behind || silhouettes_misses(a, b));
}

// Whether a segment certainly passes beside a flat light: one of the outline's sides or the segment's own line parts them.
fn silhouettes_misses(a: vec3f, b: vec3f) -> bool {
    let count = silhouettes_plane_count;
    var beside = false;
    let normal = cross(a, b - a);
    var low = 3e38;
    var high = -3e38;
    for (var i = 0u; i < count; i++) {
        let n = silhouettes_planes[i];
        beside = beside || max(dot(n, a), dot(n, b)) < 0.0;
        let at = dot(normal, silhouettes_corners[i]);
        low = min(low, at);
        high = max(high, at);
    }
    let size = sqrt(dot(normal, normal)) * silhouettes_margin;
    return count > 0u && (beside || low > size || high < -size);
}

// Depth of the circle where a cone touches its light.
fn silhouettes_far(cone: Cone) -> f32 {
    let cos = cone_cos(cone);
    return select(cone.distance * cos * cos, 3e38, cone.distance > 1e30);
}

// Distances of a point, relative to the receiver, inside the square's sides.
fn silhouettes_sides(eye: SilhouetteEye, p: vec3f) -> vec4f {
    let across = vec2f(dot(eye.u, p), dot(eye.v, p));
    return dot(eye.slope, p) + vec4f(across, -across);
}

// Whether a child of a node may have silhouettes in front of the light. Its three rows begin at `row`.
fn silhouettes_meet(eye: SilhouetteEye, row: u32) -> bool {
    let middle = bitcast<vec4f>(silhouettes_data[row]);
    let half = bitcast<vec3f>(silhouettes_data[row + 1u].xyz);
    let normals = bitcast<vec3f>(silhouettes_data[row + 2u].xyz);
    let to = middle.xyz - eye.x;
    let size = abs(to) + half;
    let rounding = SILHOUETTES_ROUNDING * (eye.reach + (size.x + size.y) + size.z);
    let along = dot(eye.cone.axis, to);
    let deep = dot(abs(eye.cone.axis), half) + rounding;
    if (along + deep < 0.0 || along - deep > eye.far) {
        return false;
    }
    if (!eye.is_wide) {
        // |n| is below 12 for all four.
        let reaches = vec4f(
            dot(abs(eye.slope + eye.u), half), dot(abs(eye.slope + eye.v), half),
            dot(abs(eye.slope - eye.u), half), dot(abs(eye.slope - eye.v), half)
        );
        if (any(silhouettes_sides(eye, to) + reaches + 12.0 * rounding < vec4f(0.0))) {
            return false;
        }
    }
    // If all normals of the cone are on one side, none of its edges is a silhouette.
    let away = sqrt(dot(size, size));
    let unsure = (away + eye.reach) * (2.0 * SILHOUETTES_UNSURE);
    return abs(dot(to, normals)) - dot(half, abs(normals)) - unsure <= away * middle.w;
}

// The growth of the number of surfaces from left to right across an edge, looking from its first end to the second; 0 if it is not
// a silhouette, or certainly not in front of the light.
fn silhouettes_step(eye: SilhouetteEye, edge: u32) -> i32 {
    let ends = silhouettes_data[silhouettes_data[0].w + edge];
    let a = silhouettes_from(eye.x, ends.x);
    let b = silhouettes_from(eye.x, ends.y);
    if (!eye.is_wide) {
        if (any(max(silhouettes_sides(eye, a), silhouettes_sides(eye, b)) < vec4f(0.0))) {
            return 0;
        }
    }
    var step = 0;
    for (var k = 0u; k < 2u; k++) {
        let side = silhouettes_side(eye.x, select(ends.z, ends.w, k == 1u));
        step += select(side, -side, k == 1u);
    }
    if (step != 0 && ((!eye.is_wide && silhouettes_beside(eye, a, b)) || silhouettes_beside_outline(a, b))) {
        return 0;
    }
    return step;
}

// Whether an edge certainly passes beside the disc of the light, with its part between the receiver and the light's plane.
fn silhouettes_beside(eye: SilhouetteEye, a: vec3f, b: vec3f) -> bool {
    let axis = eye.cone.axis;
    let cos = cone_cos(eye.cone);
    let edge = b - a;
    // The plane through the edge and the receiver misses the disc: |n·axis| > |n| sin θ.
    let normal = cross(a, edge);
    let along = abs(dot(normal, axis)) - sqrt(dot(a, a) * dot(edge, edge)) * 1e-6;
    if (along > sqrt(dot(normal, normal) * (cone_sin_sq(eye.cone) * SILHOUETTES_AROUND_SQ))) {
        return true;
    }
    // Parts behind the light's plane do not count.
    var first = a;
    var last = b;
    var depth = vec2f(dot(a, axis), dot(b, axis));
    let is_far = depth > vec2f(eye.far);
    if (all(is_far)) {
        return true;
    }
    if (any(is_far)) {
        let cut = a + edge * ((eye.far - depth.x) / (depth.y - depth.x));
        first = select(a, cut, is_far.x);
        last = select(b, cut, is_far.y);
        depth = min(depth, vec2f(eye.far));
    }
    // Or the edge ends before it reaches the disc: the sign of d/dt of the squared cosine at an end tells whether it comes nearer
    // from there on. An end behind the receiver is on the far side of the other one.
    let front = depth > vec2f(0.0);
    let across = dot(edge, axis);
    let squares = vec2f(dot(first, first), dot(last, last));
    let turns = across * squares - depth * vec2f(dot(first, edge), dot(last, edge));
    let leaves = turns.x < 0.0 && (turns.y < 0.0 || !front.y);
    let comes = turns.y > 0.0 && (turns.x > 0.0 || !front.x);
    let outside = (depth * depth < squares * (cos * cos * (2.0 - SILHOUETTES_AROUND_SQ))) | !front;
    return !any(front) || ((leaves || comes) && all(outside));
}

// The place of the triangles that the light's plane may cut, three rows each, and their number.
fn silhouettes_near() -> vec2u {
    let lights = silhouettes_data[1].xy;
    if (!light_is_flat() || frame.number >= lights.y) {
        return vec2u(0u);
    }
    return silhouettes_data[lights.x + frame.number].xy;
}

// Coverage of the light by the receiver's own facet.
fn silhouettes_facet(at: Receiver, cone: Cone) -> u32 {
    if (!any_hit_has(at.object)) {
        return LIT;
    }
    return facet_coverage(at, cone);
}
