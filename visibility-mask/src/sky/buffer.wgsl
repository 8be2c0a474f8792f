// The sky before one receiver, by a workgroup of LANES threads: `Pole`, `Horizon`, `Meridians`, `SkyArcs` and `SkyBuffer`. SKY_ROWS and
// SKY_SAMPLES are those of the table, `sky_table`.
//
// Blockers first say where their outlines cross meridians. Surfaces are then counted part by part: LANES meridians, one a thread, and
// SKY_COLUMNS samples of each. All numbers are whole ones, so no order of the threads changes them.

// Samples of a meridian that are counted at a time.
const SKY_COLUMNS = 16u;
const SKY_CELLS = SKY_COLUMNS * LANES;
// Parts of the buffer: along LANES meridians, then along the next ones.
const SKY_ALONG = SKY_SAMPLES / SKY_COLUMNS;
// Instead of a part: crossings are listed.
const SKY_LISTS = 0xffffffffu;
// Crossings that are listed, one a word; if there are more, blockers draw again for each part.
const SKY_ROOM = 768u;
const SKY_WORDS = SKY_CELLS + SKY_ROOM;
// Half a surface.
const SKY_HALF = i32(SKY_PLACES);
// A count that no sample has.
const SKY_MOST = 0x7fffffff;

// For each sample of the part the change of the count, then how much of it is seen.
var<workgroup> sky_counts: array<atomic<i32>, SKY_CELLS>;
// For each sample the part that folds hide besides, where other outlines pass; then crossings: row, column, fraction and step. Or all of it
// lists the crossings of a crowd.
var<workgroup> sky_words: array<atomic<u32>, SKY_WORDS>;
var<workgroup> sky_crossing_count: atomic<u32>;
// Rows that are crossed, as bits.
var<workgroup> sky_crossed: array<atomic<u32>, (SKY_ROWS + 31u) / 32u>;
// The fewest surfaces before samples that no outline passes through, and before any.
var<workgroup> sky_least: atomic<i32>;
var<workgroup> sky_least_of_any: atomic<i32>;
// The longest run of samples with the fewest, and of rows that nothing crosses: greater numbers for longer ones.
var<workgroup> sky_best_run: atomic<u32>;
var<workgroup> sky_open_run: atomic<u32>;
var<workgroup> sky_plan: i32;

struct SkyHorizon {
    normal: vec3f,
    pole: u32,
    // The x, y and z of the pole's frame in the world.
    frame: mat3x3f,
    // The normal in the pole's frame.
    local: vec3f,
    is_facet: bool,
}

var<private> sky_horizon: SkyHorizon;
// The part that is drawn; how many rows it has, their first, and whether they are a crowd's.
var<private> sky_part: u32;
var<private> sky_rows: u32;
var<private> sky_first_row: u32;
var<private> sky_is_crowd: bool;
// The thread's row: the count of the last sample (of a crowd the surfaces before the next one), the fewest of whole samples, the present run with these, the longest.
var<private> sky_number: i32;
var<private> sky_row_least: i32;
var<private> sky_run: u32;
var<private> sky_row_run: u32;
// Of all rows of the thread.
var<private> sky_own_least: i32;
var<private> sky_own_least_of_any: i32;
var<private> sky_own_run: u32;

// The frame of the pole that is nearest to a normal: its x, y and z in the world; and the pole's number.
fn sky_set_pole(normal: vec3f) {
    var axes = SKY_AXES;
    let size = abs(vec3f(dot(axes[0], normal), dot(axes[1], normal), dot(axes[2], normal)));
    var axis = select(0u, 1u, size.y > size.x);
    axis = select(axis, 2u, size.z > max(size.x, size.y));
    let one = axes[(axis + 1u) % 3u];
    let other = axes[(axis + 2u) % 3u];
    let up = axes[axis];
    if (dot(up, normal) < 0.0) {
        sky_horizon.pole = axis + 3u;
        sky_horizon.frame = mat3x3f(other, one, -up);
    } else {
        sky_horizon.pole = axis;
        sky_horizon.frame = mat3x3f(one, other, up);
    }
}

// One order of additions, so that a corner of two edges has one azimuth, however a compiler joins them.
fn sky_along(axis: vec3f, v: vec3f) -> f32 { return fma(axis.z, v.z, fma(axis.y, v.y, axis.x * v.x)); }

