// The visible fraction of microfacets' light, as `MaskVisibility::microfacets`.

// The exponent of microfacets whose edge fraction is known, and that fraction.
var<private> known_edge: vec2f = vec2f(-1.0, 0.0);

fn is_known_edge(lobe: Lobe) -> bool { return microfacets_is_edge(lobe) && known_edge.x == lobe.exponent; }

// The highlight has masks of its own, beside those of the whole light.
fn masks_of_microfacets(at: Receiver, tolerance: f32, lobe: Lobe, is_narrow_finer: bool) -> Masks {
    if (is_known_edge(lobe)) {
        return Masks();
    }
    let square = microfacets_highlight(places_whole, at, lobe, tolerance);
    let is_finer = is_narrow_finer && light_size(places_whole) > 2.0 * microfacets_width(lobe);
    return masks_of_highlight(square, is_finer);
}

// From the sums of all masks.
fn microfacet_fraction(sums: vec4f, lobe: Lobe) -> f32 {
    if (is_known_edge(lobe)) {
        known_edge.x = -1.0;
        return known_edge.y;
    }
    let is_edge = microfacets_is_edge(lobe);
    var fractions = sums.xy / sums.zw;
    // If all weights vanish, every sample counts alike.
    let is_known = (sums.zw > vec2f(0.0)) & (sums.zw < vec2f(3e38)) & (abs(fractions) < vec2f(3e38));
    fractions = clamp(select(vec2f(visibility_alike()), fractions, is_known), vec2f(0.0), vec2f(1.0));
    known_edge = vec2f(select(lobe.exponent, -1.0, is_edge), fractions.y);
    return select(fractions.x, fractions.y, is_edge);
}

// The part of the window that shows the highlight, along its cells; the whole window if the part is most of it.
fn microfacets_highlight(whole: UnitSquare, at: Receiver, lobe: Lobe, tolerance: f32) -> UnitSquare {
    let widths = clamp(HIGHLIGHT / sqrt(max(tolerance, 1e-6)), 1.5, 20.0);
    let mirror = microfacets_mirror(microfacets_of(at.normal, lobe));
    let peak = square_peak(whole, Lobe(mirror, 1.0, vec3f(1.0), LOBE_PLAIN), at.normal).point;
    let along = dot(whole.axis, mirror);
    let aside = vec2f(dot(whole.right, mirror), dot(whole.up, mirror));
    var beside = 1e30;
    if (along > 1e-3) {
        let away = aside / along - peak;
        beside = sqrt(dot(away, away));
    }
    let reach = widths * max(2.0 * microfacets_width(lobe) * (1.0 + dot(peak, peak)), 0.5 * beside);
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

// The microfacets in the frame of a mask's square.
fn microfacets_in(square: UnitSquare, world: MicrofacetsAt) -> MicrofacetsAt {
    return microfacets_local(world, square.right, square.up, square.axis);
}

// Sums over all rows, in steradians of samples: both lobes over the lit samples, and over the emitting samples. Of the whole light's
// masks the samples in the highlight's window do not count. Requires uniform control flow.
fn microfacet_sums(lane: u32, mask: Mask, at: Receiver, lobe: Lobe, masks: Masks, is_own: bool) -> vec4f {
    let microfacets = microfacets_in(mask.square, microfacets_of(at.normal, lobe));
    var sum = vec4f(0.0);
    if (emitting.x < emitting.y) {
        let y = open_y(mask, lane);
        let counts = row_counts(lit);
        let samples = f32(row_width / (4u * row_groups));
        let ends = vec2f(emitting) / samples;
        for (var group = 0u; group < row_groups; group++) {
            let x = middles(mask, group);
            let column = vec4f(row_columns(group));
            let open = open_of(counts, group);
            let emits = (saturate(ends.y - column) - saturate(ends.x - column)) * samples;
            for (var k = 0u; k < 4u; k++) {
                let point = vec2f(x[k], y);
                let inverse = 1.0 / (dot(point, point) + 1.0);
                let root = sqrt(inverse);
                let both = microfacets_both(microfacets, vec3f(point, 1.0) * root) * (inverse * root);
                let is_left_out = !is_own && all(point > masks.low) && all(point < masks.high);
                let w = select(select(vec2f(0.0), both, both > vec2f(0.0)), vec2f(0.0), is_left_out);
                sum += vec4f(open[k] * w, emits[k] * w);
            }
        }
        let cell = mask_cell(mask);
        sum *= cell.x * cell.y * f32(SIDE) / f32(row_width);
    }
    return total(lane, sum);
}
