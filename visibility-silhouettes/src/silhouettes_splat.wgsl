// Masks from silhouettes, by a workgroup: `project.rs`, `count.rs` and `SilhouetteBlockers::splat`.
//
// The threads search the hierarchy together, one thread for a child of a node, then the edges of the leaves. All sums are of
// integers, so no order of the threads changes a mask.

const SILHOUETTES_NODES = 4u;
// Silhouettes that are kept for the next mask of the receiver, if these are all; a round finds up to eight in a leaf.
const SILHOUETTES_ROOM = 480u;
// Samples of a row that are counted at a time, two in a word: fewer for masks of many rows, whose workgroups need more memory.
const SILHOUETTES_PART = 2048u / LANES;
const SILHOUETTES_WORDS = SILHOUETTES_PART / 2u;
// Words with one bit a sample.
const SILHOUETTES_BITS = WIDTH / 32u;

// Edges and their steps; their number.
var<workgroup> silhouettes_list: array<u32, SILHOUETTES_ROOM>;
var<workgroup> silhouettes_found: atomic<u32>;
// `row_width`, which all threads load at once: browsers want proof that they meet at barriers.
var<workgroup> silhouettes_width: u32;
// Whether the list has all silhouettes of the receiver.
var<workgroup> silhouettes_known: u32;
// The sum of edges, and the sum with four times their angles.
var<workgroup> silhouettes_sums: array<atomic<i32>, 4>;
// The change of the number of surfaces from sample to sample of a row, and at its start from row to row.
var<workgroup> silhouettes_counts: array<atomic<i32>, LANES * SILHOUETTES_WORDS>;
var<workgroup> silhouettes_starts: array<atomic<i32>, LANES + 1u>;
var<workgroup> silhouettes_least: atomic<i32>;
var<workgroup> silhouettes_best: atomic<u32>;
var<workgroup> silhouettes_open: u32;
// Whether a flat light's plane cuts triangles in front of the mask.
var<workgroup> silhouettes_cut: atomic<u32>;

// The window that is drawn, as `View`.
struct SilhouetteView {
    square: UnitSquare,
    raster: Raster,
    near: f32,
    far: f32,
    // Position at row 0, in samples, of a line that crosses the visible part of the light in every row, and its growth from row to row.
    middle: vec2f,
    // The first sample of the part that is counted.
    first: u32,
}

var<private> silhouettes_view: SilhouetteView;
// The window whose edges are summed, and the light in front of which they are.
var<private> silhouettes_window: Cone;
var<private> silhouettes_light: Cone;
// Whether edges are summed; otherwise they are drawn.
var<private> silhouettes_adds: bool;

// The stages of a mask: its samples, then the openings between samples, which are looked for and marked.
const SILHOUETTES_SAMPLES = 0u;
const SILHOUETTES_OPENINGS = 1u;
const SILHOUETTES_MARKS = 2u;
var<workgroup> silhouettes_stage: u32;
// Openings are looked for between no more edges than these.
const SILHOUETTES_LINES = 1u + 63u * u32(LOOKS_AGAIN);
// The lines of edges on the mask, if openings are wanted: the place at row line 0 and its growth from row to row, in samples, then the row at
// sample 0 and its growth from sample to sample.
var<workgroup> silhouettes_lines: array<vec4f, SILHOUETTES_LINES>;
// The samples between which the edge lies, as bits, then a byte each: its first row, the one after its last, and eight more than the growth of the number
// of surfaces where it is crossed from left to right, and from below.
var<workgroup> silhouettes_crossed: array<vec3u, SILHOUETTES_LINES>;

fn silhouettes_view_of(mask: Mask, eye: SilhouetteEye) -> SilhouetteView {
    let square = mask.square;
    let raster = mask_raster(mask);
    let near = SILHOUETTES_NEAR * select(eye.cone.distance, 1.0, eye.cone.distance > 1e30);
    let middle = silhouettes_middle_line(square, raster);
    // The square of a flat light is in its plane.
    let far = select(eye.far, light_plane().w, light_is_flat());
    return SilhouetteView(square, raster, near, max(far, near), middle, 0u);
}

