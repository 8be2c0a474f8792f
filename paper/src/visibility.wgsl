// The paper's shadow nodes (§5.3) by a workgroup, from a mask of DEPTH. Their quad-tree has PAPER_DEPTH, which is one less, or
// the same at the greatest depth.

const CELL_SAMPLES = WIDTH / SIDE;

// Rows of all levels as bits, row r of level l at 2^l + r: nodes that the disc touches, and nodes in which any of it is visible.
var<workgroup> tree_touched: array<vec2u, 2u * SIDE>;
var<workgroup> tree_seen: array<vec2u, 2u * SIDE>;

// Nodes k and above of a row of 64.
fn cells_above(k: u32) -> vec2u {
    let shift = min(max(vec2u(k), vec2u(0u, 32u)) - vec2u(0u, 32u), vec2u(32u));
    // A shift by 32 is not defined; two shifts by half of it are.
    let half = shift >> vec2u(1u);
    return (vec2u(0xffffffffu) << half) << (shift - half);
}

// Cells of the row with any emitting sample.
fn emitting_cells() -> vec2u {
    let last = (emitting.y + (CELL_SAMPLES - 1u)) / CELL_SAMPLES;
    return select(vec2u(0u), cells_above(emitting.x / CELL_SAMPLES) & ~cells_above(last), emitting.x < emitting.y);
}

// Cells of the row that emit and are not blocked from end to end.
fn lit_cells() -> vec2u {
    // Four samples are one bit of the four planes of either half.
    let low = (lit.a.x | lit.a.y) | (lit.a.z | lit.a.w);
    let high = (lit.b.x | lit.b.y) | (lit.b.z | lit.b.w);
    var cells = spread(low) | (spread(high) << vec2u(1u));
    for (var side = 64u; side > SIDE; side /= 2u) {
        cells = pairs(cells);
    }
    return cells;
}

// Bit k of the result: bit 2k or 2k + 1.
fn pairs(bits: vec2u) -> vec2u {
    var b = (bits | (bits >> vec2u(1u))) & vec2u(0x55555555u);
    b = (b | (b >> vec2u(1u))) & vec2u(0x33333333u);
    b = (b | (b >> vec2u(2u))) & vec2u(0x0f0f0f0fu);
    b = (b | (b >> vec2u(4u))) & vec2u(0x00ff00ffu);
    b = (b | (b >> vec2u(8u))) & vec2u(0x0000ffffu);
    return vec2u(b.x | (b.y << 16u), 0u);
}

// Bit 2k of the result: bit k.
fn spread(bits: u32) -> vec2u {
    var b = vec2u(bits & 0xffffu, bits >> 16u);
    b = (b | (b << vec2u(8u))) & vec2u(0x00ff00ffu);
    b = (b | (b << vec2u(4u))) & vec2u(0x0f0f0f0fu);
    b = (b | (b << vec2u(2u))) & vec2u(0x33333333u);
    return (b | (b << vec2u(1u))) & vec2u(0x55555555u);
}

// Bits 2k and 2k + 1 of the result: bit k, of 32.
fn twice(bits: vec2u) -> vec2u {
    let even = spread(bits.x);
    return even | (even << vec2u(1u));
}

// `ShadowTree::read`, and its levels above. Requires uniform control flow.
fn paper_tree(lane: u32) {
    if lane < SIDE {
        tree_touched[SIDE + lane] = emitting_cells();
        tree_seen[SIDE + lane] = lit_cells();
    }
    for (var side = SIDE / 2u; side > 0u; side /= 2u) {
        workgroupBarrier();
        if lane < side {
            let child = 2u * (side + lane);
            tree_touched[side + lane] = pairs(tree_touched[child] | tree_touched[child + 1u]);
            tree_seen[side + lane] = pairs(tree_seen[child] | tree_seen[child + 1u]);
        }
    }
    workgroupBarrier();
}