// A vector of the world in the pole's frame.
fn sky_local(v: vec3f) -> vec3f {
    let frame = sky_horizon.frame;
    return vec3f(sky_along(frame[0], v), sky_along(frame[1], v), sky_along(frame[2], v));
}

// A vector of the pole's frame in the world.
fn sky_world(v: vec3f) -> vec3f { return sky_horizon.frame * v; }

fn sky_set_horizon(at: Receiver, has_facet: bool) {
    let normal = select(at.normal, at.face, has_facet);
    sky_horizon.normal = normal;
    sky_set_pole(normal);
    sky_horizon.local = sky_local(normal);
    sky_horizon.is_facet = has_facet && any(at.face != at.normal);
}

// Cosine and sine of a row's azimuth.
fn sky_circle(row: u32) -> vec2f { return vec2f(sky_table[row], sky_table[SKY_ROWS + row]); }

fn sky_azimuth(v: vec2f) -> f32 {
    let p = v.y / max(abs(v.x) + abs(v.y), MIN_POSITIVE);
    return select(p, select(2.0, -2.0, v.y < 0.0) - p, v.x < 0.0);
}

// How many rows lie before an azimuth number.
fn sky_rows_before(azimuth: f32) -> f32 { return ceil((azimuth + 2.0) * (0.25 * f32(SKY_ROWS)) - 0.5); }

// Whether a box may hold edges that cross a meridian: its middle as seen from the receiver, and half its sides. `may_cross_boxes`.
fn sky_may_cross(middle: vec3f, half: vec3f) -> bool {
    let to = sky_local(middle).xy;
    let frame = sky_horizon.frame;
    let size = vec2f(dot(abs(frame[0]), half), dot(abs(frame[1]), half));
    // No wider than a circle around the box, seen along the pole.
    let off = sqrt(min(dot(size, size), dot(half, half))) * SKY_AROUND;
    let wide = abs(to);
    let distance = max(max(wide.x, wide.y), (wide.x + wide.y) * SKY_DIAGONAL) - off;
    // The azimuth number turns no faster than the azimuth.
    let spread = select(4.0, off / distance, distance > 0.0) + SKY_SPREAD;
    let azimuth = sky_azimuth(to);
    let begin = sky_rows_before(azimuth - spread);
    let end = sky_rows_before(azimuth + spread);
    return begin != end && (!sky_is_crowd || sky_are_drawn(i32(begin), u32(end - begin)));
}

// Whether any of a number of rows is among those of the part.
fn sky_are_drawn(begin: i32, count: u32) -> bool {
    let off = u32(begin - i32(sky_first_row) + 4 * i32(SKY_ROWS)) % SKY_ROWS;
    return off < sky_rows || off + count > SKY_ROWS;
}

// Where on its row a direction is, in samples from the pole: its z, and its distance from the axis.
fn sky_place(z: f32, across: f32) -> f32 {
    let e = z / max(across + abs(z), MIN_POSITIVE);
    return clamp((0.5 - e * 0.5) * f32(SKY_SAMPLES), 0.0, f32(SKY_SAMPLES));
}

// Where a row crosses a plane whose normal, in the pole's frame, is on the pole's side.
fn sky_end(row: u32, normal: vec3f) -> f32 { return sky_place(-dot(sky_circle(row), normal.xy), normal.z); }

// The unit direction, in the world, of a place in samples on the middle of a row.
fn sky_direction_at(row: u32, sample: f32) -> vec3f {
    let e = 1.0 - 2.0 * sample / f32(SKY_SAMPLES);
    let across = 1.0 - abs(e);
    return sky_world(vec3f(sky_circle(row) * across, e)) / sqrt(across * across + e * e);
}

// A great-circle arc that crosses meridians: the normal of its plane in the pole's frame, the first row after its beginning, and how
// many it crosses (negative: clockwise; 0: it is left out, as before a crowd where it crosses none of the part's rows).
struct SkyArc {
    plane: vec3f,
    first: i32,
    rows: i32,
}

