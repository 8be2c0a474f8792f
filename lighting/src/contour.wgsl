// The Contour of contour.rs, followed by a workgroup: each thread has a row, and all share the questions. Needs mask.wgsl and
// `light_is_hidden(v: vec3f) -> bool` for unit directions. Everything only where all threads come by.
//
// Cells of a row are bits of two words. What is asked does not depend on the order of the answers, so neither do they.

// Coarse blocks a side, and questions for each place where the contour crosses a row.
const CONTOUR_START = 8u;
const CONTOUR_BISECTIONS = 2u;
const CONTOUR_STEPS = 1u << CONTOUR_BISECTIONS;
// A whole cell in the units of what the contour covers.
const CONTOUR_WHOLE = 127.0;
const CONTOUR_WORDS = 2u * LANES;
const CONTOUR_PART = LANES / 8u;
// A byte for every second cell, in three layers.
const CONTOUR_ROW = (SIDE + 7u) / 8u;
const CONTOUR_LAYERS = 3u * LANES;
const CONTOUR_BYTES = CONTOUR_LAYERS * CONTOUR_ROW;
// Cosine and sine of the rim's directions in a quadrant.
const CONTOUR_RIM = array<vec2f, 8>(
    vec2f(0.99518472667, 0.09801714033), vec2f(0.95694033573, 0.29028467725),
    vec2f(0.88192126435, 0.47139673683), vec2f(0.77301045336, 0.63439328416),
    vec2f(0.63439328416, 0.77301045336), vec2f(0.47139673683, 0.88192126435),
    vec2f(0.29028467725, 0.95694033573), vec2f(0.09801714033, 0.99518472667),
);

// What is done one after the other. Cells are asked for up to CONTOUR_FOLLOW, then how far the contour is from a dark point.
const CONTOUR_RIM_CELLS = 0u;
const CONTOUR_COARSE = 1u;
const CONTOUR_FOLLOW = 2u;
// Asks for nothing.
const CONTOUR_THIN = 3u;
// Between two rows; between the outermost rows and the rim below and above; beside the runs of a row. Layers count from the
// first, and from the fourth again.
const CONTOUR_BETWEEN = 4u;
const CONTOUR_BELOW = 5u;
const CONTOUR_ABOVE = 6u;
const CONTOUR_LEFT = 7u;
const CONTOUR_RIGHT = 8u;

// Of each row: samples that emit, cells that emit, cells that were asked for, cells that are hidden as far as is known.
var<workgroup> contour_spans: array<vec2u, LANES>;
var<workgroup> contour_emit: array<vec2u, LANES>;
var<workgroup> contour_known: array<atomic<u32>, CONTOUR_WORDS>;
var<workgroup> contour_dark: array<atomic<u32>, CONTOUR_WORDS>;
// Cells to be asked for next.
var<workgroup> contour_marks: array<atomic<u32>, CONTOUR_WORDS>;
// Items that the rows want done, and how many there are in an eighth of the rows so far.
var<workgroup> contour_want: array<vec2u, LANES>;
var<workgroup> contour_sums: array<u32, LANES>;
var<workgroup> contour_total: u32;
var<workgroup> contour_answers: array<atomic<u32>, CONTOUR_BYTES>;
// Where it was asked for heights, in the same layers.
var<workgroup> contour_flats: array<Flat, CONTOUR_LAYERS>;

fn bits_ones(n: u32) -> vec2u {
    return vec2u(
        select(0xffffffffu, (1u << (n & 31u)) - 1u, n < 32u),
        select(select(0xffffffffu, (1u << (n & 31u)) - 1u, n < 64u), 0u, n < 32u)
    );
}

fn bits_one(i: u32) -> vec2u { return select(vec2u(0u, 1u << (i & 31u)), vec2u(1u << (i & 31u), 0u), i < 32u); }

fn bits_has(v: vec2u, i: u32) -> bool { return ((select(v.y, v.x, i < 32u) >> (i & 31u)) & 1u) == 1u; }

// The lowest bit, 64 where there is none.
fn bits_first(v: vec2u) -> u32 { return select(32u + countTrailingZeros(v.y), countTrailingZeros(v.x), v.x != 0u); }

// The lowest bit that is not set, from `first` on.
fn bits_end(v: vec2u, first: u32) -> u32 { return bits_first(~v & ~bits_ones(first)); }

fn bits_last(v: vec2u) -> u32 { return select(31u - countLeadingZeros(v.x), 63u - countLeadingZeros(v.y), v.y != 0u); }

