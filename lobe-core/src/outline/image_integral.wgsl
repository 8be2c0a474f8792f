// Integrals over lights that show an image, by channel, in place of plain.wgsl.

// By channel, and for a light that is as bright everywhere.
alias OutlineSum = vec4f;

const OUTLINE_SHOWS = true;

// Of the reflectance times the image, and alone; of the image alone over the plane, and of one.
var<private> outline_shown: vec4f;
var<private> outline_plane: vec4f;
var<private> outline_places: Places;
// Whether the reflectance has long tails: cells see the image then, and nodes do not.
var<private> outline_has_tails: bool;

// Only of lights without images.
fn outline_in_parts(value: OutlineValue) -> f32 { return 0.0; }

fn outline_rule(length: f32, is_beside: bool) -> vec2u {
    if (length < 0.5) {
        return select(OUTLINE_EIGHT, OUTLINE_FOUR, is_beside);
    }
    return select(OUTLINE_SIXTEEN, OUTLINE_EIGHT, length < 1.1);
}

fn outline_begin(right: vec3f, value: OutlineValue) {
    outline_places = image_places(right);
    outline_has_tails = value.kind == OUTLINE_FACETS;
    outline_shown = vec4f(0.0);
    outline_plane = vec4f(0.0);
}

fn outline_sample(p: vec3f, area: f32, angle: f32, value: f32) {
    if (outline_has_tails) {
        outline_shown.w += area * angle * value;
        return;
    }
    let place = outline_places.origin + outline_places.x * p.x + outline_places.y * p.y;
    let texel = vec4f(image_at(place, image_level(image_area(outline_places, area))), 1.0);
    outline_shown += texel * (area * angle * value);
    outline_plane += texel * area;
}

// The mean of the image, weighted by a reflectance, and 1; 0 where nothing has a weight. `mean_shown` says why.
fn outline_mean_shown(peak: OutlinePeak, value: OutlineValue) -> vec4f {
    let places = outline_places;
    // The image's middle and its half sides on the plane at distance 1.
    let area = places.x.x * places.y.y - places.y.x * places.x.y;
    let right = vec2f(places.y.y, -places.x.y) / area;
    let up = vec2f(-places.y.x, places.x.x) / area;
    let middle = -(right * places.origin.x + up * places.origin.y);
    let finest = image_copy(0u).xy;
    let least = min(finest.x, finest.y);
    let roots = finest / least;
    let levels = firstTrailingBit(least);
    var sum = vec4f(0.0);
    for (var k = 0u; k < roots.x * roots.y; k++) {
        let root = vec2u(k % roots.x, k / roots.x);
        var cell = vec2u(0u);
        var depth = 0u;
        loop {
            let half = 1.0 / vec2f(roots << vec2u(depth));
            let place = vec2f((root << vec2u(depth)) + cell) * (2.0 * half) + half - 1.0;
            let on_plane = middle + right * place.x + up * place.y;
            let away = (on_plane - peak.point) / peak.width;
            let across = right * half.x / peak.width;
            let along = up * half.y / peak.width;
            let small = OUTLINE_SMALL_CELL * OUTLINE_SMALL_CELL * (1.0 + dot(away, away));
            if (dot(across, across) + dot(along, along) > small && depth < OUTLINE_DEEPEST) {
                cell *= 2u;
                depth += 1u;
                continue;
            }
            let p = vec3f(on_plane, 1.0);
            if (dot(value.normal, p) > 0.0) {
                let inverse = 1.0 / dot(p, p);
                let weight = half.x * half.y * inverse * sqrt(inverse) * outline_value(value, p, inverse);
                var shown = vec3f(0.0);
                if (depth <= levels) {
                    shown = image_nearest(image_copy(levels - depth), place);
                } else {
                    shown = image_at(place, 0.0);
                }
                sum += vec4f(shown, 1.0) * weight;
            }
            // The first cell that is in none of those before it.
            while (depth > 0u && (cell.x & cell.y & 1u) == 1u) {
                cell /= 2u;
                depth -= 1u;
            }
            if (depth == 0u) {
                break;
            }
            let is_left = (cell.x & 1u) == 0u;
            cell = select(vec2u(cell.x - 1u, cell.y + 1u), vec2u(cell.x + 1u, cell.y), is_left);
        }
    }
    return select(vec4f(0.0), sum / sum.w, sum.w > 0.0);
}

fn outline_end(peak: OutlinePeak, value: OutlineValue) -> vec4f {
    if (outline_has_tails) {
        return outline_shown.w * outline_mean_shown(peak, value);
    }
    var is_small = !outline.is_clipped;
    for (var i = 0u; i < outline_point_count; i++) {
        let away = (outline_points[i] - peak.point) / peak.width;
        is_small = is_small && dot(away, away) < OUTLINE_SMALL_LIGHT;
    }
    // The mean of the image is one: the part of it that the nodes miss, they miss of the product.
    let off = outline_shown.w * (1.0 - outline_plane.xyz / outline_plane.w);
    return outline_shown + select(vec4f(0.0), vec4f(off, 0.0), is_small);
}

fn light_integral(at: Receiver, lobe: Lobe, cone: Cone) -> vec3f {
    if (!light_is_flat()) {
        return vec3f(0.0);
    }
    let is_diffuse = is_lambert(at, lobe);
    if (is_diffuse && !outline.is_clipped && light_images[frame.image + 1u] != 0u) {
        var irradiance = vec3f(0.0);
        for (var k = 0u; k < 3u; k++) {
            let word = frame.image + 2u + 3u * k;
            let vector = vec3u(light_images[word], light_images[word + 1u], light_images[word + 2u]);
            irradiance[k] = dot(bitcast<vec3f>(vector), at.normal);
        }
        return max(irradiance, vec3f(0.0)) * FRAC_1_PI;
    }
    let sums = outline_integral(at, lobe);
    var part = 1.0;
    if (is_diffuse) {
        // A closed form is nearer to the truth than its rows.
        let closed = outline_closed(at.normal);
        part = select(1.0, closed.x / sums.w, closed.y > OUTLINE_WIDE);
    }
    let value = sums.xyz * part;
    return select(vec3f(0.0), value, value > vec3f(0.0) & value < vec3f(3e38));
}
