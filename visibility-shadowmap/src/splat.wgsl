// Draws the texels that block into the mask: `splat` of blockers.rs for the thread's own row, from the pyramids' roots. No
// barriers. Reads `frame`.

// Clears bits of the row `lit`. All threads of the workgroup call it.
fn maps_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
    let map = map_of_light();
    if map == 0u || map_leaves(at.object) || lane >= SIDE || emitting.x >= emitting.y {
        return;
    }
    let square = mask.square;
    let cell = mask_cell(mask);
    union_begin(lane, mask);
    if map_own_face(at, light) == PARTIAL {
        map_draw_below(square_local(square, at.face), square);
    }
    // The row's lines are at most 3/8 of a cell from its centre, and edges move by an eighth of a cell.
    let y = mask_row_y(mask, lane) + vec2f(-0.53125, 0.53125) * cell.y;
    let x = union_range() + vec2f(-0.15625, 0.15625) * cell.x;
    for (var f = 0u; f < maps_word(map); f++) {
        let face = map + 1u + MAP_FACE * f;
        let view = map_view(face, frame.light, at, square, vec2f(x.x, y.x), vec2f(x.y, y.y), min(cell.x, cell.y));
        for (var l = 0u; l < maps_word(face + 15u); l++) {
            map_draw_layer(view, map_layer(face, l));
        }
    }
    union_write(lane, mask);
}

fn map_draw_layer(view: MapView, layer: MapLayer) {
    var item = MapItem(layer.top, 0u, 0u);
    loop {
        let node = map_node(layer, item);
        var verdict = MAP_NO;
        var block: MapBlock;
        if node.low <= node.high {
            block = map_block(view, layer, item, node);
            verdict = map_judge(view, layer, item, node, block);
            // Skips a node that is covered already: the far side of an object is mostly behind its near side.
            if verdict != MAP_NO && map_is_covered(view, block) {
                verdict = MAP_NO;
            }
        }
        // Both parts of a small node, or a whole large one: drawn in one place, since drivers inline a function at each call.
        var quads = 0u;
        var quad: MapQuad;
        var next: MapQuad;
        if verdict >= MAP_PARTLY {
            let parts = map_parts(view, layer, item, node, block, verdict);
            if parts.is_split {
                verdict = MAP_SPLIT;
            } else {
                quads = 2u;
                quad = map_part_quad(parts.near);
                next = map_part_quad(parts.far);
            }
        } else if verdict == MAP_BLOCKS {
            let texels = map_texels(layer, item);
            let box = vec4f(texels);
            let deviations = map_edge_deviations(layer, texels, node.deviation);
            quads = 1u;
            quad = MapQuad(box.xyyx, box.zzww, map_corners(layer, texels), deviations, true);
        }
        for (var k = 0u; k < quads; k++) {
            if quad.is_there {
                map_draw(view, quad);
            }
            quad = next;
        }
        if verdict == MAP_SPLIT {
            item = map_first_part(item);
            continue;
        }
        item = map_next(layer, item);
        if item.level == layer.top {
            break;
        }
    }
}

// Whether the whole image of a node on this row is covered already.
fn map_is_covered(view: MapView, block: MapBlock) -> bool {
    let middle = view.image * block.middle;
    let spread = abs(view.image[0]) * block.half.x + abs(view.image[1]) * block.half.y + abs(view.image[2]) * block.half.z;
    let low = middle - spread;
    let high = middle + spread;
    let most = max(abs(low), abs(high));
    if low.z < MAP_NEAR * max(max(most.x, most.y), most.z) {
        // The block reaches behind the receiver.
        return false;
    }
    let far = 1.0 / high.z;
    let near = 1.0 / low.z;
    return union_is_covered(
        min(low.xy * far, low.xy * near) - view.slack,
        max(high.xy * far, high.xy * near) + view.slack
    );
}

