// The queue from `classify` to the penumbra kernel, and the counters of a frame.

// `count` items of `frame.queue_stride` words: the point (as an index into `points`), then for each reflectance lobe its integral
// over the whole light, in one word or one a colour channel. Items of one light are in no order; each point occurs at most once.
struct Queue {
    count: atomic<u32>,
    counters: array<atomic<u32>, QUEUE_COUNTERS>,
    items: array<u32>,
}

// By the paper's method: marks a queued point for which one blocker hides the whole light.
const HIDDEN = 0x80000000u;

// The most workgroups of a dispatch along x.
const QUEUE_WIDEST = 32768u;

// Number of workgroups along x and y for `count` items, one each. A workgroup takes the item `y * size.x + x`, if below `count`.
fn queue_size(count: u32) -> vec2u {
    let rows = max((count + (QUEUE_WIDEST - 1u)) / QUEUE_WIDEST, 1u);
    return vec2u((count + (rows - 1u)) / rows, rows);
}

// Counts this thread if the driver has ended its loops early; call it last. Mesa's software driver allows a thread 65 535 rounds of
// all its loops together, and ends each later loop after one round.
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

