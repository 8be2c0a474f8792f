// Masks from silhouettes, by a workgroup, and the directions of edges: the twin of `blockers.rs`. The list, the counts and the lit part's area have
// files of their own.

// Words with one bit a sample.
const SILHOUETTES_BITS = WIDTH / 32u;

// `row_width`, which all threads load at once: browsers want proof that they meet at barriers.
var<workgroup> silhouettes_width: u32;
var<workgroup> silhouettes_least: atomic<i32>;
var<workgroup> silhouettes_best: atomic<u32>;
var<workgroup> silhouettes_open: u32;

// The stages of a mask: its samples, then the area of its lit part.
const SILHOUETTES_SAMPLES = 0u;
const SILHOUETTES_AREA = 1u;
var<workgroup> silhouettes_stage: u32;

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
        edges += edges_add_plane(edges_frame_of(window), at.face, window);
    }
    return edges;
}

// Blocks the hidden samples, and finds the area of the lit part if that is wanted, or that alone. Requires uniform control flow.
fn silhouettes_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
    let eye = silhouettes_eye(at, light);
    silhouettes_horizon = square_local(mask.square, at.normal);
    silhouettes_face = vec3f(0.0, 0.0, 1.0);
    if (silhouettes_facet(at, light) == PARTIAL) {
        _ = mask_block_below(mask, lane, at.face);
        silhouettes_face = square_local(mask.square, at.face);
    }
    silhouettes_adds = false;
    silhouettes_view = silhouettes_view_of(mask, eye);
    var keep: array<u32, SILHOUETTES_BITS>;
    var above = -0x7fffffff;
    if (lane == 0u) {
        silhouettes_stage = select(SILHOUETTES_SAMPLES, SILHOUETTES_AREA, LOOKS_AGAIN && area_wish == AREA_ALONE);
        if (area_wish != AREA_ALONE) {
            atomicStore(&silhouettes_cut, 0u);
        }
    }
    loop {
        if (lane == 0u) {
            atomicStore(&silhouettes_least, 0x7fffffff);
            atomicStore(&silhouettes_best, 0u);
            silhouettes_width = row_width;
        }
        let width = workgroupUniformLoad(&silhouettes_width);
        let is_area = LOOKS_AGAIN && workgroupUniformLoad(&silhouettes_stage) == SILHOUETTES_AREA;
        var fewest: SilhouetteFewest;
        var own = 0u;
        var place: vec2f;
        if (is_area) {
            if (!decide(lane, silhouettes_are_listed())) {
                break;
            }
            silhouettes_gather(lane, eye);
            let are_few = decide(lane, atomicLoad(&silhouettes_pieces) <= SILHOUETTES_PIECES);
            var area: SilhouetteArea;
            if (are_few) {
                area = silhouettes_row(lane, mask, above);
            }
            workgroupBarrier();
            if (!are_few || !decide(lane, atomicLoad(&silhouettes_pieces) <= SILHOUETTES_PIECES)) {
                break;
            }
            fewest.least = area.least;
            place = area.middle;
            own = u32(area.part * 0x1p20f);
        } else {
            fewest = silhouettes_scan(lane, eye, width, above);
        }
        atomicMin(&silhouettes_least, fewest.least);
        workgroupBarrier();
        let least = atomicLoad(&silhouettes_least);
        if (is_area) {
            own = select(0u, own, fewest.least == least);
        } else {
            for (var w = 0u; w < SILHOUETTES_BITS; w++) {
                fewest.bits[w] = select(0u, fewest.bits[w], fewest.least == least);
                own += countOneBits(fewest.bits[w]);
            }
        }
        atomicMax(&silhouettes_best, 256u * own + (255u - lane));
        let sums = total(lane, vec4f(f32(own), f32(fewest.rest), 0.0, 0.0));
        var is_done = sums.x == 0.0;
        var is_open = false;
        if (!is_done) {
            // One ray decides whether the fewest surfaces are none.
            if (lane == 255u - atomicLoad(&silhouettes_best) % 256u) {
                if (!is_area) {
                    place = vec2f(f32(silhouettes_middle(fewest.bits)) + 0.5 + row_phase(lane), f32(lane));
                }
                silhouettes_open = select(0u, 1u, silhouettes_sees(eye, place));
            }
            is_open = workgroupUniformLoad(&silhouettes_open) != 0u;
            // The order of two edges that coincide to the last digit may be wrong, and a few samples between them, or a sliver, open or not, then
            // have too small a number.
            let is_sliver = is_area && sums.x < SILHOUETTES_SLIVER * f32(SIDE) * 0x1p20f;
            is_done = select(u32(sums.x) >= u32(sums.y) / SILHOUETTES_FEW, !is_sliver, is_area);
            above = least;
        }
        if (is_area && is_done) {
            if (!is_open || fewest.least != least) {
                area_clear();
            }
            area_take(mask);
            area_is_found = true;
            break;
        }
        if (!is_area && is_open) {
            for (var w = 0u; w < SILHOUETTES_BITS; w++) {
                keep[w] |= fewest.bits[w];
            }
        }
        if (!is_done) {
            continue;
        }
        if (!LOOKS_AGAIN || !decide(lane, area_wish == AREA_BESIDE)) {
            break;
        }
        above = -0x7fffffff;
        if (lane == 0u) {
            silhouettes_stage = SILHOUETTES_AREA;
        }
    }
    if (LOOKS_AGAIN && area_wish == AREA_ALONE) {
        return;
    }
    for (var w = 0u; 32u * w < row_width; w++) {
        mask_block_set(w, ~keep[w]);
    }
}
