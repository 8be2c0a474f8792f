// Masks around the lit part of a light, if that is small: as `NearMasks`, but one of a window that shrinks or grows until the lit part fills it,
// or one in each of a few cells.

// Their windows, the lower corner and the upper one in plane coordinates, and their number.
var<workgroup> near_windows: array<vec4f, PLACES_CELLS>;
var<workgroup> near_count: u32;
// The masks that are drawn in cells, 0 for one window; and into how many parts a window is divided along each side, a mask for each.
var<workgroup> near_cells: u32;
var<workgroup> near_parts: u32;
// The window that is tried.
var<private> near_square: UnitSquare;
// The number of the mask that is drawn or read, and the area of its samples over that of the whole light's.
var<private> near_index: u32;
var<private> near_scale: f32;
// Where nothing is lit, the number of the quarter of the light that is looked at next; else 0.
var<private> near_quarter: u32;
// Bits of columns: with lit samples, and with such that end where the light does.
var<workgroup> near_columns: array<atomic<u32>, 16>;
// The corners of a box around this thread's lit samples, the lower one negated.
var<private> near_box: vec4f;

fn near_begin(lane: u32) {
    near_box = vec4f(-1e30);
    places_clear(lane);
    places_are_listed = false;
    if (lane == 0u) {
        near_count = 0u;
        near_cells = 0u;
        near_parts = 1u;
    }
}

// Whether openings between the samples of a mask matter: before a wide light, or if all of a light's own radiance does.
fn near_seeks() -> bool {
    return frame.look_again > 1u || (frame.look_again > 0u && max(places_whole.half.x, places_whole.half.y) > NEAR_WIDE);
}

// Adds the lit samples of this thread's row of a mask. Of its sides, left and right, those that are `inner` to the window are no ends.
// Returns whether any sample is lit, and whether the lit ones end where the light does.
fn near_add(lane: u32, mask: Mask, inner: vec2<bool>) -> vec2u {
    if (row_is_none(lit)) {
        return vec2u(0u);
    }
    let ends = row_bounds(lit);
    let half = mask.square.half;
    let sample = 2.0 * half / vec2f(f32(row_width), f32(SIDE));
    let origin = mask.square.center - half;
    let low = origin + (vec2f(f32(ends.x), f32(lane)) - NEAR_ROOM) * sample;
    let high = origin + (vec2f(f32(ends.y), f32(lane + 1u)) + NEAR_ROOM) * sample;
    near_box = max(near_box, vec4f(-low, high));
    let at_left = ends.x <= emitting.x && !(emitting.x == 0u && inner.x);
    let at_right = ends.y >= emitting.y && !(emitting.y == row_width && inner.y);
    return vec2u(1u, u32(at_left || at_right));
}

// Whether so little of the light is lit that few samples measure its size: `counts` has its lit and its emitting samples, and its rows with
// lit ones; there are `rows` in all. Where none is lit, an opening between samples may be marked, or lie between the marks' lines.
fn near_is_little(counts: vec4f, rows: u32) -> bool {
    if (counts.x == 0.0) {
        let may_be_missed = near_seeks() && places_are_listed && !outline_has_sides();
        return counts.y > 0.0 && (frame.look_again > 1u || atomicLoad(&places_count) > 0u || may_be_missed);
    }
    return near_are_few(counts, rows) || near_is_cut(counts) || (near_seeks() && !outline_has_sides() && near_is_narrow(counts));
}

// Whether a part of a sky is half hidden: behind a window a few parts are all that is seen. Only where blockers have exact outlines.
fn near_is_cut(counts: vec4f) -> bool {
    return frame.look_again > 0u && outline_has_sides() && places_are_listed && counts.x > 0.0 && counts.x < counts.y;
}

// Whether so few samples are lit, or so few rows have any, that their number is no measure: `LitCounts::are_few`.
fn near_are_few(counts: vec4f, rows: u32) -> bool {
    let is_few = NEAR_LEAST * counts.x < counts.y || NEAR_OF * counts.z < NEAR_FEW * f32(rows);
    return frame.look_again > 0u && NEAR_LITTLE * counts.x < counts.y && is_few;
}

