// The lit part of a mask's window with its exact area, from outlines: the twin of `blockers/trapezoids.rs`. Each thread has the heights of its row, divided where
// outlines end, and at two lines between each two of them finds the parts of the line with the fewest surfaces.

// Heights of a row are SILHOUETTES_SLAB from each other at least; after this number of steps SILHOUETTES_THICK: drivers end loops that take long.
const SILHOUETTES_STEPS = 3072u;
// The most steps between two heights.
const SILHOUETTES_MOST = 8192u;

// The lit part of a row: the fewest surfaces, the largest of its pieces as a part of the row, and the middle of that, in samples without a shift
// and in rows from the middle of the lowest one.
struct SilhouetteArea {
    least: i32,
    part: f32,
    middle: vec2f,
}

// A piece of an outline, which crosses heights from `low` to `high`.
struct SilhouettePiece {
    low: f32,
    high: f32,
    // Its place at the lower end, and how that grows.
    x: f32,
    slope: f32,
    // The growth of the number of surfaces from left to right, and what the lower end and all of it add on the left of the window.
    growth: i32,
    below: i32,
    above: i32,
}

fn silhouettes_piece(k: u32) -> SilhouettePiece {
    let first = SILHOUETTES_PIECE * k;
    let packed = atomicLoad(&silhouettes_counts[first + 4u]);
    let growth = (packed >> 2u) - 8;
    let low_left = packed & 1;
    let high_left = (packed >> 1u) & 1;
    return SilhouettePiece(
        bitcast<f32>(atomicLoad(&silhouettes_counts[first])),
        bitcast<f32>(atomicLoad(&silhouettes_counts[first + 1u])),
        bitcast<f32>(atomicLoad(&silhouettes_counts[first + 2u])),
        bitcast<f32>(atomicLoad(&silhouettes_counts[first + 3u])),
        growth,
        -growth * low_left,
        growth * (high_left - low_left)
    );
}

// Bits of the pieces at heights of the thread's row, and of those between two of these heights; and the number of surfaces on the left of the window below them.
const SILHOUETTES_FLAGS = (SILHOUETTES_PIECES + 31u) / 32u;
var<private> silhouettes_in_row: array<u32, SILHOUETTES_FLAGS>;
var<private> silhouettes_between: array<u32, SILHOUETTES_FLAGS>;
var<private> silhouettes_base: i32;

// The piece after a number, or the first one after none.
fn silhouettes_next(before: u32, in_row: bool) -> u32 {
    let first = before + 1u;
    for (var word = first / 32u; 32u * word < atomicLoad(&silhouettes_pieces); word++) {
        var bits = select(silhouettes_between[word], silhouettes_in_row[word], in_row);
        bits &= select(0xffffffffu, 0xffffffffu << (first % 32u), word == first / 32u);
        if (bits != 0u) {
            return 32u * word + firstTrailingBit(bits);
        }
    }
    return SILHOUETTES_NONE;
}

// Sets the pieces of the row from `low` to `high`, and returns the number on the left below them.
fn silhouettes_set_row(low: f32, high: f32) -> i32 {
    var base = 0;
    for (var k = 0u; k < SILHOUETTES_FLAGS; k++) {
        silhouettes_in_row[k] = 0u;
    }
    for (var k = 0u; k < atomicLoad(&silhouettes_pieces); k++) {
        let piece = silhouettes_piece(k);
        if (piece.high <= low) {
            base += piece.above;
        } else if (piece.low < high) {
            silhouettes_in_row[k / 32u] |= 1u << (k % 32u);
        }
    }
    return base;
}

// Sets those between two heights of it. Returns the steps that two lines there take at most.
fn silhouettes_set_between(low: f32, high: f32, base: i32) -> u32 {
    silhouettes_base = base;
    for (var k = 0u; k < SILHOUETTES_FLAGS; k++) {
        silhouettes_between[k] = 0u;
    }
    var all = 0u;
    var begins = 1u;
    for (var k = SILHOUETTES_NONE;;) {
        k = silhouettes_next(k, true);
        if (k == SILHOUETTES_NONE) {
            break;
        }
        let piece = silhouettes_piece(k);
        if (piece.high <= low) {
            silhouettes_base += piece.above;
        } else if (piece.low < high) {
            silhouettes_between[k / 32u] |= 1u << (k % 32u);
            all++;
            begins += u32(piece.growth < 0);
        }
    }
    return 2u * all * begins;
}

// Whether the lit part can be found: all silhouettes are listed, and no triangles are cut.
fn silhouettes_are_listed() -> bool { return silhouettes_known != 0u && atomicLoad(&silhouettes_cut) == 0u; }

// Lists the pieces of outlines in the window. Requires uniform control flow.
fn silhouettes_gather(lane: u32, eye: SilhouetteEye) {
    if (lane == 0u) {
        atomicStore(&silhouettes_pieces, 0u);
    }
    workgroupBarrier();
    for (var k = lane; k < atomicLoad(&silhouettes_found); k += LANES) {
        let entry = silhouettes_list[k];
        let ends = silhouettes_data[silhouettes_data[0].w + entry / 8u];
        let segment = silhouettes_segment(silhouettes_from(eye.x, ends.x), silhouettes_from(eye.x, ends.y));
        if (segment.is_some) {
            silhouettes_list_piece(segment.a.xy / segment.a.z, segment.b.xy / segment.b.z, segment.line, i32(entry % 8u) - 2);
        }
    }
    workgroupBarrier();
}

