// The directions that a sphere blocks, seen from a receiver: a cone about its centre. Needs LIT, PARTIAL, DARK.
struct BlockedCone {
    // From the receiver to the sphere's centre.
    to: vec3f,
    radius: f32,
    // Radius of the ball about the same centre whose tangent cone it is: d sin β.
    tangent_radius: f32,
    // cos β of the half-angle.
    cos: f32,
    // Ball and light intersect.
    meets_light: bool,
    // Nothing is blocked.
    empty: bool,
}

// The cone that a sphere blocks under the self-distance τ.
fn blocked_cone(to: vec3f, radius: f32, tau: f32) -> BlockedCone {
    let d_sq = dot(to, to);
    let power = d_sq - radius * radius;
    let d = sqrt(d_sq);
    if (power > 0.0 && tau * tau <= power) {
        return BlockedCone(to, radius, radius, sqrt(power / d_sq), false, false);
    }
    if (tau <= 0.0) {
        // Inside the sphere of another object.
        return BlockedCone(to, radius, 0.0, -1.0, false, false);
    }
    // 1 − cos β = (r² − (d − τ)²)/(2τd).
    let above = (radius - (d - tau)) * (radius + (d - tau));
    if (above <= 0.0) {
        return BlockedCone(to, radius, 0.0, 1.0, false, true);
    }
    var one_minus_cos = 2.0;
    if (d > 0.0) {
        one_minus_cos = min(above / (2.0 * tau * d), 2.0);
    }
    let sin_sq = one_minus_cos * (2.0 - one_minus_cos);
    return BlockedCone(to, radius, d * sqrt(sin_sq), 1.0 - one_minus_cos, false, false);
}

// How the cone covers a light's cone (axis, sin θ, cos θ). Says PARTIAL when in doubt.
fn blocked_cover(blocked: BlockedCone, axis: vec3f, sin: f32, cos: f32) -> u32 {
    if (blocked.cos <= -1.0) {
        return select(DARK, PARTIAL, blocked.meets_light);
    }
    let along = dot(blocked.to, axis);
    let beside = blocked.to - axis * along;
    let aside = sqrt(dot(beside, beside));
    if (blocked.cos >= 0.0) {
        // d sin(γ − θ) and d cos(γ − θ), γ the angle between the two axes.
        let outside = aside * cos - along * sin;
        let toward = along * cos + aside * sin;
        if (outside >= blocked.tangent_radius || toward <= 0.0) {
            return LIT;
        }
        let far = aside * cos + along * sin;
        let far_toward = along * cos - aside * sin;
        if (!blocked.meets_light && far_toward > 0.0 && far <= blocked.tangent_radius) {
            return DARK;
        }
    } else {
        // Wider than a hemisphere: d cos(γ ∓ θ) against d cos β.
        let edge = blocked.cos * sqrt(dot(blocked.to, blocked.to));
        if (along * sin <= aside * cos && along * cos + aside * sin <= edge) {
            return LIT;
        }
        if (!blocked.meets_light && aside * cos + along * sin >= 0.0 && along * cos - aside * sin > edge) {
            return DARK;
        }
    }
    return PARTIAL;
}
