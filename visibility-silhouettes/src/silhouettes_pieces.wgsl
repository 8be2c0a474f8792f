// The parts of outlines in front of a light, for the area of its lit part.

// Their number. They are listed in place of the counts.
var<workgroup> silhouettes_pieces: atomic<u32>;
// The heights of a piece's ends in rows, its place at the lower one in samples, its slope, then the growth of the number of surfaces and in two bits
// whether the ends are left of the view's middle.
const SILHOUETTES_PIECE = 5u;
const SILHOUETTES_PIECES = LANES * SILHOUETTES_WORDS / SILHOUETTES_PIECE;

// Normals in the frame of the mask's square: of the receiver, and of its facet, or one that cuts nothing.
var<private> silhouettes_horizon: vec3f;
var<private> silhouettes_face: vec3f;

// The sides of what is seen of a window, as half-planes: its own, the first one on the left, two of the receiver's planes, then those of the light.
fn silhouettes_window_side(k: u32) -> vec3f {
    let square = silhouettes_view.square;
    if (k < 4u) {
        let sign = select(-1.0, 1.0, k % 2u == 0u);
        let across = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), k < 2u);
        return vec3f(sign * across, dot(across, square.half - sign * square.center));
    } else if (k == 4u) {
        return silhouettes_horizon;
    } else if (k == 5u) {
        return silhouettes_face;
    }
    return light_side(k - 6u);
}

// Lists the part of an edge that is in front of the light, from its ends in plane coordinates: other parts change numbers of surfaces there by a constant, if
// at all.
fn silhouettes_list_piece(a: vec2f, b: vec2f, line: vec3f, step: i32) {
    var ends = array<vec2f, 2>(a, b);
    var leans = vec2f(0.0);
    for (var k = 0u; k < 6u + light_side_count(); k++) {
        let side = silhouettes_window_side(k);
        let inside = vec2f(dot(side.xy, ends[0]), dot(side.xy, ends[1])) + side.z;
        let is_out = inside < vec2f(0.0);
        if (all(is_out)) {
            return;
        }
        if (any(is_out)) {
            let cut = cross(line, side);
            ends[select(0u, 1u, is_out.y)] = cut.xy / cut.z;
            leans = select(leans, vec2f(side.x), is_out);
        }
    }
    let disc = light_disc(silhouettes_view.square);
    let from_middle = ends[0] - disc.xy;
    let along = ends[1] - ends[0];
    let square = dot(along, along);
    let half = dot(from_middle, along);
    let root = half * half - square * (dot(from_middle, from_middle) - disc.z * disc.z);
    let cuts = (vec2f(-1.0, 1.0) * sqrt(max(root, 0.0)) - half) / square;
    if (!(root > 0.0 && cuts.x < 1.0 && cuts.y > 0.0)) {
        return;
    }
    let first = ends[0];
    if (cuts.x > 0.0) {
        ends[0] = first + cuts.x * along;
        leans.x = disc.x - ends[0].x;
    }
    if (cuts.y < 1.0) {
        ends[1] = first + cuts.y * along;
        leans.y = disc.x - ends[1].x;
    }
    silhouettes_push_piece(ends, leans, step);
}

// Lists a piece between two ends in front of the light. `leans`: above 0 for an end at a side on the left of what is seen, below 0 for one on the right;
// the view's middle may lie along a side, where rounding would decide.
fn silhouettes_push_piece(ends: array<vec2f, 2>, leans: vec2f, step: i32) {
    let view = silhouettes_view;
    let raster = view.raster;
    var x: vec2f;
    var height: vec2f;
    var is_left: vec2<bool>;
    for (var k = 0u; k < 2u; k++) {
        let end = select(ends[0], ends[1], k == 1u);
        x[k] = (end.x - raster.left) * raster.samples;
        height[k] = (end.y - raster.bottom) * raster.rows - 0.5;
        let middle = view.middle.x + view.middle.y * clamp(height[k], -1.0, f32(SIDE));
        is_left[k] = select(x[k] < clamp(middle, 0.0, f32(row_width)), leans[k] > 0.0, leans[k] != 0.0);
    }
    let is_up = height.x <= height.y;
    if (!is_up) {
        x = x.yx;
        height = height.yx;
        is_left = is_left.yx;
    }
    let rise = height.y - height.x;
    if (rise <= 0.0 && is_left.x == is_left.y) {
        return;
    }
    let k = atomicAdd(&silhouettes_pieces, 1u);
    if (k < SILHOUETTES_PIECES) {
        let at = SILHOUETTES_PIECE * k;
        let growth = select(-step, step, is_up);
        atomicStore(&silhouettes_counts[at], bitcast<i32>(height.x));
        atomicStore(&silhouettes_counts[at + 1u], bitcast<i32>(height.y));
        atomicStore(&silhouettes_counts[at + 2u], bitcast<i32>(x.x));
        atomicStore(&silhouettes_counts[at + 3u], bitcast<i32>(select(0.0, (x.y - x.x) / rise, rise > 0.0)));
        atomicStore(&silhouettes_counts[at + 4u], ((growth + 8) << 2u) + select(0, 1, is_left.x) + select(0, 2, is_left.y));
    }
}
