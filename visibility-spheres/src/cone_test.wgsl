// Which spheres may hide something of one receiver's light: the cheap question before the exact one.
struct ConeTest {
    start: vec3f,
    axis: vec3f,
    sin: f32,
    sin_sq: f32,
    cos_sq: f32,
    // The light is seen within less than a hemisphere.
    narrow: bool,
}

fn cone_test(x: vec3f, cone: Cone) -> ConeTest {
    let sin_sq = cone_sin_sq(cone);
    let cos = cone_cos(cone);
    return ConeTest(
        x,
        cone.axis,
        sqrt(sin_sq),
        sin_sq * (1.0 + CONE_SLACK),
        cos * cos * (1.0 - CONE_SLACK),
        cos > 0.0,
    );
}

// Whether the cone may meet the sphere.
fn cone_meets(test: ConeTest, center: vec3f, radius: f32) -> bool {
    if (!test.narrow) {
        return true;
    }
    let w = center - test.start;
    let along = dot(w, test.axis);
    let beside = w - test.axis * along;
    let aside_sq = dot(beside, beside);
    // d sin(γ − θ) > r, γ the angle between the axes, θ the light's half-angle.
    let reach = radius + along * test.sin + (abs(along) + radius) * CONE_SLACK;
    let outside = aside_sq * test.cos_sq > reach * reach || reach < 0.0;
    // γ − θ > 90°, and not inside the sphere.
    let back = -along - radius * CONE_SLACK;
    let behind = back > 0.0
        && back * back * test.cos_sq > aside_sq * test.sin_sq
        && dot(w, w) > radius * radius * (1.0 + CONE_SLACK);
    return !(outside || behind);
}
