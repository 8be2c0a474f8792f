// The thread's own row of the canvas where convex polygons are united before they go to the mask. Needs mask.wgsl of lighting.
//
// Only what the row emits is kept: columns of cells from `canvas_columns.x` up to `canvas_columns.y`.

// Samples in a cell: columns in a row line, row lines.
const CANVAS_ACROSS = 16u;
const CANVAS_LINES = 4u;
// Words in a line: two cells each.
const CANVAS_WORDS = SIDE / 2u;

// Bits of the own row's lines, one line after the other.
var<private> canvas_bits: array<u32, CANVAS_LINES * CANVAS_WORDS>;
// Columns that matter: those of cells that emit.
var<private> canvas_columns: vec2u;
// From plane coordinates to columns and lines.
var<private> canvas_low: vec2f;
var<private> canvas_scale: vec2f;
// Numbers of the own row's lines.
var<private> canvas_rows: vec4f;

// What of each line a polygon covers, so far; between which of its corners.
var<private> canvas_from: vec4f;
var<private> canvas_to: vec4f;
// The first and the last corner, and how many there were.
var<private> canvas_first: vec2f;
var<private> canvas_last: vec2f;
var<private> canvas_count: u32;

// Starts anew over a mask's window.
fn canvas_begin(lane: u32, mask: Mask) {
    for (var k = 0u; k < CANVAS_LINES * CANVAS_WORDS; k++) {
        canvas_bits[k] = 0u;
    }
    let cell = row_width / SIDE;
    canvas_columns = CANVAS_ACROSS * vec2u(emitting.x / cell, min((emitting.y + cell - 1u) / cell, SIDE));
    canvas_low = mask.square.center - mask.square.half;
    canvas_scale = vec2f(f32(CANVAS_ACROSS), f32(CANVAS_LINES)) / mask_cell(mask);
    canvas_rows = f32(CANVAS_LINES * lane) + vec4f(0.0, 1.0, 2.0, 3.0);
}

// The plane coordinates x between which the own row matters.
fn canvas_range() -> vec2f { return canvas_low.x + vec2f(canvas_columns) / canvas_scale.x; }

// Whether every sample of the own row between two corners, in plane coordinates, is covered.
fn canvas_is_covered(low: vec2f, high: vec2f) -> bool {
    let start = (low - canvas_low) * canvas_scale;
    let to = (high - canvas_low) * canvas_scale;
    let range = vec2f(canvas_columns);
    let columns = vec2u(u32(clamp(start.x, range.x, range.y)), u32(ceil(clamp(to.x, range.x, range.y))));
    if columns.x >= columns.y {
        return true;
    }
    for (var line = 0u; line < CANVAS_LINES; line++) {
        let at = canvas_rows.x + f32(line);
        if start.y < at + 1.0 && to.y > at && !canvas_is_set(line, columns.x, columns.y) {
            return false;
        }
    }
    return true;
}

fn canvas_is_set(line: u32, start: u32, to: u32) -> bool {
    let last = (to - 1u) >> 5u;
    var mask = 0xffffffffu << (start & 31u);
    for (var word = start >> 5u; word <= last; word++) {
        if word == last {
            mask &= 0xffffffffu >> (31u - ((to - 1u) & 31u));
        }
        if (~canvas_bits[line * CANVAS_WORDS + word] & mask) != 0u {
            return false;
        }
        mask = 0xffffffffu;
    }
    return true;
}

fn canvas_set(line: u32, start: u32, to: u32) {
    let last = (to - 1u) >> 5u;
    var mask = 0xffffffffu << (start & 31u);
    for (var word = start >> 5u; word <= last; word++) {
        if word == last {
            mask &= 0xffffffffu >> (31u - ((to - 1u) & 31u));
        }
        canvas_bits[line * CANVAS_WORDS + word] |= mask;
        mask = 0xffffffffu;
    }
}

// Lines are sampled at their middle: the first line above a height.
fn canvas_line(y: f32) -> f32 { return floor(clamp(y, 0.0, f32(CANVAS_LINES * SIDE)) + 0.5); }

// A plane coordinate in columns and lines.
fn canvas_point(p: vec2f) -> vec2f { return (p - canvas_low) * canvas_scale; }

// An edge between two points, moved outward by `grow` in plane coordinates: what it bounds of `lines`.
fn canvas_edge(p: vec2f, q: vec2f, grow: f32, lines: vec4f) {
    // The same arithmetic on both sides of an edge.
    let ordered = p.y < q.y || (p.y == q.y && p.x <= q.x);
    let a = select(q, p, ordered);
    let b = select(p, q, ordered);
    let inside = (lines >= vec4f(canvas_line(a.y))) & (lines < vec4f(canvas_line(b.y)));
    if !any(inside) {
        return;
    }
    let slope = (b.x - a.x) / (b.y - a.y);
    // The edge moved along its normal, measured along the line.
    let g = canvas_scale * grow;
    let aside = sqrt(g.x * g.x + slope * slope * g.y * g.y);
    let x = a.x + (lines + 0.5 - a.y) * slope;
    canvas_from = select(canvas_from, min(canvas_from, x - aside), inside);
    canvas_to = select(canvas_to, max(canvas_to, x + aside), inside);
}

fn canvas_clear_spans() {
    canvas_from = vec4f(1e30);
    canvas_to = vec4f(-1e30);
}