// From the lowest to the highest corner of an outline, which is convex; of a round light through its middle.
fn silhouettes_middle_line(square: UnitSquare, raster: Raster) -> vec2f {
    if (!light_is_flat()) {
        return vec2f(-raster.left * raster.samples, 0.0);
    }
    var low = vec2f(0.0, 3e38);
    var high = vec2f(0.0, -3e38);
    for (var i = 0u; i < light_corner_count(); i++) {
        let p = vec2f(dot(square.right, light_corner(i)), dot(square.up, light_corner(i)));
        low = select(low, p, p.y < low.y);
        high = select(high, p, p.y > high.y);
    }
    let scale = vec2f(raster.samples, raster.rows);
    low = (low - vec2f(raster.left, raster.bottom)) * scale - vec2f(0.0, 0.5);
    high = (high - vec2f(raster.left, raster.bottom)) * scale - vec2f(0.0, 0.5);
    let slope = select(0.0, (high.x - low.x) / (high.y - low.y), high.y > low.y);
    return vec2f(low.x - slope * low.y, slope);
}

// Draws or sums all silhouettes of the receiver. Requires uniform control flow.
fn silhouettes_each(lane: u32, eye: SilhouetteEye) {
    let is_known = workgroupUniformLoad(&silhouettes_known) != 0u;
    if (!is_known) {
        if (lane == 0u) {
            silhouettes_begin();
            atomicStore(&silhouettes_found, 0u);
        }
        workgroupBarrier();
    }
    var is_whole = true;
    loop {
        let is_last = is_known || silhouettes_list_more(lane, eye);
        silhouettes_use(lane, eye, atomicLoad(&silhouettes_found));
        workgroupBarrier();
        if (is_last) {
            break;
        }
        is_whole = false;
        if (lane == 0u) {
            atomicStore(&silhouettes_found, 0u);
        }
    }
    if (lane == 0u && is_whole) {
        silhouettes_known = 1u;
    }
    workgroupBarrier();
}

// Continues the search of the hierarchy until the list may be too short for another round; returns true at the end.
fn silhouettes_list_more(lane: u32, eye: SilhouetteEye) -> bool {
    var is_last = false;
    loop {
        if (lane == 0u) {
            let is_full = atomicLoad(&silhouettes_found) > SILHOUETTES_ROOM - 8u * SILHOUETTES_LEAVES;
            silhouettes_begin_round(select(SILHOUETTES_NODES, 0u, is_full));
        }
        let plan = workgroupUniformLoad(&silhouettes_plan);
        if (plan.y == 0u) {
            is_last = plan.x == 0u;
            break;
        }
        let row = silhouettes_child(lane, plan);
        let is_met = row != SILHOUETTES_NONE && silhouettes_meet(eye, row);
        workgroupBarrier();
        if (is_met) {
            silhouettes_keep(row);
        }
        workgroupBarrier();
        let edges = 8u * atomicLoad(&silhouettes_leaf_count);
        for (var e = lane; e < edges; e += LANES) {
            let edge = silhouettes_leaf_edge(e);
            if (edge != SILHOUETTES_NONE) {
                let step = silhouettes_step(eye, edge);
                if (step != 0) {
                    silhouettes_list[atomicAdd(&silhouettes_found, 1u)] = 8u * edge + u32(step + 2);
                }
            }
        }
        workgroupBarrier();
    }
    return is_last;
}

