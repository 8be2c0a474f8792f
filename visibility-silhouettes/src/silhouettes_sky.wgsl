// Silhouettes before a whole sky, by a workgroup of LANES threads: `Looker` of look.rs for meshes without simplified forms.

const SILHOUETTES_NODES = LANES / 8u;

// Whether a child of a node may have silhouettes above the horizon that cross a meridian. Its three rows begin at `row`.
fn silhouettes_sky_meets(x: vec3f, row: u32) -> bool {
    let middle = bitcast<vec4f>(silhouettes_data[row]);
    let half = bitcast<vec3f>(silhouettes_data[row + 1u].xyz);
    let to = middle.xyz - x;
    let far = length(abs(to) + half);
    let unsure = (far + silhouettes_reach(x)) * (2.0 * SILHOUETTES_UNSURE);
    if (dot(to, sky_horizon.normal) + dot(half, abs(sky_horizon.normal)) < -unsure) {
        return false;
    }
    // If all normals of the cone are on one side, none of its edges is a silhouette.
    let normals = bitcast<vec3f>(silhouettes_data[row + 2u].xyz);
    if (abs(dot(to, normals)) - dot(half, abs(normals)) - unsure > far * middle.w) {
        return false;
    }
    return sky_may_cross(to, half);
}

// Draws an edge if it is a silhouette and crosses a meridian.
fn silhouettes_sky_edge(x: vec3f, edge: u32) {
    let ends = silhouettes_data[silhouettes_data[0].w + edge];
    let arc = sky_arc(silhouettes_from(x, ends.x), silhouettes_from(x, ends.y));
    if (arc.rows == 0) {
        return;
    }
    var step = 0;
    for (var k = 0u; k < 2u; k++) {
        let side = silhouettes_side(x, select(ends.z, ends.w, k == 1u));
        // To the right as the receiver sees it; masks are seen from the light.
        step += select(-side, side, k == 1u);
    }
    if (step != 0) {
        // Of closed surfaces only the triangles count that face one way.
        let triangle = select(ends.z, ends.w, ends.z == SILHOUETTES_NONE);
        let is_closed = silhouettes_data[silhouettes_data[0].z + 2u * triangle + 1u].w != 0u;
        sky_draw_arc(arc, select(2 * step, step, is_closed));
    }
}

// Draws all silhouettes of the receiver. Requires uniform control flow.
fn silhouettes_sky(lane: u32, at: Receiver) {
    let x = any_hit_leave(at);
    if (lane == 0u) {
        silhouettes_begin();
    }
    workgroupBarrier();
    loop {
        if (lane == 0u) {
            silhouettes_begin_round(SILHOUETTES_NODES);
        }
        let plan = workgroupUniformLoad(&silhouettes_plan);
        if (plan.y == 0u) {
            break;
        }
        let row = silhouettes_child(lane, plan);
        let is_met = row != SILHOUETTES_NONE && silhouettes_sky_meets(x, row);
        workgroupBarrier();
        if (is_met) {
            silhouettes_keep(row);
        }
        workgroupBarrier();
        let edges = 8u * atomicLoad(&silhouettes_leaf_count);
        for (var e = lane; e < edges; e += LANES) {
            let edge = silhouettes_leaf_edge(e);
            if (edge != SILHOUETTES_NONE) {
                silhouettes_sky_edge(x, edge);
            }
        }
        workgroupBarrier();
    }
}

// Whether a surface lies in a direction.
fn silhouettes_sky_hides(at: Receiver, direction: vec3f) -> bool {
    return any_hit(any_hit_leave(at), direction, SILHOUETTES_SKY_FAR);
}

fn silhouettes_sky_has_facet(at: Receiver) -> bool { return any_hit_has(at.object); }