// The arc in which an edge from `a` to `b`, seen from the receiver, is seen: `SkyArcs::push`.
fn sky_arc(a: vec3f, b: vec3f) -> SkyArc {
    let p = sky_local(a);
    let q = sky_local(b);
    let first = sky_rows_before(sky_azimuth(p.xy));
    var rows = sky_rows_before(sky_azimuth(q.xy)) - first;
    if (rows == 0.0 || max(dot(a, sky_horizon.normal), dot(b, sky_horizon.normal)) <= 0.0) {
        return SkyArc();
    }
    var plane = cross(p, q);
    let all = f32(SKY_ROWS);
    rows = select(rows, rows - all, rows > 0.5 * all);
    rows = select(rows, rows + all, rows < -0.5 * all);
    // Beside the pole the edge's plane says on which side it passes.
    if (abs(rows) > 0.5 * all - 2.0 && rows * plane.z < 0.0) {
        rows = select(rows + all, rows - all, rows > 0.0);
    }
    if (plane.z == 0.0) {
        // Through the pole, for which no plane stands, or through the opposite one, which is never seen.
        if (p.z * sqrt(dot(b, b)) + q.z * sqrt(dot(a, a)) < 0.0) {
            return SkyArc();
        }
        plane = vec3f(0.0);
    }
    let arc = SkyArc(plane, i32(first), i32(rows));
    if (sky_is_crowd && !sky_are_drawn(arc.first + min(arc.rows, 0), u32(abs(arc.rows)))) {
        return SkyArc();
    }
    return arc;
}

// Draws an arc, to the right of which the number of surfaces grows by `step`, in half surfaces.
fn sky_draw_arc(arc: SkyArc, step: i32) {
    // Away from the pole is to the left of an arc that runs counter-clockwise.
    let outward = select(step, -step, arc.rows > 0);
    let begin = u32(arc.first + min(arc.rows, 0) + i32(SKY_ROWS));
    let count = u32(abs(arc.rows));
    for (var k = 0u; k < count; k++) {
        let row = (begin + k) % SKY_ROWS;
        let along = dot(arc.plane.xy, sky_circle(row));
        sky_cross(row, sky_place(select(along, -along, arc.plane.z > 0.0) + MIN_POSITIVE, abs(arc.plane.z)), outward);
    }
}

// Says that an outline crosses a row at a place in samples from the pole, beyond which `step` more half surfaces lie.
fn sky_cross(row: u32, place: f32, step: i32) {
    let column = floor(place);
    let fraction = u32((place - column) * f32(SKY_HALF) + 0.5);
    if (sky_is_crowd) {
        sky_link(row, u32(column), fraction, step);
        return;
    }
    if (sky_part != SKY_LISTS) {
        sky_put(row, u32(column), i32(fraction), step);
        return;
    }
    atomicOr(&sky_crossed[row / 32u], 1u << (row % 32u));
    let place_in_list = atomicAdd(&sky_crossing_count, 1u);
    if (place_in_list < SKY_ROOM) {
        let crossing = row | (u32(column) << 8u) | (fraction << 16u) | (u32(step + 8) << 28u);
        atomicStore(&sky_words[SKY_CELLS + place_in_list], crossing);
    }
}

// Adds a crossing to the counts of the part: `SkyBuffer::put`.
fn sky_put(row: u32, column: u32, fraction: i32, step: i32) {
    // Rows and columns before the part wrap to numbers beyond all.
    let lane = row - sky_first_row;
    let here = column - sky_part % SKY_ALONG * SKY_COLUMNS;
    let next = here + 1u;
    if (lane >= LANES) {
        return;
    }
    let usual = clamp(step, -2, 2);
    let others = (step - usual) * SKY_HALF;
    if (here < SKY_COLUMNS) {
        let more = select(others, 0, step > 0) + usual * (SKY_HALF - fraction);
        atomicAdd(&sky_counts[here * LANES + lane], (more << SKY_CUTS) + 1);
        if (others != 0) {
            atomicAdd(&sky_words[here * LANES + lane], u32(select(fraction, SKY_HALF - fraction, step > 0)));
        }
    }
    if (next < SKY_COLUMNS) {
        let more = select(0, others, step > 0) + usual * fraction;
        atomicAdd(&sky_counts[next * LANES + lane], (more << SKY_CUTS) - 1);
    }
}

// Begins a receiver: no crossings.
fn sky_begin(lane: u32) {
    if (lane < (SKY_ROWS + 31u) / 32u) {
        atomicStore(&sky_crossed[lane], 0u);
    }
    if (lane == 0u) {
        atomicStore(&sky_crossing_count, 0u);
    }
}

