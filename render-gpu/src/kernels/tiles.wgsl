// The parts that both `classify` kernels share: 64 threads, one tile, and its counters. Calls `classify_point(tile, point)`,
// which ends with `finish_point`.

// Coverage not computed yet.
const UNKNOWN = 3u;

var<workgroup> tally: array<atomic<u32>, 5>;

fn count(what: u32) {
    atomicAdd(&tally[what], 1u);
}

// Counts a point by its class, and adds the unshadowed radiance to a lit point.
fn finish_point(point: u32, coverage: u32, sum: vec3f) {
    if (coverage == LIT) {
        count(LIT_POINTS);
        radiance[point] += vec4f(sum, 0.0);
    } else if (coverage == DARK) {
        count(DARK_POINTS);
    } else if (coverage == PARTIAL) {
        count(PENUMBRA_POINTS);
    }
}

@compute @workgroup_size(64)
fn classify(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let tile = group.x;
    let point = tile * 64u + lane;
    if (point < frame.point_count) {
        classify_point(tile, point);
        note_cut_loops();
    }
    workgroupBarrier();
    if (lane < 5u) {
        atomicAdd(&queue.counters[lane], atomicLoad(&tally[lane]));
    }
}
