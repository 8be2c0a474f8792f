// The visible fraction of a reflectance lobe through a mask, summed over its samples: each thread sums its row, and the weights
// of columns are shared.

// Four columns each: the weights u, u·dx, u·dx², if weights are a product of one by row and one by column.
var<workgroup> columns: array<mat3x4f, COLUMNS / 4u>;

// Sums over all rows: Σ w over the lit samples, Σ w over the emitting samples, and the numbers of both. The unit is that of
// `window`, the same for all masks that are parts of it. Requires uniform control flow.
fn fraction_sums(lane: u32, mask: Mask, window: UnitSquare, at: Receiver, lobe: Lobe) -> vec4f {
    let weights = weights_of(mask, window, at, lobe);
    if (lane < row_groups) {
        columns[lane] = weights_columns(weights, middles(mask, lane));
    }
    workgroupBarrier();
    var sum = vec4f(0.0, 0.0, open_count(), 0.0);
    // Threads without a row, and rows without emitting samples, add nothing.
    if (emitting.x < emitting.y) {
        let y = open_y(mask, lane);
        let factors = weights_row(weights, y);
        let counts = row_counts(lit);
        // The emitting part, in columns.
        let ends = vec2f(emitting) / f32(row_width / (4u * row_groups));
        for (var group = 0u; group < row_groups; group++) {
            var w = columns[group] * factors;
            if (!weights.by_row) {
                w = weights_samples(weights, middles(mask, group), y);
                // A partly emitting column is sampled at its centre, which may be below the horizon.
                w = select(vec4f(0.0), w, w > vec4f(0.0));
            }
            let column = vec4f(row_columns(group));
            sum.x += dot(open_of(counts, group), w);
            sum.y += dot(saturate(ends.y - column) - saturate(ends.x - column), w);
        }
        sum.y *= f32(row_width / (4u * row_groups));
        sum.w = f32(emitting.y - emitting.x);
    }
    return total(lane, sum);
}

// The visible fraction of the lobe.
fn fraction_of(sum: vec4f) -> f32 {
    // If all weights vanish, since the whole light is far outside the lobe, every sample counts alike.
    let ratio = sum.x / sum.y;
    if (sum.y > 0.0 && sum.y < 3e38 && abs(ratio) < 3e38) {
        return clamp(ratio, 0.0, 1.0);
    }
    return select(0.0, sum.z / sum.w, sum.w > 0.0);
}

// Plane coordinates x of the centres of four columns, in the order of their counts.
fn middles(mask: Mask, group: u32) -> vec4f {
    let width = 2.0 * mask.square.half.x / f32(4u * row_groups);
    let left = mask.square.center.x - mask.square.half.x + 0.5 * width;
    return left + width * vec4f(row_columns(group));
}

// The lit samples of the row.
fn open_count() -> f32 {
    if (!LOOKS_AGAIN || !area_counts) {
        return f32(row_count(lit));
    }
    var sum = 0.0;
    for (var k = 0u; k < 4u * row_groups; k++) {
        sum += area_row.columns[k];
    }
    return sum;
}

// Those in the four columns of a group.
fn open_of(counts: Counts, group: u32) -> vec4f {
    if (!LOOKS_AGAIN || !area_counts) {
        return counts_of(counts, group);
    }
    let k = row_columns(group);
    return vec4f(area_row.columns[k.x], area_row.columns[k.y], area_row.columns[k.z], area_row.columns[k.w]);
}

// The height at which the row's weights are taken.
fn open_y(mask: Mask, j: u32) -> f32 {
    return mask_row_y(mask, j) + select(0.0, area_row.above, LOOKS_AGAIN && area_counts);
}
