// Unit vectors.

fn unit_or(v: vec3f, other: vec3f) -> vec3f {
    let length = sqrt(dot(v, v));
    return select(other, v / max(length, MIN_POSITIVE), length > 0.0);
}