// Unites what the edges cover of those of the own lines that are from `first` up to `end`.
fn canvas_fill(first: f32, end: f32) {
    let range = vec2f(canvas_columns);
    let start = vec4u(floor(clamp(canvas_from, vec4f(range.x), vec4f(range.y)) + 0.5));
    let to = vec4u(floor(clamp(canvas_to, vec4f(range.x), vec4f(range.y)) + 0.5));
    for (var line = 0u; line < CANVAS_LINES; line++) {
        let at = canvas_rows.x + f32(line);
        if at >= first && at < end && start[line] < to[line] {
            canvas_set(line, start[line], to[line]);
        }
    }
}

// A polygon begins; its corners follow, in plane coordinates.
fn canvas_open() {
    canvas_clear_spans();
    canvas_count = 0u;
}

fn canvas_corner(p: vec2f) {
    let at = canvas_point(p);
    if canvas_count == 0u {
        canvas_first = at;
    } else {
        canvas_edge(canvas_last, at, 0.0, canvas_rows);
    }
    canvas_last = at;
    canvas_count++;
}

// Unites the polygon.
fn canvas_close() {
    if canvas_count >= 3u {
        canvas_edge(canvas_last, canvas_first, 0.0, canvas_rows);
        canvas_fill(0.0, f32(CANVAS_LINES * SIDE));
    }
}

// Unites a convex quadrilateral in plane coordinates. Its edges, from each corner to the next one, move outward by `grow`.
fn canvas_quadrilateral(corners: mat4x2f, grow: vec4f) {
    let p = array(
        canvas_point(corners[0]), canvas_point(corners[1]), canvas_point(corners[2]), canvas_point(corners[3])
    );
    var low = min(min(p[0], p[1]), min(p[2], p[3]));
    var high = max(max(p[0], p[1]), max(p[2], p[3]));
    canvas_clear_spans();
    let most = max(max(grow.x, grow.y), max(grow.z, grow.w));
    let begin = canvas_line(low.y);
    let last = canvas_line(high.y) - 1.0;
    var lines = canvas_rows;
    if most > 0.0 {
        // A corner moves up or down as both its edges do.
        let ends = min(grow, grow.wxyz);
        let heights = vec4f(p[0].y, p[1].y, p[2].y, p[3].y);
        let above = canvas_first_of(heights == vec4f(high.y), ends);
        let below = canvas_first_of(heights == vec4f(low.y), ends);
        low -= vec2f(most * canvas_scale.x, below * canvas_scale.y);
        high += vec2f(most * canvas_scale.x, above * canvas_scale.y);
        // Lines that only the growth reaches take the span of the line next to them, or all there is.
        lines = clamp(canvas_rows, vec4f(begin), vec4f(max(last, begin)));
    }
    let first = canvas_line(low.y);
    let end = canvas_line(high.y);
    if first > canvas_rows.w || end <= canvas_rows.x {
        return;
    }
    if begin <= last {
        canvas_edge(p[0], p[1], grow.x, lines);
        canvas_edge(p[1], p[2], grow.y, lines);
        canvas_edge(p[2], p[3], grow.z, lines);
        canvas_edge(p[3], p[0], grow.w, lines);
        if most > 0.0 {
            canvas_from = max(canvas_from, vec4f(low.x));
            canvas_to = min(canvas_to, vec4f(high.x));
        }
    } else {
        canvas_from = vec4f(low.x);
        canvas_to = vec4f(high.x);
    }
    canvas_fill(first, end);
}

fn canvas_first_of(are: vec4<bool>, values: vec4f) -> f32 {
    return select(select(select(values.w, values.z, are.z), values.y, are.y), values.x, are.x);
}

// Blocks what is covered.
fn canvas_write(lane: u32, mask: Mask) {
    let cell = mask_cell(mask).x;
    let end = canvas_columns.y / CANVAS_ACROSS;
    // Start of the run of whole cells.
    var run = end;
    for (var i = canvas_columns.x / CANVAS_ACROSS; i < end; i++) {
        let word = i >> 1u;
        let shift = 16u * (i & 1u);
        let low = canvas_cell(0u, word, shift) | (canvas_cell(1u, word, shift) << 16u);
        let high = canvas_cell(2u, word, shift) | (canvas_cell(3u, word, shift) << 16u);
        let count = countOneBits(low) + countOneBits(high);
        if count == CANVAS_LINES * CANVAS_ACROSS {
            run = min(run, i);
            continue;
        }
        if run < end {
            mask_block_span(mask, lane, canvas_x(run, cell), canvas_x(i, cell));
            run = end;
        }
        if count != 0u {
            // As much at the side where more of it is. Ends among the samples of a cell that differ from cell to cell, else a
            // whole row would round alike.
            let part = cell * f32(count) / f32(CANVAS_LINES * CANVAS_ACROSS);
            let shift = (row_phase(i) + row_phase(lane)) / mask.scale;
            let left = countOneBits(low & 0x00ff00ffu) + countOneBits(high & 0x00ff00ffu);
            if left * 2u >= count {
                mask_block_span(mask, lane, canvas_x(i, cell), canvas_x(i, cell) + part + shift);
            } else {
                mask_block_span(mask, lane, canvas_x(i + 1u, cell) - part + shift, canvas_x(i + 1u, cell));
            }
        }
    }
    if run < end {
        mask_block_span(mask, lane, canvas_x(run, cell), 1e30);
    }
}

// Left side of a cell.
fn canvas_x(i: u32, cell: f32) -> f32 { return canvas_low.x + f32(i) * cell; }

fn canvas_cell(line: u32, word: u32, shift: u32) -> u32 {
    return (canvas_bits[line * CANVAS_WORDS + word] >> shift) & 0xffffu;
}
