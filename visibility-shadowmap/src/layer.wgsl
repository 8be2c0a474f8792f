// Depth layers and their pyramids in the layout of packed.rs. Calls `maps_word`.

// Part of a layer: `2^level` texels a side, at most.
struct MapItem { level: u32, i: u32, j: u32 }

// The places of a layer's parts, in words.
struct MapLayer { q: u32, nodes: u32, top: u32, width: u32, height: u32 }

// Bounds of q, `low > high` if there is no surface; the largest difference from the bilinear function of the corners.
struct MapNode { low: f32, high: f32, deviation: f32 }

// All texels with a surface have a larger q; empty ones have less.
const MAP_EMPTY = -1.0;
const MAP_NO_CORNERS = 0xffffffffu;

fn map_f32(k: u32) -> f32 { return bitcast<f32>(maps_word(k)); }

fn map_vec3(k: u32) -> vec3f { return vec3f(map_f32(k), map_f32(k + 1u), map_f32(k + 2u)); }

// Layer `k` of a face that begins at `face`.
fn map_layer(face: u32, k: u32) -> MapLayer {
    let at = maps_word(face + 16u + k);
    return MapLayer(maps_word(at + 1u), at + 1u, maps_word(at), maps_word(face + 13u), maps_word(face + 14u));
}

fn map_q(layer: MapLayer, i: u32, j: u32) -> f32 { return map_f32(layer.q + j * layer.width + i); }

// Number of columns and rows of nodes in a level.
fn map_size(layer: MapLayer, level: u32) -> vec2u {
    return (vec2u(layer.width, layer.height) + vec2u((1u << level) - 1u)) >> vec2u(level);
}

// The place of a node of level 1 or more.
fn map_node_at(layer: MapLayer, level: u32, i: u32, j: u32) -> u32 {
    let columns = (layer.width + (1u << level) - 1u) >> level;
    return maps_word(layer.nodes + level) + 4u * (j * columns + i);
}

fn map_node(layer: MapLayer, item: MapItem) -> MapNode {
    if item.level == 0u {
        let q = map_q(layer, item.i, item.j);
        return MapNode(select(1.0, q, q > MAP_EMPTY), select(-1.0, q, q > MAP_EMPTY), 0.0);
    }
    let at = map_node_at(layer, item.level, item.i, item.j);
    return MapNode(map_f32(at), map_f32(at + 1u), map_f32(at + 2u));
}

// Texels of a node: first column, end of columns, first row, end of rows.
fn map_texels(layer: MapLayer, item: MapItem) -> vec4u {
    let start = vec2u(item.i, item.j) << vec2u(item.level);
    let to = min(start + vec2u(1u << item.level), vec2u(layer.width, layer.height));
    return vec4u(start.x, to.x, start.y, to.y);
}

// The first child of a node.
fn map_first_part(item: MapItem) -> MapItem { return MapItem(item.level - 1u, 2u * item.i, 2u * item.j); }

// The node that follows when a node's children are skipped: its next sibling, or that of the nearest ancestor that has one; the
// root at the end. With it a traversal needs no stack.
fn map_next(layer: MapLayer, item: MapItem) -> MapItem {
    var at = item;
    while at.level < layer.top {
        let size = map_size(layer, at.level);
        if (at.i & 1u) == 0u && at.i + 1u < size.x {
            at.i += 1u;
            break;
        }
        if (at.j & 1u) == 0u && at.j + 1u < size.y {
            at.i &= 0xfffffffeu;
            at.j += 1u;
            break;
        }
        at = MapItem(at.level + 1u, at.i >> 1u, at.j >> 1u);
    }
    return at;
}

// q at corner `k` of a texel, counter-clockwise from the lower left: a mean, if all texels around the node of level 1 belong to one
// surface; else from a table.
fn map_corner(layer: MapLayer, i: u32, j: u32, k: u32) -> f32 {
    let table = maps_word(map_node_at(layer, 1u, i >> 1u, j >> 1u) + 3u);
    if table != MAP_NO_CORNERS {
        return map_f32(table + 4u * ((i & 1u) + 2u * (j & 1u)) + k);
    }
    let x = i + select(0u, 1u, k == 1u || k == 2u) - 1u;
    let y = j + (k >> 1u) - 1u;
    return ((map_q(layer, x, y) + map_q(layer, x + 1u, y + 1u)) + (map_q(layer, x + 1u, y) + map_q(layer, x, y + 1u))) * 0.25;
}

// q at the corners of a node's texels.
fn map_corners(layer: MapLayer, texels: vec4u) -> vec4f {
    let to = texels.yw - vec2u(1u);
    return vec4f(
        map_corner(layer, texels.x, texels.z, 0u),
        map_corner(layer, to.x, texels.z, 1u),
        map_corner(layer, to.x, to.y, 2u),
        map_corner(layer, texels.x, to.y, 3u)
    );
}

fn map_is_there(layer: MapLayer, i: u32, j: u32) -> bool {
    return i < layer.width && j < layer.height && map_q(layer, min(i, layer.width - 1u), min(j, layer.height - 1u)) > MAP_EMPTY;
}

// The largest differences of q from a node's bilinear function along its edges (below, right, above, left): 0 at an outline.
fn map_edge_deviations(layer: MapLayer, texels: vec4u, deviation: f32) -> vec4f {
    if deviation <= 0.0 {
        return vec4f(0.0);
    }
    let x = (texels.x + texels.y) >> 1u;
    let y = (texels.z + texels.w) >> 1u;
    let there = vec4<bool>(
        map_is_there(layer, x, texels.z - 1u),
        map_is_there(layer, texels.y, y),
        map_is_there(layer, x, texels.w),
        map_is_there(layer, texels.x - 1u, y)
    );
    return select(vec4f(0.0), vec4f(deviation), there);
}

// A part of a node: a trapezoid at one depth, corners counter-clockwise from the lower left; empty if `share` is 0.
struct MapPart { x: vec4f, y: vec4f, q: f32, share: f32 }

// A trapezoid that covers a fraction of the texels' rectangle, along the side that is nearest to the centre of the covered texels.
// Its slant follows the offset of that centre from the middle of the side. `sum`: sums of i, j, q and 1 over the covered texels, of
// `count`.
fn map_part(texels: vec4u, sum: vec4f, count: f32) -> MapPart {
    let box = vec4f(texels);
    let size = box.yw - box.xz;
    let share = sum.w / count;
    let mean = sum.xyz / max(sum.w, 1.0);
    let aside = (mean.xy - 0.5 * (box.xz + box.yw)) / size;
    var x = box.xyyx;
    var y = box.zzww;
    if abs(aside.x) >= abs(aside.y) {
        let ends = size.x * map_ends(share, aside.y);
        if aside.x >= 0.0 {
            x = vec4f(box.y - ends.x, box.y, box.y, box.y - ends.y);
        } else {
            x = vec4f(box.x, box.x + ends.x, box.x + ends.y, box.x);
        }
    } else {
        let ends = size.y * map_ends(share, aside.x);
        if aside.y >= 0.0 {
            y = vec4f(box.w - ends.x, box.w - ends.y, box.w, box.w);
        } else {
            y = vec4f(box.z, box.z, box.z + ends.y, box.z + ends.x);
        }
    }
    return MapPart(x, y, mean.z, share);
}

// The width of a trapezoid at its two ends.
fn map_ends(share: f32, off: f32) -> vec2f {
    let first = min(min(max(max(share * (1.0 - 6.0 * off), 2.0 * share - 1.0), 0.0), 2.0 * share), 1.0);
    return vec2f(first, 2.0 * share - first);
}
