// The visible fraction of a light that shows an image, by channel: as `image_fractions`.

alias Fraction = vec3f;

// Sums over the masks of the lobe: the lit part, and the emitting part.
var<private> image_sums: array<vec3f, 2>;

fn masks_of_lobe(at: Receiver, light: Cone, tolerance: f32, lobe: Lobe, is_narrow_finer: bool) -> Masks {
    image_sums = array<vec3f, 2>();
    let whole = places_whole;
    if (is_microfacets(lobe)) {
        let is_finer = is_narrow_finer && light_size(whole) > 2.0 * image_alpha(lobe);
        return masks_of_highlight(image_highlight(whole, at, tolerance, lobe), is_finer);
    }
    return masks_of_cosines(at, light, tolerance, lobe, is_narrow_finer);
}

fn masks_fraction(lobe: Lobe) -> vec3f {
    let all = image_sums[1];
    // If all weights vanish, every sample counts alike.
    let fraction = image_sums[0] / all;
    let is_known = (all > vec3f(0.0)) & (all < vec3f(3e38)) & (abs(fraction) < vec3f(3e38));
    return clamp(select(vec3f(visibility_alike()), fraction, is_known), vec3f(0.0), vec3f(1.0));
}

// Adds all rows, in steradians of samples: the lit part, and the emitting part. Of the whole light's masks the samples in the
// window of the lobe's own masks do not count. Requires uniform control flow.
fn masks_add(
    lane: u32, mask: Mask, window: UnitSquare, masks: Masks, is_own: bool, is_near: bool, at: Receiver, lobe: Lobe
) {
    let square = mask.square;
    let axis = square_local(square, lobe.axis);
    let normal = square_local(square, at.normal);
    let is_diffuse = is_lambert(at, lobe);
    let is_facets = is_microfacets(lobe);
    let cell = mask_cell(mask);
    let widest = max(cell.x, cell.y);
    let half_exponent = 0.5 * min(lobe.exponent, max(2.0 / (widest * widest), MIRROR_EXPONENT));
    if (is_facets) {
        image_facets_in(square, at, lobe);
    }
    var sums = array<vec3f, 2>();
    if (emitting.x < emitting.y) {
        let y = open_y(mask, lane);
        let counts = row_counts(lit);
        let samples = f32(row_width / (4u * row_groups));
        let ends = vec2f(emitting) / samples;
        let places = image_places(square.right);
        let area = 4.0 * square.half.x * square.half.y / f32(4u * row_groups * SIDE);
        let copy = image_copy(u32(round(image_level(image_area(places, area)))));
        for (var group = 0u; group < row_groups; group++) {
            let x = middles(mask, group);
            let column = vec4f(row_columns(group));
            let open = open_of(counts, group);
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
                let is_left_out = !is_own && all(p.xy > masks.low) && all(p.xy < masks.high);
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
        sums[1] *= select(sample, 0.0, is_near);
    }
    image_sums[0] += total(lane, vec4f(sums[0], 0.0)).xyz;
    image_sums[1] += total(lane, vec4f(sums[1], 0.0)).xyz;
}