// Draws or sums the edges of the list.
fn silhouettes_use(lane: u32, eye: SilhouetteEye, count: u32) {
    for (var k = lane; k < count; k += LANES) {
        let entry = silhouettes_list[k];
        let ends = silhouettes_data[silhouettes_data[0].w + entry / 8u];
        let a = silhouettes_from(eye.x, ends.x);
        let b = silhouettes_from(eye.x, ends.y);
        if (silhouettes_adds) {
            silhouettes_add(eye, a, b);
            continue;
        }
        if (LOOKS_AGAIN && places_seek && k < SILHOUETTES_LINES) {
            silhouettes_crossed[k] = vec3u(0u);
        }
        silhouettes_draw(k, a, b, i32(entry % 8u) - 2);
    }
}

// Adds the part of an edge in front of the window to the directions that a mask is turned by.
fn silhouettes_add(eye: SilhouetteEye, a: vec3f, b: vec3f) {
    // A flat light's cone may be a hemisphere.
    let light = silhouettes_light;
    let far = eye.far;
    let depth = vec2f(dot(a, light.axis), dot(b, light.axis));
    // An edge that passes beside the receiver, far outside the disc of a light at infinity, has a depth of nothing but rounding.
    let beside = SILHOUETTES_BESIDE * sqrt(dot(a, a) + dot(b, b));
    let near = select(1e-6 * light.distance, beside, light.distance > 1e30);
    // Behind the light or the receiver only some edges are listed, so none counts.
    if (all(depth < vec2f(near)) || all(depth > vec2f(far))) {
        return;
    }
    let edge = b - a;
    var first = a;
    var last = b;
    for (var k = 0u; k < 2u; k++) {
        let limit = select(near, far, k == 1u);
        let is_out = select((depth < vec2f(limit)), (depth > vec2f(limit)), vec2<bool>(k == 1u));
        let cut = a + edge * ((limit - depth.x) / (depth.y - depth.x));
        first = select(first, cut, is_out.x);
        last = select(last, cut, is_out.y);
    }
    let normal = cross(first, last - first);
    let length = silhouettes_length(silhouettes_window, first, last, normal);
    if (!(length > 0.0 && silhouettes_length(light, first, last, normal) > 0.0)) {
        return;
    }
    let frame = edges_frame(silhouettes_window.axis);
    let d = vec2f(dot(frame.right, normal), dot(frame.up, normal));
    let square = dot(d, d);
    if (!(square > 0.0 && length < 1e4)) {
        return;
    }
    let two = vec2f(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y) / square;
    let four = vec2f(two.x * two.x - two.y * two.y, 2.0 * two.x * two.y);
    let all = vec4i(vec4f(two, four) * (length * EDGES_STEPS));
    atomicAdd(&silhouettes_sums[0], all.x);
    atomicAdd(&silhouettes_sums[1], all.y);
    atomicAdd(&silhouettes_sums[2], all.z);
    atomicAdd(&silhouettes_sums[3], all.w);
}

// The length of an edge in front of the disc of a light, in its radii; not above zero if no part is.
fn silhouettes_length(cone: Cone, a: vec3f, b: vec3f, normal: vec3f) -> f32 {
    let tan = cone_tan(cone);
    let along = dot(normal, cone.axis);
    let across = normal - cone.axis * along;
    let square = dot(across, across);
    // The line passes the disc's centre at |n·axis|/|n − axis(n·axis)|; from it half the chord follows.
    let half = sqrt(max(1.0 - along * along / (square * (tan * tan)), 0.0));
    let line = cross(cone.axis, normal);
    let scale = max(sqrt(square) * tan, 1e-37);
    let start = dot(a, line) / (scale * dot(a, cone.axis));
    let end = dot(b, line) / (scale * dot(b, cone.axis));
    return min(max(start, end), half) - max(min(start, end), -half);
}

fn silhouettes_limit(x: f32) -> f32 { return clamp(x, -SILHOUETTES_FAR_OUTSIDE, SILHOUETTES_FAR_OUTSIDE); }

// The point at which an edge meets a plane of equal depth, from the end on the right side of it.
fn silhouettes_clip(depth: f32, start: vec3f, end: vec3f) -> vec3f {
    return vec3f(start.xy + (end.xy - start.xy) * ((depth - start.z) / (end.z - start.z)), depth);
}

