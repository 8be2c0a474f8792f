// The thread's own row of the union of convex polygons, before they are drawn into the mask.
//
// Stores only the emitting part of the row: columns of cells from `union_columns.x` up to `union_columns.y`.

// Words in a line: two cells each.
const UNION_WORDS = SIDE / 2u;

// Bits of the row's lines, one line after the other.
var<private> union_bits: array<u32, UNION_LINES * UNION_WORDS>;
// The columns of cells that emit.
var<private> union_columns: vec2u;
// From plane coordinates to columns and lines.
var<private> union_low: vec2f;
var<private> union_scale: vec2f;
// Numbers of the row's lines.
var<private> union_rows: vec4f;

// The span of each line that the current polygon covers: from, to.
var<private> union_from: vec4f;
var<private> union_to: vec4f;
// The first and the last corner, and the number of corners.
var<private> union_first: vec2f;
var<private> union_last: vec2f;
var<private> union_count: u32;

// Clears the union, for a mask's window.
fn union_begin(lane: u32, mask: Mask) {
    for (var k = 0u; k < UNION_LINES * UNION_WORDS; k++) {
        union_bits[k] = 0u;
    }
    let cell = row_width / SIDE;
    union_columns = UNION_ACROSS * vec2u(emitting.x / cell, min((emitting.y + cell - 1u) / cell, SIDE));
    union_low = mask.square.center - mask.square.half;
    union_scale = vec2f(f32(UNION_ACROSS), f32(UNION_LINES)) / mask_cell(mask);
    union_rows = f32(UNION_LINES * lane) + vec4f(0.0, 1.0, 2.0, 3.0);
}

// The range of plane coordinates x in which the row emits.
fn union_range() -> vec2f { return union_low.x + vec2f(union_columns) / union_scale.x; }

// Whether every sample of the row between two corners, in plane coordinates, is covered.
fn union_is_covered(low: vec2f, high: vec2f) -> bool {
    let start = (low - union_low) * union_scale;
    let to = (high - union_low) * union_scale;
    let range = vec2f(union_columns);
    let columns = vec2u(u32(clamp(start.x, range.x, range.y)), u32(ceil(clamp(to.x, range.x, range.y))));
    if columns.x >= columns.y {
        return true;
    }
    for (var line = 0u; line < UNION_LINES; line++) {
        let at = union_rows.x + f32(line);
        if start.y < at + 1.0 && to.y > at && !union_is_set(line, columns.x, columns.y) {
            return false;
        }
    }
    return true;
}

fn union_is_set(line: u32, start: u32, to: u32) -> bool {
    let last = (to - 1u) >> 5u;
    var mask = 0xffffffffu << (start & 31u);
    for (var word = start >> 5u; word <= last; word++) {
        if word == last {
            mask &= 0xffffffffu >> (31u - ((to - 1u) & 31u));
        }
        if (~union_bits[line * UNION_WORDS + word] & mask) != 0u {
            return false;
        }
        mask = 0xffffffffu;
    }
    return true;
}

fn union_set(line: u32, start: u32, to: u32) {
    let last = (to - 1u) >> 5u;
    var mask = 0xffffffffu << (start & 31u);
    for (var word = start >> 5u; word <= last; word++) {
        if word == last {
            mask &= 0xffffffffu >> (31u - ((to - 1u) & 31u));
        }
        union_bits[line * UNION_WORDS + word] |= mask;
        mask = 0xffffffffu;
    }
}

// The first line above a height; lines are sampled at their centres.
fn union_line(y: f32) -> f32 { return floor(clamp(y, 0.0, f32(UNION_LINES * SIDE)) + 0.5); }

// A point in plane coordinates, in columns and lines.
fn union_point(p: vec2f) -> vec2f { return (p - union_low) * union_scale; }

// Extends the spans of `lines` by the edge between two points, moved outward by `grow` in plane coordinates.
fn union_edge(p: vec2f, q: vec2f, grow: f32, lines: vec4f) {
    // Neighbours on both sides of an edge compute it by the same arithmetic.
    let ordered = p.y < q.y || (p.y == q.y && p.x <= q.x);
    let a = select(q, p, ordered);
    let b = select(p, q, ordered);
    let inside = (lines >= vec4f(union_line(a.y))) & (lines < vec4f(union_line(b.y)));
    if !any(inside) {
        return;
    }
    let slope = (b.x - a.x) / (b.y - a.y);
    // The shift of the edge along its normal, measured along the line.
    let g = union_scale * grow;
    let aside = sqrt(g.x * g.x + slope * slope * g.y * g.y);
    let x = a.x + (lines + 0.5 - a.y) * slope;
    union_from = select(union_from, min(union_from, x - aside), inside);
    union_to = select(union_to, max(union_to, x + aside), inside);
}

fn union_clear_spans() {
    union_from = vec4f(1e30);
    union_to = vec4f(-1e30);
}

