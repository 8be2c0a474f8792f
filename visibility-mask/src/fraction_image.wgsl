// The visible fraction of a light that shows an image, by channel: as `image_fractions`. Needs visibility.wgsl, LOBES, image.wgsl
// of lobe-core, and fraction_image_microfacets.wgsl or its replacement.

// The visible fraction of the light for a lobe. Requires uniform control flow.
fn visible_fraction(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: UnitSquare, lobe: Lobe) -> vec3f {
    let is_facets = HAS_MICROFACETS && lobe.kind >= LOBE_MICROFACETS_F0;
    var square = whole;
    var is_finer = false;
    if (is_facets) {
        square = image_highlight(whole, at, tolerance, lobe);
        is_finer = light_size(whole) > 2.0 * image_alpha(lobe);
    } else if (!is_lambert(at, lobe)) {
        let peak = square_peak(whole, lobe, at.normal);
        square = square_around(whole, peak, zoom_sigmas(tolerance));
        is_finer = peak_fall(peak, whole) > STEEP;
    }
    let is_part = any(square.half < whole.half);
    is_finer = IS_NARROW_FINER && is_finer && !is_part;
    var seen = vec3f(0.0);
    var all = vec3f(0.0);
    if (decide(lane, is_part || is_finer)) {
        row_refine(true);
        for (var k = 0u; k < NARROW_GRID.x * NARROW_GRID.y; k++) {
            let mask = mask_reset(square_part(square, k, NARROW_GRID), lane, at.normal);
            blockers_splat(lane, tile, at, light, mask);
            let sums = image_sums(lane, mask, at, lobe, is_facets, vec2f(1e30), vec2f(-1e30));
            seen += sums[0];
            all += sums[1];
        }
        row_refine(false);
    }
    // The masks of the whole light leave out the window of a highlight's masks; a lobe's own window replaces them.
    if (decide(lane, !is_finer && (is_facets || !is_part))) {
        let low = select(vec2f(1e30), square.center - square.half, is_part);
        let high = select(vec2f(-1e30), square.center + square.half, is_part);
        for (var k = 0u; k < BROAD_COUNT; k++) {
            emitting = broad_emitting[k];
            lit = broad_lit[k];
            let sums = image_sums(lane, mask_of(square_part(whole, k, BROAD_GRID)), at, lobe, is_facets, low, high);
            seen += sums[0];
            all += sums[1];
        }
    }
    // If all weights vanish, every sample counts alike.
    let areas = visibility_areas(lane);
    let alike = select(0.0, areas.x / areas.y, areas.y > 0.0);
    let fraction = seen / all;
    let is_known = (all > vec3f(0.0)) & (all < vec3f(3e38)) & (abs(fraction) < vec3f(3e38));
    return clamp(select(vec3f(alike), fraction, is_known), vec3f(0.0), vec3f(1.0));
}

// Sums over all rows, in steradians of samples: the lit part, and the emitting part. Samples between `low` and `high` do not count.
// Requires uniform control flow.
fn image_sums(lane: u32, mask: Mask, at: Receiver, lobe: Lobe, is_facets: bool, low: vec2f, high: vec2f) -> array<vec3f, 2> {
    let square = mask.square;
    let axis = square_local(square, lobe.axis);
    let normal = square_local(square, at.normal);
    let is_diffuse = is_lambert(at, lobe);
    let cell = mask_cell(mask);
    let widest = max(cell.x, cell.y);
    let half_exponent = 0.5 * min(lobe.exponent, max(2.0 / (widest * widest), MIRROR_EXPONENT));
    if (is_facets) {
        image_facets_in(square, at, lobe);
    }
    var sums = array<vec3f, 2>();
    if (emitting.x < emitting.y) {
        let y = mask_row_y(mask, lane);
        let counts = row_counts(lit);
        let samples = f32(row_width / (4u * row_groups));
        let ends = vec2f(emitting) / samples;
        let places = image_places(square.right);
        let area = 4.0 * square.half.x * square.half.y / f32(4u * row_groups * SIDE);
        let copy = image_copy(u32(round(image_level(image_area(places, area)))));
        for (var group = 0u; group < row_groups; group++) {
            let x = middles(mask, group);
            let column = vec4f(row_columns(group));
            let open = counts_of(counts, group);
            let emits = (saturate(ends.y - column) - saturate(ends.x - column)) * samples;
            for (var k = 0u; k < 4u; k++) {
                let p = vec3f(x[k], y, 1.0);
                let inverse = 1.0 / dot(p, p);
                let root = sqrt(inverse);
                var value = dot(normal, p) * root;
                if (is_facets) {
                    value = image_facets(p * root);
                } else if (!is_diffuse) {
                    let along = dot(axis, p);
                    let power = exp_f32(half_exponent * ln_1p(along * along * inverse - 1.0));
                    value = select(0.0, power * select(1.0, value, lobe.kind == LOBE_COSINE), along > 0.0);
                }
                let weight = value * inverse * root;
                let is_left_out = all(p.xy > low) && all(p.xy < high);
                if (weight > 0.0 && !is_left_out) {
                    let place = places.origin + places.x * p.x + places.y * p.y;
                    let texel = image_nearest(copy, place) * weight;
                    sums[0] += texel * open[k];
                    sums[1] += texel * emits[k];
                }
            }
        }
        let sample = cell.x * cell.y * f32(SIDE) / f32(row_width);
        sums[0] *= sample;
        sums[1] *= sample;
    }
    let seen = total(lane, vec4f(sums[0], 0.0)).xyz;
    let all = total(lane, vec4f(sums[1], 0.0)).xyz;
    return array<vec3f, 2>(seen, all);
}
