// Sums of a sky's light over what one receiver sees of it: `SkyView`. SKY_LOBES is the most lobes of a material.

var<workgroup> sky_lobes: array<Lobe, SKY_LOBES>;
// Which of the lobes the samples resolve, as bits.
var<workgroup> sky_resolved: u32;

// The thread's sums of each lobe, over what is seen and over all.
var<private> sky_sums_seen: array<vec3f, SKY_LOBES>;
var<private> sky_sums_all: array<vec3f, SKY_LOBES>;
// A uniform sky's light by Lambert's lobe: the part that is seen, and all, in a unit of their own.
var<private> sky_open_seen: f32;
var<private> sky_open_all: f32;

// Light and direction of a sample.
fn sky_table_at(row: u32, sample: u32, component: u32) -> f32 {
    return sky_table[2u * SKY_ROWS + ((6u * sky_horizon.pole + component) * SKY_SAMPLES + sample) * SKY_ROWS + row];
}

fn sky_light(row: u32, sample: u32) -> vec3f {
    return vec3f(sky_table_at(row, sample, 0u), sky_table_at(row, sample, 1u), sky_table_at(row, sample, 2u));
}

fn sky_direction(row: u32, sample: u32) -> vec3f {
    return vec3f(sky_table_at(row, sample, 3u), sky_table_at(row, sample, 4u), sky_table_at(row, sample, 5u));
}

// `SkyView::resolves_at`.
fn sky_resolves(at: Receiver, lobe: Lobe) -> bool {
    if (lobe.kind < LOBE_MICROFACETS_F0) {
        return lobe.exponent * SKY_STEP_SQ <= 1.0;
    }
    // Directions turn twice as far as half vectors. From low views a highlight is narrow across; that of a grain at most as narrow.
    let deviation = 1.0 / sqrt(max(lobe.exponent, MIN_POSITIVE));
    let height = positive(dot(lobe.axis, at.normal)) + 0.5 * deviation;
    return 0.25 * lobe.exponent * SKY_STEP_SQ <= 1.0 && 2.0 * deviation * height >= SKY_ACROSS;
}

// Finds which of the first `count` lobes the samples resolve, as bits; lobes without flux count as resolved. Requires uniform control flow.
fn sky_choose(lane: u32, at: Receiver, count: u32) -> u32 {
    if (lane == 0u) {
        sky_resolved = 0u;
        for (var k = 0u; k < count; k++) {
            sky_resolved |= select(0u, 1u << k, sky_resolves(at, sky_lobes[k]) || all(sky_lobes[k].flux == vec3f(0.0)));
        }
    }
    return workgroupUniformLoad(&sky_resolved);
}

// The value of a lobe of flux 1 in a direction.
fn sky_value(lobe: Lobe, at: Receiver, v: vec3f, cosine: f32) -> f32 {
    if (lobe.kind >= LOBE_MICROFACETS_F0) {
        return sky_facets(lobe, v);
    }
    let value = (lobe.exponent + 1.0) * FRAC_1_TAU * power(lobe.axis, v, lobe.exponent);
    return select(value, value * positive(cosine), lobe.kind == LOBE_COSINE);
}

// Adds the part's samples to the sums of a lobe, and with the first one to those of a uniform sky.
fn sky_add(lane: u32, at: Receiver, k: u32) {
    if (sky_part == 0u) {
        sky_sums_seen[k] = vec3f(0.0);
        sky_sums_all[k] = vec3f(0.0);
        sky_open_seen = select(sky_open_seen, 0.0, k == 0u);
        sky_open_all = select(sky_open_all, 0.0, k == 0u);
    }
    let row = sky_row(lane);
    if (row >= SKY_ROWS) {
        return;
    }
    let lobe = sky_lobes[k];
    let is_diffuse = is_lambert(at, lobe);
    sky_set_facets(at, lobe);
    // Where the receiver's own horizon is, and its facet's.
    let local = sky_local(at.normal);
    let is_steep = local.z <= SKY_STEEP;
    let end = select(sky_end(row, local), MAX_FLOAT, is_steep);
    let facet = sky_end(row, sky_horizon.local);
    let first = sky_column();
    var seen = vec3f(0.0);
    var all = vec3f(0.0);
    for (var c = 0u; c < SKY_COLUMNS; c++) {
        let column = f32(first + c);
        if (column >= end) {
            break;
        }
        let v = sky_direction(row, first + c);
        let cosine = dot(at.normal, v);
        var value = FRAC_1_PI * positive(cosine);
        if (!is_diffuse) {
            let inside = select(min(end - column, 1.0), select(0.0, 1.0, cosine > 0.0), is_steep);
            value = sky_value(lobe, at, v, cosine) * inside;
        }
        var part = sky_seen_part(lane, c);
        if (k == 0u) {
            let along = dot(sky_horizon.frame[2], v);
            let weight = positive(cosine) * sqrt(positive(1.0 - along * along));
            sky_open_all += weight;
            sky_open_seen += weight * part;
        }
        if (value == 0.0) {
            continue;
        }
        if (sky_horizon.is_facet) {
            part *= clamp(facet - column, 0.0, 1.0);
        }
        let light = sky_light(row, first + c) * value;
        all += light;
        seen += light * part;
    }
    sky_sums_seen[k] += seen;
    sky_sums_all[k] += all;
}
