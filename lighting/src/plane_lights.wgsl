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
    var a = frame.shape[2].xyz - at.position;
    var b = frame.shape[3].xyz - at.position;
    let long = b - a;
    let nearest = clamp(-dot(a, long) / dot(long, long), 0.0, 1.0);
    let near = a + long * nearest;
    let far = TUBE_FARTHEST * sqrt(dot(near, near) / dot(long, long));
    if (far < 1.0) {
        b = a + long * min(nearest + far, 1.0);
        a += long * max(nearest - far, 0.0);
    }
    let length = distance(a, b);
    let along = (b - a) / length;
    // From the receiver to the foot of its perpendicular on the middle line.
    let foot = a - along * dot(a, along);
    let own_height = sqrt(dot(foot, foot));
    let places = vec2f(dot(a, along), dot(b, along));
    let is_beside = places.x <= 0.0 && places.y >= 0.0;
    if (!(own_height > 0.0 && length > 0.0 && (is_beside || own_height > radius))) {
        return;
    }
    let toward = foot / own_height;
    let height = max(own_height, TUBE_BESIDE * radius);
    let side = cross(toward, along);
    let start = tube_end(radius, height, toward, -along, -places.x);
    let end = tube_end(radius, height, toward, along, places.y);
    let part = end.half_turn / (start.half_turn + end.half_turn);
    let steps = clamp(u32(round(f32(TUBE_STEPS) * part)), 1u, TUBE_STEPS - 1u);
    tube_arc(end, side, 0u, steps);
    tube_arc(start, -side, steps + 1u, TUBE_STEPS - steps);
    let plane = tube_plane(toward * height + along * places.x, toward * height + along * places.y, toward, height, radius);
    for (var k = 0u; k < TUBE_STEPS + 2u; k++) {
        outline_corners[k] *= plane.w / dot(plane.xyz, outline_corners[k]);
    }
    outline_new(TUBE_STEPS + 2u, plane.xyz);
}

// The sphere at an end as a receiver sees it: `TubeEnd`.
struct TubeEnd {
    middle: vec3f,
    outermost: vec3f,
    circle: f32,
    half_turn: f32,
}

fn tube_end(radius: f32, height: f32, toward: vec3f, outward: vec3f, place: f32) -> TubeEnd {
    let distance = sqrt(height * height + place * place);
    let sin = radius / distance;
    let cos = sqrt((1.0 - sin) * (1.0 + sin));
    let slope = radius / height;
    let half_turn = atan2(sqrt((1.0 - slope) * (1.0 + slope)) / cos, slope * place / (distance * cos));
    let outermost = (outward * height - toward * place) / distance;
    return TubeEnd((toward * height + outward * place) * (cos * cos), outermost, radius * cos, half_turn);
}

// Corners from `first` on of a polygon with the area of the arc: `TubeEnd::write_arc`.
fn tube_arc(end: TubeEnd, side: vec3f, first: u32, last: u32) {
    let step = 2.0 * end.half_turn / f32(last);
    let grown = step / max(sin(step), 1e-30);
    let inner = f32(last) - 2.0;
    var reach = 1.0;
    if (last == 2u) {
        reach = grown;
    } else if (last > 2u) {
        reach = (sqrt(1.0 + inner * (inner + 2.0) * grown) - 1.0) / inner;
    }
    for (var k = 0u; k <= last; k++) {
        let turn = f32(k) * step - end.half_turn;
        let length = end.circle * select(reach, 1.0, k == 0u || k == last);
        outline_corners[first + k] = end.middle + (end.outermost * cos(turn) + side * sin(turn)) * length;
    }
}

// The plane in which the surface is in the mean: `TubeLight::plane`. Its normal, and its distance.
fn tube_plane(a: vec3f, b: vec3f, toward: vec3f, height: f32, radius: f32) -> vec4f {
    let is_first = dot(a, a) < dot(b, b);
    let near = select(b, a, is_first);
    let body = select(a, b, is_first) - near;
    let away = body / sqrt(dot(body, body));
    let place = dot(near, away);
    if (place <= 0.0) {
        return vec4f(toward, height - tube_inward(radius, height));
    }
    let distance = sqrt(height * height + place * place);
    let view = (toward * height + away * place) / distance;
    let side = (away * height - toward * place) / distance;
    let beside = dot(body, side);
    let whole = beside + TUBE_END * radius;
    let slope = dot(body, view) * beside / (whole * whole);
    let length = sqrt(1.0 + slope * slope);
    let depth = distance - tube_inward(radius, distance) + TUBE_OUT * radius * slope;
    return vec4f((view - side * slope) / length, depth / length);
}

fn tube_inward(radius: f32, distance: f32) -> f32 { return radius * (1.0 - TUBE_DEPTH * (1.0 - radius / distance)); }
