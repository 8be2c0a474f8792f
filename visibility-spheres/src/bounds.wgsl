// A sphere around each block of spheres, one block a thread, as `Block::bounds`. The buffers are those of gpu.rs.

// Larger numbers are no floats.
const BOUNDS_EVERYTHING = 3e38;

@compute @workgroup_size(64)
fn bounds(@builtin(global_invocation_id) id: vec3u) {
    let block = id.x;
    if (block >= arrayLength(&spheres_bounds)) {
        return;
    }
    let first = block * SPHERE_BLOCK;
    let end = min(first + SPHERE_BLOCK, arrayLength(&spheres));
    var low = vec3f(BOUNDS_EVERYTHING);
    var high = vec3f(-BOUNDS_EVERYTHING);
    for (var k = first; k < end; k++) {
        let sphere = spheres[k];
        low = min(low, sphere.center - sphere.radius);
        high = max(high, sphere.center + sphere.radius);
    }
    let center = 0.5 * low + 0.5 * high;
    var reach = 0.0;
    for (var k = first; k < end; k++) {
        let sphere = spheres[k];
        let d = center - sphere.center;
        reach = max(reach, sqrt(dot(d, d)) + sphere.radius);
    }
    // Rounding of the distances is relative to them: the centre is exact by definition.
    reach *= 1.000001;
    // Not by the distances: squares overflow before them.
    let all = max(max(max(abs(low.x), abs(low.y)), abs(low.z)), max(max(abs(high.x), abs(high.y)), abs(high.z)));
    if (all < 1e18) {
        spheres_bounds[block] = vec4f(center, reach);
    } else {
        spheres_bounds[block] = vec4f(0.0, 0.0, 0.0, BOUNDS_EVERYTHING);
    }
}
