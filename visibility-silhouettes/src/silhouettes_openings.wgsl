// Openings between the samples of a mask: the twin of `blockers/openings.rs`.

// Where edge `k` is crossed by a row at its middle (`axis` 0), as a place in samples, or by a column at a place, as a row; and the growth of the
// number of surfaces, 0 if it is not crossed.
fn silhouettes_cross(k: u32, axis: u32, at: f32) -> vec2f {
    let line = silhouettes_lines[k];
    let crossed = silhouettes_crossed[k];
    let rows = vec2f(vec2u(crossed.z, crossed.z >> 8u) & vec2u(255u));
    let ends = select(rows, bitcast<vec2f>(crossed.xy), axis == 1u);
    let growth = f32((crossed.z >> (16u + 8u * axis)) & 255u) - 8.0;
    let place = line.xz + line.yw * at;
    return vec2f(select(place.x, place.y, axis == 1u), select(0.0, growth, at >= ends.x && at < ends.y));
}

// The intervals between samples of a row or a column that have the fewest surfaces, for the thread's row and its column. Marks those with the number
// `least`, or returns the widest of those with the fewest: the number, width as a part of the mask, and the middle in samples and rows.
fn silhouettes_openings(lane: u32, span: vec2u, marks: bool, least: i32) -> SilhouetteOpening {
    let raster = silhouettes_view.raster;
    let count = min(atomicLoad(&silhouettes_found), SILHOUETTES_LINES);
    let size = vec2f(f32(row_width), f32(SIDE));
    let phase = row_phase(lane);
    var best = SilhouetteOpening(0x7fffffff, 0.0, vec2f(0.0));
    if (lane >= SIDE) {
        return best;
    }
    var base = 0;
    for (var j = 0u; j <= lane; j++) {
        base += atomicLoad(&silhouettes_starts[j]);
    }
    var at = f32(lane);
    var ends = vec2f(span) + phase;
    // 2, which compilers do not know: they would copy the loop's body.
    let axes = 1u + silhouettes_known;
    for (var axis = 0u; axis < axes; axis++) {
        if (axis == 1u) {
            // Along the column from the middle of the lowest row on.
            at = (f32(lane) + 0.5) * (size.x / size.y);
            ends = vec2f(0.0, size.y - 1.0);
            base = atomicLoad(&silhouettes_starts[0]);
            for (var k = 0u; k < count; k++) {
                let crossing = silhouettes_cross(k, 0u, 0.0);
                base += select(0, i32(crossing.y), crossing.x <= at);
            }
        }
        let narrowest = PLACES_NARROWEST * select(size.x, size.y, axis == 1u);
        // From each edge behind which there are fewer surfaces to the next edge, and from the beginning.
        for (var i = 0u; i <= count && ends.x < ends.y; i++) {
            var begin = ends.x;
            if (i < count) {
                let crossing = silhouettes_cross(i, axis, at);
                begin = crossing.x;
                if (!(crossing.y < 0.0 && begin > ends.x && begin < ends.y)) {
                    continue;
                }
            }
            var number = base;
            var end = ends.y;
            for (var k = 0u; k < count; k++) {
                let crossing = silhouettes_cross(k, axis, at);
                if (crossing.y != 0.0) {
                    let is_before = crossing.x <= begin;
                    number += select(0, i32(crossing.y), is_before && (axis == 0u || crossing.x > 0.0));
                    end = select(min(end, crossing.x), end, is_before);
                }
            }
            let width = end - begin;
            let middle = 0.5 * (begin + end);
            let emits = places_emitting[min(u32(max(middle, 0.0) + 0.5), SIDE - 1u)];
            if (!(width > narrowest) || (axis == 1u && !(at >= f32(emits.x) && at < f32(emits.y)))) {
                continue;
            }
            if (marks) {
                let is_hidden = select(row_index(begin - phase) >= row_index(end - phase), width < 1.0, axis == 1u);
                if (number == least && is_hidden) {
                    let half = select(vec2f(0.5 * width, 1.0), vec2f(size.x / size.y, 0.5 * width), axis == 1u);
                    let center = select(vec2f(middle, at), vec2f(at, middle), axis == 1u);
                    let scale = vec2f(raster.samples, raster.rows);
                    let origin = vec2f(raster.left, raster.bottom + 0.5 / raster.rows);
                    places_add(origin + (center - half) / scale, origin + (center + half) / scale);
                }
                continue;
            }
            let part = width / select(size.x, size.y, axis == 1u);
            if (number < best.number || (number == best.number && part > best.part)) {
                best = SilhouetteOpening(number, part, select(vec2f(middle, at), vec2f(at, middle), axis == 1u));
            }
        }
    }
    return best;
}

struct SilhouetteOpening {
    number: i32,
    part: f32,
    // In samples without a shift, and in rows from the middle of the lowest one.
    middle: vec2f,
}

// Whether the list has all edges that may bound an opening.
fn silhouettes_are_listed() -> bool {
    let is_whole = silhouettes_known != 0u && atomicLoad(&silhouettes_found) <= SILHOUETTES_LINES;
    return is_whole && atomicLoad(&silhouettes_cut) == 0u;
}
