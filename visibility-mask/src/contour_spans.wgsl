// The region that the contour of contour.wgsl covers: heights between rows, parts of cells, runs of a row.

// The shift of a bisection's steps: slightly different from line to line.
fn contour_shift(line: u32) -> f32 {
    let order = ((line & 1u) << 2u) | (line & 2u) | ((line >> 2u) & 1u);
    return (f32(order) / 8.0 - 7.0 / 16.0) / f32(CONTOUR_STEPS);
}

// The interval, between the dark point (0) and the lit one (1), that a bisection has found.
fn contour_bounds(line: u32, low: u32) -> vec2f {
    let at = vec2f(f32(low), f32(low + 1u)) / f32(CONTOUR_STEPS) + contour_shift(line);
    return vec2f(select(0.0, at.x, low > 0u), select(1.0, at.y, low + 1u < CONTOUR_STEPS));
}

// The middle of that interval.
fn contour_way(line: u32, low: u32) -> f32 {
    let bounds = contour_bounds(line, low);
    return 0.5 * (bounds.x + bounds.y);
}

// The same for a step between a dark row and a lit one: twice a bisection's result and, next to either row, one more for the upper
// half.
fn contour_height(line: u32, step: u32) -> f32 {
    let low = step / 2u;
    let bounds = contour_bounds(line, low);
    let middle = 0.5 * (bounds.x + bounds.y);
    let half = 0.5 * (middle + select(bounds.x, bounds.y, (step & 1u) == 1u));
    return select(half, middle, contour_is_inside(low));
}

// Whether a bisection's result is at neither end.
fn contour_is_inside(low: u32) -> bool { return low > 0u && low + 1u < CONTOUR_STEPS; }

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

// The columns in which the contour runs between rows `j` and `j + 1`: first columns of pairs, and all columns.
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
        // The contour enters through one line and soon leaves through the other.
        if (end - first < CONTOUR_LONG && left.x != left.y && right.x != right.y && left.x != right.x) {
            continue;
        }
        out.all |= bits_ones(end) & ~bits_ones(first);
        for (var i = first; i < end; i += 2u) {
            out.starts |= bits_one(i);
        }
    }
    return out;
}

// Cells of row `j` beyond which nothing emits; and those of them whose distance to the light's rim is tested, if the rim runs along
// the row.
fn contour_outer(mask: Mask, j: u32, above: bool) -> Flat {
    var out = Flat(vec2u(0u), contour_emit[j] & ~contour_steps(j));
    if (above && j + 1u < SIDE) {
        out.all &= ~contour_emit[j + 1u];
    } else if (!above && j > 0u) {
        out.all &= ~contour_emit[j - 1u];
    }
    let disc_sq = mask.square.disc * mask.square.disc;
    let y = mask_row_y(mask, j);
    let cell = mask_cell(mask).y;
    var rest = out.all;
    while (bits_any(rest)) {
        let i = bits_first(rest);
        rest &= ~bits_one(i);
        let x = mask_cell_center(mask, i, j).x;
        let height = sqrt(max(disc_sq - x * x, 0.0)) - select(-y, y, above);
        // Not if the rim is steep, nor at the window's border or the horizon.
        if (2.0 * x * x <= disc_sq && height >= 0.05 * cell && height <= cell) {
            out.starts |= bits_one(i);
            rest &= ~bits_one(i + 1u);
        }
    }
    return out;
}

// The part of a cell of the lower (or upper) of two rows that the contour between them covers, in 127ths.
fn contour_between(flat: Flat, i: u32, gap: u32, lower: bool) -> f32 {
    if (!bits_has(flat.all, i)) {
        return 0.0;
    }
    let start = select(i - 1u, i, bits_has(flat.starts, i));
    let way = contour_height(start / 2u, contour_noted(0u, start, gap) - 1u);
    // Beyond half the height it covers a part of the lit cells; below that it leaves open a part of the dark ones.
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
    let way = contour_height(start / 2u, noted - 1u);
    return trunc(0.5 * CONTOUR_WHOLE * select(way, way - 1.0, bits_has(hides, i)));
}

// Blocks the partly covered cells of the row. Returns the wholly covered ones.
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
        let cell = mask_cell(mask).x;
        let left = mask_cell_center(mask, i, j).x + (part.x - f32(i) - 0.5) * cell;
        // The end is shifted among the cell's samples from cell to cell, or a whole row would round in the same way.
        let shift = (row_phase(i) + row_phase(j)) / mask.scale;
        mask_block_span(mask, j, left, left + share * part.y * cell + shift);
    }
    return whole;
}

// The contour beside a dark cell `i` of row `j`, toward its neighbour `next`.
fn contour_edge(mask: Mask, i: u32, next: u32, j: u32, layer: u32) -> f32 {
    if (bits_has(contour_dark_of(j), next)) {
        return 0.5 * (mask_cell_center(mask, i, j).x + mask_cell_center(mask, next, j).x);
    }
    let start = contour_sample(mask, i, j);
    let way = contour_way(j, contour_noted(layer, i, j) - 1u);
    return start + (contour_sample(mask, next, j) - start) * way;
}

// Blocks the runs of wholly covered cells.
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