// Whether openings between samples are marked beside lit ones, or the lit ones may all be one more, or one less, in a row after another.
fn near_is_narrow(counts: vec4f) -> bool {
    let is_narrow = NEAR_NARROW * counts.x < counts.z * f32(row_width);
    return NEAR_SLIGHT * counts.x < counts.y && (is_narrow || atomicLoad(&places_count) > 0u);
}

// Whether that is looked at again: of an opening the lit part ends at blockers on two opposite sides, of an ordinary penumbra where the light does,
// of which that is done if few samples show it and it is slight. `counts` has the lit and the emitting samples, the rows with lit samples and those of them that end where the light does, `columns` the same across them.
fn near_is_opening(counts: vec4f, columns: vec2f, rows: u32) -> bool {
    let is_opening = NEAR_ENDS * counts.w < counts.z || NEAR_ENDS * columns.y < columns.x;
    let is_slight = near_are_few(counts, rows) && NEAR_SLIGHT * counts.x < counts.y;
    return is_opening || is_slight || frame.look_again > 1u || outline_has_sides() || counts.x == 0.0;
}

// Of the mask that was drawn last the columns with lit samples, and those of them that end where the light does. Requires uniform control flow.
fn near_columns_of(lane: u32) -> vec2f {
    places_emitting[lane] = emitting;
    if (lane < 16u) {
        atomicStore(&near_columns[lane], 0u);
    }
    workgroupBarrier();
    if (!row_is_none(lit)) {
        near_gather(0u, lit);
        for (var k = 0u; k < 2u; k++) {
            let is_last = lane == select(0u, SIDE - 1u, k > 0u);
            let beside = places_emitting[select(lane + 2u * k - 1u, lane, is_last)];
            var ends = lit;
            if (!is_last && beside.x < beside.y) {
                // Rows are shifted by up to half a sample.
                ends = row_without(lit, row_span(max(beside.x, 1u) - 1u, min(beside.y + 1u, row_width)));
            }
            near_gather(8u, ends);
        }
    }
    workgroupBarrier();
    var counts = vec4f(0.0);
    if (lane < 16u) {
        let count = f32(countOneBits(atomicLoad(&near_columns[lane])));
        counts = select(vec4f(0.0, count, 0.0, 0.0), vec4f(count, 0.0, 0.0, 0.0), lane < 8u);
    }
    return total(lane, counts).xy;
}

fn near_gather(first: u32, row: Row) {
    for (var k = 0u; k < ROW_WORDS; k++) {
        atomicOr(&near_columns[first + k], row_word(row, k));
    }
}

// The first windows: around all that is lit, in cells if these are much smaller together, or where nothing is lit a quarter of the light.
// `is_one`: whether the light has one mask, whose samples are those of the thread's row. Requires uniform control flow.
fn near_first(lane: u32, whole: UnitSquare, is_one: bool) {
    // Before lit samples are added.
    let is_marked = atomicLoad(&places_count) > 0u;
    let box = largest(lane, near_box);
    near_box = vec4f(-1e30);
    near_quarter = 0u;
    if (is_one) {
        near_add_places(lane);
    }
    workgroupBarrier();
    if (lane == 0u) {
        near_divide(whole, box, is_one, is_marked);
    }
    let count = workgroupUniformLoad(&near_count);
    if (lane == 0u) {
        // One window's mask may not stay.
        near_count = near_cells;
    }
    if (count == 0u) {
        near_square = square_part(whole, 0u, vec2u(2u));
        near_quarter = 1u;
    } else {
        let window = near_windows[0];
        near_square = square_within(whole, window.xy, window.zw);
    }
}

// Adds the lit samples of this thread's row to the places, in pieces.
fn near_add_places(lane: u32) {
    let half = places_whole.half;
    let sample = 2.0 * half / vec2f(f32(row_width), f32(SIDE));
    let origin = places_whole.center - half;
    let piece = row_width / (2u * PLACES_SIDE);
    for (var first = 0u; first < row_width; first += piece) {
        let samples = row_without(row_without(lit, row_span(0u, first)), row_span(first + piece, row_width));
        if (!row_is_none(samples)) {
            let ends = row_bounds(samples);
            places_add(
                origin + (vec2f(f32(ends.x), f32(lane)) - NEAR_ROOM) * sample,
                origin + (vec2f(f32(ends.y), f32(lane + 1u)) + NEAR_ROOM) * sample
            );
        }
    }
}

