// The visibility mask, one row a thread: thread j of the workgroup has row j; threads from SIDE on have an empty one.

struct Mask {
    square: UnitSquare,
    // Plane coordinate of the window's left side, and samples per unit of plane coordinates.
    left: f32,
    scale: f32,
}

// The conversion from plane coordinates to rows and samples: row line `j` is at height `j + ½` of `(y − bottom)·rows`; samples are
// counted from `(x − left)·samples`, minus the shift of the row.
struct Raster { left: f32, bottom: f32, samples: f32, rows: f32 }

// Samples of the row that emit and are not blocked.
var<private> lit: Row;
// Emitting samples of the row: start, end.
var<private> emitting: vec2u;

// The first sample at or after a position (sample k is at k + ½), 0…row_width; 0 for NaN.
fn row_index(position: f32) -> u32 {
    let x = select(0.0, position, position > 0.0);
    return u32(round(min(x, f32(row_width))));
}

fn row_indices(positions: vec4f) -> vec4u {
    let x = select(vec4f(0.0), positions, positions > vec4f(0.0));
    return vec4u(round(min(x, vec4f(f32(row_width)))));
}

// Number of bands of SIDE rows in which a mask is drawn, and the number of its rows before this band.
var<private> row_bands: u32 = 1u;
var<private> row_first: u32 = 0u;

// Shift of the samples of row `j`, in samples within ±½: the fraction of a multiple of the golden section, by its bits.
fn row_phase(j: u32) -> f32 {
    return f32(bitcast<i32>(((2u * (j + row_first) + 1u) * GOLDEN) ^ 0x80000000u)) * 0x1p-32f;
}

// Height of line `k` above the row's own, in rows within ±½.
fn row_height(k: u32) -> f32 { return (f32(k) + 0.5) * 0.125 - 0.5; }

fn mask_of(square: UnitSquare) -> Mask {
    return Mask(square, square.center.x - square.half.x, f32(row_width) / (2.0 * square.half.x));
}

// Clears the row: no blocker; the light's disc above the horizon of `normal` (world space) emits.
fn mask_reset(square: UnitSquare, j: u32, normal: vec3f) -> Mask {
    let mask = mask_of(square);
    let n = square_local(square, normal);
    let above = n.z > 0.0 && n.z * n.z >= square.disc * square.disc * dot(n.xy, n.xy);
    if (!light_is_flat() && above && all(square.half == vec2f(square.disc)) && all(square.center == vec2f(0.0))) {
        // All whole discs have the same samples.
        let unit = UnitSquare(square.right, square.up, square.axis, vec2f(0.0), vec2f(1.0), 1.0);
        mask_emit(Mask(unit, -1.0, f32(row_width) * 0.5), j, vec3f(0.0, 0.0, 1.0));
    } else {
        mask_emit(mask, j, n);
    }
    return mask;
}

// Computes the emitting samples, with the normal in the square's frame.
fn mask_emit(mask: Mask, j: u32, n: vec3f) {
    let ends = mask_emits_at(mask, mask_row_y(mask, j), n);
    emitting = select(vec2u(0u), mask_samples(mask, j, ends.x, ends.y), j < SIDE);
    lit = row_span(emitting.x, emitting.y);
}

// The emitting part of a line at height `y`, in plane coordinates x; empty if it is not from less to more.
fn mask_emits_at(mask: Mask, y: f32, n: vec3f) -> vec2f {
    let disc = light_disc(mask.square);
    let off = y - disc.y;
    let half = sqrt(max(disc.z * disc.z - off * off, 0.0));
    return mask_above(light_row(vec2f(disc.x - half, disc.x + half), y), y, n);
}

// The part of a line above a plane through the receiver, with this normal in the square's frame: n.x x + n.y y + n.z > 0.
fn mask_above(ends: vec2f, y: f32, n: vec3f) -> vec2f {
    let rest = n.y * y + n.z;
    if (n.x > 0.0) {
        return vec2f(max(ends.x, -rest / n.x), ends.y);
    } else if (n.x < 0.0) {
        return vec2f(ends.x, min(ends.y, -rest / n.x));
    }
    return vec2f(ends.x, select(ends.y, ends.x, rest <= 0.0));
}

// Sides of a cell in plane coordinates.
fn mask_cell(mask: Mask) -> vec2f { return 2.0 * mask.square.half / f32(SIDE); }

