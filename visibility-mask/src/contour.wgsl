// The Contour of contour.rs, followed by a workgroup: each thread has a row, and all share the tests. All functions require
// uniform control flow. Calls `light_is_hidden(v: vec3f) -> bool` for unit directions.
//
// Cells of a row are bits of two words. The set of tests does not depend on the order of their results, so the results do not
// either.

const CONTOUR_STEPS = 1u << CONTOUR_BISECTIONS;
const CONTOUR_WORDS = 2u * LANES;
const CONTOUR_PART = LANES / 8u;
// A byte for every second cell, in three layers.
const CONTOUR_ROW = (SIDE + 7u) / 8u;
const CONTOUR_LAYERS = 3u * LANES;
const CONTOUR_BYTES = CONTOUR_LAYERS * CONTOUR_ROW;

// The stages, in order. Up to CONTOUR_FOLLOW cells are tested, then the distance of the contour from a dark point.
const CONTOUR_RIM_CELLS = 0u;
const CONTOUR_COARSE = 1u;
const CONTOUR_FOLLOW = 2u;
// Whether anything is lit.
const CONTOUR_LIT = 3u;
// Tests nothing.
const CONTOUR_THIN = 4u;
// Between two rows; between the outermost rows and the rim below and above; beside the runs of a row. Layers are counted from the
// first of these stages, and again from the fourth.
const CONTOUR_BETWEEN = 5u;
const CONTOUR_BELOW = 6u;
const CONTOUR_ABOVE = 7u;
const CONTOUR_LEFT = 8u;
const CONTOUR_RIGHT = 9u;

// For each row: samples that emit, cells that emit, cells that were tested, cells that are hidden as far as is known.
var<workgroup> contour_spans: array<vec2u, LANES>;
var<workgroup> contour_emit: array<vec2u, LANES>;
var<workgroup> contour_known: array<atomic<u32>, CONTOUR_WORDS>;
var<workgroup> contour_dark: array<atomic<u32>, CONTOUR_WORDS>;
// Cells to be tested next.
var<workgroup> contour_marks: array<atomic<u32>, CONTOUR_WORDS>;
// Items of each row, and the number of items up to a row within its eighth of the rows.
var<workgroup> contour_want: array<vec2u, LANES>;
var<workgroup> contour_sums: array<u32, LANES>;
var<workgroup> contour_total: u32;
var<workgroup> contour_answers: array<atomic<u32>, CONTOUR_BYTES>;
// Columns whose heights were tested, in the same layers.
var<workgroup> contour_flats: array<Flat, CONTOUR_LAYERS>;

fn contour_ask(mask: Mask, p: vec2f) -> bool {
    // The centre of a cell on the rim may be outside the disc.
    return light_is_hidden(unit(square_world(mask.square, vec3f(shortened(p, mask.square.disc), 1.0))));
}

// The number of items of all rows; items are bits of the rows.
fn contour_items(lane: u32, want: vec2u) -> u32 {
    contour_want[lane] = want;
    contour_sums[lane] = countOneBits(want.x) + countOneBits(want.y);
    workgroupBarrier();
    // Sums in eight parts, each by a thread.
    if (lane < 8u) {
        for (var k = lane * CONTOUR_PART + 1u; k < (lane + 1u) * CONTOUR_PART; k++) {
            contour_sums[k] += contour_sums[k - 1u];
        }
    }
    workgroupBarrier();
    if (lane == 0u) {
        var sum = 0u;
        for (var k = CONTOUR_PART - 1u; k < LANES; k += CONTOUR_PART) {
            sum += contour_sums[k];
        }
        contour_total = sum;
    }
    return workgroupUniformLoad(&contour_total);
}

