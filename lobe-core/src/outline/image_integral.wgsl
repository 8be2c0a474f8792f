// Integrals over lights that show an image, by channel, in place of plain.wgsl.

// By channel, and for a light that is as bright everywhere.
alias OutlineSum = vec4f;

const OUTLINE_SHOWS = true;

// Of the reflectance times the image, and alone; of the image alone over the plane, and of one.
var<private> outline_shown: vec4f;
var<private> outline_plane: vec4f;
var<private> outline_places: Places;

// Only of lights without images.
fn outline_in_parts(value: OutlineValue) -> f32 { return 0.0; }

fn outline_rule(length: f32, is_beside: bool) -> vec2u {
    if (length < 0.5) {
        return select(OUTLINE_EIGHT, OUTLINE_FOUR, is_beside);
    }
    return select(OUTLINE_SIXTEEN, OUTLINE_EIGHT, length < 1.1);
}

fn outline_begin(right: vec3f) {
    outline_places = image_places(right);
    outline_shown = vec4f(0.0);
    outline_plane = vec4f(0.0);
}

fn outline_sample(p: vec3f, area: f32, angle: f32, value: f32) {
    let place = outline_places.origin + outline_places.x * p.x + outline_places.y * p.y;
    let texel = vec4f(image_at(place, image_level(image_area(outline_places, area))), 1.0);
    outline_shown += texel * (area * angle * value);
    outline_plane += texel * area;
}

fn outline_end(peak: OutlinePeak) -> vec4f {
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
