// The cells of contour.wgsl: the ones that are tested, and the known results of their neighbours.

fn contour_known_of(j: u32) -> vec2u {
    return vec2u(atomicLoad(&contour_known[2u * j]), atomicLoad(&contour_known[2u * j + 1u]));
}

fn contour_dark_of(j: u32) -> vec2u {
    return vec2u(atomicLoad(&contour_dark[2u * j]), atomicLoad(&contour_dark[2u * j + 1u]));
}

// Cells of a row of which samples emit.
fn contour_cells(span: vec2u) -> vec2u {
    let width = row_width / SIDE;
    let cells = bits_ones((span.y + width - 1u) / width) & ~bits_ones(span.x / width);
    return select(vec2u(0u), cells, span.x < span.y);
}

// Part of a cell that emits, as (start, length) in cells.
fn contour_part(i: u32, j: u32) -> vec2f {
    let ends = vec2f(contour_spans[j]) / f32(row_width / SIDE);
    let at = clamp(ends, vec2f(f32(i)), vec2f(f32(i) + 1.0));
    return vec2f(at.x, max(at.y - at.x, 0.0));
}

// The position in its row at which a cell is tested: the centre of its emitting part. In rows of at least four cells the outermost
// cells are tested at the ends of the row.
fn contour_sample(mask: Mask, i: u32, j: u32) -> f32 {
    let cells = contour_emit[j];
    let part = contour_part(i, j);
    let first = bits_first(cells);
    let last = bits_last(cells);
    var at = part.x + 0.5 * part.y;
    if (last >= first + 3u && i == first) {
        at = part.x;
    } else if (last >= first + 3u && i == last) {
        at = part.x + part.y;
    }
    return mask_cell_center(mask, 0u, j).x + (at - 0.5) * mask_cell(mask).x;
}

fn contour_mark(i: u32, j: u32) { atomicOr(&contour_marks[2u * j + i / 32u], 1u << (i & 31u)); }

// Marks cells all around the rim.
fn contour_rim(lane: u32) {
    var first = SIDE;
    var last = 0u;
    for (var j = 0u; j < SIDE; j++) {
        if (bits_any(contour_emit[j])) {
            first = min(first, j);
            last = j;
        }
    }
    if (lane >= 32u || first > last) {
        return;
    }
    let middle = contour_emit[(first + last) / 2u];
    let center = 0.5 * vec2f(f32(bits_first(middle) + bits_last(middle) + 1u), f32(first + last + 1u));
    var rim = CONTOUR_RIM;
    var toward = rim[lane % 8u];
    for (var k = lane / 8u; k > 0u; k--) {
        toward = vec2f(-toward.y, toward.x);
    }
    for (var way = 0.75 * f32(SIDE); way >= 0.0; way -= 0.5) {
        let cell = vec2i(floor(center + way * toward));
        if (all(cell >= vec2i(0)) && all(cell < vec2i(i32(SIDE)))) {
            let at = vec2u(cell);
            if (bits_has(contour_emit[at.y], at.x)) {
                contour_mark(at.x, at.y);
                return;
            }
        }
    }
}

// The centre cell of a block if it emits, else one that is known, else the emitting cell nearest to the centre; the last component
// is 0 if there is none.
fn contour_representative(corner: vec2u, size: u32) -> vec3u {
    let middle = corner + size / 2u;
    if (bits_has(contour_emit[middle.y], middle.x)) {
        return vec3u(middle, 1u);
    }
    var best = 0x7fffffff;
    var found = vec3u(0u);
    for (var y = corner.y; y < corner.y + size; y++) {
        let known = contour_known_of(y);
        for (var x = corner.x; x < corner.x + size; x++) {
            if (bits_has(known, x)) {
                return vec3u(x, y, 1u);
            }
            let d = vec2i(vec2u(x, y)) - vec2i(middle);
            let distance = d.x * d.x + d.y * d.y;
            if (bits_has(contour_emit[y], x) && distance < best) {
                best = distance;
                found = vec3u(x, y, 1u);
            }
        }
    }
    return found;
}

// Marks one cell of each of `blocks`² blocks.
fn contour_coarse(lane: u32, blocks: u32) {
    let size = SIDE / blocks;
    for (var b = lane; b < blocks * blocks; b += LANES) {
        let cell = contour_representative(size * vec2u(b % blocks, b / blocks), size);
        if (cell.z != 0u) {
            contour_mark(cell.x, cell.y);
        }
    }
}

// The untested cells take the result of their block's cell.
fn contour_fill(lane: u32, blocks: u32) {
    let size = SIDE / blocks;
    for (var b = lane; b < blocks * blocks; b += LANES) {
        let corner = size * vec2u(b % blocks, b / blocks);
        let cell = contour_representative(corner, size);
        if (cell.z == 0u) {
            continue;
        }
        let hidden = bits_has(contour_dark_of(cell.y), cell.x);
        let columns = bits_ones(corner.x + size) & ~bits_ones(corner.x);
        for (var j = corner.y; j < corner.y + size; j++) {
            let others = columns & ~contour_known_of(j);
            for (var word = 0u; word < 2u; word++) {
                if (hidden) {
                    atomicOr(&contour_dark[2u * j + word], others[word]);
                } else {
                    atomicAnd(&contour_dark[2u * j + word], ~others[word]);
                }
            }
        }
    }
}

// The unknown cells among neighbours that differ.
fn contour_open(lane: u32) -> vec2u {
    var differ = contour_steps(lane);
    if (lane > 0u) {
        differ |= contour_differ(lane, lane - 1u);
    }
    if (lane + 1u < SIDE) {
        differ |= contour_differ(lane, lane + 1u);
    }
    return differ & contour_emit[lane] & ~contour_known_of(lane);
}

// Cells of row `j` that differ from a neighbour in row `k`; along the rim, cells that touch at a corner are neighbours too.
fn contour_differ(j: u32, k: u32) -> vec2u {
    let hides = contour_dark_of(j);
    let other = contour_dark_of(k);
    let rim = contour_rim_cells(k);
    let beside = ((hides ^ bits_up(other)) & bits_up(rim)) | ((hides ^ bits_down(other)) & bits_down(rim));
    return ((hides ^ other) & contour_emit[k]) | (beside & contour_rim_cells(j));
}

// Cells of row `j` at the rim of the emitting region: one of their four neighbours does not emit.
fn contour_rim_cells(j: u32) -> vec2u {
    let e = contour_emit[j];
    var inner = bits_up(e) & bits_down(e);
    if (j == 0u || j + 1u >= SIDE) {
        inner = vec2u(0u);
    } else {
        inner &= contour_emit[j - 1u] & contour_emit[j + 1u];
    }
    return e & ~inner;
}

// Single lit or dark cells between two others in a row or column.
fn contour_thin(lane: u32) -> vec2u {
    let e = contour_emit[lane];
    let d = contour_dark_of(lane);
    var thin = (d ^ bits_up(d)) & (d ^ bits_down(d)) & bits_up(e) & bits_down(e);
    if (lane > 0u && lane + 1u < SIDE) {
        let apart = (d ^ contour_dark_of(lane - 1u)) & (d ^ contour_dark_of(lane + 1u));
        thin |= apart & contour_emit[lane - 1u] & contour_emit[lane + 1u];
    }
    return thin & e;
}

// Cells of row `j` that differ from their left or right neighbour, if both emit.
fn contour_steps(j: u32) -> vec2u {
    let emits = contour_emit[j];
    let hides = contour_dark_of(j);
    let right = (hides ^ bits_down(hides)) & emits & bits_down(emits);
    return right | bits_up(right);
}