// Every bit moved to the next higher place, and to the next lower one.
fn bits_up(v: vec2u) -> vec2u { return vec2u(v.x << 1u, (v.y << 1u) | (v.x >> 31u)); }

fn bits_down(v: vec2u) -> vec2u { return vec2u((v.x >> 1u) | (v.y << 31u), v.y >> 1u); }

fn bits_any(v: vec2u) -> bool { return (v.x | v.y) != 0u; }

fn contour_known_of(j: u32) -> vec2u {
    return vec2u(atomicLoad(&contour_known[2u * j]), atomicLoad(&contour_known[2u * j + 1u]));
}

fn contour_dark_of(j: u32) -> vec2u {
    return vec2u(atomicLoad(&contour_dark[2u * j]), atomicLoad(&contour_dark[2u * j + 1u]));
}

// Cells of a row of which samples emit.
fn contour_cells(span: vec2u) -> vec2u {
    let width = WIDTH / SIDE;
    let cells = bits_ones((span.y + width - 1u) / width) & ~bits_ones(span.x / width);
    return select(vec2u(0u), cells, span.x < span.y);
}

// Part of a cell that emits, as (start, length) in cells.
fn contour_part(i: u32, j: u32) -> vec2f {
    let ends = vec2f(contour_spans[j]) / f32(WIDTH / SIDE);
    let at = clamp(ends, vec2f(f32(i)), vec2f(f32(i) + 1.0));
    return vec2f(at.x, max(at.y - at.x, 0.0));
}

// Where on its row a cell is asked for: in the middle of what emits of it; in rows of at least four cells the outermost
// ones at the ends of the row.
fn contour_sample(mask: Mask, i: u32, j: u32) -> f32 {
    let cells = contour_emit[j];
    let part = contour_part(i, j);
    let first = bits_first(cells);
    let last = bits_last(cells);
    var at = part.x + 0.5 * part.y;
    if (last >= first + 3u && i == first) {
        at = part.x;
    } else if (last >= first + 3u && i == last) {
        at = part.x + part.y;
    }
    return mask_cell_center(mask, 0u, j).x + (at - 0.5) * mask_cell(mask);
}

fn contour_ask(mask: Mask, p: vec2f) -> bool {
    // The centre of a cell on the rim may be outside.
    return light_is_hidden(unit(square_world(mask.square, vec3f(shortened(p, mask.square.disc), 1.0))));
}

// How many items all rows want done; items are bits of the rows.
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

fn contour_mark(i: u32, j: u32) { atomicOr(&contour_marks[2u * j + i / 32u], 1u << (i & 31u)); }

// Marks cells all around the rim.
fn contour_rim(lane: u32) {
    var first = SIDE;
    var last = 0u;
    for (var j = 0u; j < SIDE; j++) {
        if (bits_any(contour_emit[j])) {
            first = min(first, j);
            last = j;
        }
    }
    if (lane >= 32u || first > last) {
        return;
    }
    let middle = contour_emit[(first + last) / 2u];
    let center = 0.5 * vec2f(f32(bits_first(middle) + bits_last(middle) + 1u), f32(first + last + 1u));
    var rim = CONTOUR_RIM;
    var toward = rim[lane % 8u];
    for (var k = lane / 8u; k > 0u; k--) {
        toward = vec2f(-toward.y, toward.x);
    }
    for (var way = 0.75 * f32(SIDE); way >= 0.0; way -= 0.5) {
        let cell = vec2i(floor(center + way * toward));
        if (all(cell >= vec2i(0)) && all(cell < vec2i(i32(SIDE)))) {
            let at = vec2u(cell);
            if (bits_has(contour_emit[at.y], at.x)) {
                contour_mark(at.x, at.y);
                return;
            }
        }
    }
}

// The middle cell of a block if it emits, else one that is known, else the emitting cell nearest to the middle; the last is
// 0 where there is none.
fn contour_representative(corner: vec2u, size: u32) -> vec3u {
    let middle = corner + size / 2u;
    if (bits_has(contour_emit[middle.y], middle.x)) {
        return vec3u(middle, 1u);
    }
    var best = 0x7fffffff;
    var found = vec3u(0u);
    for (var y = corner.y; y < corner.y + size; y++) {
        let known = contour_known_of(y);
        for (var x = corner.x; x < corner.x + size; x++) {
            if (bits_has(known, x)) {
                return vec3u(x, y, 1u);
            }
            let d = vec2i(vec2u(x, y)) - vec2i(middle);
            let distance = d.x * d.x + d.y * d.y;
            if (bits_has(contour_emit[y], x) && distance < best) {
                best = distance;
                found = vec3u(x, y, 1u);
            }
        }
    }
    return found;
}

