// Masks of what is lit where that is little of the light, as `NearMasks`. Needs mask.wgsl, total.wgsl, `blockers_splat` and
// `blockers_edge_bounds(lane, tile, at, light, window) -> vec4f`: the lower and the upper corner between which all edges are, or the whole window.

// Of masks that leave less than this part of what emits, those are drawn again that leave less than this part, or that have anything lit in less
// than so many of this number of rows.
const NEAR_LITTLE = 3.0;
const NEAR_LEAST = 40.0;
const NEAR_FEW = 3.0;
const NEAR_OF = 8.0;
// Masks of which this part is lit are fine enough.
const NEAR_FILLED = 4u;
// So many masks are drawn for a window at most.
const NEAR_MOST = 16u;
// A window around lit samples leaves so much room, in samples and in rows.
const NEAR_ROOM_SAMPLES = 2.0;
const NEAR_ROOM_ROWS = 1.0;
// No rectangle.
const NEAR_NOTHING = vec4f(1e30, 1e30, -1e30, -1e30);

// A window that is to be drawn, and what it may grow to: lower and upper corners.
struct NearJob { window: vec4f, limit: vec4f }

// The windows of broad lobes' masks, then those of a lobe of its own, and how many these are.
var<workgroup> near_windows: array<vec4f, 2u * NEAR_MOST>;
var<workgroup> near_counts: array<u32, 2>;
var<workgroup> near_jobs: array<NearJob, NEAR_MOST + 1u>;
// Jobs that wait, and masks that are left.
var<workgroup> near_plan: vec2u;
// Where a mask is divided: 1 along its samples, 2 along its rows, 0 not; and in the middle of which samples or rows.
var<workgroup> near_cut: vec2u;
var<workgroup> near_block: array<atomic<u32>, 4>;

fn near_rect(square: UnitSquare) -> vec4f { return vec4f(square.center - square.half, square.center + square.half); }

fn near_within(a: vec4f, b: vec4f) -> vec4f { return vec4f(max(a.xy, b.xy), min(a.zw, b.zw)); }

fn near_size(a: vec4f) -> vec2f { return max(a.zw - a.xy, vec2f(0.0)); }

fn near_area(a: vec4f) -> f32 {
    let size = near_size(a);
    return size.x * size.y;
}

// Bits of samples k and above, of those from `first` on.
fn near_from(k: u32, first: u32) -> u32 {
    let bits = max(k, first) - first;
    let half = min(bits, 32u) >> 1u;
    return (0xffffffffu << half) << (min(bits, 32u) - half);
}

// Samples and rows of a part of the mask, `.xy` and `.zw`, between which what is lit lies; the first is not below the second where nothing is.
// Requires uniform control flow.
fn near_lit_block(lane: u32, part: vec4u) -> vec4u {
    if (lane < 4u) {
        atomicStore(&near_block[lane], select(0u, 0xffffu, lane == 0u || lane == 2u));
    }
    workgroupBarrier();
    if (lane >= part.z && lane < part.w) {
        var ends = vec2u(0xffffu, 0u);
        for (var k = 0u; 32u * k < row_width; k++) {
            let first = 32u * k;
            let bits = row_samples(lit, k) & near_from(part.x, first) & ~near_from(part.y, first);
            if (bits != 0u) {
                ends = vec2u(min(ends.x, first + firstTrailingBit(bits)), first + firstLeadingBit(bits) + 1u);
            }
        }
        if (ends.x < ends.y) {
            atomicMin(&near_block[0], ends.x);
            atomicMax(&near_block[1], ends.y);
            atomicMin(&near_block[2], lane);
            atomicMax(&near_block[3], lane + 1u);
        }
    }
    workgroupBarrier();
    let block = vec4u(
        atomicLoad(&near_block[0]), atomicLoad(&near_block[1]), atomicLoad(&near_block[2]), atomicLoad(&near_block[3])
    );
    workgroupBarrier();
    return block;
}

fn near_all() -> vec4u { return vec4u(0u, row_width, 0u, SIDE); }

