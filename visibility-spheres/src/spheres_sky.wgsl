// Spheres before a whole sky, by a workgroup of LANES threads: sky.rs. A thread draws into a row.

// Draws the outline of the cone that a sphere hides: `SkyBuffer::draw_cone`.
fn spheres_sky_draw(row: u32, blocked_axis: vec3f, blocked_cos: f32) {
    // More than a hemisphere is all but the opposite cone.
    let is_wide = blocked_cos < 0.0;
    let axis = sky_local(select(blocked_axis, -blocked_axis, is_wide));
    let cos = abs(blocked_cos);
    let step = select(2, -2, is_wide);
    // Decided once for all rows. A cone that holds a pole crosses each row once.
    let has_pole = axis.z > cos;
    let has_opposite = -axis.z > cos;
    // The height over the cone's plane along the row: along sin θ + axis.z cos θ = R cos(θ − θ₀).
    let along = dot(sky_circle(row), axis.xy);
    let beside = along * along + (axis.z * axis.z - cos * cos);
    if (!has_pole && !has_opposite && (beside <= 0.0 || along <= 0.0)) {
        return;
    }
    let root = sqrt(max(beside, 0.0));
    for (var k = 0u; k < 2u; k++) {
        let sign = select(1.0, -1.0, k == 0u);
        if (select(has_opposite, has_pole, k == 0u)) {
            continue;
        }
        // θ₀ ∓ acos(cos/R), times R².
        let up = axis.z * cos - along * root * sign;
        let across = max(along * cos + root * (axis.z * sign), 0.0);
        sky_cross(row, sky_place(up, across), select(-step, step, k == 0u));
    }
}

// The cosine of the cone that a sphere hides above the horizon; more than 1 if it hides nothing there.
fn spheres_sky_cos(blocked: BlockedCone) -> f32 {
    let is_below = dot(sky_horizon.normal, blocked.to) <= -blocked.radius;
    return select(blocked.cos, 2.0, is_below || blocked.empty || blocked.cos >= 1.0);
}

fn spheres_sky_axis(to: vec3f) -> vec3f {
    let distance = length(to);
    return select(vec3f(0.0, 0.0, 1.0), to / distance, distance > 0.0);
}

fn spheres_sky(lane: u32, at: Receiver) {
    for (var index = 0u; index < arrayLength(&spheres); index++) {
        let blocked = spheres_blocked(index, at);
        let cos = spheres_sky_cos(blocked);
        // One that hides all has no outline.
        if (cos <= 1.0 && cos > -1.0) {
            for (var row = lane; row < SKY_ROWS; row += LANES) {
                spheres_sky_draw(row, spheres_sky_axis(blocked.to), cos);
            }
        }
    }
}

fn spheres_sky_hides(at: Receiver, direction: vec3f) -> bool {
    var hides = false;
    for (var index = 0u; index < arrayLength(&spheres) && !hides; index++) {
        let blocked = spheres_blocked(index, at);
        let cos = spheres_sky_cos(blocked);
        hides = cos <= -1.0 || dot(spheres_sky_axis(blocked.to), direction) >= cos;
    }
    return hides;
}

fn spheres_sky_has_facet(at: Receiver) -> bool { return spheres_cast(at.object); }
