// Which spheres meet a shaft, the convex hull of a sphere of receivers and a sphere of light. Spheres are (centre, radius).
//
// As in Rust, but in single precision: its rounding is in the slack, and shafts that open by nearly 90° count as nested.
struct ShaftTest {
    receivers: vec4f,
    light: vec4f,
    // From the receivers to the light, unit, and how far.
    axis: vec3f,
    length: f32,
    // Sine of the angle by which the cone opens, its tangent, and the cosine's reciprocal.
    sin: f32,
    tan: f32,
    secant: f32,
    // One of the spheres holds the other, or nearly: `hull` is around both.
    nested: bool,
    hull: vec4f,
}

// Relative to distances. The sine is right to 4e-7, the secant, at most 7.1, to 2e-5.
const SHAFT_SLACK = 4e-5;
const SHAFT_NEARLY = 0.01;

fn shaft_test(receivers: vec4f, light: vec4f) -> ShaftTest {
    var test: ShaftTest;
    test.receivers = receivers;
    test.light = light;
    let to = light.xyz - receivers.xyz;
    let length = sqrt(dot(to, to));
    let grow = light.w - receivers.w;
    // NaN counts as nested, in a sphere that keeps everything.
    let beside = abs(grow) < length * (1.0 - SHAFT_NEARLY);
    test.nested = !beside;
    test.length = length;
    test.axis = vec3f(0.0, 0.0, 1.0);
    if (beside) {
        test.axis = to / length;
        test.sin = grow / length;
        let cos_sq = ((length - grow) / length) * ((length + grow) / length);
        test.secant = 1.0 / sqrt(cos_sq);
        test.tan = test.sin * test.secant;
    } else {
        var hull = receivers;
        if (light.w > receivers.w) {
            hull = light;
        }
        hull.w = hull.w * (1.0 + SHAFT_SLACK) + 1.1 * SHAFT_NEARLY * length;
        test.hull = hull;
    }
    return test;
}

// Whether a sphere may meet it.
fn shaft_meets(test: ShaftTest, center: vec3f, radius: f32) -> bool {
    if (test.nested) {
        let d = center - test.hull.xyz;
        let reach = (test.hull.w + radius) * (1.0 + SHAFT_SLACK);
        return !(dot(d, d) > reach * reach);
    }
    let w = center - test.receivers.xyz;
    let along = dot(w, test.axis);
    let beside = w - test.axis * along;
    let aside_sq = dot(beside, beside);
    let past = along - test.length;
    // Where along + aside·tan lies, the foot on the axis of the nearest sphere: by squares with sign.
    let shift = aside_sq * test.tan * abs(test.tan);
    var offset = 0.0;
    var reach = (test.receivers.w + test.sin * along + radius) * test.secant;
    if (along * abs(along) + shift < 0.0) {
        offset = along;
        reach = test.receivers.w + radius;
    } else if (past * abs(past) + shift > 0.0) {
        offset = past;
        reach = test.light.w + radius;
    }
    reach += SHAFT_SLACK * (abs(along) + abs(reach));
    return !(aside_sq + offset * offset > reach * reach || reach < 0.0);
}

// Whether a sphere hides all of the light from all receivers, each at least `clear` away from it along the tangent. Not
// always when it does.
fn shaft_darkens(test: ShaftTest, center: vec3f, radius: f32, clear: f32) -> bool {
    let r = radius * (1.0 - SHAFT_MARGIN);
    if (test.nested || r <= min(test.receivers.w, test.light.w)) {
        return false;
    }
    let w = center - test.receivers.xyz;
    let along = dot(w, test.axis);
    // The shaft's cut through the sphere's middle is inside the sphere, between the two spheres.
    let cut = (test.receivers.w + test.sin * along) * test.secant;
    let beside = w - test.axis * along;
    let aside = sqrt(dot(beside, beside));
    let near = sqrt(dot(w, w)) - test.receivers.w;
    let outer = radius * (1.0 + SHAFT_MARGIN);
    let from_light = center - test.light.xyz;
    return aside + cut + SHAFT_SLACK * abs(along) < r
        && along > test.receivers.w
        && along < test.length - test.light.w
        && near > outer
        && (near - outer) * (near + outer) > clear * clear
        && sqrt(dot(from_light, from_light)) > (outer + test.light.w) * (1.0 + SHAFT_MARGIN);
}
