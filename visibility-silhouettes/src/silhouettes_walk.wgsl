// The search of the hierarchy by a workgroup, one thread for a child of a node, then the edges of the leaves. SILHOUETTES_NODES is the number of
// nodes that a round visits, with eight threads each.

const SILHOUETTES_LEAVES = 8u * SILHOUETTES_NODES;
// The most waiting nodes: on each level the children that a round finds, minus those that the next one takes.
const SILHOUETTES_STACK = 7u * SILHOUETTES_DEPTH * SILHOUETTES_NODES + 8u;

var<workgroup> silhouettes_stack: array<u32, SILHOUETTES_STACK>;
var<workgroup> silhouettes_waiting: atomic<u32>;
var<workgroup> silhouettes_leaves: array<vec2u, SILHOUETTES_LEAVES>;
var<workgroup> silhouettes_leaf_count: atomic<u32>;
// The first thread's values for all threads: the nodes that wait, and those of this round.
var<workgroup> silhouettes_plan: vec2u;

// Begins at the root, by one thread.
fn silhouettes_begin() {
    silhouettes_stack[0] = 0u;
    atomicStore(&silhouettes_waiting, 1u);
}

// Begins a round of no more nodes than `most`, by one thread.
fn silhouettes_begin_round(most: u32) {
    let waiting = atomicLoad(&silhouettes_waiting);
    let next = min(waiting, most);
    atomicStore(&silhouettes_waiting, waiting - next);
    atomicStore(&silhouettes_leaf_count, 0u);
    silhouettes_plan = vec2u(waiting - next, next);
}

// The first of three rows of a thread's child in a round, SILHOUETTES_NONE where it has none.
fn silhouettes_child(lane: u32, plan: vec2u) -> u32 {
    if (lane / 8u >= plan.y) {
        return SILHOUETTES_NONE;
    }
    let row = silhouettes_data[0].x + 24u * silhouettes_stack[plan.x + lane / 8u] + 3u * (lane % 8u);
    return select(row, SILHOUETTES_NONE, silhouettes_data[row + 2u].w == SILHOUETTES_NONE);
}

// Keeps a child for later: a node, or a leaf with its edges.
fn silhouettes_keep(row: u32) {
    let first = silhouettes_data[row + 1u].w;
    let count = silhouettes_data[row + 2u].w;
    if (count != 0u) {
        silhouettes_leaves[atomicAdd(&silhouettes_leaf_count, 1u)] = vec2u(first, count);
        return;
    }
    let place = atomicAdd(&silhouettes_waiting, 1u);
    if (place < SILHOUETTES_STACK) {
        silhouettes_stack[place] = first;
    }
}

// Edge `e` of a round's leaves, eight for each; SILHOUETTES_NONE where there is none.
fn silhouettes_leaf_edge(e: u32) -> u32 {
    let leaf = silhouettes_leaves[e / 8u];
    return select(SILHOUETTES_NONE, leaf.x + e % 8u, e % 8u < leaf.y);
}