// Counts the crossings of edge `k` of the list with the rows, and its ends between them.
fn silhouettes_draw(k: u32, world_a: vec3f, world_b: vec3f, step: i32) {
    let view = silhouettes_view;
    var a = square_local(view.square, world_a);
    var b = square_local(view.square, world_b);
    let is_near = vec2f(a.z, b.z) < vec2f(view.near);
    let is_far = vec2f(a.z, b.z) >= vec2f(view.far);
    if (all(is_near) || all(is_far)) {
        return;
    }
    // The line through both ends, from a × (b − a): clipped ends would be too far outside for it.
    let line = cross(a, b - a);
    for (var side = 0u; side < 2u; side++) {
        let cut = select(is_near, is_far, vec2<bool>(side == 1u));
        if (any(cut)) {
            let depth = select(view.near, view.far, side == 1u);
            let old = a;
            if (cut.x) {
                a = silhouettes_clip(depth, b, a);
            }
            if (cut.y) {
                b = silhouettes_clip(depth, old, b);
            }
        }
    }
    silhouettes_count(k, a, b, line, step);
}

// Draws the outlines in which a flat light's plane cuts triangles: from the point at which a triangle goes behind it to the one at
// which it comes back.
fn silhouettes_draw_clipped(lane: u32, eye: SilhouetteEye) {
    let near = silhouettes_near();
    for (var t = lane; t < near.y; t += LANES) {
        var corners: array<vec3f, 3>;
        var local: array<vec3f, 3>;
        for (var k = 0u; k < 3u; k++) {
            corners[k] = bitcast<vec3f>(silhouettes_data[near.x + 3u * t + k].xyz);
            local[k] = square_local(silhouettes_view.square, corners[k] - eye.x);
        }
        let far = silhouettes_view.far;
        var start = vec3f(0.0);
        var end = vec3f(0.0);
        for (var k = 0u; k < 3u; k++) {
            let a = local[k];
            let b = local[(k + 1u) % 3u];
            if (a.z >= far && b.z < far) {
                end = silhouettes_clip(far, b, a);
            } else if (a.z < far && b.z >= far) {
                start = silhouettes_clip(far, a, b);
            }
        }
        let side = any_hit_side(corners[0], corners[1], corners[2], eye.x);
        if (start.z > 0.0 && end.z > 0.0 && side != 0.0) {
            atomicStore(&silhouettes_cut, 1u);
            silhouettes_count(SILHOUETTES_LINES, start, end, cross(start, end - start), select(-1, 1, side > 0.0));
        }
    }
}

