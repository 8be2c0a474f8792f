// Results that the threads of a workgroup compute together.

var<workgroup> totals: array<vec4f, LANES>;
var<workgroup> whole_total: vec4f;
var<workgroup> decision: bool;

// The sum over all threads, always in the same order, and the same for each thread. Requires uniform control flow.
fn total(lane: u32, value: vec4f) -> vec4f {
    totals[lane] = value;
    workgroupBarrier();
    if (lane < 8u) {
        var sum = totals[lane];
        for (var k = lane + 8u; k < LANES; k += 8u) {
            sum += totals[k];
        }
        totals[lane] = sum;
    }
    workgroupBarrier();
    if (lane == 0u) {
        whole_total = ((totals[0] + totals[4]) + (totals[2] + totals[6])) + ((totals[1] + totals[5]) + (totals[3] + totals[7]));
    }
    return workgroupUniformLoad(&whole_total);
}

// The largest of each component. Requires uniform control flow.
fn largest(lane: u32, value: vec4f) -> vec4f {
    totals[lane] = value;
    workgroupBarrier();
    if (lane == 0u) {
        var most = totals[0];
        for (var k = 1u; k < LANES; k++) {
            most = max(most, totals[k]);
        }
        whole_total = most;
    }
    return workgroupUniformLoad(&whole_total);
}

// The first thread's value, for a decision that must be the same in all threads. Requires uniform control flow.
fn decide(lane: u32, what: bool) -> bool {
    if (lane == 0u) {
        decision = what;
    }
    return workgroupUniformLoad(&decision);
}
