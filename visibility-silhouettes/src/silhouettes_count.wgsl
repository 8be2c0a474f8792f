// The number of surfaces before each sample: edges change it where they cross a row. The twin of `project.rs` and `count.rs`.

// Samples of a row that are counted at a time, two in a word: fewer for masks of many rows, whose workgroups need more memory.
const SILHOUETTES_PART = 2048u / LANES;
const SILHOUETTES_WORDS = SILHOUETTES_PART / 2u;

// The change of the number of surfaces from sample to sample of a row, and at its start from row to row.
var<workgroup> silhouettes_counts: array<atomic<i32>, LANES * SILHOUETTES_WORDS>;
var<workgroup> silhouettes_starts: array<atomic<i32>, LANES + 1u>;
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

fn silhouettes_view_of(mask: Mask, eye: SilhouetteEye) -> SilhouetteView {
    let square = mask.square;
    let raster = mask_raster(mask);
    let near = SILHOUETTES_NEAR * min(eye.cone.distance, 1.0);
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

fn silhouettes_limit(x: f32) -> f32 { return clamp(x, -SILHOUETTES_FAR_OUTSIDE, SILHOUETTES_FAR_OUTSIDE); }

// The point at which an edge meets a plane of equal depth, from the end on the right side of it.
fn silhouettes_clip(depth: f32, start: vec3f, end: vec3f) -> vec3f {
    return vec3f(start.xy + (end.xy - start.xy) * ((depth - start.z) / (end.z - start.z)), depth);
}

// The part of an edge between the receiver and the light's plane, in the square's frame; and the normal of the plane through it and the receiver.
struct SilhouetteSegment {
    a: vec3f,
    b: vec3f,
    line: vec3f,
    is_some: bool,
}

fn silhouettes_segment(world_a: vec3f, world_b: vec3f) -> SilhouetteSegment {
    let view = silhouettes_view;
    var a = square_local(view.square, world_a);
    var b = square_local(view.square, world_b);
    let is_near = vec2f(a.z, b.z) < vec2f(view.near);
    let is_far = vec2f(a.z, b.z) >= vec2f(view.far);
    // From a × (b − a): clipped ends would be too far outside for it.
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
    return SilhouetteSegment(a, b, line, !all(is_near) && !all(is_far));
}

// Counts the crossings of an edge with the rows, and its ends between them.
fn silhouettes_draw(world_a: vec3f, world_b: vec3f, step: i32) {
    let segment = silhouettes_segment(world_a, world_b);
    if (segment.is_some) {
        silhouettes_count(segment.a, segment.b, segment.line, step);
    }
}

// Draws the outlines in which a flat light's plane cuts triangles: from the point at which a triangle goes behind it to the one at
// which it comes back. Those that certainly pass beside it change nothing.
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
        let square = silhouettes_view.square;
        if (start.z > 0.0 && end.z > 0.0 && side != 0.0
            && !silhouettes_misses(square_world(square, start), square_world(square, end))) {
            atomicStore(&silhouettes_cut, 1u);
            silhouettes_count(start, end, cross(start, end - start), select(-1, 1, side > 0.0));
        }
    }
}

// Counts an edge between two points of the square's frame, in front of the light; `line` is the normal of the plane through them.
fn silhouettes_count(a: vec3f, b: vec3f, line: vec3f, step: i32) {
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