// Counts an edge between two points of the square's frame, in front of the light; `line` is the normal of the plane through them, `number` that
// of the edge in the list.
fn silhouettes_count(number: u32, a: vec3f, b: vec3f, line: vec3f, step: i32) {
    let view = silhouettes_view;
    let raster = view.raster;
    // Computed once for a vertex: the same for all its edges, whichever end it is.
    var x: array<f32, 2>;
    var row: array<f32, 2>;
    var middle: array<f32, 2>;
    for (var k = 0u; k < 2u; k++) {
        let p = select(a, b, k == 1u);
        x[k] = silhouettes_limit((p.x / p.z - raster.left) * raster.samples);
        let height = silhouettes_limit((p.y / p.z - raster.bottom) * raster.rows - 0.5);
        row[k] = clamp(ceil(height), 0.0, f32(SIDE));
        middle[k] = clamp(view.middle.x + view.middle.y * clamp(height, -1.0, f32(SIDE)), 0.0, f32(row_width));
    }
    let low = min(x[0], x[1]);
    let high = max(x[0], x[1]);
    let is_left = vec2<bool>(x[0] < middle[0], x[1] < middle[1]);
    if (max(row[0], row[1]) == 0.0 || min(row[0], row[1]) == f32(SIDE) || low > f32(row_width) + 1.0 || high < -1.0) {
        return;
    }
    var slope = 0.0;
    var start = 0.5 * (x[0] + x[1]);
    if (line.x != 0.0) {
        let inverse = -1.0 / line.x;
        let lean = line.y * inverse;
        start = (lean * (raster.bottom + 0.5 / raster.rows) + (line.z * inverse - raster.left)) * raster.samples;
        slope = lean * (raster.samples / raster.rows);
    }
    let is_up = row[0] <= row[1];
    let first = u32(select(row[1], row[0], is_up));
    let last = u32(select(row[0], row[1], is_up));
    let grows = select(-step, step, is_up);
    if (LOOKS_AGAIN && places_seek && number < SILHOUETTES_LINES && view.first == 0u) {
        let rise = select(0.0, -line.x / line.y, line.y != 0.0);
        let height = select(0.0, -line.z / line.y, line.y != 0.0) + rise * raster.left;
        let bottom = (height - raster.bottom) * raster.rows - 0.5;
        silhouettes_lines[number] = vec4f(start, slope, bottom, rise * (raster.rows / raster.samples));
        let goes_right = x[0] < x[1];
        let growths = vec2u(vec2i(grows, select(step, -step, goes_right)) + 8);
        let bytes = first | (last << 8u) | (growths.x << 16u) | (growths.y << 24u);
        silhouettes_crossed[number] = vec3u(bitcast<vec2u>(vec2f(low, high)), bytes);
    }
    if (row[0] == row[1] && is_left.x == is_left.y) {
        return;
    }
    if (view.first == 0u) {
        if (select(is_left.y, is_left.x, is_up)) {
            atomicAdd(&silhouettes_starts[first], -grows);
        }
        if (select(is_left.x, is_left.y, is_up)) {
            atomicAdd(&silhouettes_starts[last], grows);
        }
    }
    for (var j = first; j < last; j++) {
        let sample = row_index(clamp(f32(j) * slope + start, low - 1.0, high + 1.0) - row_phase(j)) - view.first;
        // A sample of an earlier part wraps to a number beyond all.
        if (sample < SILHOUETTES_PART) {
            atomicAdd(&silhouettes_counts[SILHOUETTES_WORDS * j + sample / 2u], grows << (16u * (sample & 1u)));
        }
    }
}

// The samples of the row with the fewest surfaces, among those with more than `above`.
struct SilhouetteFewest {
    bits: array<u32, SILHOUETTES_BITS>,
    least: i32,
    // Number of samples with more than `above`.
    rest: u32,
}

fn silhouettes_scan(lane: u32, eye: SilhouetteEye, width: u32, above: i32) -> SilhouetteFewest {
    var fewest: SilhouetteFewest;
    fewest.least = 0x7fffffff;
    var number = 0;
    var emits = 0u;
    for (var first = 0u; first < width; first += SILHOUETTES_PART) {
        silhouettes_view.first = first;
        for (var k = 0u; k < SILHOUETTES_WORDS; k++) {
            atomicStore(&silhouettes_counts[SILHOUETTES_WORDS * lane + k], 0);
        }
        if (first == 0u) {
            atomicStore(&silhouettes_starts[lane], 0);
            if (lane == 0u) {
                atomicStore(&silhouettes_starts[LANES], 0);
            }
        }
        workgroupBarrier();
        silhouettes_draw_clipped(lane, eye);
        silhouettes_each(lane, eye);
        if (first == 0u) {
            for (var j = 0u; j <= lane; j++) {
                number += atomicLoad(&silhouettes_starts[j]);
            }
        }
        var word = 0;
        for (var k = first; k < first + SILHOUETTES_PART; k++) {
            if (k % 32u == 0u) {
                emits = row_samples(lit, k / 32u);
            }
            // A lower half below 0 has borrowed from the upper half.
            if (k % 2u == 0u) {
                word = atomicLoad(&silhouettes_counts[SILHOUETTES_WORDS * lane + (k - first) / 2u]);
            } else {
                word = (word - ((word << 16u) >> 16u)) >> 16u;
            }
            number += (word << 16u) >> 16u;
            let bit = 1u << (k % 32u);
            if ((emits & bit) == 0u || number <= above) {
                continue;
            }
            fewest.rest += 1u;
            if (number < fewest.least) {
                fewest.least = number;
                for (var w = 0u; w <= k / 32u; w++) {
                    fewest.bits[w] = 0u;
                }
            }
            if (number == fewest.least) {
                fewest.bits[k / 32u] |= bit;
            }
        }
        workgroupBarrier();
    }
    return fewest;
}

