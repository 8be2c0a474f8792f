// Silhouettes before a whole sky, by a workgroup of LANES threads: `Looker` of look.rs for meshes without simplified forms.

// Nodes that a round visits, with eight threads each.
const SILHOUETTES_SKY_NODES = LANES / 8u;
const SILHOUETTES_SKY_LEAVES = 8u * SILHOUETTES_SKY_NODES;
// The most waiting nodes: on each level the children that a round finds, minus those that the next one takes.
const SILHOUETTES_SKY_STACK = 7u * SILHOUETTES_DEPTH * SILHOUETTES_SKY_NODES + 8u;

var<workgroup> silhouettes_stack: array<u32, SILHOUETTES_SKY_STACK>;
var<workgroup> silhouettes_waiting: atomic<u32>;
var<workgroup> silhouettes_leaves: array<vec2u, SILHOUETTES_SKY_LEAVES>;
var<workgroup> silhouettes_leaf_count: atomic<u32>;
// The first thread's values for all threads: the nodes that wait, and those of this round.
var<workgroup> silhouettes_plan: vec2u;

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
        silhouettes_stack[0] = 0u;
        atomicStore(&silhouettes_waiting, 1u);
    }
    workgroupBarrier();
    loop {
        if (lane == 0u) {
            let waiting = atomicLoad(&silhouettes_waiting);
            let next = min(waiting, SILHOUETTES_SKY_NODES);
            atomicStore(&silhouettes_waiting, waiting - next);
            atomicStore(&silhouettes_leaf_count, 0u);
            silhouettes_plan = vec2u(waiting - next, next);
        }
        let plan = workgroupUniformLoad(&silhouettes_plan);
        if (plan.y == 0u) {
            break;
        }
        var count = SILHOUETTES_NONE;
        var first = 0u;
        if (lane / 8u < plan.y) {
            let row = silhouettes_data[0].x + 24u * silhouettes_stack[plan.x + lane / 8u] + 3u * (lane % 8u);
            count = silhouettes_data[row + 2u].w;
            first = silhouettes_data[row + 1u].w;
            if (count != SILHOUETTES_NONE && !silhouettes_sky_meets(x, row)) {
                count = SILHOUETTES_NONE;
            }
        }
        workgroupBarrier();
        if (count == 0u) {
            let place = atomicAdd(&silhouettes_waiting, 1u);
            if (place < SILHOUETTES_SKY_STACK) {
                silhouettes_stack[place] = first;
            }
        } else if (count != SILHOUETTES_NONE) {
            silhouettes_leaves[atomicAdd(&silhouettes_leaf_count, 1u)] = vec2u(first, count);
        }
        workgroupBarrier();
        let edges = 8u * atomicLoad(&silhouettes_leaf_count);
        for (var e = lane; e < edges; e += LANES) {
            let leaf = silhouettes_leaves[e / 8u];
            if (e % 8u < leaf.y) {
                silhouettes_sky_edge(x, leaf.x + e % 8u);
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
