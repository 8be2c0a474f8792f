// Cosine and sine of an angle of some turns at most; absolute error 2e-7.
fn cos_sin(angle: f32) -> vec2f {
    let quarter = round(angle * (2.0 * FRAC_1_PI));
    let r = (angle - quarter * 1.5703125) - quarter * 4.8382679e-4;
    let z = r * r;
    let s = sin_of_octant(r);
    let c = 1.0 + z * (-0.5 + z * (4.1666667e-2 + z * (-1.3888889e-3 + z * (2.4801587e-5 - z * 2.7557319e-7))));
    let turned = select(vec2f(c, s), vec2f(-s, c), (i32(quarter) & 1) != 0);
    return select(turned, -turned, (i32(quarter) & 2) != 0);
}
