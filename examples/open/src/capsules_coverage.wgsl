// `Capsules::select`, one thread a receiver.

fn capsules_meet(c: Capsule, x: vec3f, cone: Cone) -> bool {
    let way = c.b - c.a;
    let around = cone_of_sphere(x, vec4f(0.5 * (c.a + c.b), 0.5 * length(way) + c.radius));
    let s = clamp(dot(x - c.a, way) / max(dot(way, way), 1e-37), 0.0, 1.0);
    let nearest = distance(c.a + way * s, x) - c.radius;
    let reach = acos(clamp(cone_cos(around), -1.0, 1.0)) + acos(clamp(cone_cos(cone), -1.0, 1.0));
    let between = acos(clamp(dot(around.axis, cone.axis), -1.0, 1.0));
    return nearest < cone.distance && (around.one_minus_cos > 1.0 || between <= reach + 1e-3);
}

fn capsules_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {
    for (var i = 0u; i < arrayLength(&capsules_all); i++) {
        if capsules_all[i].radius > 0.0 && capsules_meet(capsules_all[i], at.position, cone) {
            return PARTIAL;
        }
    }
    return LIT;
}