// Plane coordinate y of row `j`.
fn mask_row_y(mask: Mask, j: u32) -> f32 {
    return mask.square.center.y + ((f32(j) + 0.5) - 0.5 * f32(SIDE)) * mask_cell(mask).y;
}

// Plane coordinates of the centre of cell `i` of row `j`.
fn mask_cell_center(mask: Mask, i: u32, j: u32) -> vec2f {
    return vec2f(
        mask.square.center.x + ((f32(i) + 0.5) - 0.5 * f32(SIDE)) * mask_cell(mask).x,
        mask_row_y(mask, j)
    );
}

fn mask_raster(mask: Mask) -> Raster {
    let half = mask.square.half.y;
    return Raster(mask.left, mask.square.center.y - half, mask.scale, f32(SIDE) / (2.0 * half));
}

// Converts a plane coordinate x to a sample, without a shift.
fn mask_sample(mask: Mask, x: f32) -> u32 { return row_index((x - mask.left) * mask.scale); }

// Converts plane coordinates x to samples of row `j`, clamped to the row. An empty or NaN interval gives an empty one.
fn mask_samples(mask: Mask, j: u32, start: f32, end: f32) -> vec2u {
    let phase = row_phase(j);
    let a = row_index((start - mask.left) * mask.scale - phase);
    let b = row_index((end - mask.left) * mask.scale - phase);
    return select(vec2u(0u), vec2u(a, b), start < end);
}

// Blocks the row `j` between two plane coordinates x; these may be infinite; an empty or NaN interval blocks nothing.
fn mask_block_span(mask: Mask, j: u32, start: f32, end: f32) {
    let samples = mask_samples(mask, j, start, end);
    mask_block_samples(samples.x, samples.y);
}

// Blocks everything in the row `j` below the plane through the receiver with this normal (world space), and returns the emitting
// samples above it: start, end.
fn mask_block_below(mask: Mask, j: u32, normal: vec3f) -> vec2u {
    let n = square_local(mask.square, normal);
    let rest = n.y * mask_row_y(mask, j) + n.z;
    var below = vec2u(0u);
    if (n.x > 0.0) {
        below = mask_samples(mask, j, -1e30, -rest / n.x);
    } else if (n.x < 0.0) {
        below = mask_samples(mask, j, -rest / n.x, 1e30);
    } else if (rest <= 0.0) {
        below = vec2u(0u, row_width);
    }
    mask_block_samples(below.x, below.y);
    if (below.x >= below.y) {
        return emitting;
    }
    return select(
        vec2u(emitting.x, min(emitting.y, below.x)),
        vec2u(max(emitting.x, below.y), emitting.y),
        below.x == 0u
    );
}

// Blocks samples `start..end` of the row: for shapes that compute the samples themselves, with mask_raster and row_phase.
fn mask_block_samples(start: u32, end: u32) { lit = row_without(lit, row_span(start, end)); }

// Blocks samples of the row `j` at height `k`, one of eight. Of every eight samples one is at this height, a different one in each
// row. For shapes whose edge runs along the row; `start` and `end` are without a shift.
fn mask_block_line(j: u32, k: u32, start: u32, end: u32) {
    // Bits reversed, so that any few heights are spread evenly.
    let order = ((k & 1u) << 2u) | (k & 2u) | (k >> 2u);
    lit = row_without_line(lit, (order + j) & 7u, start, end);
}

// Heights of four of the eight lines of row `j`, as row_height; `first` is 0 or 4.
fn mask_heights(j: u32, first: u32) -> vec4f {
    let order = (vec4u(0u, 1u, 2u, 3u) + (first - j)) & vec4u(7u);
    let k = ((order & vec4u(1u)) << vec4u(2u)) | (order & vec4u(2u)) | (order >> vec4u(2u));
    return (vec4f(k) + 0.5) * 0.125 - 0.5;
}

// Blocks the same as mask_block_line on the four lines that have these heights.
fn mask_block_lines(first: u32, starts: vec4u, ends: vec4u) { lit = row_without_lines(lit, first, starts, ends); }

// Blocks those of samples 32k … 32k + 31 of the row whose bit is set.
fn mask_block_set(k: u32, bits: u32) { lit = row_without_samples(lit, k, bits); }

// Blocks every sample of the row.
fn mask_block_all() { lit = row_none(); }

// True if no sample of the row is lit.
fn mask_is_row_dark() -> bool { return row_is_none(lit); }