// Where what is lit of a block may lie in a mask's window.
fn near_around(window: vec4f, block: vec4u) -> vec4f {
    let sample = (window.zw - window.xy) / vec2f(f32(row_width), f32(SIDE));
    let room = vec2f(NEAR_ROOM_SAMPLES, NEAR_ROOM_ROWS);
    let low = window.xy + (vec2f(block.xz) - room) * sample;
    return vec4f(low, window.xy + (vec2f(block.yw) + room) * sample);
}

// The rectangle around what the mask of a part of the light shows, with that of others; one that is alone is left to `near_find`. Requires
// uniform control flow.
fn near_with(lane: u32, around: vec4f, square: UnitSquare, grid: vec2u) -> vec4f {
    if (all(grid == vec2u(1u))) {
        return around;
    }
    return near_union(lane, around, square);
}

fn near_union(lane: u32, around: vec4f, square: UnitSquare) -> vec4f {
    let block = near_lit_block(lane, near_all());
    if (block.x >= block.y) {
        return around;
    }
    let lit = near_around(near_rect(square), block);
    return vec4f(min(around.xy, lit.xy), max(around.zw, lit.zw));
}

// Finds the windows of a part of the light: `shown` is what its masks show to be lit, or nothing where it is one, drawn last; `areas` what
// `visibility_counts` says of all rows; masks are as `finer` says. Those of broad lobes are number 0, those of a lobe of its own 1. Requires uniform control
// flow.
fn near_find(
    lane: u32, tile: u32, at: Receiver, light: Cone, window: UnitSquare, shown: vec4f, areas: vec4f, number: u32, finer: bool
) {
    if (lane == 0u) {
        near_counts[number] = 0u;
    }
    let are_few = NEAR_LEAST * areas.x < areas.y || NEAR_OF * areas.z < NEAR_FEW * areas.w;
    if (!decide(lane, NEAR_LITTLE * areas.x < areas.y && are_few)) {
        return;
    }
    let limit = near_rect(window);
    var around = shown;
    if (decide(lane, shown.x > shown.z)) {
        around = near_union(lane, shown, window);
    }
    row_refine(finer);
    let edges = near_within(blockers_edge_bounds(lane, tile, at, light, window), limit);
    let is_by_edges = all(edges.xy <= edges.zw) && 2.0 * near_area(edges) <= near_area(limit);
    let first = near_within(select(around, edges, is_by_edges), limit);
    if (!decide(lane, first.x <= first.z)) {
        return;
    }
    if (lane == 0u) {
        near_jobs[0] = NearJob(first, limit);
        near_plan = vec2u(1u, NEAR_MOST);
    }
    loop {
        let plan = workgroupUniformLoad(&near_plan);
        if (plan.x == 0u) {
            break;
        }
        let job = near_jobs[plan.x - 1u];
        let mask = mask_reset(near_square(window, job.window), lane, at.normal);
        blockers_splat(lane, tile, at, light, mask);
        let block = near_lit_block(lane, near_all());
        let lit_count = total(lane, vec4f(f32(row_count(lit)), 0.0, 0.0, 0.0)).x;
        if (lane == 0u) {
            near_plan = plan - 1u;
            near_cut = near_next(window, job, block, u32(lit_count), number);
        }
        let cut = workgroupUniformLoad(&near_cut);
        if (cut.x > 0u) {
            near_divide(lane, job, block, cut, number);
        }
    }
}

fn near_square(window: UnitSquare, rect: vec4f) -> UnitSquare {
    let half = max(0.5 * near_size(rect), vec2f(THINNEST * window.disc));
    return UnitSquare(window.right, window.up, window.axis, 0.5 * (rect.xy + rect.zw), half, window.disc);
}

// Keeps the window of the mask just drawn.
fn near_keep(job: NearJob, number: u32) {
    near_windows[NEAR_MOST * number + near_counts[number]] = job.window;
    near_counts[number] += 1u;
}