// Marks one cell of each of `blocks`² blocks.
fn contour_coarse(lane: u32, blocks: u32) {
    let size = SIDE / blocks;
    for (var b = lane; b < blocks * blocks; b += LANES) {
        let cell = contour_representative(size * vec2u(b % blocks, b / blocks), size);
        if (cell.z != 0u) {
            contour_mark(cell.x, cell.y);
        }
    }
}

// The others follow it.
fn contour_fill(lane: u32, blocks: u32) {
    let size = SIDE / blocks;
    for (var b = lane; b < blocks * blocks; b += LANES) {
        let corner = size * vec2u(b % blocks, b / blocks);
        let cell = contour_representative(corner, size);
        if (cell.z == 0u) {
            continue;
        }
        let hidden = bits_has(contour_dark_of(cell.y), cell.x);
        let columns = bits_ones(corner.x + size) & ~bits_ones(corner.x);
        for (var j = corner.y; j < corner.y + size; j++) {
            let others = columns & ~contour_known_of(j);
            for (var word = 0u; word < 2u; word++) {
                if (hidden) {
                    atomicOr(&contour_dark[2u * j + word], others[word]);
                } else {
                    atomicAnd(&contour_dark[2u * j + word], ~others[word]);
                }
            }
        }
    }
}

// The unknown ones among neighbours that differ.
fn contour_open(lane: u32) -> vec2u {
    let hides = contour_dark_of(lane);
    var differ = contour_steps(lane);
    if (lane > 0u) {
        differ |= (hides ^ contour_dark_of(lane - 1u)) & contour_emit[lane - 1u];
    }
    if (lane + 1u < SIDE) {
        differ |= (hides ^ contour_dark_of(lane + 1u)) & contour_emit[lane + 1u];
    }
    return differ & contour_emit[lane] & ~contour_known_of(lane);
}

// Single lit or dark cells between two others in a row or column.
fn contour_thin(lane: u32) -> vec2u {
    let e = contour_emit[lane];
    let d = contour_dark_of(lane);
    var thin = (d ^ bits_up(d)) & (d ^ bits_down(d)) & bits_up(e) & bits_down(e);
    if (lane > 0u && lane + 1u < SIDE) {
        let apart = (d ^ contour_dark_of(lane - 1u)) & (d ^ contour_dark_of(lane + 1u));
        thin |= apart & contour_emit[lane - 1u] & contour_emit[lane + 1u];
    }
    return thin & e;
}

// Cells of row `j` that differ from their left or right neighbour, where both emit.
fn contour_steps(j: u32) -> vec2u {
    let emits = contour_emit[j];
    let hides = contour_dark_of(j);
    let right = (hides ^ bits_down(hides)) & emits & bits_down(emits);
    return right | bits_up(right);
}

// How far the steps of a bisection are shifted: a little from line to line.
fn contour_shift(line: u32) -> f32 {
    let order = ((line & 1u) << 2u) | (line & 2u) | ((line >> 2u) & 1u);
    return (f32(order) / 8.0 - 7.0 / 16.0) / f32(CONTOUR_STEPS);
}

// How far from the dark point (0) to the lit one (1) a step is.
fn contour_way(line: u32, step: u32) -> f32 {
    let shift = contour_shift(line);
    let low = select(0.0, f32(step) / f32(CONTOUR_STEPS) + shift, step > 0u);
    let high = select(1.0, f32(step + 1u) / f32(CONTOUR_STEPS) + shift, step + 1u < CONTOUR_STEPS);
    return 0.5 * (low + high);
}

fn contour_slot(layer: u32, i: u32, j: u32) -> u32 { return (layer * LANES + j) * CONTOUR_ROW + i / 8u; }

// Notes the step of a crossing, of cells that are never neighbours.
fn contour_note(layer: u32, i: u32, j: u32, step: u32) {
    atomicOr(&contour_answers[contour_slot(layer, i, j)], (step + 1u) << (8u * (i / 2u % 4u)));
}

// One more than the step; 0 where none was noted.
fn contour_noted(layer: u32, i: u32, j: u32) -> u32 {
    return (atomicLoad(&contour_answers[contour_slot(layer, i, j)]) >> (8u * (i / 2u % 4u))) & 0xffu;
}

fn contour_forget(lane: u32) {
    for (var k = lane; k < CONTOUR_BYTES; k += LANES) {
        atomicStore(&contour_answers[k], 0u);
    }
    workgroupBarrier();
}

// Where the contour runs along between rows `j` and `j + 1`: first columns of pairs, and all columns.
struct Flat { starts: vec2u, all: vec2u }

