// `rows::lobes`: the lobe of a slot, 1 + 3 family + place. A row has five numbers for each family, as in ggx.rs: two fluxes, tilt, spread,
// exponent.
fn row_lobe(rows: u32, slot: u32, f0: vec3f, f90: vec3f, at: Receiver) -> Lobe {
    let n = at.normal;
    let cosine = clamp(dot(n, at.view), 0.0, 1.0);
    // Views below the horizon, which smooth normals have, are taken as at it.
    let along = n * dot(n, at.view) - at.view;
    let length = sqrt(dot(along, along));
    var forward = along / max(length, 1e-12);
    if length <= 1e-12 {
        forward = orthonormal_basis_u(n);
    }
    let sine = min(length, 1.0);

    // √(1 − cos) without cancellation.
    let place = clamp(sine / sqrt(1.0 + cosine), 0.0, 1.0) * f32(METAL_ROWS - 1u);
    let first = min(u32(place), METAL_ROWS - 2u);
    let t = place - f32(first);
    let family = (slot - 1u) / 3u;
    let side = f32((slot - 1u) % 3u) - 1.0;
    let number = rows + first * METAL_ROW_WORDS + 5u * family;
    let flux = f0 * row_value(number, t) + f90 * row_value(number + 1u, t);
    let tilt = row_value(number + 2u, t);
    let spread = row_value(number + 3u, t);
    let exponent = row_value(number + 4u, t);
    // So near each other that they are one.
    let single = spread * spread * (exponent + 2.0) < 1e-3;
    let share = select(0.5 - 0.25 * abs(side), select(0.0, 1.0, side == 0.0), single);

    let mirror = unit_or(n * cosine + forward * sine, n);
    let beside = unit_or(forward * cosine - n * sine, forward);
    let turn = cos_sin(tilt + side * spread);
    let axis = mirror * turn.x + beside * turn.y;
    return Lobe(axis / sqrt(dot(axis, axis)), exponent, flux * share, LOBE_PLAIN);
}

// Between a row and the next.
fn row_value(word: u32, t: f32) -> f32 {
    let low = material_f32(word);
    return low + (material_f32(word + METAL_ROW_WORDS) - low) * t;
}
