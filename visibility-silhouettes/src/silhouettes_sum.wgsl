// Sums of the directions of edges, by which masks are turned.

// The sum of edges, and the sum with four times their angles.
var<workgroup> silhouettes_sums: array<atomic<i32>, 4>;
// The window whose edges are summed, and the light in front of which they are.
var<private> silhouettes_window: Cone;
var<private> silhouettes_light: Cone;

// Adds the part of an edge in front of the window to the directions that a mask is turned by.
fn silhouettes_add(eye: SilhouetteEye, a: vec3f, b: vec3f) {
    // A flat light's cone may be a hemisphere.
    let light = silhouettes_light;
    let far = eye.far;
    let depth = vec2f(dot(a, light.axis), dot(b, light.axis));
    // An edge that passes beside the receiver, far outside the disc of a light at infinity, has a depth of nothing but rounding.
    let beside = SILHOUETTES_BESIDE * sqrt(dot(a, a) + dot(b, b));
    let near = select(1e-6 * min(light.distance, 1.0), beside, light.distance > 1e30);
    // Behind the light or the receiver only some edges are listed, so none counts.
    if (all(depth < vec2f(near)) || all(depth > vec2f(far))) {
        return;
    }
    let edge = b - a;
    var first = a;
    var last = b;
    for (var k = 0u; k < 2u; k++) {
        let limit = select(near, far, k == 1u);
        let is_out = select((depth < vec2f(limit)), (depth > vec2f(limit)), vec2<bool>(k == 1u));
        let cut = a + edge * ((limit - depth.x) / (depth.y - depth.x));
        first = select(first, cut, is_out.x);
        last = select(last, cut, is_out.y);
    }
    let normal = cross(first, last - first);
    let length = silhouettes_length(silhouettes_window, first, last, normal);
    if (!(length > 0.0 && silhouettes_length(light, first, last, normal) > 0.0)) {
        return;
    }
    let frame = edges_frame_of(silhouettes_window);
    let d = vec2f(dot(frame.right, normal), dot(frame.up, normal));
    let square = dot(d, d);
    if (!(square > 0.0 && length < 1e4)) {
        return;
    }
    let two = vec2f(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y) / square;
    let four = vec2f(two.x * two.x - two.y * two.y, 2.0 * two.x * two.y);
    let all = vec4i(vec4f(two, four) * (length * EDGES_STEPS));
    atomicAdd(&silhouettes_sums[0], all.x);
    atomicAdd(&silhouettes_sums[1], all.y);
    atomicAdd(&silhouettes_sums[2], all.z);
    atomicAdd(&silhouettes_sums[3], all.w);
}

// The length of an edge in front of the disc of a light, in its radii; not above zero if no part is.
fn silhouettes_length(cone: Cone, a: vec3f, b: vec3f, normal: vec3f) -> f32 {
    let tan = cone_tan(cone);
    let along = dot(normal, cone.axis);
    let across = normal - cone.axis * along;
    let square = dot(across, across);
    // The line passes the disc's centre at |n·axis|/|n − axis(n·axis)|; from it half the chord follows.
    let half = sqrt(max(1.0 - along * along / (square * (tan * tan)), 0.0));
    let line = cross(cone.axis, normal);
    let scale = max(sqrt(square) * tan, 1e-37);
    let start = dot(a, line) / (scale * dot(a, cone.axis));
    let end = dot(b, line) / (scale * dot(b, cone.axis));
    return min(max(start, end), half) - max(min(start, end), -half);
}