// Column and row of an item.
fn contour_item(number: u32) -> vec2u {
    var k = number;
    var row = 0u;
    while (row + CONTOUR_PART < LANES && contour_sums[row + CONTOUR_PART - 1u] <= k) {
        k -= contour_sums[row + CONTOUR_PART - 1u];
        row += CONTOUR_PART;
    }
    while (row + 1u < LANES && contour_sums[row] <= k) {
        row += 1u;
    }
    var want = contour_want[row];
    var n = k + countOneBits(want.x) + countOneBits(want.y) - contour_sums[row];
    for (; n > 0u; n--) {
        want &= ~bits_one(bits_first(want));
    }
    return vec2u(bits_first(want), row);
}

// The tests of one item. It is the only place that calls the test, since a compiler repeats the whole search of a scene at each
// call.
fn contour_do(mask: Mask, stage: u32, i: u32, j: u32) {
    var center = vec2f(mask_cell_center(mask, i, j).x, mask_row_y(mask, j));
    if (stage == CONTOUR_BETWEEN && i + 1u < SIDE && bits_has(contour_flats[j].all & ~contour_flats[j].starts, i + 1u)) {
        // One height for two columns.
        center.x = 0.5 * (center.x + mask_cell_center(mask, i + 1u, j).x);
    }
    let hides = bits_has(contour_dark_of(j), i);
    // From a dark point to a lit one; and the point that is tested first.
    var start = center;
    var end = center;
    var check = center;
    var line = i / 2u;
    if (stage <= CONTOUR_FOLLOW) {
        check.x = contour_sample(mask, i, j);
    } else if (stage <= CONTOUR_ABOVE) {
        var beyond = vec2f(center.x, mask_row_y(mask, j + 1u));
        if (stage != CONTOUR_BETWEEN) {
            let disc = mask.square.disc;
            let height = sqrt(max(disc * disc - center.x * center.x, 0.0));
            beyond.y = select(-height, height, stage == CONTOUR_ABOVE);
        }
        check = beyond;
        start = select(beyond, center, hides);
        end = select(center, beyond, hides);
    } else {
        start.x = contour_sample(mask, i, j);
        end.x = contour_sample(mask, select(i + 1u, i - 1u, stage == CONTOUR_LEFT), j);
        line = j;
    }
    let shift = contour_shift(line);
    var low = 0u;
    var half = 0u;
    for (var q = select(1u, 0u, stage <= CONTOUR_FOLLOW || stage == CONTOUR_BELOW || stage == CONTOUR_ABOVE);
        q <= CONTOUR_BISECTIONS + 1u; q++) {
        let step = CONTOUR_STEPS >> q;
        var way = f32(low + step) / f32(CONTOUR_STEPS) + shift;
        if (q > CONTOUR_BISECTIONS) {
            // Rows are not shifted: one more test next to them.
            if (stage > CONTOUR_ABOVE || contour_is_inside(low)) {
                break;
            }
            way = contour_way(line, low);
        }
        let hidden = contour_ask(mask, select(start + way * (end - start), check, q == 0u));
        if (q > CONTOUR_BISECTIONS) {
            half = select(0u, 1u, hidden);
        } else if (q > 0u) {
            low += select(0u, step, hidden);
        } else if (stage <= CONTOUR_FOLLOW) {
            let word = 2u * j + i / 32u;
            let bit = 1u << (i & 31u);
            if (hidden) {
                atomicOr(&contour_dark[word], bit);
            } else {
                atomicAnd(&contour_dark[word], ~bit);
            }
            atomicOr(&contour_known[word], bit);
            return;
        } else if (hidden == hides) {
            return;
        }
    }
    contour_note((stage - CONTOUR_BETWEEN) % 3u, i, j, select(2u * low + half, low, stage > CONTOUR_ABOVE));
}