// Begins a part of this number of rows, and the sums of all parts with the first. A crowd's rows are whole ones, and are drawn with their first part.
fn sky_begin_part(lane: u32, part: u32, rows: u32, is_crowd: bool) {
    sky_part = part;
    sky_rows = rows;
    sky_is_crowd = is_crowd;
    if (part == SKY_LISTS) {
        return;
    }
    sky_first_row = part / SKY_ALONG * rows;
    let is_first_of_rows = part % SKY_ALONG == 0u;
    if (!is_crowd || is_first_of_rows) {
        for (var k = lane; k < SKY_CELLS; k += LANES) {
            atomicStore(&sky_counts[k], 0);
            atomicStore(&sky_words[k], 0u);
        }
    }
    if (is_crowd && is_first_of_rows && lane == 0u) {
        atomicStore(&sky_crossing_count, 0u);
    }
    if (part == 0u) {
        sky_own_least = SKY_MOST;
        sky_own_least_of_any = SKY_MOST;
        sky_own_run = 0u;
    }
    if (is_first_of_rows) {
        sky_number = 0;
        sky_row_least = SKY_MOST;
        sky_run = 0u;
        sky_row_run = 0u;
    }
}

// How many crossings were found. Requires uniform control flow.
fn sky_found(lane: u32) -> u32 {
    if (lane == 0u) {
        sky_plan = i32(atomicLoad(&sky_crossing_count));
    }
    return u32(workgroupUniformLoad(&sky_plan));
}

// Draws the listed crossings into the part.
fn sky_draw_list(lane: u32) {
    let count = min(atomicLoad(&sky_crossing_count), SKY_ROOM);
    for (var k = lane; k < count; k += LANES) {
        let crossing = atomicLoad(&sky_words[SKY_CELLS + k]);
        sky_put(crossing & 255u, (crossing >> 8u) & 255u, i32((crossing >> 16u) & 4095u), i32(crossing >> 28u) - 8);
    }
}

// The thread's row in the part, or the number of all rows; and its first sample there.
fn sky_row(lane: u32) -> u32 { return select(SKY_ROWS, sky_first_row + lane, lane < sky_rows); }

fn sky_column() -> u32 { return sky_part % SKY_ALONG * SKY_COLUMNS; }

// Makes counts of their changes, and of these the parts that are seen if samples with the `fewest` have no surface before them:
// `SkyBuffer::resolve` and `seen`.
fn sky_count(lane: u32, fewest: i32) {
    let row = sky_row(lane);
    if (row >= SKY_ROWS) {
        return;
    }
    let sure = sky_end(row, sky_horizon.local) - SKY_SURE;
    let first = sky_column();
    for (var c = 0u; c < SKY_COLUMNS; c++) {
        let cell = c * LANES + lane;
        sky_number += atomicLoad(&sky_counts[cell]);
        let cuts = sky_number & ((1 << SKY_CUTS) - 1);
        sky_note(f32(first + c) <= sure, first + c, sky_number, sky_number);
        var hidden = sky_number >> SKY_CUTS;
        if (cuts > 1) {
            hidden += i32(atomicLoad(&sky_words[cell]));
        }
        atomicStore(&sky_counts[cell], clamp((fewest >> SKY_CUTS) + 2 * SKY_HALF - hidden, 0, 2 * SKY_HALF));
    }
    sky_end_row(row);
}

// Notes the count of a sample, and the least there can be before a part of it.
fn sky_note(is_above: bool, sample: u32, count: i32, least: i32) {
    if (is_above) {
        sky_own_least_of_any = min(sky_own_least_of_any, least);
        let cuts = count & ((1 << SKY_CUTS) - 1);
        if (cuts == 0 && count < sky_row_least) {
            sky_row_least = count;
            sky_run = 0u;
            sky_row_run = 0u;
        }
    }
    if (is_above && count == sky_row_least) {
        sky_run += SKY_RUN;
        sky_row_run = max(sky_row_run, sky_run + sample);
    } else {
        sky_run = 0u;
    }
}

// With the last part of a row notes its fewest and its longest run.
fn sky_end_row(row: u32) {
    if (sky_column() + SKY_COLUMNS == SKY_SAMPLES && sky_row_least <= sky_own_least) {
        let run = select(0u, (sky_row_run << 8u) | (255u - row), sky_row_run > 0u);
        sky_own_run = select(run, max(run, sky_own_run), sky_row_least == sky_own_least);
        sky_own_least = sky_row_least;
    }
}

