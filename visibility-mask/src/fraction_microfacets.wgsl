// What is seen of microfacets' light, as `MaskVisibility::microfacets`. Needs visibility.wgsl and microfacets.wgsl of lobe-core.

// Microfacets' highlights have a mask of their own up to so many of their widths 2α, over the root of the tolerance.
const HIGHLIGHT = 0.2;

// The exponent of microfacets whose visible fraction is known, and that of their edge.
var<private> known_edge: vec2f = vec2f(-1.0, 0.0);

// Requires uniform control flow.
fn microfacet_fraction(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: UnitSquare, lobe: Lobe) -> f32 {
    let is_edge = lobe.kind == LOBE_MICROFACETS_F90;
    if (decide(lane, is_edge && known_edge.x == lobe.exponent)) {
        known_edge.x = -1.0;
        return known_edge.y;
    }
    let counts = workgroupUniformLoad(&grid_counts);
    let forms = workgroupUniformLoad(&grid_forms);
    let microfacets = microfacets_of(at.normal, lobe);
    let alpha = sqrt(microfacets.alpha_sq);
    var square = microfacets_highlight(whole, microfacets, at.normal, tolerance);
    let is_part = any(square.half < whole.half);
    let is_finer = forms.z > 0u && !is_part && light_size(whole) > 2.0 * alpha;
    // First those of the highlight, then those of the whole light, where what they show is not counted.
    let own = select(0u, counts.z * counts.w, decide(lane, is_part || is_finer));
    let broad = select(counts.x * counts.y, 0u, decide(lane, is_finer));
    var sum = vec4f(0.0);
    var areas = vec4f(0.0);
    var around = NEAR_NOTHING;
    row_refine(true);
    for (var k = 0u; k < own; k++) {
        let mask = visibility_draw(lane, tile, at, light, square, k, counts.zw, forms.x);
        sum += microfacet_sums(lane, mask, microfacets, NEAR_NOTHING);
        areas += total(lane, visibility_counts(lane));
        around = near_with(lane, around, mask.square, counts.zw);
    }
    if (own > 0u && near_count(0u) > 0u) {
        near_find(lane, tile, at, light, square, around, areas, 1u, true);
        sum = microfacets_instead(lane, tile, at, light, square, microfacets, 1u, NEAR_NOTHING, sum);
    }
    let cut = select(NEAR_NOTHING, near_rect(square), is_part);
    var rest = vec4f(0.0);
    row_refine(forms.y > 0u);
    for (var k = 0u; k < broad; k++) {
        if (forms.w > 0u) {
            visibility_draw(lane, tile, at, light, whole, k, counts.xy, forms.x);
        } else {
            emitting = broad_emitting[k];
            lit = broad_lit[k];
        }
        rest += microfacet_sums(lane, mask_of(square_part(whole, k, counts.xy)), microfacets, cut);
    }
    if (broad > 0u) {
        row_refine(false);
        rest = microfacets_instead(lane, tile, at, light, whole, microfacets, 0u, cut, rest);
        row_refine(forms.y > 0u);
    }
    sum += rest;
    var fractions = sum.xy / sum.zw;
    // Where the weights say nothing every sample counts alike.
    let alike = visibility_share();
    let is_known = (sum.zw > vec2f(0.0)) & (sum.zw < vec2f(3e38)) & (abs(fractions) < vec2f(3e38));
    fractions = clamp(select(vec2f(alike), fractions, is_known), vec2f(0.0), vec2f(1.0));
    known_edge = vec2f(select(lobe.exponent, -1.0, is_edge), fractions.y);
    return select(fractions.x, fractions.y, is_edge);
}

