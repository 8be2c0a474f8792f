// Coverage of the light, as `SilhouetteBlockers::select`.

// The most waiting nodes: a node's siblings wait on each level.
const SILHOUETTES_WAITING = 7u * SILHOUETTES_DEPTH + 8u;

// Whether any silhouette is in front of the light.
fn silhouettes_any(eye: SilhouetteEye) -> bool {
    var stack: array<u32, SILHOUETTES_WAITING>;
    let nodes = silhouettes_data[0].x;
    var waiting = 1u;
    stack[0] = 0u;
    while (waiting > 0u) {
        waiting -= 1u;
        let row = nodes + 24u * stack[waiting];
        for (var k = 0u; k < 8u; k++) {
            let child = row + 3u * k;
            let count = silhouettes_data[child + 2u].w;
            if (count == SILHOUETTES_NONE) {
                break;
            }
            if (!silhouettes_meet(eye, child)) {
                continue;
            }
            let first = silhouettes_data[child + 1u].w;
            if (count == 0u && waiting < SILHOUETTES_WAITING) {
                stack[waiting] = first;
                waiting += 1u;
            }
            for (var edge = first; edge < first + count; edge++) {
                if (silhouettes_step(eye, edge) != 0) {
                    return true;
                }
            }
        }
    }
    return false;
}

// Whether a flat light's plane cuts any triangle near it, not certainly beside it.
fn silhouettes_are_clipped(eye: SilhouetteEye) -> bool {
    let near = silhouettes_near();
    let plane = light_plane();
    for (var row = near.x; row < near.x + 3u * near.y; row += 3u) {
        var corners: array<vec3f, 3>;
        var heights: vec3f;
        for (var k = 0u; k < 3u; k++) {
            corners[k] = bitcast<vec3f>(silhouettes_data[row + k].xyz) - eye.x;
            heights[k] = dot(plane.xyz, corners[k]) - plane.w;
        }
        let behind = heights >= vec3f(0.0);
        if (!any(behind) || all(behind)) {
            continue;
        }
        // Two of its sides cross the plane.
        var ends: array<vec3f, 2>;
        var count = 0u;
        for (var k = 0u; k < 3u; k++) {
            let next = (k + 1u) % 3u;
            if (behind[k] != behind[next]) {
                let part = clamp(heights[k] / (heights[k] - heights[next]), 0.0, 1.0);
                ends[count] = corners[k] + part * (corners[next] - corners[k]);
                count = 1u;
            }
        }
        if (!silhouettes_misses(ends[0], ends[1])) {
            return true;
        }
    }
    return false;
}

fn silhouettes_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {
    let facet = silhouettes_facet(at, cone);
    if (facet == DARK) {
        return DARK;
    }
    let eye = silhouettes_eye(at, cone);
    if (cone.one_minus_cos > 0.0 && (facet == PARTIAL || silhouettes_any(eye) || silhouettes_are_clipped(eye))) {
        return PARTIAL;
    }
    // The number of surfaces is the same in front of the whole light.
    var toward = cone.axis;
    var far = eye.far;
    if (light_is_flat()) {
        toward = light_middle();
        far = light_distance(toward);
    }
    return select(LIT, DARK, any_hit(eye.x, toward, far));
}
