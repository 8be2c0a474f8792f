// The part of a face that can block light from one receiver.
//
// This is f32, while Rust has f64: texels and q are counted from the receiver's own place in the face. With T = L − x, that place
// has depth −F·T and q_x = z₀/(−F·T) − 1, and
//     (1 + q) m·(P − x) = (q − q_x) m·T + z₀ texel (Δi m·R + Δj m·U):
// without differences of large numbers. A receiver far outside a face has only distant blockers there.

// Verdicts.
const MAP_NO = 0u;
const MAP_SPLIT = 1u;
const MAP_BLOCKS = 2u;
// The node is small and some of it may block; combined with MAP_INSIDE if all of it does, and MAP_STEP if it has two depths.
const MAP_PARTLY = 4u;
const MAP_INSIDE = 1u;
const MAP_STEP = 2u;

struct MapView {
    // From (Δi, Δj, Δq, 1) to homogeneous plane coordinates.
    image: mat4x3f,
    // Origin of texel coordinates and q.
    origin: vec3f,
    // Tests that decide whether a point blocks: above, clear, front. Rows are functions of (Δi, Δj, Δq, 1).
    inner: mat4x4f,
    // Tests that bound the window.
    window: mat4x4f,
    reach: f32,
    small: f32,
    slack: f32,
}

// A box of texels and depths: centre and half extents.
struct MapBlock { middle: vec4f, half: vec3f }

// The view of a face from one receiver through the window from `low` to `high` of a square; `cell`: side of a mask's cell.
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
    // The face's centre, or the receiver's place in it, and the distance of the light's direction from there.
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
    // In front of the circle in which the receiver's tangents touch the light.
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
        // For a point light only flat nodes are merged.
        select(farthest * distance / (MAP_SHIFT * max(cell, 1e-30)), 1e15, cell <= 0.0),
        z0 * texel / (MAP_SMALL * max(cell, 1e-30)),
        2.0 * MAP_SHIFT * cell
    );
}

// The box around all of a node's texels, corners included.
fn map_block(view: MapView, layer: MapLayer, item: MapItem, node: MapNode) -> MapBlock {
    let box = vec4f(map_texels(layer, item));
    var low = node.low;
    var high = node.high;
    if item.level == 0u {
        // The bounds of a texel do not include its corners; those of its parent node do.
        let above = map_node_at(layer, 1u, item.i >> 1u, item.j >> 1u);
        low = map_f32(above);
        high = map_f32(above + 1u);
    }
    let middle = 0.5 * vec3f(box.xz + box.yw, low + high) - view.origin;
    return MapBlock(vec4f(middle, 1.0), 0.5 * vec3f(box.yw - box.xz, high - low));
}

// The largest differences of functions from their values at a block's centre.
fn map_spread(functions: mat4x4f, half: vec3f) -> vec4f {
    return abs(functions[0]) * half.x + abs(functions[1]) * half.y + abs(functions[2]) * half.z;
}

// Whether some function is negative in the whole block.
fn map_is_outside(functions: mat4x4f, block: MapBlock) -> bool {
    return any(functions * block.middle + map_spread(functions, block.half) <= vec4f(0.0));
}

// Whether all functions are positive in the whole block.
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
        // A texel blocks if its centre does.
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

// The parts of a small node that block: one nearer to the light than its middle depth and one farther, or a single one if the node
// is flat. If depths differ too much within a part, the node must be split.
struct MapParts { near: MapPart, far: MapPart, is_split: bool }

// Visits 4 × 4 texels of a larger node.
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