// A quadrilateral of the face with q at its corners; `deviations` bound how far the neighbours' q is from its edges.
struct MapQuad { x: vec4f, y: vec4f, q: vec4f, deviations: vec4f, is_there: bool }

fn map_part_quad(part: MapPart) -> MapQuad {
    return MapQuad(part.x, part.y, vec4f(part.q), vec4f(0.0), part.share > 0.0);
}

fn map_draw(view: MapView, quad: MapQuad) {
    let deviations = quad.deviations;
    let i = quad.x - view.origin.x;
    let j = quad.y - view.origin.y;
    let k = quad.q - view.origin.z;
    let corners = mat4x3f(
        view.image * vec4f(i.x, j.x, k.x, 1.0),
        view.image * vec4f(i.y, j.y, k.y, 1.0),
        view.image * vec4f(i.z, j.z, k.z, 1.0),
        view.image * vec4f(i.w, j.w, k.w, 1.0)
    );
    let most = max(max(abs(corners[0]), abs(corners[1])), max(abs(corners[2]), abs(corners[3])));
    let near = MAP_NEAR * max(max(most.x, most.y), most.z);
    let nearest = min(min(corners[0].z, corners[1].z), min(corners[2].z, corners[3].z));
    if nearest >= near {
        let points = mat4x2f(
            corners[0].xy / corners[0].z,
            corners[1].xy / corners[1].z,
            corners[2].xy / corners[2].z,
            corners[3].xy / corners[3].z
        );
        var grow = vec4f(0.0);
        if any(deviations > vec4f(0.0)) {
            let lengths = vec4f(
                dot(points[0], points[0]), dot(points[1], points[1]), dot(points[2], points[2]), dot(points[3], points[3])
            );
            let farthest = sqrt(max(max(lengths.x, lengths.y), max(lengths.z, lengths.w)));
            // Within the window the shift is at most that for which nodes are merged; `slack` is twice that.
            let shift = min(farthest * (view.image[2].z * deviations / nearest + 1e-5), vec4f(0.5 * view.slack));
            grow = select(vec4f(0.0), shift, deviations > vec4f(0.0));
        }
        union_quadrilateral(points, grow);
    } else {
        map_draw_clipped(corners, near);
    }
}

// Draws the part of a quadrilateral in homogeneous plane coordinates that is in front of the receiver.
fn map_draw_clipped(corners: mat4x3f, near: f32) {
    union_open();
    var before = corners;
    for (var k = 0u; k < 4u; k++) {
        let p = before[k];
        let next = before[(k + 1u) & 3u];
        let here = p.z - near;
        let there = next.z - near;
        if here >= 0.0 {
            union_corner(p.xy / p.z);
        }
        if (here >= 0.0) != (there >= 0.0) {
            // Computed from the inner end, so that both neighbours of an edge find the same point.
            var at = next + (p - next) * (there / (there - here));
            if here >= 0.0 {
                at = p + (next - p) * (here / (here - there));
            }
            union_corner(at.xy / at.z);
        }
    }
    union_close();
}

// Draws the part of the window below a plane through the receiver; `n` is its normal in the square's frame.
fn map_draw_below(n: vec3f, square: UnitSquare) {
    let low = square.center - square.half;
    let high = square.center + square.half;
    var before = mat4x2f(low, vec2f(high.x, low.y), high, vec2f(low.x, high.y));
    union_open();
    for (var k = 0u; k < 4u; k++) {
        let p = before[k];
        let next = before[(k + 1u) & 3u];
        let here = -(dot(n.xy, p) + n.z);
        let there = -(dot(n.xy, next) + n.z);
        if here >= 0.0 {
            union_corner(p);
        }
        if (here >= 0.0) != (there >= 0.0) {
            if here >= 0.0 {
                union_corner(p + (next - p) * (here / (here - there)));
            } else {
                union_corner(next + (p - next) * (there / (there - here)));
            }
        }
    }
    union_close();
}