// Writes the windows: none if nothing is lit or marked. `box`: around the lit samples. Where openings between samples are marked, no more than
// a few outlines are before the light, so that there are several masks for each window. By one thread.
fn near_divide(whole: UnitSquare, box: vec4f, may_divide: bool, is_marked: bool) {
    var low = select(-box.xy, vec2f(1e30), box.z < -1e29);
    var high = select(box.zw, vec2f(-1e30), box.z < -1e29);
    var sum = 0.0;
    var count = 0u;
    // No constant, or compilers would copy the loop's body for each cell.
    let cells = select(0u, PLACES_CELLS, atomicLoad(&places_count) > 0u);
    for (var cell = 0u; cell < cells; cell++) {
        if (places_has(cell)) {
            let window = places_box(cell);
            near_windows[count] = window;
            let size = window.zw - window.xy;
            sum += size.x * size.y;
            low = min(low, window.xy);
            high = max(high, window.zw);
            count += 1u;
        }
    }
    let all = min(high, whole.center + whole.half) - max(low, whole.center - whole.half);
    let is_patch = outline_has_sides();
    let has_parts = NEAR_PARTS > 1u && is_marked && count > 0u;
    if (may_divide && (has_parts || (count > 1u && sum < NEAR_SMALLER * all.x * all.y))) {
        near_parts = select(1u, NEAR_PARTS, has_parts);
        near_cells = count * near_parts * near_parts;
        near_count = near_cells;
    } else if (all.x > 0.0 && all.y > 0.0) {
        near_windows[0] = vec4f(low, high);
        near_count = 1u;
        if (NEAR_PARTS > 1u && may_divide && is_patch && places_are_listed) {
            near_parts = NEAR_PARTS;
            near_cells = NEAR_PARTS * NEAR_PARTS;
        }
    }
}

// After the mask of the window is drawn: whether it stays, else the window is the next one. `count`: its lit samples. Requires uniform
// control flow.
fn near_stays(lane: u32, whole: UnitSquare, count: f32) -> bool {
    let box = largest(lane, near_box);
    near_box = vec4f(-1e30);
    if (count == 0.0 && near_quarter > 0u && near_quarter < 4u) {
        near_square = square_part(whole, near_quarter, vec2u(2u));
        near_quarter++;
        return false;
    }
    near_quarter = 0u;
    let low = near_square.center - near_square.half;
    let high = near_square.center + near_square.half;
    let size = high - low;
    let limit_low = whole.center - whole.half;
    let limit_high = whole.center + whole.half;
    // Lit samples at a side continue beyond it.
    let touch = 0.5 * NEAR_ROOM * size / vec2f(f32(row_width), f32(SIDE));
    let room = 1e-3 * size;
    let at_low = (-box.xy < low - touch) & (low > limit_low + room);
    let at_high = (box.zw > high + touch) & (high < limit_high - room);
    let next_low = select(max(-box.xy, limit_low), low - 0.5 * size, at_low);
    let next_high = select(min(box.zw, limit_high), high + 0.5 * size, at_high);
    let next = next_high - next_low;
    let grows = any(at_low) || any(at_high);
    let is_filled = NEAR_FILLED * count >= f32(row_width * SIDE) || any(size < vec2f(2.0 * THINNEST * whole.disc));
    if (count == 0.0 || (!grows && (is_filled || 2.0 * next.x * next.y > size.x * size.y))) {
        return true;
    }
    near_square = square_within(whole, next_low, next_high);
    return false;
}

// The mask `near_index` of the window `square` counts beside those of the whole light, whose window is divided so.
fn near_scale_of(square: UnitSquare, grid: vec2u) -> f32 {
    let whole = places_whole.half;
    return square.half.x * square.half.y * f32(grid.x * grid.y) / (whole.x * whole.y);
}

fn near_window(whole: UnitSquare, index: u32) -> UnitSquare {
    let count = near_parts * near_parts;
    let window = near_windows[index / count];
    return square_part(square_within(whole, window.xy, window.zw), index % count, vec2u(near_parts));
}

// The window that was tried is that of the mask.
fn near_keep(lane: u32, square: UnitSquare) {
    if (lane == 0u) {
        near_count = 1u;
        near_windows[0] = vec4f(square.center - square.half, square.center + square.half);
    }
}