// Finds the lit part of the thread's row, among parts with more surfaces than `above`. Where that takes too long the number of pieces grows to one that is too large.
fn silhouettes_row(lane: u32, mask: Mask, above: i32) -> SilhouetteArea {
    var area = SilhouetteArea(0x7fffffff, 0.0, vec2f(0.0));
    area_clear();
    if (lane >= SIDE) {
        return area;
    }
    let top = f32(lane) + 0.5;
    var low = top - 1.0;
    let base = silhouettes_set_row(low, top);
    var steps = 0u;
    while (low < top) {
        let next = low + select(SILHOUETTES_SLAB, SILHOUETTES_THICK, steps > SILHOUETTES_STEPS);
        var high = top;
        for (var k = SILHOUETTES_NONE;;) {
            k = silhouettes_next(k, true);
            if (k == SILHOUETTES_NONE) {
                break;
            }
            let piece = silhouettes_piece(k);
            high = select(high, piece.low, piece.low > next && piece.low < high);
            high = select(high, piece.high, piece.high > next && piece.high < high);
            steps++;
        }
        let more = silhouettes_set_between(low, high, base);
        steps += more;
        if (more > SILHOUETTES_MOST) {
            atomicMax(&silhouettes_pieces, SILHOUETTES_PIECES + 1u);
            return area;
        }
        // 2, which compilers do not know: they would copy the loop's body.
        for (var line = 0u; line < 1u + silhouettes_known; line++) {
            let half = 0.5 * (high - low);
            let y = low + half * (1.0 + select(-2.0, 2.0, line > 0u) * SILHOUETTES_GAUSS);
            area = silhouettes_line(area, lane, mask, above, y, half);
        }
        low = high;
    }
    return area;
}

// Adds the parts of a line with the fewest surfaces, or begins again with them if they have fewer than all before.
fn silhouettes_line(before: SilhouetteArea, lane: u32, mask: Mask, above: i32, y: f32, height: f32) -> SilhouetteArea {
    var area = before;
    let raster = silhouettes_view.raster;
    let at = raster.bottom + (y + 0.5) / raster.rows;
    var ends = mask_above(mask_emits_at(mask, at, silhouettes_horizon), at, silhouettes_face);
    ends = clamp((ends - raster.left) * raster.samples, vec2f(0.0), vec2f(f32(row_width)));
    // From the beginning, and from each piece behind which there are fewer surfaces.
    var begin = ends.x;
    var piece_number = SILHOUETTES_NONE;
    var is_more = ends.x < ends.y;
    while (is_more) {
        let part = silhouettes_part(vec2f(begin, ends.y), piece_number, y);
        let width = (part.end - begin) / f32(row_width);
        if (part.is_new && part.number > above && part.number <= area.least && width > AREA_NARROWEST) {
            if (part.number < area.least) {
                area = SilhouetteArea(part.number, 0.0, vec2f(0.0));
                area_clear();
            }
            area_add(begin, part.end, y - f32(lane), height);
            if (width * height > area.part) {
                area.part = width * height;
                area.middle = vec2f(0.5 * (begin + part.end), y);
            }
        }
        is_more = false;
        while (!is_more) {
            piece_number = silhouettes_next(piece_number, false);
            if (piece_number == SILHOUETTES_NONE) {
                break;
            }
            let piece = silhouettes_piece(piece_number);
            begin = piece.x + (y - piece.low) * piece.slope;
            is_more = piece.growth < 0 && y >= piece.low && y < piece.high && begin > ends.x && begin < ends.y;
        }
    }
    return area;
}

// A part of a line: the surfaces before it, its end, and whether no piece with a lower number begins it as well.
struct SilhouettePart { number: i32, end: f32, is_new: bool }

// The part from `ends.x` to the next piece, or to `ends.y`. `first`: the piece at its beginning, or none.
fn silhouettes_part(ends: vec2f, first: u32, y: f32) -> SilhouettePart {
    var part = SilhouettePart(silhouettes_base, ends.y, true);
    for (var k = SILHOUETTES_NONE;;) {
        k = silhouettes_next(k, false);
        if (k == SILHOUETTES_NONE) {
            break;
        }
        let piece = silhouettes_piece(k);
        let is_crossed = y >= piece.low && y < piece.high;
        let place = piece.x + (y - piece.low) * piece.slope;
        part.number += select(select(0, piece.above, y >= piece.high), piece.below, is_crossed);
        if (is_crossed && place <= ends.x) {
            part.number += piece.growth;
            part.is_new = part.is_new && !(place == ends.x && k < first && piece.growth < 0 && first != SILHOUETTES_NONE);
        } else if (is_crossed) {
            part.end = min(part.end, place);
        }
    }
    return part;
}
