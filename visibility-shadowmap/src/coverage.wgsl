// Coverage of a light by texels, one thread a receiver: `select` of blockers.rs, from the pyramids' roots. Reads `frame`.

fn maps_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {
    let map = map_of_light();
    if map == 0u || map_leaves(at.object) {
        return LIT;
    }
    let own = map_own_face(at, cone);
    if own != LIT {
        return own;
    }
    let square = square_facing(cone, vec3f(0.0));
    let cell = 2.0 * square.disc / frame.cells;
    for (var f = 0u; f < maps_word(map); f++) {
        let face = map + 1u + MAP_FACE * f;
        let view = map_view(face, frame.light, at, square, -square.half, square.half, cell);
        // Includes all cells at the rim.
        let rows = transpose(view.image);
        let disc = rows[2] * (square.disc + 1.5 * cell);
        let aside = (rows[0] + rows[1]) * FRAC_1_SQRT_2;
        let across = (rows[0] - rows[1]) * FRAC_1_SQRT_2;
        let rim = transpose(mat4x4f(disc - aside, disc + aside, disc - across, disc + across));
        for (var l = 0u; l < maps_word(face + 15u); l++) {
            let layer = map_layer(face, l);
            var item = MapItem(layer.top, 0u, 0u);
            loop {
                let node = map_node(layer, item);
                var verdict = MAP_NO;
                var block: MapBlock;
                if node.low <= node.high {
                    block = map_block(view, layer, item, node);
                    verdict = map_judge(view, layer, item, node, block);
                    if verdict != MAP_NO && map_is_outside(rim, block) {
                        verdict = MAP_NO;
                    }
                }
                if verdict >= MAP_PARTLY {
                    let parts = map_parts(view, layer, item, node, block, verdict);
                    verdict = select(MAP_NO, MAP_BLOCKS, parts.near.share + parts.far.share > 0.0);
                    verdict = select(verdict, MAP_SPLIT, parts.is_split);
                }
                if verdict == MAP_BLOCKS {
                    return PARTIAL;
                }
                if verdict == MAP_SPLIT {
                    item = map_first_part(item);
                } else {
                    item = map_next(layer, item);
                    if item.level == layer.top {
                        break;
                    }
                }
            }
        }
    }
    return LIT;
}
