// Masks around the lit part of a light, if that is small: as `NearMasks`, but one of a window that shrinks or grows until the lit part fills it,
// or one in each of a few cells.

// Their windows, the lower corner and the upper one in plane coordinates, and their number.
var<workgroup> near_windows: array<vec4f, PLACES_CELLS>;
var<workgroup> near_count: u32;
// The masks that are drawn in cells, 0 for one window.
var<workgroup> near_cells: u32;
// Whether the lit part of the whole light is known with its area, the same for all threads.
var<private> near_is_area: bool;
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
    near_is_area = false;
    places_clear(lane);
    if (lane == 0u) {
        near_count = 0u;
        near_cells = 0u;
    }
}

fn near_is_wide() -> bool { return max(places_whole.half.x, places_whole.half.y) > NEAR_WIDE; }

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

// Of all masks of the whole light the lit and the emitting samples, the rows with lit ones, and those of them that end where the light does; the number
// of rows, and columns with lit samples and those that end so.
struct NearCounts {
    lit: f32,
    emitting: f32,
    lit_rows: f32,
    row_ends: f32,
    rows: f32,
    columns: f32,
    column_ends: f32,
}

// Whether less than a part of the light is lit.
fn near_is_below(counts: NearCounts, part: f32) -> bool { return part * counts.lit < counts.emitting; }

// Whether so few samples are lit, or so few rows have any, that their number is no measure: `LitCounts::are_few`.
fn near_are_few(counts: NearCounts) -> bool {
    let is_few = near_is_below(counts, NEAR_LEAST) || NEAR_OF * counts.lit_rows < NEAR_FEW * counts.rows;
    return near_is_below(counts, NEAR_LITTLE) && is_few;
}

// Whether the lit part is that of an opening, which ends at blockers on two opposite sides; of an ordinary penumbra it ends where the light does.
fn near_is_opening(counts: NearCounts) -> bool {
    return counts.lit == 0.0 || frame.look_again > 1u || outline_has_sides()
        || NEAR_ENDS * counts.row_ends < counts.lit_rows || NEAR_ENDS * counts.column_ends < counts.columns;
}

// Whether a part of a sky, or less than a third of a wide light, is seen: behind a window that is all.
fn near_is_cut(counts: NearCounts) -> bool {
    let may_be = outline_has_sides() || (near_is_wide() && near_is_below(counts, NEAR_LITTLE));
    return may_be && counts.lit > 0.0 && counts.lit < counts.emitting;
}

// Whether the lit part is wanted with its area, where blockers can tell that, and whether masks are drawn again in windows around it otherwise: as
// `MaskVisibility::draw`.
fn near_wishes(counts: NearCounts, light: Cone) -> vec2<bool> {
    let is_dark = counts.lit == 0.0;
    let is_slight = near_is_below(counts, NEAR_SLIGHT);
    let is_few = near_are_few(counts);
    let is_cut = near_is_cut(counts);
    if (counts.emitting == 0.0 || !(is_slight || is_few || is_cut)) {
        return vec2<bool>(false);
    }
    let is_opening = near_is_opening(counts);
    let is_unsure = is_few && (is_opening || is_slight);
    let is_wide = frame.look_again > 1u || near_is_wide();
    let sin_sq = cone_sin_sq(light);
    let may_be_missed = is_dark && sin_sq >= NEAR_ASKS.x && sin_sq < NEAR_ASKS.y;
    let seeks = is_cut || (is_opening && (is_wide || outline_has_sides() || may_be_missed));
    // The lit ones may all be one more, or one less, in a row after another.
    let is_narrow = is_slight && NEAR_NARROW * counts.lit < counts.lit_rows * f32(row_width);
    let has_windows = is_unsure || (is_narrow && is_opening && is_wide && !outline_has_sides());
    // Where other blockers hide a part of what is lit, its area stays unknown.
    let is_mixed = BLOCKERS_ARE_SEVERAL && seeks;
    return vec2<bool>(seeks || is_unsure, is_mixed || select(has_windows, frame.look_again > 1u, is_dark));
}

// After the masks of the whole light, of which `sums` has the lit and the emitting samples, the rows with lit ones and those of them that end where the
// light does: 1 if its lit part is wanted with its area, the masks that are drawn in cells, and the windows that are to be drawn without the area.
// `is_one`: whether there is one mask. Requires uniform control flow.
fn near_plan(lane: u32, sums: vec4f, rows: u32, is_one: bool, light: Cone) -> vec3u {
    var counts = NearCounts(sums.x, sums.y, sums.z, sums.w, f32(rows), 0.0, 0.0);
    if (!decide(lane, near_is_below(counts, NEAR_LITTLE) || near_is_cut(counts))) {
        return vec3u(0u);
    }
    if (decide(lane, is_one)) {
        let columns = near_columns_of(lane);
        counts.columns = columns.x;
        counts.column_ends = columns.y;
    }
    let wishes = near_wishes(counts, light);
    let wants_area = u32(decide(lane, wishes.x));
    if (!decide(lane, wishes.y)) {
        return vec3u(wants_area, 0u, 0u);
    }
    near_first(lane, places_whole, is_one);
    let cells = workgroupUniformLoad(&near_cells);
    return vec3u(wants_area, cells, max(cells, 1u));
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
    let box = largest(lane, near_box);
    near_box = vec4f(-1e30);
    near_quarter = 0u;
    if (is_one) {
        near_add_places(lane);
    }
    workgroupBarrier();
    if (lane == 0u) {
        near_divide(whole, box, is_one);
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

// Writes the windows: none if nothing is lit. `box`: around the lit samples. By one thread.
fn near_divide(whole: UnitSquare, box: vec4f, may_divide: bool) {
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
    if (may_divide && count > 1u && sum < NEAR_SMALLER * all.x * all.y) {
        near_cells = count;
        near_count = count;
    } else if (all.x > 0.0 && all.y > 0.0) {
        near_windows[0] = vec4f(low, high);
        near_count = 1u;
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
    let window = near_windows[index];
    return square_within(whole, window.xy, window.zw);
}

// The window of the mask that stays.
fn near_keep(lane: u32, square: UnitSquare) {
    if (lane == 0u) {
        near_count = 1u;
        near_windows[0] = vec4f(square.center - square.half, square.center + square.half);
    }
}
