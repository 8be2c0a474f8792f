// What of a face can block one receiver's light. Needs layer.wgsl, `lobe_core::wgsl::GEOMETRY` and `visibility_mask::wgsl::SQUARE`.
//
// In f32, where the Rust has f64: texels and q are counted from the place in the picture where the receiver itself is
// seen. With T = L − x, that place at depth −F·T and q_x = z₀/(−F·T) − 1,
//     (1 + q) m·(P − x) = (q − q_x) m·T + z₀ texel (Δi m·R + Δj m·U):
// no difference of large numbers. A receiver that is far outside of a face's picture has only distant blockers there.

const MAP_BIAS = 0.5;
const MAP_TILT = 0.03125;
const MAP_ROUNDING = 0.02;
const MAP_SHIFT = 0.125;
const MAP_SMALL = 0.7;
const MAP_PART_SHIFT = 0.25;
const MAP_NEAR = 1e-4;

// Verdicts.
const MAP_NO = 0u;
const MAP_SPLIT = 1u;
const MAP_BLOCKS = 2u;
// Small, and some of it may block; also with MAP_INSIDE where all of it does, MAP_STEP where it has two depths.
const MAP_PARTLY = 4u;
const MAP_INSIDE = 1u;
const MAP_STEP = 2u;

struct MapView {
    // From (Δi, Δj, Δq, 1) to homogeneous plane coordinates.
    image: mat4x3f,
    // Where texels and q are counted from.
    origin: vec3f,
    // What holds for the whole of what blocks: above, clear, front. Rows are functions of (Δi, Δj, Δq, 1).
    inner: mat4x4f,
    // What bounds the window.
    window: mat4x4f,
    reach: f32,
    small: f32,
    slack: f32,
}

// A box of texels and depths: middle and half extents.
struct MapBlock { middle: vec4f, half: vec3f }

// One face as seen from one receiver through the window from `low` to `high` of a square; `cell`: side of a mask's cell.
fn map_view(face: u32, light: vec4f, at: Receiver, square: UnitSquare, low: vec2f, high: vec2f, cell: f32) -> MapView {
    let right = map_vec3(face);
    let up = map_vec3(face + 3u);
    let forward = map_vec3(face + 6u);
    let corner = vec2f(map_f32(face + 9u), map_f32(face + 10u));
    let texel = map_f32(face + 11u);
    let z0 = map_f32(face + 12u);

    let to_light = light.xyz - at.position;
    let distance = max(length(to_light), 1e-30);
    let receiver = -vec3f(dot(right, to_light), dot(up, to_light), dot(forward, to_light));
    // The face's middle, or where the receiver is seen, and how far the light's direction is from there.
    var seen = corner + (0.5 * texel) * vec2f(vec2u(maps_word(face + 13u), maps_word(face + 14u)));
    var toward = seen.x * right + seen.y * up + forward;
    var off = toward;
    var depth = -1.0;
    if receiver.z > 0.25 * max(abs(receiver.x), abs(receiver.y)) {
        seen = receiver.xy / receiver.z;
        toward = -to_light / receiver.z;
        off = vec3f(0.0);
        depth = z0 / receiver.z - 1.0;
    }

    let i = (z0 * texel) * right;
    let j = (z0 * texel) * up;
    // The square faces the light: T is along its axis.
    let image = mat4x3f(
        square_local(square, i),
        square_local(square, j),
        vec3f(0.0, 0.0, distance),
        z0 * square_local(square, off)
    );
    let rows = transpose(image);
    let along = vec4f(dot(at.face, i), dot(at.face, j), dot(at.face, to_light), z0 * dot(at.face, off));
    let above = along - vec4f(0.0, 0.0, 0.0, MAP_ROUNDING * texel * z0);
    let clear = along + MAP_TILT * rows[2] - vec4f(0.0, 0.0, 0.0, MAP_BIAS * texel * z0);
    // On the receiver's side of the circle in which its tangents touch the light.
    let back = -to_light / distance;
    let touch = light.w * light.w / distance;
    let front = vec4f(dot(back, i), dot(back, j), -touch, z0 * dot(back, toward) - (1.0 + depth) * touch);

    let farthest = length(square.center) + max(square.half.x, square.half.y);
    return MapView(
        image,
        vec3f((seen - corner) / texel, depth),
        transpose(mat4x4f(above, clear, front, vec4f(0.0, 0.0, 0.0, 1.0))),
        transpose(mat4x4f(
            rows[2] * high.x - rows[0],
            rows[0] - rows[2] * low.x,
            rows[2] * high.y - rows[1],
            rows[1] - rows[2] * low.y
        )),
        // Of a point light nothing is merged that is not flat.
        select(farthest * distance / (MAP_SHIFT * max(cell, 1e-30)), 1e15, cell <= 0.0),
        z0 * texel / (MAP_SMALL * max(cell, 1e-30)),
        2.0 * MAP_SHIFT * cell
    );
}