// The middle of the longest run of a row; runs begin anew at each 64 samples.
fn silhouettes_middle(bits: array<u32, SILHOUETTES_BITS>) -> u32 {
    var all = bits;
    var best = vec2u(0u);
    var length = 0u;
    for (var k = 0u; k < row_width; k++) {
        let is_in = ((all[k / 32u] >> (k % 32u)) & 1u) != 0u;
        length = select(0u, length + 1u, is_in);
        if (k % 64u == 0u) {
            length = min(length, 1u);
        }
        if (length > best.x) {
            best = vec2u(length, k + 1u - length);
        }
    }
    return best.y + (max(best.x, 1u) - 1u) / 2u;
}

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

// Whether a place of the mask sees the light; in samples without a shift, and in rows from the middle of the lowest one.
fn silhouettes_sees(eye: SilhouetteEye, at: vec2f) -> bool {
    let raster = silhouettes_view.raster;
    let x = raster.left + at.x / raster.samples;
    let y = raster.bottom + (at.y + 0.5) / raster.rows;
    let along = sqrt(1.0 + x * x + y * y);
    let far = silhouettes_view.far;
    return !any_hit(eye.x, square_world(silhouettes_view.square, vec3f(x, y, 1.0)) / along, select(far * along, far, far > 1e37));
}

// Sums the edges; the first thread returns the sum. Requires uniform control flow.
fn silhouettes_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f {
    if (lane < 4u) {
        atomicStore(&silhouettes_sums[lane], 0);
    }
    workgroupBarrier();
    let eye = silhouettes_eye(at, light);
    silhouettes_window = window;
    silhouettes_light = eye.cone;
    if (light_is_flat()) {
        // A flat light's cone may be a hemisphere, which has no disc.
        silhouettes_light.one_minus_cos = min(eye.cone.one_minus_cos, SILHOUETTES_WIDEST);
    }
    silhouettes_adds = true;
    silhouettes_each(lane, eye);
    if (lane > 0u) {
        return vec4f(0.0);
    }
    let sums = vec4i(
        atomicLoad(&silhouettes_sums[0]), atomicLoad(&silhouettes_sums[1]),
        atomicLoad(&silhouettes_sums[2]), atomicLoad(&silhouettes_sums[3])
    );
    var edges = vec4f(sums) / EDGES_STEPS;
    if (silhouettes_facet(at, light) == PARTIAL) {
        edges += vec4f(edges_add_plane(edges_frame(window.axis), at.face, window), 0.0, 0.0);
    }
    return edges;
}

