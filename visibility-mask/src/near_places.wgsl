// Boxes around what is lit in each of 4 × 4 cells of the window of the whole light: as `places.rs`, but in cells that lie fixed. A cell has the length 1, in PLACES_STEPS steps.

const PLACES_SIDE = 4u;
const PLACES_CELLS = PLACES_SIDE * PLACES_SIDE;
const PLACES_NONE = -2147483647;

// The window of the whole light.
var<private> places_whole: UnitSquare;
// Emitting samples of all rows.
var<workgroup> places_emitting: array<vec2u, 1u + (LANES - 1u) * u32(LOOKS_AGAIN)>;
// Of each cell the lower corner of its box, negated, and the upper one.
var<workgroup> places_boxes: array<atomic<i32>, 1u + (4u * PLACES_CELLS - 1u) * u32(LOOKS_AGAIN)>;
// The number of boxes that were added.
var<workgroup> places_count: atomic<u32>;

fn places_clear(lane: u32) {
    for (var k = lane; k < 4u * PLACES_CELLS; k += LANES) {
        atomicStore(&places_boxes[k], PLACES_NONE);
    }
    if (lane == 0u) {
        atomicStore(&places_count, 0u);
    }
}

// Adds a box, in plane coordinates.
fn places_add(low: vec2f, high: vec2f) {
    atomicAdd(&places_count, 1u);
    let whole = places_whole;
    let scale = f32(PLACES_SIDE) / (2.0 * whole.half);
    let a = clamp((low - (whole.center - whole.half)) * scale, vec2f(0.0), vec2f(f32(PLACES_SIDE)));
    let b = clamp((high - (whole.center - whole.half)) * scale, vec2f(0.0), vec2f(f32(PLACES_SIDE)));
    let first = min(vec2u(a), vec2u(PLACES_SIDE - 1u));
    let last = min(vec2u(b), vec2u(PLACES_SIDE - 1u));
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let cell = vec2f(f32(x), f32(y));
            let lower = vec2i(max(a, cell) * PLACES_STEPS);
            let upper = vec2i(min(b, cell + 1.0) * PLACES_STEPS);
            let k = 4u * (PLACES_SIDE * y + x);
            atomicMax(&places_boxes[k], -lower.x);
            atomicMax(&places_boxes[k + 1u], -lower.y);
            atomicMax(&places_boxes[k + 2u], upper.x);
            atomicMax(&places_boxes[k + 3u], upper.y);
        }
    }
}

// The box of a cell that has one, in plane coordinates: its lower corner and the upper one.
fn places_box(cell: u32) -> vec4f {
    let low = -vec2f(f32(atomicLoad(&places_boxes[4u * cell])), f32(atomicLoad(&places_boxes[4u * cell + 1u])));
    let high = vec2f(f32(atomicLoad(&places_boxes[4u * cell + 2u])), f32(atomicLoad(&places_boxes[4u * cell + 3u])));
    let whole = places_whole;
    let step = 2.0 * whole.half / (f32(PLACES_SIDE) * PLACES_STEPS);
    let origin = whole.center - whole.half;
    return vec4f(origin + low * step, origin + high * step);
}

fn places_has(cell: u32) -> bool { return atomicLoad(&places_boxes[4u * cell]) > PLACES_NONE; }
