// Weights of a Lambert lobe: n·p |p|⁻⁴ dA.

struct LambertWeights {
    // Whether the weights are a product of one by row and one by column.
    by_row: bool,
    // In the square's frame.
    normal: vec3f,
}

fn lambert_of(window: UnitSquare, at: Receiver) -> LambertWeights {
    let corner = abs(window.center) + window.half;
    let far = dot(corner, corner);
    return LambertWeights(far * far <= 8.0 * CORNER, square_local(window, at.normal));
}

fn lambert_columns(x: vec4f) -> mat3x4f {
    let inverse = 1.0 / (x * x + 1.0);
    let u = inverse * inverse;
    return mat3x4f(u, u * x, u * x * x);
}

fn lambert_row(weights: LambertWeights, y: f32) -> vec3f {
    let inverse = 1.0 / (y * y + 1.0);
    let w = inverse * inverse;
    let n = weights.normal;
    return vec3f(w * (n.y * y + n.z), w * n.x, 0.0);
}

fn lambert_samples(weights: LambertWeights, x: vec4f, y: f32) -> vec4f {
    let inverse = 1.0 / (x * x + y * y + 1.0);
    let n = weights.normal;
    return (n.x * x + (n.y * y + n.z)) * inverse * inverse;
}