// Blocks the hidden samples, and marks openings between them where these are wanted and little is lit. Requires uniform control flow.
fn silhouettes_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
    let eye = silhouettes_eye(at, light);
    var span = emitting;
    if (silhouettes_facet(at, light) == PARTIAL) {
        span = mask_block_below(mask, lane, at.face);
    }
    silhouettes_adds = false;
    silhouettes_view = silhouettes_view_of(mask, eye);
    var keep: array<u32, SILHOUETTES_BITS>;
    var above = -0x7fffffff;
    var least = above;
    if (lane == 0u) {
        silhouettes_stage = SILHOUETTES_SAMPLES;
        atomicStore(&silhouettes_cut, 0u);
    }
    loop {
        if (lane == 0u) {
            atomicStore(&silhouettes_least, 0x7fffffff);
            atomicStore(&silhouettes_best, 0u);
            silhouettes_width = row_width;
        }
        let width = workgroupUniformLoad(&silhouettes_width);
        let stage = workgroupUniformLoad(&silhouettes_stage);
        var fewest: SilhouetteFewest;
        var own = 0u;
        var place: vec2f;
        if (!LOOKS_AGAIN || stage == SILHOUETTES_SAMPLES) {
            fewest = silhouettes_scan(lane, eye, width, above);
        } else {
            let opening = silhouettes_openings(lane, span, stage == SILHOUETTES_MARKS, least);
            fewest.least = opening.number;
            place = opening.middle;
            own = u32(opening.part * 0x1p20f);
        }
        if (LOOKS_AGAIN && stage == SILHOUETTES_MARKS) {
            break;
        }
        atomicMin(&silhouettes_least, fewest.least);
        workgroupBarrier();
        least = atomicLoad(&silhouettes_least);
        if (!LOOKS_AGAIN || stage == SILHOUETTES_SAMPLES) {
            for (var w = 0u; w < SILHOUETTES_BITS; w++) {
                fewest.bits[w] = select(0u, fewest.bits[w], fewest.least == least);
                own += countOneBits(fewest.bits[w]);
            }
        } else if (fewest.least != least) {
            own = 0u;
        }
        atomicMax(&silhouettes_best, 256u * own + (255u - lane));
        let sums = total(lane, vec4f(f32(own), f32(fewest.rest), 0.0, 0.0));
        var is_done = sums.x == 0.0;
        if (!is_done) {
            // One ray decides whether the fewest surfaces are none.
            if (lane == 255u - atomicLoad(&silhouettes_best) % 256u) {
                if (!LOOKS_AGAIN || stage == SILHOUETTES_SAMPLES) {
                    place = vec2f(f32(silhouettes_middle(fewest.bits)) + 0.5 + row_phase(lane), f32(lane));
                }
                silhouettes_open = select(0u, 1u, silhouettes_sees(eye, place));
            }
            let is_open = workgroupUniformLoad(&silhouettes_open) != 0u;
            if (LOOKS_AGAIN && stage == SILHOUETTES_OPENINGS) {
                if (lane == 0u) {
                    silhouettes_stage = SILHOUETTES_MARKS;
                }
                if (is_open) {
                    continue;
                }
                break;
            }
            if (is_open) {
                for (var w = 0u; w < SILHOUETTES_BITS; w++) {
                    keep[w] |= fewest.bits[w];
                }
            }
            // The order of two edges that coincide to the last digit may be wrong, and a few samples between them then have too small a
            // number.
            is_done = u32(sums.x) >= u32(sums.y) / SILHOUETTES_FEW;
            above = least;
        }
        if (!is_done) {
            continue;
        }
        // Then the openings, once.
        if (!LOOKS_AGAIN || !decide(lane, stage == SILHOUETTES_SAMPLES && places_seek && silhouettes_are_listed())) {
            break;
        }
        var seen = 0u;
        for (var w = 0u; w < SILHOUETTES_BITS; w++) {
            seen += countOneBits(keep[w]);
        }
        places_emitting[lane] = span;
        if (PLACES_FAINT * total(lane, vec4f(f32(seen), 0.0, 0.0, 0.0)).x >= f32(width * SIDE)) {
            break;
        }
        if (lane == 0u) {
            silhouettes_stage = SILHOUETTES_OPENINGS;
        }
    }
    for (var w = 0u; 32u * w < row_width; w++) {
        mask_block_set(w, ~keep[w]);
    }
}

// Whether the list has all edges that may bound an opening.
fn silhouettes_are_listed() -> bool {
    let is_whole = silhouettes_known != 0u && atomicLoad(&silhouettes_found) <= SILHOUETTES_LINES;
    return is_whole && atomicLoad(&silhouettes_cut) == 0u;
}
