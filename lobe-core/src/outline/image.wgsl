// Lights that show an image: `LightImage` as `LightImage::pack` writes it, from the word `frame.image` of `light_images` on.
// Reads `frame` and `light_images`.

// Sizes and where the texels begin: of copy 0, the finest, and so on.
fn image_copy(level: u32) -> vec3u {
    let at = frame.image + 11u + 3u * min(level, image_copies() - 1u);
    return vec3u(light_images[at], light_images[at + 1u], frame.image + light_images[at + 2u]);
}

fn image_copies() -> u32 { return light_images[frame.image]; }

fn image_texel(copy: vec3u, x: u32, y: u32) -> vec3f {
    let at = copy.z + 3u * (y * copy.x + x);
    return bitcast<vec3f>(vec3u(light_images[at], light_images[at + 1u], light_images[at + 2u]));
}

// The texel that a place is in.
fn image_nearest(copy: vec3u, place: vec2f) -> vec3f {
    let part = clamp(0.5 * (place + 1.0) * vec2f(copy.xy) + IMAGE_BORDER, vec2f(0.0), vec2f(copy.xy) - 1.0);
    return image_texel(copy, u32(part.x), u32(part.y));
}

fn image_between(copy: vec3u, place: vec2f) -> vec3f {
    let p = clamp(0.5 * (place + 1.0) * vec2f(copy.xy) - 0.5, vec2f(0.0), vec2f(copy.xy) - 1.0);
    let low = vec2u(p);
    let high = min(low + 1u, copy.xy - 1u);
    let part = p - vec2f(low);
    let below = mix(image_texel(copy, low.x, low.y), image_texel(copy, high.x, low.y), part.x);
    let above = mix(image_texel(copy, low.x, high.y), image_texel(copy, high.x, high.y), part.x);
    return mix(below, above, part.y);
}

// Its factor about a place, of a copy or of two of them.
fn image_at(place: vec2f, level: f32) -> vec3f {
    let clamped = clamp(level, 0.0, f32(image_copies() - 1u));
    let fine = u32(clamped);
    let part = clamped - f32(fine);
    let here = image_between(image_copy(fine), place);
    if (part > 0.0) {
        return mix(here, image_between(image_copy(fine + 1u), place), part);
    }
    return here;
}

// The copy whose texels are as large as an area in places.
fn image_level(area: f32) -> f32 {
    let finest = image_copy(0u);
    let texels = max(area * (0.25 * f32(finest.x * finest.y)), 1.0);
    return 0.5 * LOG2_E * ln_1p(texels - 1.0);
}

// The places on the light of points of the plane at distance 1, in the frame of `outline_project`: where 0 is, and steps along it.
struct Places {
    origin: vec2f,
    x: vec2f,
    y: vec2f,
}

fn image_place_of(v: vec3f) -> vec2f { return vec2f(dot(outline_sides[0], v), dot(outline_sides[1], v)); }

fn image_places(right: vec3f) -> Places {
    let up = cross(outline.axis, right);
    let h = outline.height;
    return Places(
        image_place_of(outline.axis) * h - image_place_of(outline.center), image_place_of(right) * h, image_place_of(up) * h
    );
}

fn image_area(places: Places, area: f32) -> f32 { return abs((places.x.x * places.y.y - places.x.y * places.y.x) * area); }
