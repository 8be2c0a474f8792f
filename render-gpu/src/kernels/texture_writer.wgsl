// Writes radiance to a texture, one pixel a thread; points are listed by tiles of 8 × 8 pixels. `target_texture` is a storage
// texture of binding 10.
@group(0) @binding(1) var<storage, read> points: array<Receiver>;
@group(0) @binding(3) var<storage, read> radiance: array<vec4f>;

// The first row of tiles in the binding.
struct Band {
    first: u32,
}
@group(0) @binding(0) var<uniform> band: Band;

@compute @workgroup_size(8, 8)
fn write_points(
    @builtin(workgroup_id) tile: vec3u,
    @builtin(num_workgroups) tiles: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let point = 64u * (tile.y * tiles.x + tile.x) + lane;
    let pixel = 8u * vec2u(tile.x, band.first + tile.y) + vec2u(lane % 8u, lane / 8u);
    let size = textureDimensions(target_texture);
    if pixel.x < size.x && pixel.y < size.y {
        // Coverage: a pixel without a visible point is transparent.
        let alpha = select(1.0, 0.0, points[point].material == NO_MATERIAL);
        textureStore(target_texture, pixel, vec4f(radiance[point].xyz, alpha));
    }
}