// The shadow nodes of a row: touched by the disc, wholly hidden, in a parent that is not wholly hidden.
fn paper_row(row: u32) -> vec2u {
    let dark = tree_touched[row] & ~tree_seen[row];
    if row <= 1u {
        return dark;
    }
    return dark & twice(tree_seen[row / 2u]);
}

fn count_of(bits: vec2u) -> u32 {
    return countOneBits(bits.x) + countOneBits(bits.y);
}

// Number of the nth set bit.
fn nth_bit(bits: vec2u, n: u32) -> u32 {
    let below = countOneBits(bits.x);
    var word = select(bits.x, bits.y, n >= below);
    var left = select(n, n - below, n >= below);
    var at = select(0u, 32u, n >= below);
    for (var width = 16u; width > 0u; width /= 2u) {
        let half = countOneBits(word & ((1u << width) - 1u));
        if left >= half {
            left -= half;
            word >>= width;
            at += width;
        }
    }
    return at;
}

// The number of shadow nodes.
fn paper_count(lane: u32) -> u32 {
    var count = 0u;
    for (var row = lane; row < (2u << PAPER_DEPTH); row += LANES) {
        if row > 0u {
            count += count_of(paper_row(row));
        }
    }
    return u32(total(lane, vec4f(f32(count), 0.0, 0.0, 0.0)).x);
}

// `PaperWeights::weight`, from the pairs after the tables: level by level, distance by distance.
fn paper_weight(level: u32, dist: f32) -> f32 {
    var above = u32(min(dist, 9.0)) + 2u;
    if dist < 1.0 {
        above = 1u;
        if dist >= 0.5 {
            above = 2u;
        }
    }
    let d0 = paper_distance(above - 1u);
    let t = clamp((dist - d0) / (paper_distance(above) - d0), 0.0, 1.0);
    let w0 = paper_solved(above - 1u, level);
    return w0 + t * (paper_solved(above, level) - w0);
}

fn paper_distance(k: u32) -> f32 {
    return select(f32(k) - 1.0, 0.25 * f32(k + 1u), k < 2u);
}

fn paper_solved(distance: u32, level: u32) -> f32 {
    let k = distance * 7u + level;
    let pair = paper_tables[paper_end() + k / 2u];
    return select(pair.x, pair.y, (k & 1u) != 0u);
}

// `node_lobe`: the lobe of the sphere around a node's square (Fig. 10).
fn paper_node_lobe(square: UnitSquare, level: u32, node: vec2u) -> Lobe {
    let half = square.half.x / f32(1u << level);
    let at = vec2f(2u * node + vec2u(1u)) * half - square.half;
    let cone = cone_of_sphere(vec3f(0.0), vec4f(at, 1.0, 1.41421356237310 * half));
    return paper_occluder(Cone(unit(square_world(square, cone.axis)), cone.one_minus_cos, cone.distance));
}

// A thread's part of the weighted sum of a product's products with the lobes of all shadow nodes; and the number of products
// dropped below the threshold.
fn paper_shadow(lane: u32, square: UnitSquare, product: Lobe, threshold: f32) -> vec4f {
    let dist = 0.5 / square.disc;
    var sum = vec3f(0.0);
    var pruned = 0.0;
    var first = 0u;
    for (var row = 1u; row < (2u << PAPER_DEPTH); row++) {
        let bits = paper_row(row);
        let nodes = count_of(bits);
        // The nodes in the order of levels and rows are distributed to the threads in turn.
        for (var k = (lane - first) & (LANES - 1u); k < nodes; k += LANES) {
            let level = firstLeadingBit(row);
            let lobe = paper_node_lobe(square, level, vec2u(nth_bit(bits, k), row - (1u << level)));
            let weighted = lobe.flux * -paper_weight(level, dist);
            let taken = paper_product(product, Lobe(lobe.axis, lobe.exponent, weighted, LOBE_PLAIN)).flux;
            if max(max(abs(taken.x), abs(taken.y)), abs(taken.z)) < threshold {
                pruned += 1.0;
            } else {
                sum += taken;
            }
        }
        first += nodes;
    }
    return vec4f(sum, pruned);
}