// The part of the window that shows the highlight, along its cells; all of it where that is most.
fn microfacets_highlight(whole: UnitSquare, microfacets: MicrofacetsAt, normal: vec3f, tolerance: f32) -> UnitSquare {
    let widths = clamp(HIGHLIGHT / sqrt(max(tolerance, 1e-6)), 1.5, 20.0);
    let mirror = 2.0 * dot(microfacets.normal, microfacets.view) * microfacets.normal - microfacets.view;
    let peak = square_peak(whole, Lobe(mirror, 1.0, vec3f(1.0), LOBE_PLAIN), normal).point;
    let along = dot(whole.axis, mirror);
    let aside = vec2f(dot(whole.right, mirror), dot(whole.up, mirror));
    var beside = 1e30;
    if (along > 1e-3) {
        let away = aside / along - peak;
        beside = sqrt(dot(away, away));
    }
    let reach = widths * max(2.0 * sqrt(microfacets.alpha_sq) * (1.0 + dot(peak, peak)), 0.5 * beside);
    let most = vec2f(grid_counts.xy * vec2u(4u * row_groups, SIDE));
    let cell = 2.0 * whole.half / most;
    let origin = whole.center - whole.half;
    let low = clamp(floor((peak - reach - origin) / cell), vec2f(0.0), most - 1.0);
    let high = clamp(ceil((peak + reach - origin) / cell), low + 1.0, most);
    let size = high - low;
    if (2.0 * size.x * size.y < most.x * most.y) {
        let center = origin + 0.5 * (low + high) * cell;
        return UnitSquare(whole.right, whole.up, whole.axis, center, 0.5 * size * cell, whole.disc);
    }
    return whole;
}

// In the frame of a mask's square.
fn microfacets_in(square: UnitSquare, world: MicrofacetsAt) -> MicrofacetsAt {
    return MicrofacetsAt(square_local(square, world.normal), world.alpha_sq, square_local(square, world.view), world.shadowing);
}

// What masks of what is lit show, if there are some, in place of what `sum` says of that. Requires uniform control flow.
fn microfacets_instead(
    lane: u32, tile: u32, at: Receiver, light: Cone, window: UnitSquare, world: MicrofacetsAt, number: u32, cut: vec4f, sum: vec4f
) -> vec4f {
    let count = near_count(number);
    var near = vec4f(0.0);
    for (var k = 0u; k < count; k++) {
        near += microfacet_sums(lane, near_draw(lane, tile, at, light, window, number, k), world, cut);
    }
    return vec4f(select(sum.xy, near.xy, count > 0u), sum.zw);
}

// Of all rows, in steradians of samples: both lobes over the lit samples, and over those that emit. Samples in the rectangle `cut` do not
// count. Requires uniform control flow.
fn microfacet_sums(lane: u32, mask: Mask, world: MicrofacetsAt, cut: vec4f) -> vec4f {
    let square = mask.square;
    let microfacets = microfacets_in(square, world);
    var sum = vec4f(0.0);
    if (emitting.x < emitting.y) {
        let y = mask_row_y(mask, lane);
        let counts = row_counts(lit);
        let samples = f32(row_width / (4u * row_groups));
        let ends = vec2f(emitting) / samples;
        for (var group = 0u; group < row_groups; group++) {
            let x = middles(mask, group);
            let column = vec4f(row_columns(group));
            let open = counts_of(counts, group);
            let emits = (saturate(ends.y - column) - saturate(ends.x - column)) * samples;
            for (var k = 0u; k < 4u; k++) {
                let point = vec2f(x[k], y);
                let inverse = 1.0 / (dot(point, point) + 1.0);
                let root = sqrt(inverse);
                let both = microfacets_both(microfacets, vec3f(point, 1.0) * root) * (inverse * root);
                let is_left_out = all(point > cut.xy) && all(point < cut.zw);
                let w = select(select(vec2f(0.0), both, both > vec2f(0.0)), vec2f(0.0), is_left_out);
                sum += vec4f(open[k] * w, emits[k] * w);
            }
        }
        let cell = mask_cell(mask);
        sum *= cell.x * cell.y * f32(SIDE) / f32(row_width);
    }
    return total(lane, sum);
}
