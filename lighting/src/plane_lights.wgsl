// Rectangles, discs, polygons, tubes and patches of the sky, as `FlatLight`, `TubeLight` and `SkyPatch`. `frame.shape[1]`:
// corners or radius, whether it has places, which object it is inside of, kind. Reads `frame`.

fn light_cone(at: Receiver) -> Cone {
    let middle = frame.light.xyz - at.position;
    outline.count = 0u;
    if (frame.shape[1].w == PLANE_TUBE) {
        tube_outline(at);
        if (outline.count == 0u) {
            let a = frame.shape[2].xyz - at.position;
            let b = frame.shape[3].xyz - at.position;
            let end = select(frame.shape[3].xyz, frame.shape[2].xyz, dot(a, a) < dot(b, b));
            return cone_of_sphere(at.position, vec4f(end, frame.shape[1].x));
        }
    } else {
        flat_outline(at, middle);
    }
    var cone = outline_cone(middle);
    outline_keep_above(at.normal);
    if (outline.count == 0u) {
        cone.one_minus_cos = 0.0;
    }
    return cone;
}

fn light_radiance(at: Receiver) -> vec3f { return select(frame.radiance, vec3f(0.0), f32(at.object) == frame.shape[1].z); }

fn flat_outline(at: Receiver, middle: vec3f) {
    let normal = frame.shape[0].xyz;
    let is_sky = frame.shape[1].w == PLANE_SKY;
    let is_lit_side = !is_sky && dot(normal, at.position - frame.light.xyz) > 0.0;
    if (!is_sky && !is_lit_side && frame.shape[0].w == 0.0) {
        return;
    }
    let axis = select(normal, -normal, is_lit_side);
    if (frame.shape[1].w == PLANE_DISC) {
        outline_disc(middle, frame.shape[1].x, axis);
        return;
    }
    let count = u32(frame.shape[1].x);
    for (var k = 0u; k < count; k++) {
        outline_corners[k] = frame.shape[2u + k].xyz - select(at.position, vec3f(0.0), is_sky);
    }
    outline_new(count, axis);
    if (frame.shape[1].y > 0.0) {
        let corner = frame.shape[2].xyz;
        outline_set_sides(0.5 * (frame.shape[3].xyz - corner), 0.5 * (frame.shape[5].xyz - corner));
    }
}

fn tube_outline(at: Receiver) {
    let radius = frame.shape[1].x;
    let a = frame.shape[2].xyz - at.position;
    let b = frame.shape[3].xyz - at.position;
    let length = distance(a, b);
    let along = (b - a) / length;
    // From the receiver to the foot of its perpendicular on the middle line.
    let foot = a - along * dot(a, along);
    let height = sqrt(dot(foot, foot));
    if (!(height > TUBE_BESIDE * radius && length > 0.0)) {
        return;
    }
    let axis = foot / height;
    let sin = radius / height;
    let across = cross(axis, along) * (height * sin / sqrt((1.0 - sin) * (1.0 + sin)));
    let places = vec2f(dot(a, along), dot(b, along));
    // Of a tube that is far away along its own line all is farther than that.
    let farthest = TUBE_FAR * max(max(places.x, -places.y) / height, 1.0);
    let start = tube_end(places.x, height, radius, farthest);
    let end = tube_end(places.y, height, radius, farthest);
    for (var k = 0u; k < 7u; k++) {
        let turn = outline_turn(2u * k);
        outline_corners[k] = foot + along * (end.x + end.y * TUBE_REACH * turn.y) - across * turn.x;
        outline_corners[7u + k] = foot + along * (start.x - start.y * TUBE_REACH * turn.y) + across * turn.x;
    }
    let plane = tube_plane(a, b, axis, height, radius);
    for (var k = 0u; k < 14u; k++) {
        outline_corners[k] *= plane.w / dot(plane.xyz, outline_corners[k]);
    }
    outline_new(14u, plane.xyz);
}

// The plane in which the surface is in the mean: `TubeLight::plane`. Its normal, and its distance.
fn tube_plane(a: vec3f, b: vec3f, toward: vec3f, height: f32, radius: f32) -> vec4f {
    let inward = TUBE_DEPTH * radius;
    let is_first = dot(a, a) < dot(b, b);
    let near = select(b, a, is_first);
    let body = select(a, b, is_first) - near;
    let away = body / sqrt(dot(body, body));
    let place = dot(near, away);
    if (place <= 0.0) {
        return vec4f(toward, height - inward);
    }
    let distance = sqrt(height * height + place * place);
    let view = (toward * height + away * place) / distance;
    let side = (away * height - toward * place) / distance;
    let beside = dot(body, side);
    let whole = beside + 2.0 * radius;
    let slope = dot(body, view) * beside / (whole * whole);
    let length = sqrt(1.0 + slope * slope);
    return vec4f((view - side * slope) / length, (distance - inward) / length);
}

// Middle and half-length of the ellipse in which the sphere at an end is seen: from the angle φ − δ to φ + δ.
fn tube_end(place: f32, height: f32, radius: f32, farthest: f32) -> vec2f {
    let sin = radius / sqrt(height * height + place * place);
    let tan = sin / sqrt((1.0 - sin) * (1.0 + sin));
    let slope = place / height;
    let low = tube_limit(slope - tan, 1.0 + slope * tan, select(farthest, -farthest, slope < 0.0));
    let high = tube_limit(slope + tan, 1.0 - slope * tan, select(farthest, -farthest, slope < 0.0));
    return vec2f(0.5 * (low + high), 0.5 * max(high - low, 0.0)) * height;
}

fn tube_limit(over: f32, under: f32, farthest: f32) -> f32 {
    let limit = abs(farthest);
    return select(farthest, clamp(over / under, -limit, limit), under > 0.0);
}
