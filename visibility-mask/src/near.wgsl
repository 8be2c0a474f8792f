// A mask around the lit part of a light, if that is small: as `NearMasks`, but for one window, which is not divided.

// Whether there is such a mask.
var<workgroup> near_is_there: bool;
// Its window, and the area of its samples over that of the whole light's.
var<private> near_square: UnitSquare;
var<private> near_scale: f32;
// Where nothing is lit, the number of the quarter of the light that is looked at next; else 0.
var<private> near_quarter: u32;
// Emitting samples of all rows, and bits of columns: with lit samples, and with such that end where the light does.
var<workgroup> near_emitting: array<vec2u, LANES>;
var<workgroup> near_columns: array<atomic<u32>, 16>;
// The corners of a box around this thread's lit samples, the lower one negated.
var<private> near_box: vec4f;

fn near_begin(lane: u32) {
    near_box = vec4f(-1e30);
    if (lane == 0u) {
        near_is_there = false;
    }
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
// lit ones; there are `rows` in all. Where none is lit, an opening between samples may be looked for.
fn near_is_little(counts: vec4f, rows: u32) -> bool {
    if (counts.x == 0.0) {
        return frame.look_again > 1u && counts.y > 0.0;
    }
    let is_few = NEAR_LEAST * counts.x < counts.y || NEAR_OF * counts.z < NEAR_FEW * f32(rows);
    return frame.look_again > 0u && NEAR_LITTLE * counts.x < counts.y && is_few;
}

// Whether that is looked at again: of an opening the lit part ends at blockers on two opposite sides, of an ordinary penumbra where the light does,
// of which that is done if it is slight. `counts` has the lit and the emitting samples, the rows with lit samples and those of them that end where the light does, `columns` the same across them.
fn near_is_opening(counts: vec4f, columns: vec2f) -> bool {
    let is_opening = NEAR_ENDS * counts.w < counts.z || NEAR_ENDS * columns.y < columns.x;
    let is_slight = NEAR_SLIGHT * counts.x < counts.y;
    return is_opening || is_slight || frame.look_again > 1u || outline_has_sides();
}

// Of the mask that was drawn last the columns with lit samples, and those of them that end where the light does. Requires uniform control flow.
fn near_columns_of(lane: u32) -> vec2f {
    near_emitting[lane] = emitting;
    if (lane < 16u) {
        atomicStore(&near_columns[lane], 0u);
    }
    workgroupBarrier();
    if (!row_is_none(lit)) {
        near_gather(0u, lit);
        for (var k = 0u; k < 2u; k++) {
            let is_last = lane == select(0u, SIDE - 1u, k > 0u);
            let beside = near_emitting[select(lane + 2u * k - 1u, lane, is_last)];
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

// The first window: around all lit samples, or where none is lit a quarter of the light. Requires uniform control flow.
fn near_first(lane: u32, whole: UnitSquare) {
    let box = largest(lane, near_box);
    near_box = vec4f(-1e30);
    near_quarter = 0u;
    if (box.z < -1e29) {
        near_square = square_part(whole, 0u, vec2u(2u));
        near_quarter = 1u;
    } else {
        near_square = square_within(whole, -box.xy, box.zw);
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

// The mask that was drawn last, with the window `square`, counts beside those of the whole light, whose window is divided so.
fn near_keep(lane: u32, square: UnitSquare, grid: vec2u) {
    if (lane == 0u) {
        near_is_there = true;
    }
    near_square = square;
    let whole = visibility_whole.half;
    near_scale = square.half.x * square.half.y * f32(grid.x * grid.y) / (whole.x * whole.y);
}
