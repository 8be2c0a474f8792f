// The silhouettes of a receiver, found by a workgroup: they are summed (silhouettes_sum.wgsl) or drawn (silhouettes_count.wgsl).
//
// The threads search the hierarchy together, one thread for a child of a node, then the edges of the leaves. All sums are of
// integers, so no order of the threads changes a mask.

const SILHOUETTES_NODES = 4u;
// Silhouettes that are kept for the next mask of the receiver, if these are all; a round finds up to eight in a leaf.
const SILHOUETTES_ROOM = 480u;

// Edges and their steps; their number.
var<workgroup> silhouettes_list: array<u32, SILHOUETTES_ROOM>;
var<workgroup> silhouettes_found: atomic<u32>;
// Whether the list has all silhouettes of the receiver.
var<workgroup> silhouettes_known: u32;
// Whether edges are summed; otherwise they are drawn.
var<private> silhouettes_adds: bool;

// Draws or sums all silhouettes of the receiver. Requires uniform control flow.
fn silhouettes_each(lane: u32, eye: SilhouetteEye) {
    let is_known = workgroupUniformLoad(&silhouettes_known) != 0u;
    if (!is_known) {
        if (lane == 0u) {
            silhouettes_begin();
            atomicStore(&silhouettes_found, 0u);
        }
        workgroupBarrier();
    }
    var is_whole = true;
    loop {
        let is_last = is_known || silhouettes_list_more(lane, eye);
        silhouettes_use(lane, eye, atomicLoad(&silhouettes_found));
        workgroupBarrier();
        if (is_last) {
            break;
        }
        is_whole = false;
        if (lane == 0u) {
            atomicStore(&silhouettes_found, 0u);
        }
    }
    if (lane == 0u && is_whole) {
        silhouettes_known = 1u;
    }
    workgroupBarrier();
}

// Continues the search of the hierarchy until the list may be too short for another round; returns true at the end.
fn silhouettes_list_more(lane: u32, eye: SilhouetteEye) -> bool {
    var is_last = false;
    loop {
        if (lane == 0u) {
            let is_full = atomicLoad(&silhouettes_found) > SILHOUETTES_ROOM - 8u * SILHOUETTES_LEAVES;
            silhouettes_begin_round(select(SILHOUETTES_NODES, 0u, is_full));
        }
        let plan = workgroupUniformLoad(&silhouettes_plan);
        if (plan.y == 0u) {
            is_last = plan.x == 0u;
            break;
        }
        let row = silhouettes_child(lane, plan);
        let is_met = row != SILHOUETTES_NONE && silhouettes_meet(eye, row);
        workgroupBarrier();
        if (is_met) {
            silhouettes_keep(row);
        }
        workgroupBarrier();
        let edges = 8u * atomicLoad(&silhouettes_leaf_count);
        for (var e = lane; e < edges; e += LANES) {
            let edge = silhouettes_leaf_edge(e);
            if (edge != SILHOUETTES_NONE) {
                let step = silhouettes_step(eye, edge);
                if (step != 0) {
                    silhouettes_list[atomicAdd(&silhouettes_found, 1u)] = 8u * edge + u32(step + 2);
                }
            }
        }
        workgroupBarrier();
    }
    return is_last;
}

// Draws or sums the edges of the list.
fn silhouettes_use(lane: u32, eye: SilhouetteEye, count: u32) {
    for (var k = lane; k < count; k += LANES) {
        let entry = silhouettes_list[k];
        let ends = silhouettes_data[silhouettes_data[0].w + entry / 8u];
        let a = silhouettes_from(eye.x, ends.x);
        let b = silhouettes_from(eye.x, ends.y);
        if (silhouettes_adds) {
            silhouettes_add(eye, a, b);
            continue;
        }
        silhouettes_draw(a, b, i32(entry % 8u) - 2);
    }
}