// All of a node's texels, corners included.
fn map_block(view: MapView, layer: MapLayer, item: MapItem, node: MapNode) -> MapBlock {
    let box = vec4f(map_texels(layer, item));
    var low = node.low;
    var high = node.high;
    if item.level == 0u {
        // A texel's own bounds don't have its corners in them, those of the node above do.
        let above = map_node_at(layer, 1u, item.i >> 1u, item.j >> 1u);
        low = map_f32(above);
        high = map_f32(above + 1u);
    }
    let middle = 0.5 * vec3f(box.xz + box.yw, low + high) - view.origin;
    return MapBlock(vec4f(middle, 1.0), 0.5 * vec3f(box.yw - box.xz, high - low));
}

// How much functions differ over a block.
fn map_spread(functions: mat4x4f, half: vec3f) -> vec4f {
    return abs(functions[0]) * half.x + abs(functions[1]) * half.y + abs(functions[2]) * half.z;
}

// Whether some function is negative all over a block.
fn map_is_outside(functions: mat4x4f, block: MapBlock) -> bool {
    return any(functions * block.middle + map_spread(functions, block.half) <= vec4f(0.0));
}

// Whether all of them are positive all over it.
fn map_is_inside(functions: mat4x4f, block: MapBlock) -> bool {
    return all(functions * block.middle - map_spread(functions, block.half) > vec4f(0.0));
}

// The least depth of a block toward the light.
fn map_nearest(view: MapView, block: MapBlock) -> f32 {
    let depth = vec4f(view.image[0].z, view.image[1].z, view.image[2].z, view.image[3].z);
    return dot(depth, block.middle) - dot(abs(depth.xyz), block.half);
}

fn map_judge(view: MapView, layer: MapLayer, item: MapItem, node: MapNode, block: MapBlock) -> u32 {
    if map_is_outside(view.window, block) || map_is_outside(view.inner, block) {
        return MAP_NO;
    }
    if item.level == 0u {
        // A texel is there with its centre.
        let middle = vec4f(block.middle.xy, node.low - view.origin.z, 1.0);
        return select(MAP_NO, MAP_BLOCKS, all(view.inner * middle > vec4f(0.0)));
    }
    let inside = map_is_inside(view.inner, block);
    let nearest = map_nearest(view, block);
    if inside && node.deviation * view.reach <= nearest {
        return MAP_BLOCKS;
    }
    if f32(1u << item.level) * view.small <= nearest {
        let flat = block.half.z * view.reach <= nearest;
        return MAP_PARTLY + select(0u, MAP_INSIDE, inside) + select(MAP_STEP, 0u, flat);
    }
    return MAP_SPLIT;
}

// What stands for a small node: a part nearer to the light than the middle of its depths, and one farther; one where it is
// flat. Where depths differ too much within one, the node is to be split.
struct MapParts { near: MapPart, far: MapPart, is_split: bool }

// Of a large node 4 × 4 texels are looked at.
fn map_parts(view: MapView, layer: MapLayer, item: MapItem, node: MapNode, block: MapBlock, verdict: u32) -> MapParts {
    let texels = map_texels(layer, item);
    let step = 1u << (max(item.level, 2u) - 2u);
    let inside = (verdict & MAP_INSIDE) != 0u;
    let middle = select(MAP_EMPTY, 0.5 * (node.low + node.high), (verdict & MAP_STEP) != 0u);
    var near = vec4f(0.0);
    var far = vec4f(0.0);
    // Bounds of q.
    var near_bounds = vec2f(1e30, MAP_EMPTY);
    var far_bounds = near_bounds;
    var count = 0.0;
    for (var y = texels.z + step / 2u; y < texels.w; y += step) {
        for (var x = texels.x + step / 2u; x < texels.y; x += step) {
            count += 1.0;
            let at = vec4f(f32(x) + 0.5, f32(y) + 0.5, map_q(layer, x, y), 1.0);
            if at.z > MAP_EMPTY && (inside || all(view.inner * (at - vec4f(view.origin, 0.0)) > vec4f(0.0))) {
                if at.z < middle {
                    far += at;
                    far_bounds = vec2f(min(far_bounds.x, at.z), max(far_bounds.y, at.z));
                } else {
                    near += at;
                    near_bounds = vec2f(min(near_bounds.x, at.z), max(near_bounds.y, at.z));
                }
            }
        }
    }
    let range = (2.0 * MAP_PART_SHIFT / MAP_SHIFT) * map_nearest(view, block) / view.reach;
    let is_split = max(near_bounds.y - near_bounds.x, far_bounds.y - far_bounds.x) > range;
    return MapParts(map_part(texels, near, count), map_part(texels, far, count), is_split);
}