fn contour_flat(j: u32) -> Flat {
    var out = Flat(vec2u(0u), vec2u(0u));
    if (j + 1u >= SIDE) {
        return out;
    }
    let both = contour_emit[j] & contour_emit[j + 1u];
    let low = contour_steps(j);
    let high = contour_steps(j + 1u);
    var flat = (contour_dark_of(j) ^ contour_dark_of(j + 1u)) & both & ~low & ~high;
    while (bits_any(flat)) {
        let first = bits_first(flat);
        let end = bits_end(flat, first);
        flat &= ~bits_ones(end);
        let left = vec2<bool>(
            first > 0u && bits_has(low & both, first - 1u),
            first > 0u && bits_has(high & both, first - 1u)
        );
        let right = vec2<bool>(end < SIDE && bits_has(low & both, end), end < SIDE && bits_has(high & both, end));
        // It comes through one line and leaves through the other.
        if (left.x != left.y && right.x != right.y && left.x != right.x) {
            continue;
        }
        out.all |= bits_ones(end) & ~bits_ones(first);
        for (var i = first; i < end; i += 2u) {
            out.starts |= bits_one(i);
        }
    }
    return out;
}

// Cells of row `j` with nothing that emits beyond them; and those of them whose way to the light's rim is asked for, where it
// runs along the row.
fn contour_outer(mask: Mask, j: u32, above: bool) -> Flat {
    var out = Flat(vec2u(0u), contour_emit[j] & ~contour_steps(j));
    if (above && j + 1u < SIDE) {
        out.all &= ~contour_emit[j + 1u];
    } else if (!above && j > 0u) {
        out.all &= ~contour_emit[j - 1u];
    }
    let disc_sq = mask.square.disc * mask.square.disc;
    let y = mask_row_y(mask, j);
    let cell = mask_cell(mask);
    var rest = out.all;
    while (bits_any(rest)) {
        let i = bits_first(rest);
        rest &= ~bits_one(i);
        let x = mask_cell_center(mask, i, j).x;
        let height = sqrt(max(disc_sq - x * x, 0.0)) - select(-y, y, above);
        // Not where the rim is steep, nor at the window's border or the horizon.
        if (2.0 * x * x <= disc_sq && height >= 0.05 * cell && height <= cell) {
            out.starts |= bits_one(i);
            rest &= ~bits_one(i + 1u);
        }
    }
    return out;
}

// What the contour between two rows covers of a cell of the lower (or upper) of them, in 127ths.
fn contour_between(flat: Flat, i: u32, gap: u32, lower: bool) -> f32 {
    if (!bits_has(flat.all, i)) {
        return 0.0;
    }
    let start = select(i - 1u, i, bits_has(flat.starts, i));
    let way = contour_way(start / 2u, contour_noted(0u, start, gap) - 1u);
    // Beyond half the way it reaches into the lit cells; before, it leaves some of the dark ones.
    let below = bits_has(contour_dark_of(gap), start);
    let own = (below == lower) == (way < 0.5);
    return select(0.0, trunc((way - 0.5) * CONTOUR_WHOLE), own);
}

// The same between a row and the rim.
fn contour_beyond(outer: Flat, i: u32, j: u32, layer: u32) -> f32 {
    let hides = contour_dark_of(j);
    var start = i;
    if (!bits_has(outer.starts, i)) {
        if (i == 0u || !bits_has(outer.starts, i - 1u)) {
            return 0.0;
        }
        start = i - 1u;
    }
    let noted = contour_noted(layer, start, j);
    if (noted == 0u || !bits_has(outer.all, i) || bits_has(hides, i) != bits_has(hides, start)) {
        return 0.0;
    }
    let way = contour_way(start / 2u, noted - 1u);
    return trunc(0.5 * CONTOUR_WHOLE * select(way, way - 1.0, bits_has(hides, i)));
}

