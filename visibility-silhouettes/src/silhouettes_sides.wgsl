// Corners of meshes, and on which sides of triangles a receiver lies: `select.rs` and `hull.rs`. Calls `any_hit_side` of `GpuBlockers`.

// |x| + |y| + |z| of the start of rays.
fn silhouettes_reach(x: vec3f) -> f32 {
    let size = abs(x);
    return (size.x + size.y) + size.z;
}

// A corner as seen from a point.
fn silhouettes_from(x: vec3f, corner: u32) -> vec3f {
    return bitcast<vec3f>(silhouettes_data[silhouettes_data[0].y + corner].xyz) - x;
}

// 1 if the receiver is in front of a triangle, −1 behind it, 0 if there is none. The same for all edges of the triangle: in f32 if
// that is certain, else from its corners.
fn silhouettes_side(x: vec3f, triangle: u32) -> i32 {
    if (triangle == SILHOUETTES_NONE) {
        return 0;
    }
    let row = silhouettes_data[0].z + 2u * triangle;
    let plane = bitcast<vec4f>(silhouettes_data[row]);
    if (all(plane.xyz == vec3f(0.0))) {
        return 0;
    }
    var value = dot(plane.xyz, x) + plane.w;
    if (abs(value) <= SILHOUETTES_UNSURE * (abs(plane.w) + silhouettes_reach(x))) {
        let corners = silhouettes_data[row + 1u].xyz + silhouettes_data[0].y;
        value = any_hit_side(
            bitcast<vec3f>(silhouettes_data[corners.x].xyz),
            bitcast<vec3f>(silhouettes_data[corners.y].xyz),
            bitcast<vec3f>(silhouettes_data[corners.z].xyz),
            x
        );
    }
    return select(select(0, -1, value < 0.0), 1, value > 0.0);
}
