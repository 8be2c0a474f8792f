// Integrals over lights that show an image, by channel, in place of plain.wgsl.

// By channel, and for a light that is as bright everywhere.
alias OutlineSum = vec4f;

const OUTLINE_SHOWS = true;

var<private> outline_places: Places;

// Only of lights without images.
fn outline_in_parts(value: OutlineValue) -> f32 { return 0.0; }

fn outline_begin(right: vec3f) { outline_places = image_places(right); }

// The four quarters of a cell, as far as they have come: `Quarters` says why. Sums of the image, and of its changes from half to half of each.
struct OutlineQuarters {
    weights: vec4f,
    sides: mat3x3f,
    depth: u32,
    count: u32,
}

// Adds the next cell. Returns what all four miss with the last one.
fn outline_quarters_add(all: ptr<function, OutlineQuarters>, depth: u32, cell: vec2u, weight: f32, sides: mat3x3f) -> vec3f {
    let place = (cell.x & 1u) + 2u * (cell.y & 1u);
    if (place == 0u) {
        *all = OutlineQuarters();
        (*all).depth = depth;
    }
    if ((*all).depth != depth || (*all).count != place) {
        return vec3f(0.0);
    }
    (*all).count += 1u;
    (*all).weights[place] = weight;
    (*all).sides += sides;
    let w = (*all).weights;
    let least = min(min(w.x, w.y), min(w.z, w.w));
    let most = max(max(w.x, w.y), max(w.z, w.w));
    if ((*all).count < 4u || least < OUTLINE_EVEN * most) {
        return vec3f(0.0);
    }
    return ((*all).sides[1] * (w.y + w.w - w.x - w.z) + (*all).sides[2] * (w.z + w.w - w.x - w.y)) / 12.0;
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
    let is_power = value.kind == OUTLINE_POWER;
    let is_wide_power = is_power && value.half_exponent < 0.5 * OUTLINE_STEEP;
    let of_cosines = select(OUTLINE_CELL_WIDE, OUTLINE_CELL_POWER, is_power && !is_wide_power);
    let small_cell = select(of_cosines, OUTLINE_CELL_FACETS, value.kind == OUTLINE_FACETS);
    // Where the reflectance may end.
    let horizons = mat2x3f(value.normal, select(value.normal, value.axis, is_wide_power));
    var sum = vec4f(0.0);
    var quarters = OutlineQuarters();
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
            let p = vec3f(on_plane, 1.0);
            let across_horizons = abs(vec3f(right * half.x, 0.0) * horizons) + abs(vec3f(up * half.y, 0.0) * horizons);
            let is_crossed = any(abs(p * horizons) < across_horizons);
            let part = small_cell * select(1.0, OUTLINE_AT_HORIZON, is_crossed);
            let small = part * part * (1.0 + dot(away, away));
            let is_large = depth < OUTLINE_SHALLOWEST || dot(across, across) + dot(along, along) > small;
            if (is_large && depth < OUTLINE_DEEPEST) {
                cell *= 2u;
                depth += 1u;
                continue;
            }
            if (dot(value.normal, p) > 0.0) {
                let inverse = 1.0 / dot(p, p);
                let weight = half.x * half.y * inverse * sqrt(inverse) * outline_value(value, p, inverse);
                var shown = vec3f(0.0);
                if (depth + OUTLINE_SMOOTH <= levels) {
                    let copy = image_copy(levels - depth - 1u);
                    var sides = mat3x3f();
                    for (var k = 0u; k < 4u; k++) {
                        let to = vec2f(vec2u(k & 1u, k >> 1u)) - 0.5;
                        let quarter = image_nearest(copy, place + half * to);
                        sides += mat3x3f(0.25 * quarter, to.x * quarter, to.y * quarter);
                    }
                    shown = sides[0];
                    sum += vec4f(outline_quarters_add(&quarters, depth, cell, weight, sides), 0.0);
                } else if (depth <= levels) {
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

fn outline_end(peak: OutlinePeak, value: OutlineValue) -> vec4f { return outline_sum * outline_mean_shown(peak, value); }

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