// Blocks the cells of the own row that are covered in part. Returns those that are covered as a whole.
fn contour_write_parts(j: u32, mask: Mask) -> vec2u {
    let emits = contour_emit[j];
    var whole = contour_dark_of(j) & emits;
    let flat = contour_flats[j];
    let before = max(j, 1u) - 1u;
    var flat_before = Flat(vec2u(0u), vec2u(0u));
    if (j > 0u) {
        flat_before = contour_flats[before];
    }
    let inner = contour_flats[LANES + j];
    let outer = contour_flats[2u * LANES + j];
    var rest = emits & (flat.all | flat_before.all | inner.all | outer.all);
    while (bits_any(rest)) {
        let i = bits_first(rest);
        rest &= ~bits_one(i);
        let between = contour_between(flat, i, j, true) + contour_between(flat_before, i, before, false);
        let covered = between + contour_beyond(inner, i, j, 1u) + contour_beyond(outer, i, j, 2u);
        if (covered == 0.0) {
            continue;
        }
        let share = clamp(covered, -128.0, 127.0) / CONTOUR_WHOLE + select(0.0, 1.0, bits_has(whole, i));
        whole &= ~bits_one(i);
        let part = contour_part(i, j);
        let cell = mask_cell(mask);
        let left = mask_cell_center(mask, i, j).x + (part.x - f32(i) - 0.5) * cell;
        // Ends among the samples of a cell that differ from cell to cell, else a whole row would round alike.
        let shift = (row_phase(i) + row_phase(j)) / mask.scale;
        mask_block_span(mask, j, left, left + share * part.y * cell + shift);
    }
    return whole;
}

// Where the contour is beside a dark cell `i` of row `j`, toward its neighbour `next`.
fn contour_edge(mask: Mask, i: u32, next: u32, j: u32, layer: u32) -> f32 {
    if (bits_has(contour_dark_of(j), next)) {
        return 0.5 * (mask_cell_center(mask, i, j).x + mask_cell_center(mask, next, j).x);
    }
    let start = contour_sample(mask, i, j);
    let way = contour_way(j, contour_noted(layer, i, j) - 1u);
    return start + (contour_sample(mask, next, j) - start) * way;
}

// The questions of one item: the single place where anything is asked, since a compiler repeats the whole search through a
// scene wherever it stands.
fn contour_do(mask: Mask, stage: u32, i: u32, j: u32) {
    let center = vec2f(mask_cell_center(mask, i, j).x, mask_row_y(mask, j));
    let hides = bits_has(contour_dark_of(j), i);
    // From a dark point to a lit one; and what is asked first.
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
    for (var q = select(1u, 0u, stage <= CONTOUR_FOLLOW || stage == CONTOUR_BELOW || stage == CONTOUR_ABOVE);
        q <= CONTOUR_BISECTIONS; q++) {
        let step = CONTOUR_STEPS >> q;
        let way = f32(low + step) / f32(CONTOUR_STEPS) + shift;
        let hidden = contour_ask(mask, select(start + way * (end - start), check, q == 0u));
        if (q > 0u) {
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
    contour_note((stage - CONTOUR_BETWEEN) % 3u, i, j, low);
}

// What the own row wants done.
fn contour_wish(lane: u32, mask: Mask, stage: u32, whole: vec2u) -> vec2u {
    switch stage {
        case CONTOUR_FOLLOW: {
            return contour_open(lane);
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
            // Marked cells unless their answers are known.
            let marks = vec2u(atomicLoad(&contour_marks[2u * lane]), atomicLoad(&contour_marks[2u * lane + 1u]));
            atomicStore(&contour_marks[2u * lane], 0u);
            atomicStore(&contour_marks[2u * lane + 1u], 0u);
            return marks & ~contour_known_of(lane);
        }
    }
}

// Blocks what is hidden, on top of what the own row has already.
fn contour_block(lane: u32, mask: Mask) {
    contour_spans[lane] = emitting;
    contour_emit[lane] = contour_cells(emitting);
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
    for (var stage = CONTOUR_RIM_CELLS; stage <= CONTOUR_RIGHT;) {
        if (stage == CONTOUR_COARSE) {
            contour_coarse(lane, blocks);
        }
        workgroupBarrier();
        let count = contour_items(lane, contour_wish(lane, mask, stage, whole));
        if (stage != CONTOUR_THIN) {
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
        if (stage == CONTOUR_THIN && count > 0u && !is_last) {
            is_last = true;
            blocks *= 2u;
            stage = CONTOUR_COARSE;
            continue;
        }
        stage += 1u;
    }
    contour_write_runs(lane, mask, whole);
    workgroupBarrier();
}

// Blocks the runs of cells that are covered as a whole.
fn contour_write_runs(lane: u32, mask: Mask, whole: vec2u) {
    let emits = contour_emit[lane];
    var rest = whole;
    while (bits_any(rest)) {
        let first = bits_first(rest);
        let end = bits_end(rest, first);
        rest &= ~bits_ones(end);
        var left = -1e30;
        var right = 1e30;
        if (first > 0u && bits_has(emits, first - 1u)) {
            left = contour_edge(mask, first, first - 1u, lane, 0u);
        }
        if (end < SIDE && bits_has(emits, end)) {
            right = contour_edge(mask, end - 1u, end, lane, 1u);
        }
        mask_block_span(mask, lane, left, right);
    }
}
