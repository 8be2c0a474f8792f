// Weights of a lobe: (a·p)ᵉ |p|⁻⁽ᵉ⁺³⁾ dA, times n·p/|p| for the receiver's cosine. In a small window their logarithm is a
// polynomial of second order around its peak.

struct GlossyWeights {
    // Whether the weights are a product of one by row and one by column.
    by_row: bool,
    cosine: bool,
    exponent: f32,
    // In the square's frame.
    axis: vec3f,
    normal: vec3f,
    // The peak: the point of the light nearest to the lobe's axis.
    peak: vec2f,
    // At the peak: first derivatives of ln w, and second derivatives xx, yy, xy.
    slope: vec2f,
    bend: vec3f,
}

fn glossy_of(mask: Mask, square: UnitSquare, at: Receiver, lobe: Lobe) -> GlossyWeights {
    var weights: GlossyWeights;
    weights.axis = square_local(square, lobe.axis);
    weights.normal = square_local(square, at.normal);
    weights.cosine = lobe.kind == LOBE_COSINE;
    let cell = mask_cell(mask);
    let widest = max(cell.x, cell.y);
    let half = max(square.half.x, square.half.y);
    let e = min(lobe.exponent, max(2.0 / (widest * widest), MIRROR_EXPONENT));
    weights.exponent = e;
    let m = e + 3.0;
    let aside = weights.axis.xy;
    let near = shortened(plane_point(aside, weights.axis.z), square.disc);
    let c = clamp(near, square.center - square.half, square.center + square.half);
    weights.peak = c;
    let d = dot(aside, c) + weights.axis.z;
    let over = 1.0 / (1.0 + dot(c, c));
    let slope = sqrt(dot(aside, aside)) / d;
    let reach = min(half, 2.0 / sqrt(m));
    let steep = slope * reach;
    let third = e * (steep * steep * steep) / 3.0 + m * (sqrt(dot(c, c)) + 0.25 * reach) * (reach * reach * reach);
    weights.by_row = d > 0.0 && slope * half < 0.5 && third < LEFT_OUT;
    // ln w at c; the cosine's own factor 1/|p| counts too.
    let p = select(m, m + 1.0, weights.cosine);
    let of_d = 1.0 / d;
    weights.slope = aside * (e * of_d) - c * (p * over);
    let round = 2.0 * p * over * over;
    let sharp = e * of_d * of_d;
    weights.bend = round * (c.xyx * c.xyy) - sharp * (aside.xyx * aside.xyy) - vec3f(p * over, p * over, 0.0);
    return weights;
}

fn glossy_columns(weights: GlossyWeights, x: vec4f) -> mat3x4f {
    let dx = x - weights.peak.x;
    let u = exp_of_four((weights.slope.x + 0.5 * weights.bend.x * dx) * dx);
    return mat3x4f(u, u * dx, u * dx * dx);
}

fn glossy_row(weights: GlossyWeights, y: f32) -> vec3f {
    let at_peak = select(vec3f(0.0, 0.0, 1.0), weights.normal, weights.cosine);
    let dy = y - weights.peak.y;
    let w = exp_f32((weights.slope.y + 0.5 * weights.bend.y * dy) * dy);
    // exp(h_xy dx dy) by its series, times n·p.
    let t = weights.bend.z * dy;
    let n = at_peak.x * weights.peak.x + at_peak.y * y + at_peak.z;
    return vec3f(w * n, w * (n * t + at_peak.x), w * (0.5 * n * t + at_peak.x) * t);
}

fn glossy_samples(weights: GlossyWeights, x: vec4f, y: f32) -> vec4f {
    let axis = weights.axis;
    let inverse = 1.0 / (x * x + y * y + 1.0);
    let along = axis.x * x + (axis.y * y + axis.z);
    let power = 0.5 * weights.exponent * ln_1p_of_four(along * along * inverse - 1.0);
    let value = select(vec4f(0.0), exp_of_four(power), along > vec4f(0.0));
    let angle = value * inverse * sqrt(inverse);
    let normal = weights.normal;
    return select(angle, angle * (normal.x * x + (normal.y * y + normal.z)) * sqrt(inverse), weights.cosine);
}

fn exp_of_four(x: vec4f) -> vec4f { return vec4f(exp_f32(x.x), exp_f32(x.y), exp_f32(x.z), exp_f32(x.w)); }

fn ln_1p_of_four(x: vec4f) -> vec4f { return vec4f(ln_1p(x.x), ln_1p(x.y), ln_1p(x.z), ln_1p(x.w)); }
