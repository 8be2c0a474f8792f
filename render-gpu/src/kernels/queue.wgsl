// What `classify` leaves to the penumbra kernel, and the counters of a frame. Needs frame.wgsl.

// `count` items of `frame.queue_stride` words: the point (as an index into `points`), then its integral over the whole
// light for each reflectance lobe, one word or one a channel. Items of one light are in no order; each point is there at most once.
struct Queue {
    count: atomic<u32>,
    counters: array<atomic<u32>, 15>,
    items: array<u32>,
}
@group(0) @binding(4) var<storage, read_write> queue: Queue;

// Point–light pairs by what is seen of the light. `classify` counts as penumbra what it queues; the penumbra kernel moves to
// the others what it finds to be wholly lit or dark.
const LIT_POINTS = 0u;
const DARK_POINTS = 1u;
const PENUMBRA_POINTS = 2u;
// Integrals of reflectance lobes; lobes dropped below the threshold.
const INTEGRALS = 3u;
const PRUNED = 4u;
// Threads whose loops the driver has ended early.
const CUT = 5u;

// By the paper's method: marks a queued point that one blocker hides the whole light from.
const HIDDEN = 0x80000000u;

// A dispatch has at most so many workgroups along x.
const QUEUE_WIDEST = 32768u;

// Workgroups along x and y that take `count` items, one each: the item of a workgroup is `y * size.x + x`, below `count`.
fn queue_size(count: u32) -> vec2u {
    let rows = max((count + (QUEUE_WIDEST - 1u)) / QUEUE_WIDEST, 1u);
    return vec2u((count + (rows - 1u)) / rows, rows);
}

// Mesa's software driver ends a thread's loops after 65 535 rounds of all of them together, from then on each after one. Counts
// the threads that this has happened to: called last.
fn note_cut_loops() {
    var rounds = 0u;
    for (var k = 0u; k < frame.rounds; k++) {
        rounds++;
    }
    if (rounds < frame.rounds) {
        atomicAdd(&queue.counters[CUT], 1u);
    }
}

fn queue_point(item: u32) -> u32 {
    return queue.items[item * frame.queue_stride];
}