// The part of a sample that is seen, after `sky_count` or `sky_count_crowd`.
fn sky_seen_part(lane: u32, c: u32) -> f32 {
    let cell = select(c, sky_column() + c, sky_is_crowd) * sky_rows + lane;
    return f32(atomicLoad(&sky_counts[cell])) * select(1.0, 1.0 / f32(SKY_FINER), sky_is_crowd) / f32(2 * SKY_HALF);
}

// The fewest surfaces of all parts, and the longest runs. Requires uniform control flow.
fn sky_fewest(lane: u32) -> i32 {
    if (lane == 0u) {
        atomicStore(&sky_least, SKY_MOST);
        atomicStore(&sky_least_of_any, SKY_MOST);
        atomicStore(&sky_best_run, 0u);
        atomicStore(&sky_open_run, 0u);
    }
    workgroupBarrier();
    atomicMin(&sky_least, sky_own_least);
    atomicMin(&sky_least_of_any, sky_own_least_of_any);
    for (var row = lane; row < SKY_ROWS; row += LANES) {
        atomicMax(&sky_open_run, sky_open_from(row));
    }
    workgroupBarrier();
    if (sky_own_least == atomicLoad(&sky_least)) {
        atomicMax(&sky_best_run, sky_own_run);
    }
    if (lane == 0u) {
        sky_plan = atomicLoad(&sky_least);
        if (sky_plan == SKY_MOST) {
            // Outlines pass through all samples: the fewest of which something is seen.
            sky_plan = (atomicLoad(&sky_least_of_any) >> SKY_CUTS) << SKY_CUTS;
        }
    }
    return workgroupUniformLoad(&sky_plan);
}

fn sky_is_crossed(row: u32) -> bool { return ((atomicLoad(&sky_crossed[row / 32u]) >> (row % 32u)) & 1u) != 0u; }

// The first row that is crossed, or their number if none is.
fn sky_first_crossed() -> u32 {
    var first = SKY_ROWS;
    for (var word = 0u; word < (SKY_ROWS + 31u) / 32u && first == SKY_ROWS; word++) {
        let rows = atomicLoad(&sky_crossed[word]);
        first = select(first, 32u * word + countTrailingZeros(rows), rows != 0u);
    }
    return first;
}

// The run of rows that nothing crosses and that begins with a row, as a number: its length, and 255 less its distance from the first
// crossed row. 0 if none begins there, all ones if nothing crosses any row.
fn sky_open_from(row: u32) -> u32 {
    let first = sky_first_crossed();
    if (first == SKY_ROWS) {
        return 0xffffffffu;
    }
    if (sky_is_crossed(row) || !sky_is_crossed((row + SKY_ROWS - 1u) % SKY_ROWS)) {
        return 0u;
    }
    var length = 0u;
    while (length < SKY_ROWS && !sky_is_crossed((row + length) % SKY_ROWS)) {
        length += 1u;
    }
    return (length << 8u) | (255u - (row + SKY_ROWS - first) % SKY_ROWS);
}

// A direction of the world before which the fewest surfaces lie, far from outlines: the first of `SkyBuffer::witnesses`.
fn sky_witness(fewest: i32) -> vec3f {
    let open = atomicLoad(&sky_open_run);
    if (fewest == 0 && open != 0u) {
        var row = SKY_ROWS / 2u;
        if (open != 0xffffffffu) {
            row = (sky_first_crossed() + (255u - (open & 255u)) + (open >> 8u) / 2u) % SKY_ROWS;
        }
        return sky_direction_at(row, 0.5 * sky_end(row, sky_horizon.local));
    }
    let best = atomicLoad(&sky_best_run);
    if (best == 0u) {
        return sky_horizon.normal;
    }
    let run = best >> 8u;
    let sample = f32(run % SKY_RUN) + 1.0 - 0.5 * f32(run / SKY_RUN);
    return sky_direction_at(255u - (best & 255u), select(sample, sample / f32(SKY_FINER), sky_is_crowd));
}

// Whether nothing crosses any row. Requires that `sky_fewest` has run.
fn sky_is_empty() -> bool { return atomicLoad(&sky_open_run) == 0xffffffffu; }