// The items of the thread's row.
fn contour_wish(lane: u32, mask: Mask, stage: u32, whole: vec2u) -> vec2u {
    switch stage {
        case CONTOUR_FOLLOW: {
            return contour_open(lane);
        }
        case CONTOUR_LIT: {
            return contour_emit[lane] & ~contour_dark_of(lane);
        }
        case CONTOUR_THIN: {
            return contour_thin(lane);
        }
        case CONTOUR_BETWEEN: {
            let flat = contour_flat(lane);
            contour_flats[lane] = flat;
            return flat.starts;
        }
        case CONTOUR_BELOW, CONTOUR_ABOVE: {
            let outer = contour_outer(mask, lane, stage == CONTOUR_ABOVE);
            contour_flats[(stage - CONTOUR_BETWEEN) * LANES + lane] = outer;
            return outer.starts;
        }
        case CONTOUR_LEFT, CONTOUR_RIGHT: {
            // Ends of runs whose neighbour is lit.
            let free = contour_emit[lane] & ~contour_dark_of(lane);
            let first = whole & ~bits_up(whole) & bits_up(free);
            let last = whole & ~bits_down(whole) & bits_down(free);
            return select(last, first, stage == CONTOUR_LEFT);
        }
        default: {
            // Marked cells, unless their results are known.
            let marks = vec2u(atomicLoad(&contour_marks[2u * lane]), atomicLoad(&contour_marks[2u * lane + 1u]));
            atomicStore(&contour_marks[2u * lane], 0u);
            atomicStore(&contour_marks[2u * lane + 1u], 0u);
            return marks & ~contour_known_of(lane);
        }
    }
}

// Blocks the hidden part of the row, in addition to its own blockers. Tests only the samples `span` of the row, start and end:
// those that emit, or a part of them if the others are blocked. `seeks`:
// all cells of a wide light are tested where nothing of it is lit.
fn contour_block(lane: u32, mask: Mask, span: vec2u, seeks: bool) {
    contour_spans[lane] = span;
    contour_emit[lane] = contour_cells(span);
    for (var word = 2u * lane; word < 2u * lane + 2u; word++) {
        atomicStore(&contour_known[word], 0u);
        atomicStore(&contour_dark[word], 0u);
        atomicStore(&contour_marks[word], 0u);
    }
    contour_forget(lane);
    contour_rim(lane);
    var whole = vec2u(0u);
    var blocks = min(CONTOUR_START, SIDE);
    var is_last = blocks == SIDE;
    // So many single cells between others ask for finer blocks.
    var least = 1u;
    let is_wide = seeks && max(mask.square.half.x, mask.square.half.y) > CONTOUR_WIDE;
    for (var stage = CONTOUR_RIM_CELLS; stage <= CONTOUR_RIGHT;) {
        if (stage == CONTOUR_COARSE) {
            contour_coarse(lane, blocks);
        }
        workgroupBarrier();
        let count = contour_items(lane, contour_wish(lane, mask, stage, whole));
        if (stage != CONTOUR_LIT && stage != CONTOUR_THIN) {
            for (var k = lane; k < count; k += LANES) {
                let item = contour_item(k);
                contour_do(mask, stage, item.x, item.y);
            }
        }
        workgroupBarrier();
        if (stage == CONTOUR_COARSE) {
            contour_fill(lane, blocks);
        } else if (stage == CONTOUR_ABOVE) {
            whole = contour_write_parts(lane, mask);
        }
        workgroupBarrier();
        if (stage == CONTOUR_ABOVE) {
            contour_forget(lane);
        }
        if (stage == CONTOUR_FOLLOW && count > 0u) {
            continue;
        }
        if (stage == CONTOUR_LIT && count == 0u && blocks < SIDE) {
            // All threads know it, but browsers want proof that they meet at barriers.
            if (lane == 0u) {
                contour_total = u32(is_wide);
            }
            if (workgroupUniformLoad(&contour_total) != 0u) {
                is_last = true;
                blocks *= 2u;
                stage = CONTOUR_COARSE;
                continue;
            }
        }
        if (stage == CONTOUR_THIN && count >= least && !is_last) {
            least = CONTOUR_MANY;
            blocks *= 2u;
            is_last = blocks >= SIDE;
            stage = CONTOUR_COARSE;
            continue;
        }
        stage += 1u;
    }
    contour_write_runs(lane, mask, whole);
    workgroupBarrier();
}