// Adds the spans of the row's lines from `first` up to `end`.
fn union_fill(first: f32, end: f32) {
    let range = vec2f(union_columns);
    let start = vec4u(floor(clamp(union_from, vec4f(range.x), vec4f(range.y)) + 0.5));
    let to = vec4u(floor(clamp(union_to, vec4f(range.x), vec4f(range.y)) + 0.5));
    for (var line = 0u; line < UNION_LINES; line++) {
        let at = union_rows.x + f32(line);
        if at >= first && at < end && start[line] < to[line] {
            union_set(line, start[line], to[line]);
        }
    }
}

// Begins a polygon; its corners follow, in plane coordinates.
fn union_open() {
    union_clear_spans();
    union_count = 0u;
}

fn union_corner(p: vec2f) {
    let at = union_point(p);
    if union_count == 0u {
        union_first = at;
    } else {
        union_edge(union_last, at, 0.0, union_rows);
    }
    union_last = at;
    union_count++;
}

// Adds the polygon.
fn union_close() {
    if union_count >= 3u {
        union_edge(union_last, union_first, 0.0, union_rows);
        union_fill(0.0, f32(UNION_LINES * SIDE));
    }
}

// Adds a convex quadrilateral in plane coordinates. Its edges, from each corner to the next one, move outward by `grow`.
fn union_quadrilateral(corners: mat4x2f, grow: vec4f) {
    let p = array(
        union_point(corners[0]), union_point(corners[1]), union_point(corners[2]), union_point(corners[3])
    );
    var low = min(min(p[0], p[1]), min(p[2], p[3]));
    var high = max(max(p[0], p[1]), max(p[2], p[3]));
    union_clear_spans();
    let most = max(max(grow.x, grow.y), max(grow.z, grow.w));
    let begin = union_line(low.y);
    let last = union_line(high.y) - 1.0;
    var lines = union_rows;
    if most > 0.0 {
        // A corner moves up or down by the smaller shift of its two edges.
        let ends = min(grow, grow.wxyz);
        let heights = vec4f(p[0].y, p[1].y, p[2].y, p[3].y);
        let above = union_first_of(heights == vec4f(high.y), ends);
        let below = union_first_of(heights == vec4f(low.y), ends);
        low -= vec2f(most * union_scale.x, below * union_scale.y);
        high += vec2f(most * union_scale.x, above * union_scale.y);
        // Lines that only the growth reaches take the span of the line next to them, or else the whole range.
        lines = clamp(union_rows, vec4f(begin), vec4f(max(last, begin)));
    }
    let first = union_line(low.y);
    let end = union_line(high.y);
    if first > union_rows.w || end <= union_rows.x {
        return;
    }
    if begin <= last {
        union_edge(p[0], p[1], grow.x, lines);
        union_edge(p[1], p[2], grow.y, lines);
        union_edge(p[2], p[3], grow.z, lines);
        union_edge(p[3], p[0], grow.w, lines);
        if most > 0.0 {
            union_from = max(union_from, vec4f(low.x));
            union_to = min(union_to, vec4f(high.x));
        }
    } else {
        union_from = vec4f(low.x);
        union_to = vec4f(high.x);
    }
    union_fill(first, end);
}

fn union_first_of(are: vec4<bool>, values: vec4f) -> f32 {
    return select(select(select(values.w, values.z, are.z), values.y, are.y), values.x, are.x);
}

// Blocks the covered part of the mask.
fn union_write(lane: u32, mask: Mask) {
    let cell = mask_cell(mask).x;
    let end = union_columns.y / UNION_ACROSS;
    // Start of the run of fully covered cells.
    var run = end;
    for (var i = union_columns.x / UNION_ACROSS; i < end; i++) {
        let word = i >> 1u;
        let shift = 16u * (i & 1u);
        let low = union_cell(0u, word, shift) | (union_cell(1u, word, shift) << 16u);
        let high = union_cell(2u, word, shift) | (union_cell(3u, word, shift) << 16u);
        let count = countOneBits(low) + countOneBits(high);
        if count == UNION_LINES * UNION_ACROSS {
            run = min(run, i);
            continue;
        }
        if run < end {
            mask_block_span(mask, lane, union_x(run, cell), union_x(i, cell));
            run = end;
        }
        if count != 0u {
            // As much at the side where more of it is. Ends among the samples of a cell that differ from cell to cell, else a
            // whole row would round alike.
            let part = cell * f32(count) / f32(UNION_LINES * UNION_ACROSS);
            let shift = (row_phase(i) + row_phase(lane)) / mask.scale;
            let left = countOneBits(low & 0x00ff00ffu) + countOneBits(high & 0x00ff00ffu);
            if left * 2u >= count {
                mask_block_span(mask, lane, union_x(i, cell), union_x(i, cell) + part + shift);
            } else {
                mask_block_span(mask, lane, union_x(i + 1u, cell) - part + shift, union_x(i + 1u, cell));
            }
        }
    }
    if run < end {
        mask_block_span(mask, lane, union_x(run, cell), 1e30);
    }
}

// Left side of a cell.
fn union_x(i: u32, cell: f32) -> f32 { return union_low.x + f32(i) * cell; }

fn union_cell(line: u32, word: u32, shift: u32) -> u32 {
    return (union_bits[line * UNION_WORDS + word] >> shift) & 0xffffu;
}
