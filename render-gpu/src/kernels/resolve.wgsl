// Pixels as the means of their points' radiance, one pixel a thread. The points of a pixel lie side by side, in tiles of 64 places that may
// have empty ones at their ends. `target_texture` is a storage texture of binding 10.
struct Part {
    // Where the part begins in the picture.
    corner: vec2u,
    size: vec2u,
    // One over the camera rays of a pixel.
    scale: f32,
    // 1 where pixels have radiance besides that of their points.
    has_rest: u32,
}
@group(0) @binding(0) var<uniform> part: Part;
// The place of each pixel's first point.
@group(0) @binding(1) var<storage, read> firsts: array<u32>;
// For each place the rays that its point stands for, and marks; 0 where there is none.
@group(0) @binding(2) var<storage, read> weights: array<u32>;
@group(0) @binding(3) var<storage, read> radiance: array<vec4f>;
@group(0) @binding(4) var<storage, read> rest: array<vec4f>;

@compute @workgroup_size(8, 8)
fn resolve_pixels(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= part.size.x || id.y >= part.size.y {
        return;
    }
    let pixel = id.y * part.size.x + id.x;
    var sum = vec3f(0.0);
    var place = firsts[pixel];
    while place != NO_PLACE {
        let weight = weights[place];
        if weight == 0u {
            // The rest of this tile is empty.
            place = (place / 64u + 1u) * 64u;
            continue;
        }
        sum += radiance[place].xyz * f32(weight & RAYS);
        place = select(place + 1u, NO_PLACE, (weight & LAST) != 0u);
    }
    sum *= part.scale;
    if part.has_rest != 0u {
        sum += rest[pixel].xyz;
    }
    textureStore(target_texture, part.corner + id.xy, vec4f(sum, 1.0));
}