// What is drawn instead of a mask whose lit samples are in a block: nothing, a window, or two, of which it returns where they meet. By the first
// thread.
fn near_next(window: UnitSquare, job: NearJob, block: vec4u, lit_count: u32, number: u32) -> vec2u {
    if (block.x >= block.y) {
        return vec2u(0u);
    }
    let size = near_size(job.window);
    let room = 1e-3 * size;
    let low = job.window.xy;
    let high = job.window.zw;
    // What is lit at a side goes on beyond it.
    let grows_low = (block.xz == vec2u(0u)) & (low > job.limit.xy + room);
    let grows_high = (block.yw == vec2u(row_width, SIDE)) & (high < job.limit.zw - room);
    var around = near_within(near_around(job.window, block), job.limit);
    around = vec4f(
        select(around.xy, max(low - 0.5 * size, job.limit.xy), grows_low),
        select(around.zw, min(high + 0.5 * size, job.limit.zw), grows_high)
    );
    // Each window that waits has a mask for certain.
    let left = near_plan.y - min(near_plan.y, near_plan.x);
    let is_grown = any(grows_low) || any(grows_high);
    let is_full = NEAR_FILLED * lit_count >= row_width * SIDE || any(size < vec2f(2.0 * THINNEST * window.disc));
    if (!is_grown && (is_full || left == 0u)) {
        near_keep(job, number);
        return vec2u(0u);
    }
    if (is_grown || 2.0 * near_area(around) <= near_area(job.window)) {
        if (left >= 1u) {
            near_jobs[near_plan.x] = NearJob(around, job.limit);
            near_plan.x += 1u;
        } else {
            near_keep(job, number);
        }
        return vec2u(0u);
    }
    if (left < 2u) {
        near_keep(job, number);
        return vec2u(0u);
    }
    let extent = vec2f(block.yw - block.xz) / vec2f(f32(row_width), f32(SIDE));
    if (extent.y > extent.x) {
        return vec2u(2u, (block.z + block.w) / 2u);
    }
    return vec2u(1u, (block.x + block.y) / 2u);
}

// Two windows that meet where a mask is cut. Requires uniform control flow.
fn near_divide(lane: u32, job: NearJob, block: vec4u, cut: vec2u, number: u32) {
    let along_rows = cut.x == 2u;
    let first = near_lit_block(lane, select(vec4u(block.x, cut.y, block.zw), vec4u(block.xyz, cut.y), along_rows));
    let second = near_lit_block(lane, select(vec4u(cut.y, block.yzw), vec4u(block.xy, cut.y, block.w), along_rows));
    if (lane == 0u) {
        let size = near_size(job.window);
        let middle = job.window.xy + size * (f32(cut.y) / vec2f(f32(row_width), f32(SIDE)));
        let below = select(vec4f(job.limit.xy, middle.x, job.limit.w), vec4f(job.limit.xyz, middle.y), along_rows);
        let above = select(vec4f(middle.x, job.limit.yzw), vec4f(job.limit.x, middle.y, job.limit.zw), along_rows);
        if (second.x < second.y) {
            near_jobs[near_plan.x] = NearJob(near_within(near_around(job.window, second), above), above);
            near_plan.x += 1u;
        }
        if (first.x < first.y) {
            near_jobs[near_plan.x] = NearJob(near_within(near_around(job.window, first), below), below);
            near_plan.x += 1u;
        }
    }
}

// How many there are. Requires uniform control flow.
fn near_count(number: u32) -> u32 { return workgroupUniformLoad(&near_counts[number]); }

// Draws one of them. Requires uniform control flow.
fn near_draw(lane: u32, tile: u32, at: Receiver, light: Cone, window: UnitSquare, number: u32, k: u32) -> Mask {
    let mask = mask_reset(near_square(window, near_windows[NEAR_MOST * number + k]), lane, at.normal);
    blockers_splat(lane, tile, at, light, mask);
    return mask;
}

// The area of a sample, in plane coordinates.
fn near_sample(mask: Mask) -> f32 {
    let cell = mask_cell(mask);
    return cell.x * cell.y * f32(SIDE) / f32(row_width);
}
