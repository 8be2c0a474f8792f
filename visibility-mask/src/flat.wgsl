// Lights that may have an outline, in the form of outline.wgsl of lobe-core; else they appear as discs.

// Centre and radius of the light's disc in the plane of the last window.
var<private> flat_disc: vec3f;

// The window around the emitting region, turned so that `across` lies between right and axis.
fn light_window(light: Cone, across: vec3f, normal: vec3f) -> UnitSquare {
    if (!light_is_flat()) {
        return square_above(square_facing(light, across), normal);
    }
    // Turned like the image that it shows.
    let right = outline_frame(select(across, outline_side(), outline_has_sides()));
    outline_project(right);
    var low = vec2f(3e38);
    var high = vec2f(-3e38);
    var square = 0.0;
    for (var i = 0u; i < outline_point_count; i++) {
        let p = outline_points[i];
        low = min(low, p);
        high = max(high, p);
        square = max(square, dot(p, p));
    }
    let disc = 1.0001 * sqrt(square);
    flat_disc = vec3f(0.0, 0.0, disc);
    if (outline.radius > 0.0) {
        flat_disc = outline_circle(right);
        low = max(low, flat_disc.xy - flat_disc.z);
        high = min(high, flat_disc.xy + flat_disc.z);
    }
    let half = 0.5 * (high - low);
    let widest = max(half.x, half.y);
    return UnitSquare(
        right, cross(outline.axis, right), outline.axis, 0.5 * (low + high), max(half, vec2f(THINNEST * widest)), disc
    );
}

// The cone that the rotation of a window follows: toward the middle of what a horizon leaves of an outline, and less than a hemisphere.
fn light_turn(light: Cone) -> Cone {
    if (!light_is_flat() || (light.one_minus_cos < FLAT_WIDE && !outline.is_clipped)) {
        return light;
    }
    return Cone(light_middle(), min(light.one_minus_cos, FLAT_WIDE), light.distance);
}

// The frame in which directions of edges are summed: a flat light's is in its plane, along its first side.
fn edges_frame_of(window: Cone) -> EdgeFrame {
    if (!light_is_flat()) {
        return edges_frame(window.axis);
    }
    let right = outline_frame(outline_corners[1] - outline_corners[0]);
    return EdgeFrame(right, cross(outline.axis, right));
}

// Half the size of the emitting region.
fn light_size(square: UnitSquare) -> f32 {
    return select(square.disc, max(square.half.x, square.half.y), light_is_flat());
}

// The emitting point nearest to another point; `n` is the horizon's normal in the square's frame.
fn light_nearest(square: UnitSquare, start: vec2f, n: vec3f) -> vec2f {
    if (light_is_flat()) {
        return outline_nearest(start);
    }
    return disc_nearest(square, start, n);
}

// The light's disc in the plane: centre and radius.
fn light_disc(square: UnitSquare) -> vec3f {
    return select(vec3f(0.0, 0.0, square.disc), flat_disc, light_is_flat());
}

// The emitting part of a row from `ends.x` to `ends.y`, without regard to the horizon.
fn light_row(ends: vec2f, y: f32) -> vec2f {
    if (!light_is_flat()) {
        return ends;
    }
    var row = ends;
    var p = outline_points[outline_point_count - 1u];
    for (var i = 0u; i < outline_point_count; i++) {
        let q = outline_points[i];
        let side = vec2f(p.y - q.y, q.x - p.x);
        let rest = side.y * (y - p.y) - side.x * p.x;
        let cut = -rest / side.x;
        row.x = select(row.x, max(row.x, cut), side.x > 0.0);
        row.y = select(row.y, min(row.y, cut), side.x < 0.0);
        if (side.x == 0.0 && rest <= 0.0) {
            row.y = row.x;
        }
        p = q;
    }
    return row;
}

// The sides of an outline as half-planes of the last window's plane, besides the light's disc.
fn light_side_count() -> u32 { return select(0u, outline_point_count, light_is_flat()); }

fn light_side(k: u32) -> vec3f {
    let p = outline_points[k];
    let q = outline_points[select(k + 1u, 0u, k + 1u == outline_point_count)];
    let side = vec2f(p.y - q.y, q.x - p.x);
    return vec3f(side, -dot(side, p));
}
