// The lit part of a window with its exact area, which blockers with outlines may find: as `LitArea`, in columns of the mask's rows.

// Whether it is wanted: not at all, besides the samples of a mask, or instead of them.
const AREA_UNWANTED = 0u;
const AREA_BESIDE = 1u;
const AREA_ALONE = 2u;
var<private> area_wish: u32;
// Whether it was found, the same for all threads.
var<private> area_is_found: bool;

// The lit samples in each column of a row, which are not whole numbers, and how far their middle is above that of the row, in plane coordinates.
struct LitRow { columns: array<f32, COLUMNS>, above: f32 }

// That of the thread's row in the last window.
var<private> area_row: LitRow;
// Whether `area_row` counts instead of the mask's samples.
var<private> area_counts: bool;

// Sums of parts of the row, in steps of a column and of its width times half a row: no order of parts changes them.
const AREA_STEPS = 0x1p24f;
const AREA_LIFTS = 0x1p21f;
var<private> area_columns: array<u32, COLUMNS>;
var<private> area_lift: i32;

fn area_clear() {
    for (var k = 0u; k < 4u * row_groups; k++) {
        area_columns[k] = 0u;
    }
    area_lift = 0;
}

// Adds a part of a line `above` the middle of the row, from `start` to `end` in samples without a shift, which stands for the part `height` of the
// row. Each piece of it counts in the two columns beside its middle, so that sums of linear weights are exact.
fn area_add(start: f32, end: f32, above: f32, height: f32) {
    let most = 4u * row_groups;
    let scale = f32(most) / f32(row_width);
    let ends = vec2f(start, end) * scale;
    let last = min(u32(ends.y), most - 1u);
    for (var k = u32(ends.x); k <= last; k++) {
        let low = max(ends.x, f32(k));
        let high = min(ends.y, f32(k + 1u));
        let part = (high - low) * height;
        let beside = 0.5 * (low + high) - (f32(k) + 0.5);
        let next = select(max(k, 1u) - 1u, min(k + 1u, most - 1u), beside > 0.0);
        let moved = part * abs(beside);
        area_columns[next] += u32(moved * AREA_STEPS);
        area_columns[k] += u32((part - moved) * AREA_STEPS);
    }
    area_lift += i32((ends.y - ends.x) * height * above * AREA_LIFTS);
}

// Takes the sums as the row's lit part.
fn area_take(mask: Mask) {
    var sum = 0.0;
    for (var k = 0u; k < 4u * row_groups; k++) {
        let part = f32(area_columns[k]) / AREA_STEPS;
        sum += part;
        area_row.columns[k] = part * f32(row_width / (4u * row_groups));
    }
    area_row.above = mask_cell(mask).y * f32(area_lift) / (AREA_LIFTS * max(sum, 1e-9));
}
