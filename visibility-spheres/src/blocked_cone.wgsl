// The directions that a sphere blocks, seen from a receiver: a cone about its centre.
struct BlockedCone {
    // From the receiver to the sphere's centre.
    to: vec3f,
    radius: f32,
    // Radius of the sphere about the same centre whose tangent cone it is: d sin β.
    tangent_radius: f32,
    // cos β of the half-angle.
    cos: f32,
    // Sphere and light intersect.
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
        return BlockedCone(to, radius, radius, blocked_cos(d, radius), false, false);
    }
    if (tau <= 0.0) {
        // Inside the sphere of another object.
        return BlockedCone(to, radius, 0.0, -1.0, false, false);
    }
    // d(1 − cos β) = (r² − (d − τ)²)/(2τ), and (d sin β)² = d(1 − cos β)·(2d − d(1 − cos β)).
    let above = (radius - (d - tau)) * (radius + (d - tau));
    if (above <= 0.0) {
        return BlockedCone(to, radius, 0.0, 1.0, false, true);
    }
    let rest = min(above * min(0.5 / tau, 3.40282346e38), d + d);
    let chord = sqrt(max(rest * (d + d - rest), 0.0));
    var cos = blocked_cos(d, chord);
    if (rest >= d) {
        cos = -1.0;
        if (d > 0.0) {
            cos = 1.0 - rest / d;
        }
    }
    return BlockedCone(to, radius, chord, cos, false, false);
}

// The cosine of a cone of less than a hemisphere by d sin β.
fn blocked_cos(d: f32, tangent_radius: f32) -> f32 {
    return sqrt(max(d - tangent_radius, 0.0) * (d + tangent_radius)) / d;
}

// How the cone covers a light's cone (axis, sin θ, cos θ). Says PARTIAL when in doubt.
fn blocked_cover(blocked: BlockedCone, axis: vec3f, sin: f32, cos: f32) -> u32 {
    if (blocked.cos <= -1.0) {
        return select(DARK, PARTIAL, blocked.meets_light);
    }
    let along = dot(blocked.to, axis);
    let beside = blocked.to - axis * along;
    let aside_sq = dot(beside, beside);
    if (blocked.cos > 0.0) {
        // d sin(γ ∓ θ) against d sin β, and d cos(γ ∓ θ) against 0, γ the angle between the two axes: by squares.
        let across = aside_sq * (cos * cos);
        let near = blocked.tangent_radius + along * sin;
        let far = blocked.tangent_radius - along * sin;
        let straight = along * along * (cos * cos) > aside_sq * (sin * sin);
        if (near <= 0.0 || across >= near * near || (straight && along <= 0.0)) {
            return LIT;
        }
        if (!blocked.meets_light && straight && along > 0.0 && far >= 0.0 && across <= far * far) {
            return DARK;
        }
    } else {
        // Wider than a hemisphere: d cos(γ ∓ θ) against d cos β.
        let aside = sqrt(aside_sq);
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
